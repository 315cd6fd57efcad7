"""Which names unseen tests keep: added one after the other, exchanged, left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....estimation.search.importance import LEAST_SHARE
from ....estimation.search.scan import Fit
from ....estimation.search.search_round import SearchRound
from ....estimation.search.unseen_loads import AS_GOOD, driven_by_load
from ..beside_reference import BesideReference, effects_of
from ..confirmation import EXPLAINED
from ..error_budget import fall, helps
from ..unseen_tests import ErrorsByTest, UnseenTests
from ..verdict import LEVEL
from .rivals import APART, Further
from .straight_fits import StraightFits

#: An effect that the scan sees at this level has to lower the error, but not by a full standard error.
CLEAR = 0.01
#: What is less clear must take this share of the squared error on unseen tests, or fall along them by so many standard errors:
#: effects that are both small and hardly significant are mostly chance. Of few tests, chance leaves nothing very significant.
WEAK_SHARE, SURE_ALONG = 0.3, 4.0
#: Most effects that are named together.
MOST_NAMED = 4
#: Further effects that are compared on unseen tests.
TRIED = 3
#: Standard errors by which a further effect must lower the error.
CERTAIN = 2.0
#: Standard errors that are enough where the other answer is the likelier one by what it needs, or by what it leaves.
BETTER = 1.0
#: An effect of this share of the gain of another one fits about as well.
ALIKE = 0.9
#: Rivals that are tried in place of an effect that does not help.
RIVALS = 4
#: Standard errors by which unseen tests alone show an effect that the scan does not, where nothing that it shows helps.
ALONE = 3.0
#: Share of the squared error by which unseen tests must fall where what is added is not certain by them alone.
CONFIRMED_SHARE = 0.15
#: The same for one of loads that the scan sees for certain beside others, or its share of what can be predicted beyond them, where that
#: is certain; standard errors by which the error must then fall.
CLEAR_SHARE, MUCH_OF_THE_REST, CLEARLY = 0.1, 0.5, 1.2
#: One of several names that takes less than this share of the squared error of the model may only mend the form of the others.
LITTLE_BESIDE = 0.03


@dataclass(frozen=True)
class Names:
    """Sets of effects, judged by how they predict unseen tests."""

    unseen: UnseenTests
    found: SearchRound
    straight: StraightFits
    beside: BesideReference
    further: Further

    def led(self, chosen: list[Fit]) -> tuple[list[Fit], list[Fit]]:
        """Return the effects that are led by the first one that helps, and those of them that are needed.

        What the scan sees for certain counts where it explains, the scan having its first name right: else it is another form.
        """
        first = self.that_help(chosen, 1)
        for clear in (True, False) if first and first[0] is chosen[0] else (False,):
            kept = self.grown(first, len(chosen), clear=clear)
            if (instead := self._best_led(kept)) is not kept:
                kept = self.grown(instead, len(instead), clear=clear)
            needed = self.needed(kept, clear)
            if clear and len(needed) > 1 and self.explain(needed):
                break
        return kept, needed

    def explain(self, kept: list[Fit]) -> bool:
        """Return whether unseen tests are predicted about as well as they can be."""
        return self.beside.shares(kept).left < EXPLAINED

    def that_help(self, chosen: list[Fit], most: int = MOST_NAMED) -> list[Fit]:
        """Return the effects that lower the error on unseen tests, one after the other; a rival where none does."""
        kept: list[Fit] = []
        for fit in chosen:
            if len(kept) < most and self.adds(kept, fit):
                kept.append(fit)
        if kept:
            return kept
        tried = [f for f in self.found.ranking[: RIVALS + 1] if f.name not in {c.name for c in chosen[:1]}]
        seen = (f for f in tried if (chosen and self.found.p_value(f) < LEVEL) or self._shown(f))
        return next(([f] for f in seen if self.adds([], f)), [])

    def _shown(self, fit: Fit) -> bool:
        """Return whether unseen tests alone show an effect for certain; in the scan others may drown it."""
        return fit.gain > 0.0 and falls(
            self.beside.without_names, self.unseen.errors(effects_of([fit])), ALONE
        )

    def _best_led(self, kept: list[Fit]) -> list[Fit]:
        """Return the effects led by one that fits as well and that unseen tests clearly prefer, where much is left to predict.

        One that fits all tests about as well and explains, where the first for certain does not, is the likelier answer: `BETTER` is enough.
        """
        if not kept or self.explain(kept):
            return kept
        first, *others = kept
        before = self.unseen.errors(effects_of(kept))
        sure = self.beside.shares(kept).believed
        for fit in self.found.ranking[: 2 * RIVALS]:
            if fit.name not in {f.name for f in kept} and fit.gain > AS_GOOD * first.gain:
                instead = [fit, *others]
                after = self.unseen.errors(effects_of(instead))
                alike = sure and fit.gain > ALIKE * first.gain and _prefers(before, after, BETTER)
                if _prefers(before, after) or (alike and self.explain(instead)):
                    return instead
        return kept

    def grown(self, kept: list[Fit], wanted: int, most: int = MOST_NAMED, clear: bool = False) -> list[Fit]:
        """Return the effects with further ones, while these lower the error; at least `wanted` are tried, and what is `clear`.

        Where the reference predicts no more than they do, only what unseen tests confirm by themselves follows: it does not see all.
        """
        while kept and len(kept) < most:
            left = self.beside.shares(kept)
            enough = len(kept) >= wanted and not left.believed and left.left < EXPLAINED
            if enough and not clear:
                break
            tried = self._preferred_first(kept, self.further(kept)[:TRIED])
            confirmed = (fit for fit in tried if self._confirmed(kept, fit, clear, enough))
            if (fit := next(confirmed, None)) is None:
                break
            kept = self._exchanged([*kept, fit])
        return kept

    def needed(self, kept: list[Fit], clear: bool = False) -> list[Fit]:
        """Return the effects that unseen tests miss when each is left out and the others are refitted; the least missed goes first.

        Several formulas may bend after a law that none of them describes: then their sum predicts, and one alone says little. Where
        the scan leaves no other structure, one that is `clear` to it is missed by less.
        """
        while len(kept) > 1:
            after = self.unseen.errors(effects_of(kept))
            without = [[g for g in kept if g is not f] for f in kept]
            missed = [self.missed(fits, after) for fits in without]
            least = int(np.argmin(missed))
            if missed[least] >= APART or (clear and self._clear(without[least], kept[least], after)):
                break
            kept = without[least]
        return kept

    def missed(self, without: Sequence[Fit], after: ErrorsByTest) -> float:
        """Return by how many standard errors unseen tests miss a name without which they are predicted so.

        One test that is then predicted beyond all that was measured makes the standard error as large as the mean, but is no chance.
        """
        before = self.unseen.errors(effects_of(without))
        reach = float(np.ptp(self.unseen.campaign.mu)) ** 2
        if np.max(before.total) > reach > np.max(after.total):
            return float("inf")
        return _certainty(before, after)

    def _preferred_first(self, kept: list[Fit], tried: Sequence[Fit]) -> list[Fit]:
        """Return some effects, led by the first of them, or by a later one that unseen tests clearly prefer."""
        best = 0
        for k in range(1, len(tried)):
            if self._prefer([*kept, tried[best]], [*kept, tried[k]]):
                best = k
        return [*tried[best : best + 1], *tried[:best], *tried[best + 1 :]]

    def _prefer(self, some: Sequence[Fit], others: Sequence[Fit]) -> bool:
        """Return whether unseen tests clearly prefer the second of two sets of effects; what is refitted has the last word."""
        if fall(self.straight.errors(some), self.straight.errors(others))[1] < CERTAIN:
            return False
        return _prefers(self.unseen.errors(effects_of(some)), self.unseen.errors(effects_of(others)))

    def _confirmed(self, kept: list[Fit], fit: Fit, clear: bool, enough: bool) -> bool:
        """Return whether a further effect helps for certain, or is `clear` to the scan and helps.

        One of a load of those named may only mend their form; a fault of the data that does is not named.
        """
        before, after = (self.unseen.errors(effects_of(fits)) for fits in (kept, [*kept, fit]))
        if fit.effect.driver[0] in {d for f in kept for d in f.effect.driver}:
            return fit.effect.kind != "fault" and falls(before, after, CERTAIN)
        certain = falls(before, after, CERTAIN) if enough else helps(before, after, CERTAIN)
        return certain or (clear and self._clear(kept, fit, after))

    def _clear(self, beside: Sequence[Fit], fit: Fit, after: ErrorsByTest) -> bool:
        """Return whether the scan sees an effect for certain beside others, and unseen tests agree by a standard error.

        Scatter between tests halves what squared errors of unseen tests can say: what is clear by 4 standard errors lowers them by 2.
        """
        if not any(f.name == fit.name for f in self.further(beside, CLEAR)):
            return False
        before = self.unseen.errors(effects_of(beside))
        gain, certain = fall(before, after)
        if certain <= 1.0:
            return False
        if gain > CONFIRMED_SHARE * before.rms**2:
            return True
        # the rest of the error may be noise, of which no load takes a share; of many columns of a table, one takes some by chance
        left = self.beside.shares(beside)
        most = gain > CLEAR_SHARE * before.rms**2 or (
            left.believed and gain > MUCH_OF_THE_REST * left.missing
        )
        return most and certain > CLEARLY and driven_by_load(fit.effect)

    def _exchanged(self, kept: list[Fit]) -> list[Fit]:
        """Return the effects with the first one exchanged for a rival that is clearly better beside the others."""
        first, *others = kept
        load = first.effect.driver[0]
        taken = {f.name for f in kept}
        rivals = [
            f
            for f in self.found.ranking[: 2 * RIVALS]
            if f.name not in taken and f.gain > AS_GOOD * first.gain and f.effect.driver[0] == load
        ]
        return next(([f, *others] for f in rivals if self._prefer(kept, [f, *others])), kept)

    def adds(self, kept: Sequence[Fit], fit: Fit) -> bool:
        before = self.unseen.errors(effects_of(kept)) if kept else self.beside.without_names
        after = self.unseen.errors(effects_of([*kept, fit]))
        p = self.found.p_value(fit)
        weak = not kept and p >= CLEAR and fall(before, after)[0] < WEAK_SHARE * before.rms**2
        weak = weak and fall(before, after, "within")[1] < SURE_ALONG
        return not weak and helps(before, after, 0.0 if not kept and p < CLEAR else 1.0)

    def certain(self, kept: Sequence[Fit]) -> float:
        """Return the standard errors by which the last name lowers the error; 0 where nothing is named."""
        if not kept:
            return 0.0
        return _certainty(*(self.unseen.errors(effects_of(fits)) for fits in (kept[:-1], kept)))

    def little(self, kept: list[Fit]) -> tuple[str, ...]:
        """Return of several names those without which the squared error rises by next to nothing of what the model leaves."""
        if len(kept) < 2:
            return ()
        whole, base = self.unseen.errors(effects_of(kept)).rms ** 2, self.beside.without_names.rms**2
        without = {f.name: self.unseen.errors(effects_of([o for o in kept if o is not f])) for f in kept}
        return tuple(name for name, errors in without.items() if errors.rms**2 - whole < LITTLE_BESIDE * base)


def _certainty(before: ErrorsByTest, after: ErrorsByTest) -> float:
    """Return by how many standard errors an error falls, in all or along the tests."""
    return max(fall(before, after)[1], fall(before, after, "within")[1])


def falls(before: ErrorsByTest, after: ErrorsByTest, needed: float) -> bool:
    """Return whether an error falls by `CONFIRMED_SHARE` of it at least, and by `needed` standard errors."""
    gain, certain = fall(before, after)
    return certain > needed and gain > CONFIRMED_SHARE * before.rms**2


def _prefers(before: ErrorsByTest, after: ErrorsByTest, needed: float = CERTAIN) -> bool:
    """Return whether an error falls clearly, and by enough to matter: twins may differ by a hair in every test alike."""
    gain, certain = fall(before, after)
    return certain > needed and gain > LEAST_SHARE * before.rms**2
