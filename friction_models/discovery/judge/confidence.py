"""How sure a verdict is that nothing speaks against: the share of such answers that are right.

``python -m benchmarks.prior`` draws campaigns of a broad prior (laws, plans and noises of its own), diagnoses them, and fits one
logistic regression for each kind of verdict to `grounds`; where an effect is named, campaigns of two other authors count as much.
The intercepts, one number for each kind, come from the answers to campaigns of five authors that nothing speaks against, every author
with the same weight. How well all this holds stands in ``docs/benchmarks.md``.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from scipy.special import expit

from ...estimation.search.search_round import SearchRound
from .confirmation import ANOTHER_FORM, EXPLAINED, NAMED, Confirmation
from .verdict import LEVEL, Evidence

#: Standard errors of an effect and of the reference, and powers of ten, beyond which nothing becomes surer.
MOST_CERTAIN, MOST_SURE, MOST_SEEN = 6.0, 10.0, 2.7
#: No answer of a prior that is finite is surer than this, or less sure.
LIMITS = (0.02, 0.98)
#: What is named beside something else that is missing is right less often: 19 of 30 such answers to the campaigns of three authors
#: were, too few to fit weights to; each author with the same weight this is 0.75.
MOST_PARTLY = 0.75
#: Where the reference predicts better, however little, the form is another one, and perhaps the effect: of 99 such answers to the
#: campaigns of three authors 94 were right.
MOST_IN_ANOTHER_FORM = 0.94
#: Nothing is named although an effect stands out among all of the catalogue (p below 5 %), too weak to help on unseen tests: of
#: 15 such answers to the campaigns of three authors 13 were right.
MOST_WHERE_ONE_STANDS_OUT = 0.85
#: Of points outside the domain of a model, and of spikes: these are counted, not judged.
COUNTED = 0.9
#: Kind of verdict -> intercept and weights of its grounds.
WEIGHTS: dict[str, tuple[float, dict[str, float]]] = {
    "named": (0.72, {"certain": 0.46, "gap": 1.24}),
    "ambiguous": (-0.34, {"certain": 0.39, "held": 0.54}),
    "unknown_structure": (0.36, {"reference": 0.64, "missing": 0.02, "log_tests": -0.39}),
    "nothing_missing": (-1.52, {"seen": -0.69, "log_tests": 1.44, "missing": -1.15, "structure": -0.84}),
}


def grounds(found: SearchRound, evidence: Evidence, confirmed: Confirmation, tests: int) -> dict[str, float]:
    """Return what the confidence rests on.

    Returns
    -------
    dict of str to float
        ``seen``: minus log10 of the p-value of the first effect. ``certain``: standard errors by which the last name lowers
        the error on unseen tests. ``gap``: lead in evidence over the best effect that the answer does not hold, as a share.
        ``missing``: share of the squared error of the base. ``left``: share of what can be predicted.
        ``held``: names that the answer holds, rivals included. ``reference``: standard errors by which the
        flexible reference is better. ``structure``: minus log10 of the p-value of structure. ``log_tests``: logarithm of the
        number of tests.
    """
    shares = confirmed.shares
    held = {*(f.name for f in confirmed.chosen), *confirmed.rivals, *evidence.confusion_set}
    return {
        "seen": powers_of_ten(evidence.p_value),
        "certain": float(np.clip(confirmed.certain, 0.0, MOST_CERTAIN)),
        "gap": _gap(found, held),
        "missing": shares.missing / shares.base if shares is not None and shares.base > 0.0 else 0.0,
        "held": float(len(held)),
        "left": shares.left if shares is not None else 0.0,
        "reference": min(shares.certainty, MOST_SURE) if shares is not None else 0.0,
        "beyond": min(shares.beyond, MOST_SURE) if shares is not None else 0.0,
        "structure": powers_of_ten(evidence.structure.p_value),
        "log_tests": float(np.log(tests)),
    }


def powers_of_ten(p: float) -> float:
    """Return by how many powers of ten a p-value lies below one, as far as that makes an answer surer."""
    return float(np.clip(-np.log10(max(p, 1e-9)), 0.0, MOST_SEEN))


def _gap(found: SearchRound, held: Collection[str]) -> float:
    """Return the lead in evidence over the best effect that is not held, as a share of that of the first one."""
    first = max((f.evidence for f in found.ranking[:1]), default=0.0)
    others = [f.evidence for f in found.ranking if f.name not in held]
    if not others:
        return 1.0
    if first <= 0.0:  # only unseen tests speak for what is named
        return 0.0
    return float(np.clip((first - max(others)) / first, 0.0, 1.0))


def confidence(verdict: str, grounds: dict[str, float]) -> float:
    """Return the share of such answers that are right.

    Examples
    --------
    >>> grounds = {"seen": 2.7, "certain": 6.0, "gap": 0.8, "beyond": 0.0, "left": 0.0, "log_tests": 3.7}
    >>> confidence("explained", grounds) > confidence("explained", {**grounds, "certain": 1.0})
    True
    """
    kind = verdict if verdict in WEIGHTS else "named" if verdict in NAMED else None
    if kind is None or (verdict == "data_problem" and not grounds["certain"]):
        return COUNTED
    intercept, weights = WEIGHTS[kind]
    score = intercept + sum(weight * grounds[name] for name, weight in weights.items())
    low, high = LIMITS
    if verdict == "partly_explained" or (verdict in NAMED and grounds["left"] > EXPLAINED):
        high = MOST_PARTLY
    elif verdict in NAMED and grounds["beyond"] > ANOTHER_FORM:
        high = MOST_IN_ANOTHER_FORM
    elif verdict == "nothing_missing" and grounds["seen"] > powers_of_ten(LEVEL):
        high = MOST_WHERE_ONE_STANDS_OUT
    return float(np.clip(expit(score), low, high))


def undoubted(confirmed: Confirmation, grounds: dict[str, float], off: float | None) -> float:
    """Return how sure a verdict would be without doubts; `off` is the p-value of the level of a model as it is, where that is wrong."""
    if confirmed.within_resolution:
        return LIMITS[1]
    sure = confidence(confirmed.verdict, grounds)
    if off is not None and confirmed.verdict == "unknown_structure":
        return max(sure, min(1.0 - off, LIMITS[1]))
    return sure
