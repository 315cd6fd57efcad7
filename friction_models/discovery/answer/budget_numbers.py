"""Noise floor and error budget as reports show them: in the averages, divided as unseen tests divide the error."""

from __future__ import annotations

import numpy as np

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.noise.noise_floor import NoiseFloorNumbers
from ...estimation.search.search_round import SearchRound
from ...loads import FloatArray
from ..judge.confirmation import Confirmation
from ..judge.level_offset import LevelOffset
from .findings import ErrorBudget

#: Ratio of the parts of the floor to its total from which on they come near it.
ADDS_UP = 0.75


def budget_numbers(
    campaign: BinnedTests,
    found: SearchRound,
    confirmed: Confirmation,
    level: LevelOffset,
    residual: FloatArray,
    structure: float,
) -> tuple[NoiseFloorNumbers, ErrorBudget]:
    """Return noise floor and error budget; the squares of the budget add up to the mean square of `residual`.

    `level` is that of a model that is taken as it is, `residual` what the model, as users have it, leaves in the bins, shape
    (m,), and `structure` the RMS of structure beside the names, where no tests could be left out.
    """
    floor = found.floor.to_dict()
    whole = _mean_square(campaign, residual)
    # a model that is not refitted may be off by a level or a shift, which is no part of what unseen tests divide
    beside = min(_mean_square(campaign, found.beyond_base(found.y)), whole)
    shares = confirmed.shares
    if shares is None:
        left = min(floor["total"] ** 2, beside)
        missing = min(structure**2, beside - left)
        floor["source"] = "model" if found.floor.known else "unknown"
    else:
        part = beside / max(shares.best + shares.explained + shares.missing, 1e-300)
        left, missing = part * shares.best, part * shares.missing
        if confirmed.verdict == "nothing_missing":  # what the reference does better is within chance
            left, missing = left + missing, 0.0
        floor["interval"] = [float(np.sqrt(part * edge)) for edge in shares.interval]
        floor["source"] = shares.source
        if confirmed.of_another_form and shares.source == "model":
            floor["hardly_better"] = True
    if confirmed.repeats is not None:
        floor["repeats"] = confirmed.repeats.to_dict()
        if confirmed.repeats.lacks_fit or confirmed.repeats.agrees_with(float(np.sqrt(left))):
            floor["source"], floor["interval"] = "repeats", list(confirmed.repeats.interval)
    if level.off:
        missing += min(_mean_square(campaign, level.left), whole - left - missing)
    elif not confirmed.chosen:
        left = whole - missing
    total = float(np.sqrt(left))
    low, high = floor["interval"]
    floor = {**floor, "interval": [min(low, total), max(high, total)], "total": total}
    # the parts were estimated beside the first effect, and may hold what further names or the reference explain
    parts = _parts(campaign, found)
    # of one mean a test nobody knows what its points scatter
    if not campaign.averaged and ADDS_UP * total <= float(np.sqrt(sum(parts.values()))) <= total / ADDS_UP:
        floor["shares"] = {name: part / sum(parts.values()) for name, part in parts.items()}
    floor["test"], floor["drift"] = min(floor["test"], total), min(floor["drift"], total)
    explained = max(whole - left - missing, 0.0)
    return floor, {"floor": total, "explained": float(np.sqrt(explained)), "missing": float(np.sqrt(missing))}


def _parts(campaign: BinnedTests, found: SearchRound) -> dict[str, float]:
    """Return the mean squares of test scatter, drift and sensor in the averages; the noise of the sensor falls with their points.

    What a slow drift makes of the mean of a test sets tests apart: no data tell it from their scatter.
    """
    floor = found.floor
    points = float(campaign.count.sum()) / len(campaign.count)
    apart = floor.drift**2 * _of_the_mean(campaign, floor.drift_length)
    return {
        "test": floor.test**2 + apart,
        "drift": floor.drift**2 - apart,
        "sensor": floor.bin_sensor**2 / points,
    }


def _of_the_mean(campaign: BinnedTests, length: float) -> float:
    """Return which share of the square of a drift of this correlation length [mm] is that of the mean of a test, as long as most are."""
    distance = campaign.average(campaign.distance)
    last = np.r_[campaign.first_bins[1:], len(distance)] - 1
    ratio = float(np.median(distance[last] - distance[campaign.first_bins])) / max(length, 1e-9)
    # the mean of exp(-|x - x'| / length) over all pairs of places
    return 1.0 if ratio < 1e-3 else float(2.0 * (ratio - 1.0 + np.exp(-ratio)) / ratio**2)


def _mean_square(campaign: BinnedTests, values: FloatArray) -> float:
    return float(campaign.count @ values**2 / campaign.count.sum())
