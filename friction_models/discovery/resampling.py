"""How sure errors and their change are: whole tests are resampled (bootstrap)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..loads import FloatArray

REPLICATES = 1000
#: With fewer tests resampling is not reliable, and no model counts as clearly ahead.
FEWEST_TESTS = 6
#: Errors that differ by less than this share of theirs count as equal.
SAME = 1e-4


@dataclass(frozen=True)
class Draws:
    """Errors of one model in resampled sets of whole tests: `mae`, `rmse` and `bias`, one value a set."""

    mae: FloatArray
    rmse: FloatArray
    bias: FloatArray


def resampled(
    errors: Mapping[str, FloatArray],
    group: npt.NDArray[np.integer[Any]],
    rng: np.random.Generator,
    replicates: int = REPLICATES,
) -> dict[str, Draws]:
    """Return the errors of models in resampled sets of whole tests, all models in the same sets.

    `errors` are predicted minus measured mu at each point, by model; `group` numbers the test of each point, from 0 on without
    a gap.

    Examples
    --------
    >>> found = resampled({"off": np.array([0.5, 0.5])}, np.array([0, 1]), np.random.default_rng(0), replicates=3)
    >>> found["off"].bias.tolist()
    [0.5, 0.5, 0.5]
    """
    tests = int(group.max()) + 1
    points = np.bincount(group, minlength=tests).astype(float)
    draws = rng.multinomial(tests, np.full(tests, 1.0 / tests), replicates).astype(float)
    weight = draws @ points
    found = {}
    for name, error in errors.items():
        sums = [np.bincount(group, v, tests) for v in (np.abs(error), error**2, error)]
        found[name] = Draws(
            draws @ sums[0] / weight, np.sqrt(draws @ sums[1] / weight), draws @ sums[2] / weight
        )
    return found


def is_clear(smaller: FloatArray, larger: FloatArray, tests: int) -> bool:
    """Whether an error is smaller than another one by more than chance: in 97.5 % of the resampled sets of enough tests."""
    return tests >= FEWEST_TESTS and float(np.mean(smaller < larger)) >= 0.975


@dataclass(frozen=True)
class Change:
    """How sure a change of the error is."""

    #: 95 % intervals of ``rmse`` and ``mae`` of ``before``, ``after`` and ``fall`` (before minus after); None for a single test.
    intervals: dict[str, dict[str, list[float] | None]]
    fell: bool  #: Whether the RMSE fell by more than chance.
    rose: bool  #: Whether it rose by more than chance.


def before_and_after(
    before: FloatArray, after: FloatArray, group: npt.NDArray[np.integer[Any]], seed: int = 0
) -> Change:
    """Return how sure a change of the error is, from resampling whole tests.

    `before` and `after` are predicted minus measured mu at the same points, shape (n,); `group` numbers the test of each point,
    from 0 on without a gap.

    Examples
    --------
    >>> tests = np.arange(6)
    >>> change = before_and_after(np.full(6, 0.5), np.full(6, 0.25), tests)
    >>> change.intervals["after"]["rmse"], change.intervals["fall"]["mae"], change.fell, change.rose
    ([0.25, 0.25], [0.25, 0.25], True, False)
    """
    tests = int(group.max()) + 1
    draws = resampled({"before": before, "after": after}, group, np.random.default_rng(seed))
    old, new = draws["before"], draws["after"]
    values = {
        "before": {"rmse": old.rmse, "mae": old.mae},
        "after": {"rmse": new.rmse, "mae": new.mae},
        "fall": {"rmse": old.rmse - new.rmse, "mae": old.mae - new.mae},
    }
    intervals = {
        when: {name: as_list(interval_of(v, tests)) for name, v in of.items()} for when, of in values.items()
    }
    # What rounding and the solver resolve is no change.
    fell = is_clear((1.0 + SAME) * new.rmse, old.rmse, tests)
    return Change(intervals, fell, is_clear((1.0 + SAME) * old.rmse, new.rmse, tests))


def interval_of(values: FloatArray, tests: int) -> tuple[float, float]:
    """Return the 95 % interval of an error over resampled sets of tests; NaN for a single test."""
    if tests < 2:
        return (float("nan"), float("nan"))
    low, high = np.quantile(values, [0.025, 0.975])
    return float(low), float(high)


def as_list(interval: tuple[float, float]) -> list[float] | None:
    """Return an interval as files hold it; None where it is not known."""
    return None if np.isnan(interval[0]) else list(interval)
