"""What loads that the tests lack, or hardly show, leave open of an answer."""

from __future__ import annotations

from collections.abc import Sequence

from ...common.wording import listed
from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.search.scan import Fit
from ...estimation.search.unseen_loads import constant, other_speed
from .doubts import EVEN, LIKELY, MOSTLY, Doubt


def load_doubts(campaign: BinnedTests, verdict: str, chosen: Sequence[Fit]) -> list[Doubt]:
    """Return what the recorded loads leave open of a verdict that names the `chosen` effects; each reason is a sentence of its own."""
    if verdict == "out_of_domain":
        return []
    doubts = []
    # outside forming the surface does not expand, and averages over a test have no distance
    without = [n for n in campaign.absent if n != "psi" and not (campaign.averaged and n == "sd")]
    if without:
        lacking = f"of a load that the data lack ({', '.join(without)}): record it, or keep it constant in all tests"
        told = (
            f"part of the scatter between tests may be an effect {lacking}"
            if verdict == "nothing_missing"
            else f"what is missing may as well be an effect {lacking}"
        )
        # of 76 such answers to campaigns of another author 74 were right; where something is left and no name found, fewer
        doubts.append(Doubt(told, LIKELY if verdict == "unknown_structure" else MOSTLY))
    for fit in chosen:
        effect = fit.effect
        if flat := constant(effect, campaign):
            rest = listed(n for n in effect.driver if n not in flat) or "nothing else"
            load = listed(flat)
            told = (
                f"{effect.name} needs {load} to vary along a test: these data show a dependence on {load} from test to test, and no memory of it"
                if any(campaign.varies(n) for n in flat)
                else f"{effect.name} needs {load} to vary: these data show a dependence on {rest} only"
            )
            doubts.append(Doubt(told, EVEN))
    if other_speed(campaign):
        told = (
            "distance over time is another speed than v_rel in most tests: effects of speed and of memory cannot be trusted; "
            "allowed: v_rel of every point, not the set value"
        )
        doubts.append(Doubt(told, EVEN))
    return doubts
