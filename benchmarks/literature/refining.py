"""What an accepted addition does to tests the model has not seen."""

from __future__ import annotations

from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from .answers import Answer
from .build import Campaign
from .domains import DOMAINS
from .names import ACCEPTING

#: A removed share is only computed where the linear fit is worse than the floor by this much (cold forging size).
SMALLEST_GAIN = 0.0005
#: An addition harms if the error grows by this share of the old error and by this much.
HARM_SHARE, HARM_SIZE = 0.02, 0.0002


def rms(a: NDArray[Any], b: NDArray[Any]) -> float:
    """Root mean square of a difference; infinite if a value is missing."""
    difference = np.asarray(a, float) - b
    return float(np.sqrt(np.mean(difference**2))) if np.all(np.isfinite(difference)) else float("inf")


def _raw_effects(diagnosis: Any) -> list[Any]:
    """Effects as the diagnosis spells them."""
    effects = diagnosis.effects or []
    return [effects] if isinstance(effects, str) else list(effects)


class Refinement(TypedDict):
    """Errors on held-out tests: of a fit with the true form, of the linear base and who fitted it, of the refined model.

    ``avoidable``: the base is worse than the true form by enough; ``removed`` is the share of that; ``harms``: the addition
    led away. None where nothing was added, or the refinement failed.
    """

    rms_floor: float
    accepted: bool
    rms_refined: float | None
    removed: float | None
    harms: bool | None
    refine_error: str | None
    rms_base: float
    base_by: str
    avoidable: bool


def measure_refinement(module: Any, diagnosis: Any, answer: Answer, campaign: Campaign) -> Refinement:
    """Refine with the effects of an answer and compare held-out errors.

    Parameters
    ----------
    module : module
        Has ``refine(data, tests, model="linear", add=[...])``.
    diagnosis : object
        Answer as given.
    answer : Answer
        Answer as read.
    campaign : Campaign
        Data and truth.
    """
    size = DOMAINS[campaign.record["domain"]].size
    truth = campaign.heldout_mu
    tests, seen_tests = campaign.tests, campaign.heldout_tests if campaign.tests is not None else None
    try:
        base = module.refine(campaign.data, tests, model="linear", add=[])
        before, base_by = rms(base.predict_frame(campaign.heldout_data, seen_tests), truth), "refine"
    except Exception as error:
        before, base_by = rms(campaign.linear_mu, truth), f"own fit ({type(error).__name__})"
    floor = rms(campaign.floor_mu, truth)
    gain = before - floor
    out: Refinement = {
        "rms_floor": floor,
        "accepted": False,
        "rms_refined": None,
        "removed": None,
        "harms": None,
        "refine_error": None,
        "rms_base": before,
        "base_by": base_by,
        "avoidable": bool(gain > SMALLEST_GAIN * size and campaign.record["laws"]),
    }
    effects = _raw_effects(diagnosis)
    if not effects or answer.verdict not in (*ACCEPTING, "ambiguous"):
        return out
    out["accepted"] = answer.verdict in ACCEPTING
    try:
        model = module.refine(campaign.data, tests, model="linear", add=effects)
        after = rms(model.predict_frame(campaign.heldout_data, seen_tests), truth)
    except Exception as error:
        out["refine_error"] = f"{type(error).__name__}: {error}"[:300]
        return out
    out["rms_refined"] = after
    out["harms"] = bool(after - before > max(HARM_SHARE * before, HARM_SIZE * size))
    if out["avoidable"]:
        # Bounded below, so that a prediction that is not finite still counts.
        out["removed"] = max(1.0 - (after - floor) / gain, -10.0)
    return out
