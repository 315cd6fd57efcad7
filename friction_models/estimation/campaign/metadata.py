"""Metadata of tests as columns of numbers; a few empty cells are filled with the usual value, several of texts are a level."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from ...common.errors import shown
from ...effects import CATALOGUE
from ...loads import FloatArray, TriboLoads
from ...loads.contract import ORDER
from ...loads.test_numbers import NO_NUMBERS
from ...models.variables import NOT_RECORDED

#: Share of the tests that may lack a number, or a text, of metadata: texts that are not recorded may be a level (`SEVERAL_EMPTY`).
MOST_EMPTY, MOST_WITHOUT_TEXT = 0.5, 0.8
#: Tests from which on the empty cells of texts are a level of their own. The commonest text would hide what it does: in 15 of 30 tables
#: with a third of the cells empty it hid the offset of one level, and in 12 of 12 with up to 15 % that of the empty cells.
SEVERAL_EMPTY = 3
#: Share of the tests from which on a column with empty cells may hide what its levels do.
MANY_EMPTY = 0.15
#: Columns of metadata of which curves, and repeats that differ in some of them, are looked at; a table of more is a dump.
MOST_METADATA = 24
#: Columns of the table of tests that are taken at all, beside those of the catalogue.
MOST_TAKEN = 100
#: Metadata with more levels than this share of the tests tells nothing about other tests.
MOST_LEVELS = 0.7
#: A column with a larger number, or an infinite one, is no metadata: its squares are beyond all numbers.
LARGEST = 1e100
#: Values of a column that are listed; of more numbers the range.
SHOWN = 4
#: Columns that are no metadata: an empty cell there has a meaning of its own.
NOT_METADATA = ("role", "F_r_zero", "F_r_zero_end")
#: What an evaluation of the records writes beside the settings of a test. It follows from the points, mu_mean from mu itself: taken
#: for metadata, it would predict what is to be explained.
EVALUATED = frozenset(
    [
        "contact_area",
        "upset_height",
        "T_start",
        "sliding",
        "mu_mean",
        "mu_noise",
        "sigma_n_mean",
        "psi_mean",
        "T_mean",
        "v_mean",
        "sigma_n_shear",
        "F_n_zero",
        "flow_stress_ratio",
        "contact_diameter_use",
        "contact_diameter_remark",
    ]
)


def about_table(loads: TriboLoads) -> list[str]:
    """Return warnings if the table of tests does not describe the tests of the points, or holds texts among numbers."""
    table = loads.context
    if table is None or loads.test_id is None:
        return []
    if table.index.name != "test_id" and not table.index.isin(loads.test_id).any():
        has = ", ".join(map(str, table.columns[:6]))
        return [f"the table of tests has no column test_id (it has {has}): its metadata are not used"]
    names = np.unique(loads.test_id)
    known = np.isin(names, table.index.astype(str))
    if not known.any():
        return [
            f"no test of the table of tests is in the data (there {str(table.index[0])!r}, here {str(names[0])!r}): its metadata are not used"
        ]
    said = [
        f"{name} of the test {test} is {shown(text, 30)!r}, no number{f'; {count} cells of this column are none' if count > 1 else ''}: "
        "such a test counts as one where it was not recorded"
        for name, (test, text, count) in table.attrs.get(NO_NUMBERS, {}).items()
        if name not in NOT_METADATA
    ]
    if len(_of_interest(table.columns)) < len(table.columns):
        said.append(
            f"the table of tests has {len(table.columns)} columns: of those that no effect needs only the first {MOST_TAKEN} by name are used"
        )
    if is_text(loads, ORDER):
        text = next(v for v in table[ORDER].dropna() if pd.isna(pd.to_numeric(v, errors="coerce")))
        said.append(
            f"the column {ORDER} of the table of tests holds {shown(str(text), 30)!r}: it is not used, so nothing is said about what changed from "
            "test to test; allowed: numbers in the order of the runs, or dates such as 2024-01-31"
        )
    return said


def _enough(values: pd.Series) -> bool:
    """Return whether metadata is recorded for enough tests to say something of them, or of the others."""
    return bool(values.isna().mean() <= (MOST_WITHOUT_TEXT if _holds_text(values) else MOST_EMPTY))


def _holds_text(values: pd.Series) -> bool:
    """Return whether a value of some metadata is no number."""
    numbers = pd.to_numeric(values, errors="coerce")
    return bool(numbers[values.notna()].isna().any())


def _usual(values: pd.Series) -> Any:
    """Return the value that stands for tests without one: the median of numbers, the commonest text, or `NOT_RECORDED` for several."""
    if not _holds_text(values):
        return float(pd.to_numeric(values, errors="coerce").median())
    if values.isna().sum() >= SEVERAL_EMPTY:
        return NOT_RECORDED
    return values.dropna().astype(str).mode().iloc[0]


def recorded(loads: TriboLoads, name: str) -> str:
    """Return a remark on tests that lack a value of a metadata column; an empty text if all tests have one."""
    values = _of_tests(loads, name)
    if values is None:
        return f"the test table has no {name}"
    without = int(values.isna().sum())
    if not without:
        return ""
    if not _enough(values):
        return f"{name} is recorded for {len(values) - without} of {len(values)} tests"
    usual = _usual(values)
    if usual == NOT_RECORDED:
        counted = "as a level of their own, which tells less than what it was"
    else:
        counted = (
            f"with the commonest, {usual!r}" if isinstance(usual, str) else f"with the median, {usual:g}"
        )
    return f"{name} is not recorded for {without} of {len(values)} tests: they count {counted}"


def share_empty(loads: TriboLoads, name: str) -> float:
    """Return the share of the tests without a value of a metadata column."""
    values = _of_tests(loads, name)
    return 0.0 if values is None else float(values.isna().mean())


def hardly_recorded(loads: TriboLoads, name: str) -> bool:
    """Return whether a metadata column of the table is empty for too many tests to be taken; see `recorded`."""
    values = _of_tests(loads, name)
    return values is not None and not _enough(values)


def _of_tests(loads: TriboLoads, name: str) -> pd.Series | None:
    """Return a metadata column for the tests of the points, empty cells included; None where the table has none."""
    table = loads.context
    if table is None or loads.test_id is None or name not in table.columns:
        return None
    return table[name].reindex(np.unique(loads.test_id).tolist())


def with_all_metadata(loads: TriboLoads, names: Sequence[str]) -> TriboLoads:
    """Fill columns of the table of tests that a few tests lack with their usual value, as `diagnose` does."""
    table = loads.context
    if table is None or loads.test_id is None or table.index.name != "test_id":
        return loads
    tests = np.unique(loads.test_id)
    full = table.reindex(table.index.union(pd.Index(tests, name="test_id"), sort=False))
    for name in dict.fromkeys(names):
        if (
            name in table.columns
            and full[name].reindex(tests).isna().any()
            and _enough(full[name].reindex(tests))
        ):
            full[name] = full[name].fillna(_usual(full[name].reindex(tests)))
    return replace(loads, context=full)


def metadata_columns(loads: TriboLoads) -> dict[str, FloatArray]:
    """Return metadata as columns of numbers; a text becomes its index in alphabetical order."""
    columns: dict[str, FloatArray] = {}
    if loads.context is None or loads.test_id is None:
        return columns
    starts = loads.run_starts
    lengths = np.diff(starts, append=len(loads))
    names = _of_interest([c for c in loads.context.columns if str(c) not in NOT_METADATA])
    filled = with_all_metadata(loads.take(starts), names)
    for name in map(str, names):
        if name in EVALUATED or (name == ORDER and is_text(loads, name)):
            continue
        values = filled.context_column(name)
        if values is None or bool(pd.isna(values).any()):
            continue
        numbers = pd.to_numeric(pd.Series(values), errors="coerce").to_numpy(dtype=float)
        if np.isnan(numbers).any():
            numbers = pd.Categorical(pd.Series(values).astype(str)).codes.astype(float)
        if np.abs(numbers).max(initial=0.0) > LARGEST:
            continue
        columns[name] = np.repeat(numbers, lengths)[:, None]
    return columns


def _of_interest(names: Collection[Any]) -> list[Any]:
    """Return the columns that are taken for metadata: those of the catalogue, and of a dump of thousands the first by name."""
    if len(names) <= MOST_TAKEN:
        return list(names)
    known = {m for kind in CATALOGUE.values() for m in kind.metadata}
    taken = known.union(sorted(map(str, names))[:MOST_TAKEN])
    return [n for n in names if str(n) in taken]


def is_text(loads: TriboLoads, name: str) -> bool:
    """Return whether a metadata column holds a text for any test of the data."""
    table = loads.context
    if table is None or loads.test_id is None or name not in table.columns:
        return False
    values = table[name]
    if pd.api.types.is_numeric_dtype(values):
        return False
    values = values.reindex(pd.unique(loads.test_id.astype(object))).dropna()
    return bool(pd.to_numeric(values, errors="coerce").isna().any())


def metadata_spans(loads: TriboLoads, system: Mapping[str, FloatArray]) -> dict[str, tuple[float, ...]]:
    """Return the levels of texts (``levels:NAME``) and the range of numbers (``numbers:NAME``), for `factor` effects.

    `system` holds metadata as columns of numbers [n, 1].
    """
    spans: dict[str, tuple[float, ...]] = {}
    for name, column in system.items():
        if is_text(loads, name):
            spans[f"levels:{name}"] = tuple(map(float, np.unique(column)))
        else:
            spans[f"numbers:{name}"] = (float(column.min()), float(column.max()))
    return spans


def levels_text(loads: TriboLoads, name: str) -> str:
    """Return a metadata column with what it holds: ``operator (anna, ben)``, ``Ra (0.1 to 0.8)``; its name where nothing is recorded."""
    column = loads.context_column(name)
    if column is None:
        return name
    values = pd.Series(column).dropna().unique()
    if len(values) > SHOWN and not is_text(loads, name):
        return f"{name} ({min(values):g} to {max(values):g})"
    levels = sorted(f"{v:g}" if isinstance(v, int | float) else str(v) for v in values)
    return f"{name} ({', '.join(levels[:SHOWN])}{', ...' if len(levels) > SHOWN else ''})" if levels else name
