"""What an accepted addition does to tests the model has not seen."""

from __future__ import annotations

from typing import Any

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


def measure_refinement(module: Any, diagnosis: Any, answer: Answer, campaign: Campaign) -> dict[str, Any]:
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

    Returns
    -------
    dict
        ``rms_floor, rms_base, base_by, rms_refined, accepted, removed, harms, refine_error``.
    """
    size = DOMAINS[campaign.record["domain"]].size
    truth = campaign.heldout_mu
    out: dict[str, Any] = {
        "rms_floor": rms(campaign.floor_mu, truth),
        "accepted": False,
        "rms_refined": None,
        "removed": None,
        "harms": None,
        "refine_error": None,
    }
    tests, seen_tests = campaign.tests, campaign.heldout_tests if campaign.tests is not None else None
    try:
        base = module.refine(campaign.data, tests, model="linear", add=[])
        out["rms_base"], out["base_by"] = (
            rms(base.predict_frame(campaign.heldout_data, seen_tests), truth),
            "refine",
        )
    except Exception as error:
        out["rms_base"], out["base_by"] = rms(campaign.linear_mu, truth), f"own fit ({type(error).__name__})"
    gain = out["rms_base"] - out["rms_floor"]
    out["avoidable"] = bool(gain > SMALLEST_GAIN * size and campaign.record["laws"])
    effects = _raw_effects(diagnosis)
    if not effects or answer.verdict not in (*ACCEPTING, "ambiguous"):
        return out
    out["accepted"] = answer.verdict in ACCEPTING
    try:
        model = module.refine(campaign.data, tests, model="linear", add=effects)
        out["rms_refined"] = rms(model.predict_frame(campaign.heldout_data, seen_tests), truth)
    except Exception as error:
        out["refine_error"] = f"{type(error).__name__}: {error}"[:300]
        return out
    worse = out["rms_refined"] - out["rms_base"]
    out["harms"] = bool(worse > max(HARM_SHARE * out["rms_base"], HARM_SIZE * size))
    if out["avoidable"]:
        # Bounded below, so that a prediction that is not finite still counts.
        out["removed"] = max(1.0 - (out["rms_refined"] - out["rms_floor"]) / gain, -10.0)
    return out
