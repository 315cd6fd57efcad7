"""Effects that these tests cannot tell from what is named, and which of the names leads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ....estimation.campaign.binned_tests import BinnedTests
from ....estimation.campaign.factors import factors_like
from ....estimation.search.importance import LEAST_SHARE
from ....estimation.search.rivalry import rivalry
from ....estimation.search.scan import Fit
from ....estimation.search.search_round import EQUAL, SearchRound
from ....estimation.search.significance import TWINS
from ....estimation.search.significance import alike as contribute_alike
from ....estimation.search.unseen_loads import AS_GOOD, constant
from ....estimation.search.zero_reading import credible
from ..beside_reference import effects_of
from ..error_budget import fall
from ..identifiability import one_cause
from .straight_fits import StraightFits

#: An effect must beat what could stand in its place by so many standard errors on unseen tests.
APART = 1.7
#: Share of what a named effect takes, from the fit or from the error on unseen tests, below which another one is no rival.
WORTH = 0.25
#: A rival of at least this share of the gain of the first effect stays where the tests do not prefer the first by so many
#: standard errors, formulas being as wrong as the leads of single tests show.
AS_LIKELY, AGREED = 0.5, 1.0
#: By so many standard errors, and by enough to matter, unseen tests leave a rival behind, whatever a lead in evidence may owe to formulas.
BEHIND = 3.0
#: By so many they do where the leads of single tests agree by as many: two views of the same data that can be wrong in other ways.
BEHIND_IN_BOTH = 2.0
#: From so many standard errors of agreement on, averages of unseen tests need prefer it by `AGREED` only.
IN_ALL_TESTS = 5.0
#: P-value of a name from which on the noise of the search holds it: gains tell no effect from another then, unseen tests alone do.
DROWNED = 0.2
#: Correlation of what two effects contribute, where one of fewer loads may stand for one of more.
NEARLY_ALIKE = 0.9
#: A memory of loads that no test changes takes more than this share of the squared error on unseen tests, or is not named.
UNSEEN_MEMORY = 0.05


class Further(Protocol):
    """Searches for further effects beside those given, significant at a level; the best first."""

    def __call__(self, known: Sequence[Fit], level: float = ...) -> list[Fit]: ...


@dataclass(frozen=True)
class Rivals:
    """Compares what is named with what could stand in its place."""

    campaign: BinnedTests
    found: SearchRound
    straight: StraightFits
    further: Further

    def of(self, kept: Sequence[Fit], missing: float) -> dict[str, list[str]]:
        """Return for each name the effects that would leave hardly more in its place, or that some tests prefer to it.

        What the scan prefers to a name that stands alone is a rival of it. A lead below what is `missing`, though it can be predicted, may be a matter of formulas;
        so is any lead over an effect of a load that is the same in these tests, or over a column that has the same levels.
        """
        if not kept:
            return {}
        first, *others = kept
        names = {f.name for f in kept}
        own = self.straight.errors(kept)
        unseen_only = self.found.p_value(first) > DROWNED
        tried = [
            f
            for f in self.found.ranking
            if (unseen_only or f.gain > WORTH * first.gain)
            and f.name not in names
            and not self.found.just(first, f)
        ]
        found: dict[str, list[str]] = {f.name: [] for f in kept}
        for f in tried:
            instead = [f, *others]
            as_good = missing > 0.0 and (self.straight.errors(instead).rms ** 2 - own.rms**2 < missing)
            tied = one_cause(self.campaign, first.effect.driver, f.effect.driver)
            comparable = unseen_only or f.gain > AS_LIKELY * first.gain
            likely = as_good or (comparable and not self._led(kept, instead))
            preferred = not others and not unseen_only and f.gain > first.gain
            if tied or (likely and (preferred or self._stands_for(kept, others, f))):
                found[first.name].append(f.name)
        for named in others:
            beside = [f for f in kept if f is not named]
            seen = self.further(beside)
            least = WORTH * max((f.gain for f in seen), default=0.0)
            found[named.name] = [
                f.name
                for f in seen
                if f.name not in names
                and f.gain > least
                and self._stands_for(kept, beside, f)
                and not self._apart(kept, [*beside, f], beside, named, f)
            ]
        for f in kept:
            found[f.name] += factors_like(self.campaign, f.effect, (r.effect for r in self.found.ranking))
        return found

    def _stands_for(self, kept: Sequence[Fit], beside: Sequence[Fit], rival: Fit) -> bool:
        """Return whether a rival `beside` all names but one takes a fair share of what that one takes from the error on unseen tests."""
        without = self.straight.errors(beside).rms ** 2
        taken, by_rival = (without - self.straight.errors(of).rms ** 2 for of in (kept, [*beside, rival]))
        return by_rival >= WORTH * taken

    def behind(self, kept: Sequence[Fit], alike: Sequence[str]) -> list[str]:
        """Return those of some effects, the first of them named, that are far worse in its place on unseen tests.

        In data that hold the first one they may come near it in evidence, which allows every formula to bend.
        """
        named = next((f for f in kept if f.name in alike[:1]), None)
        if named is None:
            return []
        others, names = [f for f in kept if f is not named], {f.name for f in kept}
        rivals = [f for f in self.found.ranking if f.name in alike and f.name not in names]
        return [f.name for f in rivals if self._behind(kept, [f, *others])]

    def _behind(self, kept: Sequence[Fit], instead: Sequence[Fit]) -> bool:
        """Return whether unseen tests prefer some effects to others clearly, and by enough to matter."""
        own, other = self.straight.errors(kept), self.straight.errors(instead)
        gain, certain = fall(other, own)
        if certain <= BEHIND_IN_BOTH or gain <= LEAST_SHARE * own.rms**2:
            return False
        if certain <= BEHIND and self._agreed(kept, instead) <= BEHIND_IN_BOTH:
            return False
        return self._apart(kept, instead, [], *_only_forms(kept, instead))

    def _agreed(self, kept: Sequence[Fit], instead: Sequence[Fit]) -> float:
        """Return by how many standard errors the leads of single tests prefer some effects to others."""
        return rivalry(self.campaign, self.found, kept, instead).certainty

    def _led(self, kept: Sequence[Fit], instead: Sequence[Fit]) -> bool:
        """Return whether the tests prefer some effects to others that differ in the first.

        With one mean a test, unseen tests are judged by all that the data hold, and have to prefer them as well; less surely where
        the leads of single tests agree by many standard errors.
        """
        if self.campaign.averaged and not self._apart(kept, instead, [], *_only_forms(kept, instead)):
            preferred = fall(self.straight.errors(instead), self.straight.errors(kept))[1] >= AGREED
            return preferred and self._agreed(kept, instead) >= IN_ALL_TESTS
        return self._agreed(kept, instead) >= AGREED or self._behind(kept, instead)

    def _apart(self, kept: Sequence[Fit], instead: Sequence[Fit], beside: Sequence[Fit], *forms: Fit) -> bool:
        """Return whether unseen tests prefer some effects to others; of averages also where they had no part in the choice of shapes.

        The `forms` are the named effect and its rival, that stand `beside` the same others.
        """
        if fall(self.straight.errors(instead), self.straight.errors(kept))[1] < APART:
            return False
        if not forms or not self.campaign.averaged:
            return True
        own, other = (self.straight.errors_of_form(f, beside) for f in forms)
        return fall(other, own)[1] >= APART

    def plainest_first(self, kept: list[Fit]) -> list[Fit]:
        """Return the effects led by the plainest of those that contribute the same as the first, and predict unseen tests as well.

        As in the ranking: which of them is better by a hair changes with every test that is left out. A memory of loads that no test
        changes is hardly seen: a law of these loads alone, which contributes nearly the same, is plainer. So is a law of fewer of the
        loads of the first with which, both refitted, they are predicted as well.
        """
        if not kept:
            return kept
        first, *others = kept
        own, names = self.straight.errors(kept).rms ** 2, {f.name for f in kept}
        flat = {*constant(first.effect, self.campaign)} if first.effect.needs_state else set()

        def as_good(fit: Fit) -> bool:
            without = not fit.effect.needs_state and {*fit.effect.driver} <= flat
            alike, worse = (TWINS, UNSEEN_MEMORY) if without else (EQUAL, LEAST_SHARE)
            correlation = contribute_alike(first, fit)
            if correlation > alike and self.straight.errors([fit, *others]).rms ** 2 <= (1.0 + worse) * own:
                return True
            fewer = self._of_fewer_loads(fit, first) and correlation > NEARLY_ALIKE
            return fewer and self._no_worse([fit, *others], kept)

        others_as_good = [f for f in self.found.ranking if f.name not in names and as_good(f)]
        lead = min([first, *others_as_good], key=self.found.plainness)
        return kept if lead is first else [lead, *others]

    def plainer_beside(self, kept: list[Fit]) -> list[Fit]:
        """Return the effects, each exchanged for a likelier one that unseen tests predict as well with, all refitted.

        A further name of several loads for one of fewer of them, and a fault for a column of the test table: that instruments are right
        is the better bet where what was recorded says the same.
        """
        for k, named in enumerate(kept):
            beside = [f for f in kept if f is not named]
            seen = self.further(beside) if beside else self.found.ranking
            names = {f.name for f in kept}
            likelier = (
                f
                for f in seen
                if f.name not in names
                and f.gain > AS_GOOD * named.gain
                and (self._is_recorded(f, named) or (k > 0 and self._of_fewer_loads(f, named)))
            )
            for fit in likelier:
                instead = [*kept[:k], fit, *kept[k + 1 :]]
                if self._no_worse(instead, kept):
                    return instead
        return kept

    @staticmethod
    def _is_recorded(fit: Fit, fault: Fit) -> bool:
        """Return whether an effect is one of a column of the test table, which a fault of the data may only stand for."""
        return fault.effect.kind == "fault" and fit.effect.kind == "system"

    def _no_worse(self, some: Sequence[Fit], others: Sequence[Fit]) -> bool:
        """Return whether unseen tests are predicted as well by some effects as by others, all refitted."""
        after, before = (self.straight.unseen.errors(effects_of(fits)).rms ** 2 for fits in (some, others))
        return after <= (1.0 + LEAST_SHARE) * before

    def _of_fewer_loads(self, fit: Fit, other: Fit) -> bool:
        """Return whether an effect is physics of some, not all, of the loads that vary here and drive another one; memory apart."""
        if fit.effect.kind != "physics" or fit.effect.needs_state or other.effect.needs_state:
            return False
        varied = self.campaign.varied
        own, loads = ({d for d in f.effect.driver if d in varied} for f in (fit, other))
        return own < loads

    def credible_first(
        self, kept: list[Fit], beside: Mapping[str, Sequence[str]], alike: Sequence[str]
    ) -> list[Fit]:
        """Return the effects with a first one that is too large for a fault exchanged for the best rival that is none.

        Rivals are those of unseen tests, `beside` it, and what the scan finds `alike`.
        """
        sensor = self.found.floor.sensor
        if not kept or credible(self.campaign, sensor, kept[0]):
            return kept
        names, rivals = {f.name for f in kept}, {*beside[kept[0].name], *alike}
        others = (f for f in self.found.ranking if f.name in rivals and f.name not in names)
        first = next((f for f in others if credible(self.campaign, sensor, f)), None)
        return kept if first is None else [first, *kept[1:]]

    def largest_first(self, kept: list[Fit]) -> list[Fit]:
        """Return the effects led by one that carries far more of the error on unseen tests than the first, if there is one."""
        if len(kept) < 2:
            return kept
        left = [self.straight.errors([g for g in kept if g is not f]).rms ** 2 for f in kept]
        carried = np.array(left) - self.straight.errors(kept).rms ** 2
        most = int(np.argmax(carried))
        if carried[0] > AS_GOOD * carried[most]:
            return kept
        return [kept[most], *(f for f in kept if f is not kept[most])]


def _only_forms(kept: Sequence[Fit], instead: Sequence[Fit]) -> tuple[Fit, ...]:
    """Return the only name and what stands in its place; nothing where there are several names."""
    return (kept[0], instead[0]) if len(kept) == 1 else ()


def told(kept: Sequence[Fit], rivals: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """Return the rivals of the first name; then further names, each with its own, where it has some."""
    first, *others = [f.name for f in kept] or [""]
    return (*rivals.get(first, ()), *(n for name in others if rivals[name] for n in (name, *rivals[name])))
