"""What speaks against an answer, and how often answers like it are right all the same."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...common.wording import listed
from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.campaign.clipping import clipped_share
from ...estimation.campaign.metadata import MANY_EMPTY, is_text, share_empty
from ...estimation.search.base_law import BaseLaw
from ...estimation.search.zero_reading import ZERO, credible
from .confidence import powers_of_ten
from .confirmation import NAMED, Confirmation
from .error_budget import LEAST_TESTS, ErrorShares
from .identifiability import one_load, standing_in
from .judged import Judged
from .naming.names import CLEAR

#: Answers with such a reason to doubt them are right about as often as not, in two of three cases, and in five of six.
EVEN, LIKELY, MOSTLY = 0.5, 0.7, 0.85
#: Nobody read the force without load: an offset of it may as well be an effect of pressure.
ZERO_UNREAD = "the zero of the force was not read"
#: Of fewer tests chance makes a name rather often, as they leave few numbers for it beside a model.
FEW_TESTS = 16
#: So many effects of the catalogue together draw nearly any curve.
MANY = 3
#: Less than this share of the squared error on unseen tests is little.
LITTLE = 0.1
#: Share of the points at which mu was clipped from which on nothing can be said to be missing: it would lie beyond the clip.
MOST_CLIPPED = 0.1
#: Of 108 campaigns without anything hidden the error on unseen tests was nowhere so many times the noise of the search.
FAR_ABOVE = 2.0
#: Nothing is named although the reference predicts better by so many standard errors, too few to be believed: of 67 such answers to
#: campaigns of four authors 56 were right.
BEYOND = 2.0
#: A noise floor above this share of mu hides everything else.
BLURRED = 0.5


class Doubt(NamedTuple):
    """A reason to doubt an answer."""

    reason: str  #: Completes "the confidence is held at 0.7: ...".
    most: float  #: The answer is no surer than this.


class Sureness(NamedTuple):
    """How sure a verdict is, 0 to 1, and why no surer."""

    value: float
    #: What holds it back, where something does; each completes "the confidence is held at 0.7: ...".
    held_by: tuple[str, ...] = ()


def least(doubts: Sequence[Doubt]) -> float:
    """Return how sure the worst doubt lets an answer be; 1 without doubts."""
    return min((d.most for d in doubts), default=1.0)


def sureness(sure: float, doubts: Sequence[Doubt]) -> Sureness:
    """Return how sure an answer is that would be `sure` without doubts: as sure as the worst of them lets it be.

    Examples
    --------
    >>> sureness(0.95, [Doubt("the zero was not read", 0.7), Doubt("a name rests on one test", 0.85)])
    Sureness(value=0.7, held_by=('the zero was not read',))
    >>> sureness(0.6, [Doubt("a name rests on one test", 0.85)])
    Sureness(value=0.6, held_by=())
    """
    most = least(doubts)
    if sure <= most:
        return Sureness(sure)
    return Sureness(most, tuple(dict.fromkeys(d.reason for d in doubts if d.most == most)))


def doubts_of(
    campaign: BinnedTests, base: BaseLaw, judged: Judged, grounds: Mapping[str, float], level_is_off: bool
) -> list[Doubt]:
    """Return what of the search and of the unseen tests speaks against a verdict.

    `grounds` are those of its confidence; the level of a model that is taken as it is may be off.
    """
    verdict = judged.verdict
    doubts = _doubts(
        # they draw a law their way, and swell the floor: of five names four were right
        (judged.odd_kept, MOSTLY, "tests lie far off all others"),
        (judged.knows_noise, EVEN, "the model knows the noise of these points"),
        (bool(judged.confirmed.own_law), LIKELY, judged.confirmed.own_law),
        (not judged.found.floor.known, EVEN, "nothing says how much these tests scatter"),
    )
    if verdict == "nothing_missing":
        return [*doubts, *_of_nothing(campaign, judged, grounds)]
    if verdict == "unknown_structure":
        return [*doubts, *_of_no_name(judged.confirmed, level_is_off)]
    if verdict in NAMED:
        return [*doubts, *_of_names(campaign, base, judged, grounds["seen"], level_is_off)]
    return doubts


def _doubts(*each: tuple[bool, float, str]) -> list[Doubt]:
    """Return the doubts that hold."""
    return [Doubt(reason, most) for holds, most, reason in each if holds]


def _of_nothing(campaign: BinnedTests, judged: Judged, grounds: Mapping[str, float]) -> list[Doubt]:
    few = len(campaign.tests) < LEAST_TESTS
    clipped = clipped_share(campaign.mu, campaign.point_test) > MOST_CLIPPED
    shares = judged.confirmed.shares
    better = grounds["reference"] > 0.0 or grounds["beyond"] > BEYOND
    above = shares is not None and float(np.sqrt(shares.best)) > FAR_ABOVE * judged.found.floor.total
    return _doubts(
        (few, LIKELY, f"there are fewer than {LEAST_TESTS} tests"),
        (blurred(campaign, judged), LIKELY, "the noise is more than half of mu"),
        (above, LIKELY, "unseen tests lie off by far more than the others scatter"),
        (clipped, EVEN, "many readings of mu were clipped"),
        (_hardly_recorded(campaign), LIKELY, "a column of the test table is not recorded for many tests"),
        (better, MOSTLY, "flexible curves predict unseen tests a little better"),
        (judged.odd_kept, LIKELY, "tests that lie far off hide what is missing"),
        (judged.odd_region, LIKELY, "tests that were left out lie together, where a law may begin"),
        (judged.confirmed.lacks_fit, LIKELY, "settings differ by more than their repeats"),
    )


def _hardly_recorded(campaign: BinnedTests) -> bool:
    """Return whether a text is not recorded for many tests, which hides what its levels do."""
    texts = (name for name in campaign.system if is_text(campaign.loads, name))
    return any(share_empty(campaign.loads, name) > MANY_EMPTY for name in texts)


def _of_no_name(confirmed: Confirmation, level_is_off: bool) -> list[Doubt]:
    own, by_repeats = confirmed.own_form_explains, confirmed.by_repeats and not level_is_off
    return _doubts(
        (by_repeats, LIKELY, "settings differ by more than their repeats"),
        (own is not None and not own.effect, EVEN, "the model itself could do as well"),
        (own is not None, MOSTLY, "one effect would explain what is missing, if the model had another form"),
    )


def _of_names(
    campaign: BinnedTests, base: BaseLaw, judged: Judged, seen: float, level_is_off: bool
) -> list[Doubt]:
    confirmed, chosen, little = judged.confirmed, judged.chosen, listed(judged.confirmed.little)
    hidden = blurred(campaign, judged) and drowned(confirmed.shares)
    too_large = not all(credible(campaign, judged.found.floor.sensor, f) for f in chosen)
    few = len(campaign.tests) < FEW_TESTS and seen < powers_of_ten(CLEAR)
    along_another = any(one_load(campaign, f.effect.driver) for f in chosen)
    in_form = bool(standing_in(judged.found, chosen))
    takes, many = takes_little(confirmed.shares), len(chosen) >= MANY
    as_it_is = base.fixed and bool(np.ptp(base.offset) > 0.0)
    return _doubts(
        (hidden, EVEN, "the noise is more than half of mu"),
        (bool(confirmed.own_form), EVEN, "the model itself could do as well"),
        # as likely a law of pressure
        (too_large and [f.name for f in chosen] == [ZERO], EVEN, "no cell is off by as much"),
        (too_large, MOSTLY, ZERO_UNREAD),
        # of 59 such answers to some thousand made-up campaigns 43 were right
        (along_another, LIKELY, "a load of what is named goes with another one in these tests"),
        # six of forty straight laws in nine tests had a name
        (few, MOSTLY, f"there are fewer than {FEW_TESTS} tests, and the search is not sure"),
        (bool(confirmed.parts), MOSTLY, "two laws of one load each do as well"),
        # of seven such answers to campaigns of three authors two were right
        (bool(confirmed.products), EVEN, "a product of two loads does as well"),
        (bool(confirmed.by_powers), LIKELY, "a power law of the loads does as well"),
        (in_form, EVEN, "one name may only mend the form of another"),  # of six, three
        (takes, MOSTLY, "what is named takes little of the error"),
        # of seven, two
        (bool(little), EVEN, f"{little} may only mend the form of the others"),
        # of five such answers to the campaigns of another author none was right
        (as_it_is and many, EVEN, "three names or more draw whatever form a law that is not fitted may lack"),
        (level_is_off and takes, EVEN, "nearly all of the error is that of the model's level"),
    )


def takes_little(shares: ErrorShares | None) -> bool:
    """Return whether what is named takes next to nothing of the error of the model: the form of the model itself may be off by it."""
    return shares is not None and shares.base - shares.named < LITTLE * shares.base


def drowned(shares: ErrorShares | None) -> bool:
    """Return whether what can be predicted beyond the model is less than what cannot."""
    return shares is None or shares.base < 2.0 * shares.best


def blurred(campaign: BinnedTests, judged: Judged) -> bool:
    """Return whether the noise hides everything: what unseen tests do not predict, or where none can be left out that of the search."""
    shares = judged.confirmed.shares
    noise = judged.found.floor.total if shares is None else float(np.sqrt(shares.best))
    return noise >= BLURRED * float(np.mean(campaign.mu))  # also where mu is nothing
