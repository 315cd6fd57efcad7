"""Which tests would tell rivals apart: protocols as rows of a test plan, with the separation to expect.

The expected separation is that of the tests that are there and the new ones together, less what the tests that are
there separate already: the base is refitted on both, the rival chooses its best strength and shape, and a new test has
its own offset, drift and sensor noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..loads import FloatArray
from .analysis import Round
from .base_law import BaseLaw
from .binning import Campaign
from .protocols import READING, Proposal, protocols
from .scan import Fit
from .separation import Bench

#: Rivals of the winner for which tests are sought.
RIVALS = 3
#: Largest separation that is promised.
MOST = 50.0
#: A test that separates by less tells nothing; one that separates by more is enough.
USELESS, ENOUGH = 0.5, 3.0


def propose(
    campaign: Campaign, found: Round, rivals: list[Fit], mu: FloatArray, base: BaseLaw
) -> list[dict[str, Any]]:
    """Return protocols that separate the first of `rivals` from the others, the most telling first.

    Parameters
    ----------
    campaign : Campaign
    found : Round
        The scan that gave the rivals.
    rivals : list of Fit
        The winner first.
    mu : ndarray, shape (n,)
        Friction of the base, for effects that need one.
    base : BaseLaw
        What else is refitted.
    """
    if len(rivals) < 2:
        return []
    bench = Bench(campaign, found, mu, base)
    first, result = rivals[0], []
    proposals = protocols(campaign)
    for rival in rivals[1 : 1 + RIVALS]:
        pair = [first.name, rival.name]
        for proposal in proposals:
            t = bench.separation(first, rival, proposal.loads)
            result.append(_entry(proposal, pair, t))
        points = bench.points(first, rival)
        if points is not None:
            result.append(_entry(points[0], pair, points[1]))
    names = [r.name for r in rivals]
    if "force_zero" in names:
        fault = rivals[names.index("force_zero")]
        other = next(n for n in names if n != "force_zero")
        row = {**proposals[0].plan[0], "protocol": "zero_reading", "zero_reading": READING}
        row.pop("v_levels", None)
        reading = Proposal("zero reading", {"sigma_n [MPa]": 0.0, "duration [s]": READING}, [row], [])
        result.append(_entry(reading, ["force_zero", other], bench.zero_reading(fault)))
    result.sort(key=lambda p: -p["expected_t"])
    telling = [p for p in result if p["expected_t"] >= USELESS]
    return (telling or result[:1])[:5]


def _entry(proposal: Proposal, pair: list[str], t: float) -> dict[str, Any]:
    return {
        "protocol": proposal.protocol,
        "setpoints": proposal.setpoints,
        "separates": pair,
        "expected_t": round(min(t, MOST), 2),
        "repeats": int(np.ceil((ENOUGH / max(t, 0.1)) ** 2)),
        "plan": proposal.plan,
    }


def plan_rows(next_tests: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return the rows of all proposed tests, each once, as one plan."""
    rows: list[dict[str, Any]] = []
    for entry in next_tests:
        rows += [dict(r) for r in entry["plan"] if dict(r) not in rows]
    return rows
