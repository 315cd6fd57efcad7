"""Coverage: the share of measured points that a prediction interval holds, test by test, and its uncertainty."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common import InputError
from ..estimation.campaign.binning import prepare
from ..estimation.campaign.gaps import gaps_between_tests, gaps_text
from ..families.refinement_history import left_out_tests
from ..loads import DataSet, FloatArray, TriboLoads
from ..loads.dataset import TRAINING, roles_of
from ..models.base import FrictionModel
from ..models.intervals.prediction_interval import LEVEL, PredictionInterval

#: Points of a test share its offset. Tests that happen to agree would speak for any number of observations.
MOST_A_TEST = 3.0


def coverage_measures(
    mu: FloatArray, low: FloatArray, high: FloatArray, groups: npt.NDArray[np.str_], level: float
) -> dict[str, float]:
    """Return how much of the measured `mu` lies within `low` and `high`, each test counted alike.

    The measures are `expected` (the level); `share` (mean over tests of the share of points within), with its own
    interval of 95 % `share_low`, `share_high`: Wilson's, for as many independent observations as the scatter between the
    tests speaks for, at least one and at most `MOST_A_TEST` a test; `points` (share of all points), `worst_test`
    (smallest share of a test), `tests`, `mean_width`.
    """
    inside = ((mu >= low) & (mu <= high)).astype(np.float64)
    _, test = np.unique(groups, return_inverse=True)
    shares = np.bincount(test, weights=inside) / np.bincount(test)
    tests, share = len(shares), float(shares.mean())
    independent = float(tests)
    if tests > 1:
        variance = float(shares.var(ddof=1)) / tests
        spoken_for = share * (1.0 - share) / variance if variance > 0.0 else math.inf
        independent *= min(max(spoken_for / tests, 1.0), MOST_A_TEST)
    below, above = wilson(share, independent)
    return {
        "expected": float(level),
        "share": share,
        "share_low": below,
        "share_high": above,
        "points": float(inside.mean()),
        "worst_test": float(shares.min()),
        "tests": float(tests),
        "mean_width": float(np.mean(high - low)),
    }


def wilson(share: float, count: float, z: float = 1.959964) -> tuple[float, float]:
    """Return the interval of a share seen in `count` observations (Wilson 1927, J. Am. Stat. Assoc. 22: 209)."""
    centre = (share + z * z / (2 * count)) / (1 + z * z / count)
    half = z / (1 + z * z / count) * math.sqrt(share * (1 - share) / count + z * z / (4 * count * count))
    return max(centre - half, 0.0), min(centre + half, 1.0)


def measured_coverage(model: Any, data: DataSet, level: float | None = None) -> dict[str, dict[str, float]]:
    """Return `coverage_measures` of a model with an interval by role of the tests, and of ``all``."""
    points, tests = data.points, data.tests
    low, high = model.predict_interval_frame(points, tests, level)
    mu = points["mu"].to_numpy(dtype=np.float64)
    ids = points["test_id"].to_numpy().astype(str)
    expected = level if level is not None else float(model.interval_level)
    chosen = {"all": np.ones(len(mu), dtype=bool)}
    if tests is not None and "role" in tests.columns:
        roles = roles_of(tests["role"]).set_axis(tests["test_id"].astype(str))
        found = roles.reindex(ids).fillna(TRAINING).to_numpy(dtype=object)
        present = dict.fromkeys(str(r) for r in roles.dropna())
        chosen = {r: found == r for r in sorted(present, key=lambda r: (r != "train", r))} | chosen
    return {
        name: coverage_measures(mu[own], low[own], high[own], ids[own], expected)
        for name, own in chosen.items()
        if own.any()
    }


def add_interval(
    model: FrictionModel, data: DataSet, level: float = LEVEL, seed: int = 0
) -> PredictionInterval:
    """Calibrate a model that was fitted to the training tests of `data`, and measure the coverage on the others.

    Tests that `refine` left out as far off all others count for neither. Where no role is recorded, all tests are training tests.
    The model keeps the interval, whose `coverage` has an entry for each role but ``train``.

    Raises InputError: as `FrictionModel.calibrate`.
    """
    data = data.without_tests(left_out_tests(model))
    chosen = data.select("train")
    points = chosen.points
    model.calibrate(
        TriboLoads.from_frame(points, chosen.tests), points["mu"].to_numpy(), level=level, seed=seed
    )
    for role, measures in measured_coverage(model, data).items():
        if role not in {"train", "all"}:
            model.interval_ = model.interval_.with_coverage(role, measures)
    return model.interval_


def report(interval: PredictionInterval) -> str:
    """Return a text report of a calibrated interval."""
    varies = "the width depends on the loads" if any(interval.slopes) else "the same width at all loads"
    method = f"{100.0 * interval.level:g} %, {interval.method()}"
    loads = dict.fromkeys(w.load for w in interval.between if w.extra)
    gaps = [f"{n} by up to {max(w.extra for w in interval.between if w.load == n):.2g}" for n in loads]
    between = f" but between the levels of the plan, where it is wider ({', '.join(gaps)})" if gaps else ""
    head = f"Prediction interval ({method}): {interval.tests} tests, {interval.source}; {varies}{between}\n"
    return head + (coverage_text(interval.coverage) if interval.coverage else "")


def not_measured(data: DataSet, checked: Collection[str] = ()) -> str:
    """Return in which ranges of the loads no training test measured, so that no test says how well an interval holds; empty for none.

    Gaps in loads that were `checked` by leaving levels out are none of them.
    """
    chosen = data.select("train")
    try:
        found = gaps_text(gaps_between_tests(prepare(chosen.points, chosen.tests), checked))
    except InputError:  # what cannot be averaged can still be predicted
        return ""
    return (
        f"Not measured between the levels of the plan ({found}): how well the interval holds there, no test says\n"
        if found
        else ""
    )


def coverage_text(coverage: Mapping[str, Mapping[str, float]]) -> str:
    """Return a text table of `coverage_measures` by role."""
    lines = [
        f"{'Coverage':12s}{'expected':>9s}{'within':>9s}{'95 % interval of it':>22s}{'worst test':>12s}{'width':>9s}{'tests':>7s}"
    ]
    for role, c in coverage.items():
        between = f"{c['share_low']:.1%} to {c['share_high']:.1%}"
        lines.append(
            f"{role:12s}{c['expected']:9.1%}{c['share']:9.1%}{between:>22s}{c['worst_test']:12.0%}{c['mean_width']:9.4f}{c['tests']:7g}"
        )
    return "\n".join(lines) + "\n"
