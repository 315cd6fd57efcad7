"""What a contact has been through: quantities that laws of memory depend on, whatever their formula."""

from __future__ import annotations

import numpy as np
from scipy.stats import rankdata

from ...loads import FloatArray
from ..campaign.binned_tests import BinnedTests
from ..campaign.curves import on_scale, scaled_loads

#: Share of the largest value below which a quantity that grows from nothing counts as its start.
START = 0.01
#: Two quantities that put the averages in the same order by more than this correlation are one.
SAME_ORDER = 0.995
#: Share of the range of a load by which its highest value so far must exceed the present one somewhere.
FALLS = 0.1
#: Loads that may fall again along a test.
RETURNING = ("v_rel", "T", "sigma_n")


def histories(campaign: BinnedTests) -> dict[str, FloatArray]:
    """Return quantities along which friction may change by memory, on the scales of their curves, shape (m,) each.

    ``time`` since the start of the test, ``load path`` (pressure times distance, which grows like friction work), and the
    highest value so far of each load that falls again. Without those that put the averages in the same order as a load or the
    distance does: a curve along that one follows them already.
    """
    if campaign.averaged:
        return {}  # averages of whole tests have no history
    known = [rankdata(values) for values in scaled_loads(campaign).values()]
    found = {}
    for name, values in _all(campaign).items():
        ranks = rankdata(values)
        if np.ptp(ranks) > 0.0 and all(abs(np.corrcoef(ranks, k)[0, 1]) < SAME_ORDER for k in known):
            known.append(ranks)
            found[name] = values
    return found


def _all(campaign: BinnedTests) -> dict[str, FloatArray]:
    loads, starts = campaign.loads, campaign.point_starts
    found = {}
    if loads.t is not None or "v_rel" not in campaign.absent:
        found["time"] = _growing(campaign, campaign.course.dt)
    if "sigma_n" not in campaign.absent:
        way = np.maximum(np.diff(campaign.distance, prepend=0.0), 0.0)  # back to 0 where a test begins
        found["load path"] = _growing(campaign, loads.sigma_n * way)
    for name in RETURNING:
        values = getattr(loads, name)
        highest = np.concatenate([np.maximum.accumulate(part) for part in np.split(values, starts[1:])])
        if float(np.max(highest - values)) > FALLS * float(np.ptp(values)):
            found[f"highest {name}"] = on_scale(name, campaign.average(highest))
    return found


def _growing(campaign: BinnedTests, steps: FloatArray) -> FloatArray:
    """Return averages of what grows by these steps since each test began, on a logarithmic scale."""
    total = np.cumsum(steps)
    mean = campaign.average(total - total[campaign.point_starts][campaign.point_test])
    return np.asarray(np.log(mean + START * max(float(mean.max()), 1e-300)))
