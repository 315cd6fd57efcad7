"""Warnings beside a verdict: what speaks against it, what could hide, and noise that hides everything."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...common.wording import counted, listed
from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.search.scan import Fit
from ...estimation.search.search_round import SearchRound
from ...loads import LOAD_NAMES
from ..judge.confirmation import NAMED, Confirmation
from ..judge.doubts import LITTLE, Sureness, takes_little
from ..judge.identifiability import standing_in
from ..judge.verdict import LEVEL
from .wording import mu_format, settings_text

#: Share of mu from which on what could hide is said.
MATTERS = 0.25
#: Tests that change along their path by more than this share of mu, each in a way of its own, and by so many times the sensor's noise, wander.
WANDERS, BEYOND_SENSOR = 0.1, 3.0


def stands_out(found: SearchRound, confirmed: Confirmation) -> Fit | None:
    """Return the effect that is significant though nothing is named; none where no measurement could show that it is there."""
    winner = found.winner
    if confirmed.verdict != "nothing_missing" or confirmed.within_resolution or winner is None:
        return None
    return winner if found.p_value(winner) < LEVEL else None


def held(sure: Sureness) -> list[str]:
    """Return what holds the confidence of an answer, if something does.

    Examples
    --------
    >>> held(Sureness(0.85, ("a name rests on one test",)))
    ['the confidence is held at 0.85: a name rests on one test']
    """
    return [f"the confidence is held at {sure.value:g}: {listed(sure.held_by)}"] if sure.held_by else []


def reservations(
    campaign: BinnedTests, found: SearchRound, confirmed: Confirmation, knows_noise: bool, unsure: bool
) -> list[str]:
    """Return what speaks against taking the verdict for the whole truth, and which tests would tell more.

    The model `knows_noise` of these points; where the verdict is `unsure`, more tests would tell.
    """
    verdict = confirmed.verdict
    varied = [n for n in LOAD_NAMES if n != "sd" and campaign.varies(n)]
    said = []
    if confirmed.lacks_fit and (repeats := confirmed.repeats) is not None:
        said.append(
            f"{settings_text(repeats.to_dict())}: their mu agrees to {repeats.scatter:{mu_format(repeats.scatter, 4)}}, but what the model leaves "
            f"differs by more from setting to setting (p = {repeats.p_value:.3f}): it depends on the settings, or on the day they "
            "were tested, in a way that is not named here"
        )
    if confirmed.of_another_form and verdict != "partly_explained":
        little = (
            ""
            if confirmed.shares is not None and confirmed.shares.missing > 0.0
            else ", if by too little to count"
        )
        said.append(
            f"a flexible prediction that knows no formula is better on unseen tests than what is named{little}: the law may have another "
            "form, or be another effect that looks alike here"
        )
    said += [
        f"in the place of {name}, {listed(pair)} together predict unseen tests no worse: whether the loads act together or each by "
        "itself, more tests would tell at crossed levels of them"
        for name, pair in confirmed.parts.items()
    ]
    said += [
        f"in the place of {name}, the plain product of {first} and {second} predicts unseen tests as well, or better, if not for certain: the law "
        "may have another form"
        for name, (first, second) in confirmed.products.items()
    ]
    said += [
        f"in the place of {name}, the model itself predicts unseen tests about as well with {listed(beside)}, which no fit of it does: it may lack "
        "that, and no effect"
        for name, beside in confirmed.own_form.items()
    ]
    if confirmed.own_law:
        said.append(
            f"{confirmed.own_law}, beyond what an offset of that level can be: look at them by themselves, and run the next tests with it and with another one"
        )
    if confirmed.by_powers:
        said.append(
            f"in the place of {listed(confirmed.by_powers)}, a power law of the loads predicts unseen tests about as well as the straight law does with it: "
            "the loads may multiply, and no effect be missing; try the model power_law"
        )
    if (explains := confirmed.own_form_explains) is not None:
        beside = f"{explains.effect} and " if explains.effect else ""
        said.append(
            f"with {beside}{listed(explains.own)}, which no fit of the model does, it predicts unseen tests about as well as anything does: that may "
            "be what is missing"
        )
    said += [
        f"{first} and {second} each alone change mu much where the other does: the one may only mend the form of the other, which "
        f"{_telling(confirmed.chosen, first, second)} tell"
        for first, second in standing_in(found, confirmed.chosen)
    ]
    if verdict in NAMED and takes_little(confirmed.shares):
        said.append(
            f"what is named takes less than {100 * LITTLE:.0f} % of the squared error of the model: its own form may be off by that much, and "
            "predictions hardly gain by the addition"
        )
    drift, mu = found.floor.drift, float(np.mean(np.abs(campaign.mu)))
    if verdict == "nothing_missing" and drift > max(WANDERS * mu, BEYOND_SENSOR * found.floor.sensor):
        said.append(
            f"along their path the tests change by {drift:.2g} (rms), {100 * drift / mu:.0f} % of mu, each in a way of its own that no load explains: "
            "look at the curves of single tests"
        )
    if (first := stands_out(found, confirmed)) is not None:
        said.append(
            f"{first.name} stands out (p = {found.p_value(first):.3f}), but lowers the error on tests that a fit did not see "
            f"too little to be named; there are {len(campaign.tests)} tests: more of them would tell"
        )
    elif verdict == "nothing_missing" and unsure and not (confirmed.lacks_fit or knows_noise) and varied:
        said.append(
            f"{counted(len(campaign.tests), 'test')} cannot rule an effect out: more would tell, at other levels of "
            f"{', '.join(varied)}, and some of them repeated, to show the scatter between tests"
        )
    return said


def could_hide(hidden: dict[str, tuple[float, float]], mu: float) -> list[str]:
    """Return a warning where effects that matter would not have been seen, with their sizes and loads; `hidden` as of `unseen_sizes`."""
    if max((most for _, most in hidden.values()), default=0.0) < MATTERS * mu:
        return []
    said = []
    largest_first = sorted(hidden, key=lambda name: hidden[name][1], reverse=True)
    if seen := [name for name in largest_first if hidden[name][1] < mu]:
        sizes = ", ".join(f"{hidden[name][1]:.2g} with {name}" for name in seen)
        said.append(
            f"smaller effects may be there: tests like these show an effect in most cases only if mu ({mu:.2g} on average) changes "
            f"over them by {sizes}, or more, counting what the model takes of it"
        )
    if partly := sorted(name for name in hidden if hidden[name][0] < mu <= hidden[name][1]):
        sizes = ", ".join(f"{hidden[name][0]:.2g} with {name}" for name in partly)
        said.append(
            f"an effect of {' or '.join(partly)} shows in tests like these from changes of mu by {sizes} on at best; one whose form the model "
            f"takes most of would have to change mu by more than mu itself ({mu:.2g} on average)"
        )
    if blind := sorted(name for name in hidden if mu <= hidden[name][0]):
        said.append(
            f"an effect of {' or '.join(blind)} would not show in tests like these: it would have to change mu by more than mu itself "
            f"({mu:.2g} on average)"
        )
    return said


def about_the_noise(campaign: BinnedTests, hides: float | None) -> list[str]:
    """Return warnings where averages are not trusted, and where a noise floor `hides` everything."""
    said = []
    if (off := campaign.distrusted) is not None:
        said.append(
            f"{int(off.sum())} of {len(off)} averages lie far off the rest of their test: the fit gives them no weight, budget and noise floor count them"
        )
    if hides is not None:
        said.append(
            f"the noise floor ({hides:.3g}) is more than half of mu itself ({np.mean(campaign.mu):.3g}): look for outliers "
            "and faulty tests first, little else can be seen in such data"
        )
    return said


def _telling(chosen: Sequence[Fit], first: str, second: str) -> str:
    """Return which tests tell two names apart: where both follow the same loads, no plan of loads does."""
    one, other = ({*f.effect.driver} for name in (first, second) for f in chosen if f.name == name)
    return "longer tests" if one == other else "tests that change their loads apart from each other"
