"""Which columns of the test table `diagnose` tries as factors beside the catalogue."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy.stats import rankdata

from ...common import InputError
from ...common.errors import shown
from ...common.wording import listed
from ...effects.base import Effect
from ...effects.metadata.factor import PREFIX, scanned_factor
from ...loads import FloatArray
from ...loads.contract import ORDER, POINT_COLUMNS, SETTING_UNITS
from .binned_tests import BinnedTests
from .metadata import (
    EVALUATED,
    MOST_LEVELS,
    NOT_METADATA,
    hardly_recorded,
    is_text,
    recorded,
    with_all_metadata,
)

#: Most columns that are tried.
MOST_COLUMNS = 12
#: A column that agrees with a load or with another column by more than this correlation over the tests is left out. One that only
#: moves with the order of the tests, as humidity does with the season, stays: unseen tests may tell it from a drift.
SAME, SAME_ORDER = 0.95, 0.995


def factors_of(campaign: BinnedTests, effects: Iterable[Effect]) -> tuple[list[Effect], list[str]]:
    """Return a factor for each further column of the test table, and a remark on columns that cannot be judged.

    Left out are set points, columns of the effects of the catalogue, columns that are constant, that follow a load, that say the
    same as a column of these effects or as an earlier factor, and texts that differ in nearly every test. Of two columns of which
    one divides the levels of the other both stay: neither can stand for the other. The order of the columns does not matter.
    """
    used = {m for e in effects for m in e.metadata}
    at = {n: c[campaign.point_starts, 0] for n, c in campaign.system.items()}
    loads = [n for n in campaign.varied if campaign.sets_apart(n)]
    known = {n: campaign.of_tests(campaign.average(getattr(campaign.loads, n))) for n in loads}
    columns = {n: at[n] for n in sorted(used & set(at)) if np.ptp(at[n]) > 0.0}
    found: list[Effect] = []
    alike: list[str] = []
    further = False
    for name in _further(campaign, used):
        values, text = at[name], is_text(campaign.loads, name)
        if _says_nothing(values, text):
            continue
        same = [n for n, v in known.items() if _follows(v, values, text)]
        same += [
            n
            for n, v in columns.items()
            if same_levels(values, v) or _correlated(values, v, text, SAME_ORDER if n == ORDER else SAME)
        ]
        if same:
            alike.append(f"{name} with {same[0]}")
            continue
        columns[name] = values
        if len(found) == MOST_COLUMNS:  # of a table of thousands no more is looked at
            further = True
            break
        found.append(scanned_factor(name, labels_of(campaign, name)))
    notes = []
    if hardly := _hardly_recorded(campaign, used):
        notes.append(f"columns of the test table that are no factors: {listed(hardly)}")
    if alike:
        notes.append(
            f"columns of the test table that are no factors, as they go with others: {', '.join(alike)}"
        )
    if further:
        notes.append(
            f"of further columns of the test table only the first {MOST_COLUMNS} by name were tested"
        )
    return found, notes


def factors_like(campaign: BinnedTests, effect: Effect, others: Iterable[Effect]) -> list[str]:
    """Return the names of factors that no test tells from an effect, for they have the same levels, or move with its column; those of `others` left out."""
    used = {m for e in (effect, *others) for m in e.metadata}
    own = [campaign.system[m][campaign.point_starts, 0] for m in effect.metadata if m in campaign.system]

    def goes_with_it(name: str) -> bool:
        values, text = campaign.system[name][campaign.point_starts, 0], is_text(campaign.loads, name)
        return any(same_levels(values, v) or _correlated(values, v, text) for v in own)

    return [PREFIX + name for name in _further(campaign, used) if goes_with_it(name)]


def _further(campaign: BinnedTests, used: Collection[str]) -> list[str]:
    """Return the columns of the test table that may be factors beside those `used`."""
    return _may_be_factors(campaign.system, used)


def _hardly_recorded(campaign: BinnedTests, used: Collection[str]) -> list[str]:
    """Return for each column that is empty for too many tests to be a factor how many have it, in words."""
    table = campaign.loads.context
    if table is None:
        return []
    absent = {str(n) for n in table.columns if table[n].notna().any()} - {*campaign.system} - EVALUATED
    names = (n for n in _may_be_factors(absent, used) if hardly_recorded(campaign.loads, n))
    return [recorded(campaign.loads, n) for n in names]


def _may_be_factors(names: Iterable[str], used: Collection[str]) -> list[str]:
    """Return those names, in alphabetical order, that are no loads, settings, roles or columns `used` by effects."""
    others = {*used, *NOT_METADATA, *POINT_COLUMNS, *SETTING_UNITS}
    return sorted(n for n in names if n not in others and n.strip() and n.isprintable())


def check_factors(campaign: BinnedTests, effects: Iterable[Effect], tests: npt.NDArray[np.bool_]) -> None:
    """Refuse an effect of a column that says nothing of other tests, by the rule by which `factors_of` leaves it out.

    `tests` tells which ones are fitted, shape (tests,).

    Raises InputError: one level only, or texts that differ in nearly every test.
    """
    for effect in effects:
        column = campaign.system.get(effect.metadata[0]) if effect.metadata else None
        if column is None:
            continue
        values = column[campaign.point_starts, 0][tests]
        reason = _says_nothing(values, is_text(campaign.loads, effect.metadata[0]))
        if reason:
            raise InputError(
                f"{shown(effect.name, 60)}: the column {reason} of the {len(values)} tests that are fitted, which tells nothing of "
                f"other tests; allowed: a column with at least two levels, numbers or texts with at most {100 * MOST_LEVELS:.0f} % as "
                "many levels as tests"
            )


def _says_nothing(values: FloatArray, text: bool) -> str:
    """Return why a column cannot tell tests apart so that others may profit; empty where it can."""
    if len(np.unique(values)) < 2:
        return "has the same level in all"
    return "" if not text or _has_few_levels(values) else "has another text in nearly each"


def _has_few_levels(values: FloatArray) -> bool:
    return len(np.unique(values)) <= MOST_LEVELS * len(values)


def labels_of(campaign: BinnedTests, name: str) -> list[str]:
    """Return the texts of a column of the test table in the order of their numbers; none where it holds numbers."""
    values = texts_of(campaign, name) if is_text(campaign.loads, name) else ()
    return sorted({str(v) for v in values if not pd.isna(v)})


def texts_of(campaign: BinnedTests, name: str) -> Sequence[Any]:
    """Return a column of the test table as the tests count with it, one entry a test."""
    loads = with_all_metadata(campaign.loads.take(campaign.point_starts), [name])
    values = loads.context_column(name)
    return () if values is None else list(values)


def level_columns(campaign: BinnedTests, names: Iterable[str]) -> FloatArray:
    """Return which bins are at each level of some columns of texts, shape (m, k): of each column all levels but the first."""
    texts = [n for n in names if n in campaign.system and is_text(campaign.loads, n)]
    blocks = [c[:, None] == np.unique(c)[None, 1:] for c in map(campaign.metadata, texts)]
    return np.column_stack([np.empty((len(campaign.starts), 0)), *blocks])


def as_fitted(campaign: BinnedTests, effects: Iterable[Effect]) -> list[Effect]:
    """Return effects as a fit has them: with an offset for each label of a column of texts."""
    effects = list(effects)
    levels = {name: labels_of(campaign, name) for e in effects for name in e.metadata}
    return [e.with_levels({name: labels for name, labels in levels.items() if labels}) for e in effects]


def _follows(load: FloatArray, values: FloatArray, text: bool) -> bool:
    """Return whether a column says nearly all about the mean load of a test."""
    if not text:
        return _correlated(values, load, text)
    level = pd.Series(load).groupby(values).transform("mean").to_numpy()
    return bool(np.var(level) > SAME**2 * np.var(load))


def _correlated(values: FloatArray, other: FloatArray, text: bool, least: float = SAME) -> bool:
    """Return whether two numbers rise, or fall, together."""
    if text or not (np.ptp(values) > 0.0 and np.ptp(other) > 0.0):
        return False
    ranks = np.corrcoef(rankdata(values), rankdata(other))[0, 1]
    return bool(max(abs(np.corrcoef(values, other)[0, 1]), abs(ranks)) > least)


def same_levels(values: FloatArray, other: FloatArray) -> bool:
    """Return whether each level of a column goes with one of another column, and the other way round; in a column that differs in nearly each test, none does."""
    if not _has_few_levels(values):
        return False
    pairs = len({*zip(values.tolist(), other.tolist(), strict=True)})
    return pairs == len(np.unique(values)) == len(np.unique(other))
