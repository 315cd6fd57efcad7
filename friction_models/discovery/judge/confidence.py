"""How sure a verdict is: the share of such answers that are right over made-up campaigns.

``python -m benchmarks.prior`` draws campaigns of a broad prior (laws, plans and noises of its own), diagnoses them, and fits one
logistic regression for each kind of verdict to `grounds`; where an effect is named, campaigns of two other authors count as much, and
of other answers these say how often they are right in all.
Its numbers stand here; how well they hold on other campaigns stands in ``docs/benchmarks.md``.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import numpy as np
from scipy.special import expit

from ...common.wording import listed
from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.campaign.clipping import clipped_share
from ...estimation.search.search_round import SearchRound
from ...estimation.search.unseen_loads import EITHER
from ...estimation.search.zero_reading import ZERO, credible
from .confirmation import ANOTHER_FORM, EXPLAINED, NAMED, Confirmation
from .error_budget import LEAST_TESTS
from .identifiability import one_load, standing_in
from .naming.names import CLEAR
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
#: An answer with a reason to doubt it is right in three of four cases, or less is known of it than that.
MOST_DOUBTED = 0.75
#: Of fewer tests chance makes a name rather often, as they leave few numbers for it beside a model.
FEW_TESTS = 12
#: So many effects of the catalogue together draw nearly any curve.
MANY = 3
#: Less than this share of the squared error on unseen tests is little.
LITTLE = 0.1
#: Share of the points at which mu was clipped from which on nothing can be said to be missing: it would lie beyond the clip.
MOST_CLIPPED = 0.1
#: A noise floor above this share of mu hides everything else.
BLURRED = 0.5
#: Of points outside the domain of a model, and of spikes: these are counted, not judged.
COUNTED = 0.9
#: Kind of verdict -> intercept and weights of its grounds.
WEIGHTS: dict[str, tuple[float, dict[str, float]]] = {
    "named": (0.13, {"certain": 0.46, "gap": 1.24}),
    "ambiguous": (-1.44, {"certain": 0.39, "held": 0.54}),
    "unknown_structure": (0.08, {"reference": 0.64, "missing": 0.02, "log_tests": -0.39}),
    "nothing_missing": (-1.54, {"seen": -0.69, "log_tests": 1.44, "missing": -1.15, "structure": -0.84}),
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
        "seen": _powers(evidence.p_value),
        "certain": float(np.clip(confirmed.certain, 0.0, MOST_CERTAIN)),
        "gap": _gap(found, held),
        "missing": shares.missing / shares.base if shares is not None and shares.base > 0.0 else 0.0,
        "held": float(len(held)),
        "left": shares.left if shares is not None else 0.0,
        "reference": min(shares.certainty, MOST_SURE) if shares is not None else 0.0,
        "beyond": min(shares.beyond, MOST_SURE) if shares is not None else 0.0,
        "structure": _powers(evidence.structure.p_value),
        "log_tests": float(np.log(tests)),
    }


def _powers(p: float) -> float:
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
    if verdict in NAMED and grounds["left"] > EXPLAINED:
        high = MOST_PARTLY
    elif verdict in NAMED and grounds["beyond"] > ANOTHER_FORM:
        high = MOST_IN_ANOTHER_FORM
    elif verdict == "nothing_missing" and grounds["seen"] > _powers(LEVEL):
        high = MOST_WHERE_ONE_STANDS_OUT
    return float(np.clip(expit(score), low, high))


class Sureness(NamedTuple):
    """How sure a verdict is, 0 to 1, and why no surer."""

    value: float
    #: What holds it back, where something does; each completes "the confidence is held because ...".
    held_by: tuple[str, ...] = ()


def sureness(
    campaign: BinnedTests,
    found: SearchRound,
    confirmed: Confirmation,
    grounds: dict[str, float],
    *,
    off: float | None,
    grouped: bool,
    knows_noise: bool,
    odd_kept: bool,
    unread: bool,
    on_one: bool,
    other_cause: bool,
    one_explains: bool,
    as_it_is: bool,
    codes: bool,
) -> Sureness:
    """Return how sure a verdict is by its grounds; half as sure, or a little, where these data cannot show more.

    `off` is the p-value of the level of a model as it is, where that is wrong; the tests may be `grouped` by what was not recorded, in
    two groups or in the order of the runs, the model `knows_noise` of these points, tests that lie far off be `odd_kept`, an offset of the force be `unread` beside other
    names, a name rest `on_one` test, or have an `other_cause` that does as well: a jump in the order, another law along the load. Of the
    catalogue `one_explains` what is missing, though it is not named. A law of the loads may be taken `as_it_is`, its form unknown.
    Most may be left along numbers that are `codes` of something.
    """
    verdict, own = confirmed.verdict, confirmed.own_form_explains
    nothing, named = verdict == "nothing_missing", verdict in NAMED
    sure = LIMITS[1] if confirmed.within_resolution else confidence(verdict, grounds)
    if off is not None and verdict == "unknown_structure":
        sure = max(sure, min(1.0 - off, LIMITS[1]))
    too_large = not all(credible(campaign, found.floor.sensor, f) for f in confirmed.chosen)
    hidden = blurred(campaign, found, confirmed) and (nothing or (named and drowned(confirmed)))
    unsure = {
        "nothing says how much these tests scatter": not found.floor.known,
        f"there are fewer than {LEAST_TESTS} tests": nothing and len(campaign.tests) < LEAST_TESTS,
        "the noise is more than half of mu": hidden,
        "many readings of mu were clipped": nothing
        and clipped_share(campaign.mu, campaign.point_test) > MOST_CLIPPED,
        # of 118 such answers where nothing was hidden none had it
        "flexible curves predict unseen tests a little better": nothing and grounds["reference"] > 0.0,
        "tests that lie far off hide what is missing": nothing and odd_kept,
        "tests differ by something that was not recorded": nothing and grouped,
        "settings differ by more than their repeats": (nothing and confirmed.lacks_fit)
        or (verdict == "unknown_structure" and off is None and confirmed.by_repeats),
        "the model knows the noise of these points": knows_noise,
        "a jump of the tests or another law along the load does as well": other_cause,
        # of five such answers to the campaigns of another author none was right
        "three names or more draw whatever form a law that is not fitted may lack": as_it_is
        and len(confirmed.chosen) >= MANY,
        "nearly all of the error is that of the model's level": named
        and off is not None
        and takes_little(confirmed),
        "the model itself could do as well": bool(confirmed.own_form) or (own is not None and not own.effect),
        # as likely a law of pressure
        "no cell is off by as much": too_large and [f.name for f in confirmed.chosen] == [ZERO],
    }
    doubted = {
        "one effect would explain what is missing, if the model had another form": own is not None,
        # of 59 such answers to some thousand made-up campaigns 43 were right
        "a load of what is named goes with another one in these tests": named
        and any(one_load(campaign, f.effect.driver) for f in confirmed.chosen),
        # six of forty straight laws in nine tests had a name
        f"there are fewer than {FEW_TESTS} tests, and the search is not sure": named
        and len(campaign.tests) < FEW_TESTS
        and grounds["seen"] < _powers(CLEAR),
        "a name rests on one test": on_one,  # of 23 such answers 17 were right
        # they draw a law their way, and swell the floor: of five names four were right
        "tests lie far off all others": odd_kept,
        # if not for certain: of ten such answers about half were right
        "two laws of one load each do as well": bool(confirmed.parts),
        "a product of two loads does as well": bool(confirmed.products),
        "one name may only mend the form of another": bool(standing_in(found, confirmed.chosen)),
        "what is named takes little of the error": named and takes_little(confirmed),
        # of 47 answers of several names to campaigns of another author seven had one, and all were wrong
        f"{listed(confirmed.little)} may only mend the form of the others": bool(confirmed.little),
        # of thirteen such answers to campaigns of three authors eight were right
        "one effect would explain what is missing, if its form were another": one_explains,
        "the numbers of a column may be names": codes,
        # an effect of pressure, perhaps, until the cell is read without load
        "the zero of the force was not read": unread or too_large,
    }
    most, reasons = (EITHER, unsure) if any(unsure.values()) else (MOST_DOUBTED, doubted)
    if sure <= most or not any(reasons.values()):
        return Sureness(sure)
    return Sureness(most, tuple(reason for reason, holds in reasons.items() if holds))


def takes_little(confirmed: Confirmation) -> bool:
    """Return whether what is named takes next to nothing of the error of the model: the form of the model itself may be off by it."""
    shares = confirmed.shares
    return shares is not None and shares.base - shares.named < LITTLE * shares.base


def drowned(confirmed: Confirmation) -> bool:
    """Return whether what can be predicted beyond the model is less than what cannot."""
    shares = confirmed.shares
    return shares is None or shares.base < 2.0 * shares.best


def blurred(campaign: BinnedTests, found: SearchRound, confirmed: Confirmation) -> bool:
    """Return whether the noise hides everything: what unseen tests do not predict, or where none can be left out that of the search."""
    noise = found.floor.total if confirmed.shares is None else float(np.sqrt(confirmed.shares.best))
    return noise >= BLURRED * float(np.mean(campaign.mu))  # also where mu is nothing
