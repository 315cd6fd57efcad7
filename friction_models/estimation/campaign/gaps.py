"""Gaps: ranges of a load between the levels of a plan, in which no test measured."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...common.wording import listed
from ...loads import LOAD_NAMES, POINT_UNITS, FloatArray
from ...loads.contract import behind
from ...loads.gaps import GAP, gap_places
from .binned_tests import BinnedTests
from .curves import transformed

#: A part of mu that changes over a gap by more than this share of its own change is not known there.
CHANGE = 0.4


@dataclass(frozen=True)
class Gap:
    """A range of a load without a measurement, in the unit of the load."""

    load: str
    low: float
    high: float
    middle: float  #: On the scale on which the load is drawn.
    place: int  #: Number of averages below it, in order of the load.

    def change(self, campaign: BinnedTests, part: FloatArray) -> float:
        """Return by how much a part of mu, shape (m,), changes over it, from the averages near its one end to those near the other.

        0 where that is a small share of its own change.
        """
        scaled = transformed(campaign, self.load)
        order = np.argsort(scaled)
        scaled, part = scaled[order], part[order]
        near, k = GAP * (scaled[-1] - scaled[0]), self.place
        below = part[:k][scaled[k - 1] - scaled[:k] < near]
        above = part[k:][scaled[k:] - scaled[k] < near]
        change = abs(float(np.median(above) - np.median(below)))
        return change if change > CHANGE * float(np.ptp(part)) else 0.0


def gaps_of(campaign: BinnedTests, name: str) -> list[Gap]:
    """Return the gaps in a load, from low to high.

    Examples
    --------
    Speeds are drawn on a logarithmic scale:

    >>> import numpy as np, pandas as pd
    >>> from friction_models.estimation.campaign.binning import prepare
    >>> table = pd.DataFrame({"test_id": np.repeat(["a", "b"], 50), "v_rel": np.repeat([5.0, 500.0], 50), "T": 20.0})
    >>> table = table.assign(sigma_n=800.0, psi=1.1, sd=np.tile(np.linspace(0.5, 25.0, 50), 2), mu=0.1)
    >>> [(round(g.low), round(g.middle), round(g.high)) for g in gaps_of(prepare(table), "v_rel")]
    [(5, 50, 500)]
    """
    if name not in campaign.varied:
        return []
    scaled = transformed(campaign, name)
    order = np.argsort(scaled)
    scaled, values = scaled[order], campaign.average(getattr(campaign.loads, name))[order]
    found = []
    for place in gap_places(scaled).tolist():
        low, high = float(values[place - 1]), float(values[place])
        even = name in {"T", "sd"} or low <= 0.0
        middle = 0.5 * (low + high) if even else float(np.sqrt(low * high))
        found.append(Gap(name, low, high, middle, place))
    return found


def gaps_between_tests(campaign: BinnedTests, without: Collection[str] = ()) -> dict[str, list[Gap]]:
    """Return the gaps of all loads but some, by load. Between the points of a test there is none in the distance."""
    loads = [n for n in LOAD_NAMES if n not in without and (n != "sd" or campaign.averaged)]
    return {name: gaps for name in loads if (gaps := gaps_of(campaign, name))}


def gaps_text(gaps_by_load: Mapping[str, Sequence[Gap]]) -> str:
    """Return these gaps for people; empty where there are none."""
    return "; ".join(
        f"{name} {listed(f'{gap.low:.3g} to {gap.high:.3g}' for gap in gaps)}{behind(POINT_UNITS[name])}"
        for name, gaps in gaps_by_load.items()
    )
