"""Summaries of the residual: worst tests, bias along each load, table of averages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy.special import stdtrit

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.campaign.settings import AS_SET
from ...estimation.fit.parameters import FittedTerm
from ...estimation.search.search_round import SearchRound
from ...loads import LOAD_NAMES, FloatArray
from .findings import BinnedBias, WorstTest

BIAS_BINS = 6
WORST = 10


def base_residual(campaign: BinnedTests, found: SearchRound) -> FloatArray:
    """Return bin means of mu minus the base fitted by generalised least squares, shape (m,)."""
    white = found.whiten(found.columns)
    coefficients = np.linalg.lstsq(white, found.whiten(found.y), rcond=1e-9)[0]
    return found.y - found.columns @ coefficients


def worst_tests(campaign: BinnedTests, residual: FloatArray) -> list[WorstTest]:
    """Return the tests with the largest rms residual (points weigh alike)."""
    rms = np.sqrt(campaign.of_tests(residual**2))
    order = np.argsort(-rms, kind="stable")[:WORST]
    return [{"test_id": campaign.tests[k], "rms": float(rms[k])} for k in order]


def averages(
    campaign: BinnedTests, before: FloatArray, after: FloatArray, chosen: Sequence[FittedTerm] = ()
) -> pd.DataFrame:
    """Return the bins as a table: what `Diagnosis.averages` holds."""
    columns: dict[str, npt.NDArray[Any]] = {
        "test_id": np.array(campaign.tests)[campaign.test],
        "points": campaign.count.astype(int),
    }
    loads = {n: getattr(campaign.loads, n) for n in LOAD_NAMES if n not in campaign.absent}
    columns |= {n: campaign.average(v) for n, v in loads.items()}
    needed = dict.fromkeys(n for term in chosen for n in term.effect.metadata)
    columns |= {n: campaign.metadata(n) for n in needed if n not in columns}
    columns |= {"mu": campaign.average(campaign.mu), "before": before, "after": after}
    columns |= {f"effect {term.name}": term.binned for term in chosen}
    return pd.DataFrame(columns)


def load_bins(values: FloatArray, most: int) -> npt.NDArray[np.intp]:
    """Return the bin of each value: quantiles, those that practically coincide (levels of a plan) as one."""
    ordered = np.sort(values)
    inner: list[float] = []
    for edge in np.quantile(ordered, np.linspace(0.0, 1.0, most + 1))[1:-1]:
        # cut in the widest gap near the quantile, so that one level of a test plan stays in one bin
        near = max(0.1 * abs(edge), 0.02 * float(np.ptp(ordered)))
        first = max(int(np.searchsorted(ordered, edge - near)) - 1, 0)
        last = int(np.searchsorted(ordered, edge + near, side="right"))
        part = ordered[first : last + 1]
        gaps = np.diff(part)
        if len(gaps) and gaps.max() > 4.0 * gaps.mean():
            edge = float(part[gaps.argmax()] + 0.5 * gaps.max())
        inner.append(_beside_level(ordered, edge))
    cuts = np.unique(inner)
    which = np.searchsorted(cuts, values, side="right")
    return np.unique(which, return_inverse=True)[1].astype(np.intp)


def _beside_level(ordered: FloatArray, edge: float) -> float:
    """Return an edge that would part the values of one set point moved into the nearer gap beside them; others as they are."""
    near = max(AS_SET * abs(edge), 1e-3 * float(np.ptp(ordered)))
    first, last = (int(np.searchsorted(ordered, edge + s * near)) for s in (-1.0, 1.0))
    here = int(np.searchsorted(ordered, edge, side="right"))
    if not first < last:
        return edge
    width = float(ordered[last - 1] - ordered[first])
    below = float(ordered[first] - ordered[first - 1]) if first else np.inf
    above = float(ordered[last] - ordered[last - 1]) if last < len(ordered) else np.inf
    if min(below, above) <= max(width, near):  # values everywhere: no set point
        return edge
    if here - first < last - here and first:
        return float(ordered[first] - 0.5 * below)
    if last < len(ordered):
        return float(ordered[last - 1] + 0.5 * above)
    return float(ordered[first] - 0.5 * below) if first else edge


def clustered_mean(
    residual: FloatArray, weight: FloatArray, test: npt.NDArray[np.intp], inside: npt.NDArray[np.bool_]
) -> tuple[float, float, int]:
    """Return mean, half of its 95 % interval over tests (NaN for one test), and the number of tests.

    Every test weighs the same: where a ramp stays long and others pass, the ramp alone would be the mean, and its own scatter.
    """
    tests = np.unique(test[inside])
    totals = np.bincount(test[inside], weight[inside])[tests]
    sums = np.bincount(test[inside], (weight * residual)[inside])[tests]
    means = sums / totals
    if len(tests) < 2:
        return float(means.mean()), float("nan"), len(tests)
    error = means.std(ddof=1) / np.sqrt(len(tests))
    return float(means.mean()), float(stdtrit(len(tests) - 1, 0.975) * error), len(tests)


def binned_bias(
    campaign: BinnedTests, residual: FloatArray, after: FloatArray | None = None
) -> list[BinnedBias]:
    """Return the mean residual along each load that varies, with intervals that treat a test as the unit."""
    rows: list[BinnedBias] = []
    for name in LOAD_NAMES:
        if not campaign.varies(name):
            continue
        values = campaign.average(getattr(campaign.loads, name))
        which = load_bins(values, BIAS_BINS if len(campaign.tests) > 2 else 3)
        for k in range(int(which.max()) + 1):
            inside = which == k
            mean, half, tests = clustered_mean(residual, campaign.count, campaign.test, inside)
            row: BinnedBias = {
                "load": name,
                "low": float(values[inside].min()),
                "high": float(values[inside].max()),
                "bias": mean,
                "interval": [mean - half, mean + half],
                "tests": tests,
            }
            if after is not None:
                mean, half, _ = clustered_mean(after, campaign.count, campaign.test, inside)
                row["after"], row["after_interval"] = mean, [mean - half, mean + half]
            rows.append(row)
    return rows
