"""Which tests would tell rivals apart: protocols as rows of a test plan, with the separation to expect.

The expected separation is the lead in evidence with the new tests, less the lead that the existing tests give already. The
base is refitted on both; the rival takes its best amplitude, shape and, within the form error, deviation from its formula;
a new test has its own offset, drift and sensor noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NotRequired, TypedDict, cast

import numpy as np

from ...estimation.campaign.binning import Campaign
from ...estimation.search.base_law import BaseLaw
from ...estimation.search.importance import LEAST_SHARE, weighted_rms
from ...estimation.search.scan import Fit
from ...estimation.search.search_round import SearchRound
from ...estimation.search.zero_reading import ZERO, expected
from ...loads import FloatArray
from .protocols import READING, PlanRow, Proposal, SetPoints, protocols
from .separation import ENOUGH, Bench, Separation

#: Rivals of the winner for which tests are sought.
RIVALS = 3
#: Largest separation that is promised.
MOST = 50.0
#: A test that separates by fewer standard errors is not proposed.
USELESS = 0.5


class NextTest(TypedDict):
    """A proposed test.

    What is set in it, which two effects it separates, by how many standard errors, how many repeats that takes, and the
    tests as rows of a plan.
    """

    protocol: str
    setpoints: SetPoints
    separates: list[str]
    expected_t: float
    repeats: NotRequired[int]
    plan: list[PlanRow]


def propose(
    campaign: Campaign, found: SearchRound, rivals: list[Fit], mu: FloatArray, base: BaseLaw
) -> tuple[list[NextTest], list[str]]:
    """Return protocols that separate the first of `rivals` from the others.

    Parameters
    ----------
    campaign : Campaign
    found : SearchRound
        The scan that gave the rivals.
    rivals : list of Fit
        The winner first.
    mu : ndarray, shape (n,)
        Friction of the base, for effects that need one.
    base : BaseLaw
        What else is refitted.

    Returns
    -------
    proposals : list of NextTest
        The largest separation first.
    remarks : list of str
        One for each rival that no proposal separates.
    """
    if len(rivals) < 2:
        return [], []
    bench = Bench(campaign, found, mu, base)
    first = rivals[0]
    result: list[NextTest] = []
    proposals = protocols(campaign)
    for rival in rivals[1 : 1 + RIVALS]:
        pair = [first.name, rival.name]
        for proposal in proposals:
            result.append(_entry(proposal, pair, bench.separation(first, rival, proposal.loads)))
        points = bench.points(first, rival)
        if points is not None:
            result.append(_entry(points[0], pair, points[1]))
    names = [r.name for r in rivals]
    if ZERO in names:
        fault = rivals[names.index(ZERO)]
        other = next(n for n in names if n != ZERO)
        row: PlanRow = {**proposals[0].plan[0], "protocol": "zero_reading", "zero_reading": READING}
        row.pop("v_levels", None)
        reading = Proposal("zero reading", {"sigma_n [MPa]": 0.0, "duration [s]": READING}, [row], [])
        t = expected(campaign, found.floor.sensor, fault, READING)
        result.append(_entry(reading, [ZERO, other], Separation(t, t)))
    result.sort(key=lambda p: -p["expected_t"])
    remarks = []
    for rival in rivals[1 : 1 + RIVALS]:
        if ZERO not in (first.name, rival.name):
            own = [p["expected_t"] for p in result if p["separates"] == [first.name, rival.name]]
            if max(own, default=0.0) < ENOUGH:
                remarks.append(_inseparable(campaign, found, first, rival, max(own, default=0.0)))
    telling = [p for p in result if p["expected_t"] >= USELESS]
    return telling[:5], remarks


def _inseparable(campaign: Campaign, found: SearchRound, first: Fit, rival: Fit, best: float) -> str:
    """Return a remark about two effects that no proposed test tells apart."""
    drivers = [f.prepared.candidate.effect.driver for f in (first, rival)]
    apart = weighted_rms(found.change(first) - found.change(rival), campaign.count)
    text = f"{first.name} and {rival.name}: "
    if drivers[0] == drivers[1]:
        text += f"same driver ({', '.join(drivers[0])}), other formula; "
    text += f"no test that could be proposed is expected to separate them (at best {best:.1f} standard errors, {ENOUGH:g} are needed); "
    text += f"in the tests that are there they differ by {apart:.2g} in mu (rms)"
    if apart**2 < LEAST_SHARE * found.floor.total**2:
        text += ", too little to matter: within the tested range either predicts alike"
    return text


def _entry(proposal: Proposal, pair: list[str], expected: Separation) -> NextTest:
    entry: dict[str, object] = {
        "protocol": proposal.protocol,
        "setpoints": proposal.setpoints,
        "separates": pair,
        "expected_t": round(min(expected.t, MOST), 2),
    }
    # repeats help against noise, not against errors of the formulas
    if expected.t >= ENOUGH or expected.t == expected.noise:
        entry["repeats"] = int(np.ceil((ENOUGH / max(expected.t, 0.1)) ** 2))
    return cast(NextTest, entry | {"plan": proposal.plan})


def plan_rows(next_tests: Sequence[Mapping[str, Any]]) -> list[dict[str, str | float]]:
    """Return the rows of all proposed tests, each once, as one plan."""
    rows: list[dict[str, str | float]] = []
    for entry in next_tests:
        rows += [dict(r) for r in entry["plan"] if dict(r) not in rows]
    return rows
