"""What whole tests that no fit has seen say of a verdict: which names stay, what is predictable beyond them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.search.scan import Fit
from ...estimation.search.search_round import SearchRound
from ...loads import LOAD_NAMES
from .beside_reference import BesideReference, effects_of
from .beside_repeats import BesideRepeats, beyond_repeats
from .closest import first_seen
from .confirmation import EXPLAINED, NAMED, NOT_THE_ANSWER, Confirmation
from .error_budget import BELIEVED, ErrorShares, helps
from .identifiability import RESOLUTION
from .naming.another_family import AnotherFamily
from .naming.instead import CONFIRMED, MOST_OF_THE_REST, Instead, along_the_distance
from .naming.names import Names
from .naming.other_laws import OtherLaws
from .naming.own_form import OwnForm
from .naming.products import Products
from .naming.rivals import Further, Rivals, told
from .naming.straight_fits import StraightFits
from .naming.two_loads import TwoLoads
from .unseen_tests import UnseenTests
from .verdict import BENT_MEMORY

#: What the reference finds where no effect is seen must be this share of the squared error at least, and this certain; if it is much
#: of the error, what it needs to be believed is enough.
ALONE_SHARE, ALONE_CERTAIN, MUCH = 0.05, 3.0, 0.25


class UnseenTestsJudge:
    """The judge of one diagnosis; the search gives the noise by which bins are weighed."""

    def __init__(
        self, campaign: BinnedTests, unseen: UnseenTests, found: SearchRound, further: Further
    ) -> None:
        self.campaign, self.unseen, self.found = campaign, unseen, found
        self.straight = StraightFits(campaign, unseen, found)
        self.beside = BesideReference(campaign, unseen, found)
        self.rivals = Rivals(campaign, found, self.straight, further)
        self.beside_repeats = BesideRepeats(campaign, unseen, self.straight)
        self.names = Names(unseen, found, self.straight, self.beside, further)
        self.instead = Instead(self.names)
        self.two_loads = TwoLoads(self.names)
        self.products = Products(unseen, self.straight)
        self.own_form = OwnForm(unseen)
        self.another_family = AnotherFamily(unseen)
        self.other_laws = OtherLaws(campaign, unseen, self.straight, self.two_loads, self.products)

    def __call__(
        self, verdict: str, chosen: list[Fit], named: str, bent: bool, alike: Sequence[str] = ()
    ) -> Confirmation:
        """Return a verdict whose names lower the error on unseen tests.

        `verdict` is that of the scan, and `chosen` what it names, or would name if no structure were left; `named` is the
        verdict in that case. The first name is `bent` where what is missing has another form. The scan cannot tell what is `alike`
        from the first of them.
        """
        if not self.unseen.possible:
            return Confirmation(verdict, chosen if verdict in NAMED else [])
        if self.unseen.errors().rms < RESOLUTION * float(np.mean(np.abs(self.campaign.mu))):
            return Confirmation("nothing_missing", shares=self.beside.shares([]), within_resolution=True)
        # what the scan sees for certain has to be confirmed only: a window of few tests makes no large certainty
        alone = CONFIRMED if verdict == "unknown_structure" else BELIEVED
        verdict, chosen = self._doubted(verdict, chosen, named, bent, alone)
        verdict, kept, shares = self._named(verdict, chosen, named, alone)
        plainest = self.rivals.plainer_beside(self.rivals.plainest_first(kept))
        if plainest is not kept:
            kept, shares = plainest, self.beside.shares(plainest)
            if verdict == "data_problem" and not all(self._is_fault(f.name) for f in kept):
                verdict = "explained"  # what was recorded took the place of the fault
        beside = self._rivals(kept, shares)
        likelier = self.rivals.credible_first(kept, beside, alike)
        if likelier is not kept and helps(
            self.beside.without_names, self.unseen.errors(effects_of(likelier))
        ):
            kept, shares = likelier, self.beside.shares(likelier)
            verdict = "explained" if verdict == "data_problem" else verdict
            beside = self._rivals(kept, shares)
        behind = self.rivals.behind(kept, alike)
        kept = self.rivals.largest_first(kept)
        rivals = told(kept, beside)
        faults = all(self._is_fault(name) for name in (*(f.name for f in kept), *rivals))
        if rivals and (
            verdict in ("explained", "partly_explained") or (verdict == "data_problem" and not faults)
        ):
            verdict = "ambiguous"
        elif verdict == "ambiguous" and not rivals and _told_apart(kept, alike, behind):
            verdict = "data_problem" if faults else "explained"
        other_laws = self.other_laws.among(kept, sure=verdict != "ambiguous") if verdict in NAMED else set()
        if other_laws and (instead := self._without(other_laws, kept, beside, alone)) is not None:
            verdict, kept, shares, rivals = instead
        shares, repeats = self.beside_repeats.budget(kept, shares)
        if verdict == "data_problem" and shares.left > NOT_THE_ANSWER:
            verdict, kept, rivals = "unknown_structure", [], ()
            shares, repeats = self.beside_repeats.budget(kept, self.beside.shares([], alone))
        if repeats is not None and repeats.lacks_fit:
            verdict = beyond_repeats(verdict, shares)
        left = shares.missing > 0.0 and verdict != "nothing_missing"
        return Confirmation(
            verdict,
            kept,
            shares,
            self.names.certain(kept),
            self.beside.places(kept) if left else [],
            self.beside.beyond(kept) if left else None,
            rivals,
            tuple(behind),
            self.two_loads.as_good(kept),
            self.products.as_good(kept),
            self.own_form.does_as_well(kept),
            self.own_form.explains(shares, first_seen(self.found))
            if verdict == "unknown_structure"
            else None,
            self.another_family.does_as_well(kept),
            self.names.little(kept),
            repeats,
            sharper=self.other_laws.sharper(kept),
        )

    def _doubted(
        self, verdict: str, chosen: list[Fit], named: str, bent: bool, alone: float
    ) -> tuple[str, list[Fit]]:
        """Return the verdict of the scan and what it names, after a look at unseen tests where it says that structure is left, or nothing."""
        if verdict == "unknown_structure":
            # structure that does not help to predict other tests is chance; it matters if the names leave it: of three doubts,
            # that something is left for certain, that it is much, and that the first name bends, one alone does not weigh more;
            # levels of a column have no other form
            kept = self.names.that_help(chosen)
            chosen = chosen or kept
            left = self.beside.shares(kept)
            formed = any(f.effect.driver[0] in LOAD_NAMES for f in kept)
            much = formed and left.left * self._share_along_loads(kept) >= EXPLAINED
            if kept and sum([left.believed, much, bent]) < 2:
                verdict = named
            elif not self.beside.shares([], alone).missing > 0.0:
                verdict = named if kept and not left.believed else "nothing_missing"
            elif kept and (several := self.instead.several(kept[0])):
                # one curve of another form has another name; several together may bend where each is right
                verdict, chosen = named, several
        if verdict == "nothing_missing" and (seen := self.instead.overlooked()) is not None:
            return "explained", [seen]
        return verdict, chosen

    def _named(
        self, verdict: str, chosen: list[Fit], named: str, alone: float
    ) -> tuple[str, list[Fit], ErrorShares]:
        """Return the verdict with the names that unseen tests keep, and the budget beside these."""
        unseen_by_scan = verdict == "nothing_missing"
        kept, needed = self.names.led(chosen) if verdict in NAMED else ([], [])
        if len(needed) < len(kept):
            # where no less than all of them explain, their sum is a curve of unknown form
            kept, verdict = needed, verdict if self.names.explain(needed) else "unknown_structure"
        parted = self.two_loads.parted(kept) if verdict in NAMED else kept
        if parted is not kept and not self.other_laws.cancelling(parted, sure=False):
            kept, verdict = parted, "explained"
        if (
            verdict in NAMED
            and len(kept) > 1
            and len(self.other_laws.cancelling(kept, sure=False)) == len(kept)
        ):
            # of parts that are known as a difference only, one that explains by itself is enough
            kept = next(([f] for f in kept if self.names.explain([f])), kept)
        shares = self.beside.shares(kept, alone)
        another_form = verdict in NAMED and self._in_another_form(kept, shares)
        if another_form or (verdict in NAMED and _one_of_two(kept, shares)):
            if pair := self.instead.along_the_distance():
                kept, shares = pair, self.beside.shares(pair, alone)
            elif another_form:
                return "unknown_structure", [], self.beside.shares([], alone)
        verdict = self._verdict(verdict, kept, shares)
        if verdict not in NAMED and kept:
            kept, shares = [], self.beside.shares([], alone)
        if verdict == "unknown_structure" and unseen_by_scan and (one := self.instead.alone()):
            return "explained", one, self.beside.shares(one)
        if verdict == "unknown_structure" and (
            together := self.instead.together() or self.instead.along_the_distance() or self.instead.levels()
        ):
            kept, shares = together, self.beside.shares(together)
            verdict = self._verdict(named, kept, shares)
        return verdict, kept, shares

    def _verdict(self, verdict: str, kept: list[Fit], shares: ErrorShares) -> str:
        if verdict in NAMED and kept:
            if shares.believed and shares.left * self._along_loads(kept, shares) > NOT_THE_ANSWER:
                return "unknown_structure"
            kinds = [f.effect.kind for f in kept]
            physical = any(kind != "fault" for kind in kinds)
            if verdict == "data_problem" and physical:
                verdict = "explained"  # a rival that unseen tests prefer took the place of the fault, or stands beside it
            elif verdict == "explained" and not physical:
                verdict = "data_problem"
            return "partly_explained" if shares.left > EXPLAINED and physical else verdict
        if verdict in NAMED or verdict == "nothing_missing":
            return (
                "unknown_structure"
                if _certainly_missing(shares) and _certainly_missing(self.beside.divided())
                else "nothing_missing"
            )
        return verdict

    def _rivals(self, kept: list[Fit], shares: ErrorShares) -> dict[str, list[str]]:
        """Return what unseen tests cannot tell from each name."""
        missing = shares.missing * self._along_loads(kept, shares) if shares.believed else 0.0
        return self.rivals.of(kept, missing)

    def _along_loads(self, kept: list[Fit], shares: ErrorShares) -> float:
        """Return the share of what is left that lies along loads, where much is left.

        What the order of the tests or their metadata change, alone or together with a load, says nothing against names or for rivals
        of them.
        """
        return 1.0 if shares.left <= NOT_THE_ANSWER else self._share_along_loads(kept)

    def _share_along_loads(self, kept: list[Fit]) -> float:
        """Return the share of what is left beside names that lies along loads and nothing else."""
        return 1.0 - sum(
            p["share"] for p in self.beside.places(kept) if not {*p["variables"]} <= {*LOAD_NAMES}
        )

    def _in_another_form(self, kept: list[Fit], shares: ErrorShares) -> bool:
        """Return whether one effect leaves most of what is left along its own load: what is there bends otherwise than it can.

        A hump in a load is no threshold, though a threshold beside a falling line draws most of it. Over two loads a law has more
        ways to differ from its formula, and is still that law.
        """
        if len(kept) != 1 or not shares.believed or not EXPLAINED < shares.left <= NOT_THE_ANSWER:
            return False
        effect = kept[0].effect
        if (
            (effect.needs_state and shares.left < BENT_MEMORY)
            or len(effect.driver) > 1
            or effect.driver[0] not in LOAD_NAMES
        ):
            return False
        places = self.beside.places(kept)
        return any(p["share"] > MOST_OF_THE_REST and {*p["variables"]} <= {*effect.driver} for p in places)

    def _without(
        self, other_laws: set[str], kept: list[Fit], beside: Mapping[str, list[str]], alone: float
    ) -> tuple[str, list[Fit], ErrorShares, tuple[str, ...]] | None:
        """Return verdict, names, budget and rivals without names that only draw another law; None where the only name stays all the same.

        What one of them draws, two along the distance may be.
        """
        others = [f for f in kept if f.name not in other_laws]
        if others and not helps(self.beside.without_names, self.unseen.errors(effects_of(others))):
            others = []  # they only mended the other law
        pair = [] if others else self.instead.along_the_distance()
        shares = self.beside.shares(pair or others, alone)
        if pair:
            rivals = told(pair, self._rivals(pair, shares))
            return "ambiguous" if rivals else "explained", pair, shares, rivals
        if len(kept) == 1 and not shares.missing > 0.0:
            # a law that turns is still the best there is where nothing but its name predicts anything
            return None
        if not others and (rival := self._rival_that_explains(kept, beside)) is not None:
            shares = self.beside.shares([rival])
            return self._verdict("explained", [rival], shares), [rival], shares, ()
        if not others:
            return "unknown_structure" if shares.missing > 0.0 else "nothing_missing", [], shares, ()
        rivals = told(others, beside)
        return "ambiguous" if rivals else "partly_explained", others, shares, rivals

    def _rival_that_explains(self, kept: list[Fit], beside: Mapping[str, list[str]]) -> Fit | None:
        """Return a rival of names that only draw another law, if it explains alone, and does not draw another law itself."""
        names = [n for f in kept for n in beside.get(f.name, ())]
        for fit in [f for n in names for f in self.found.ranking if f.name == n]:
            helped = helps(self.beside.without_names, self.unseen.errors(effects_of([fit])))
            if helped and self.names.explain([fit]) and not self.other_laws.among([fit], sure=True):
                return fit
        return None

    def _is_fault(self, name: str) -> bool:
        """Return whether an effect is a fault of the data."""
        return any(f.name == name and f.effect.kind == "fault" for f in self.found.ranking)


def _told_apart(kept: Sequence[Fit], alike: Sequence[str], behind: Sequence[str]) -> bool:
    """Return whether unseen tests left behind all that the scan could not tell from what is named, or need it beside that."""
    return len({*alike, *behind}) > 1 and {*alike} <= {*behind, *(f.name for f in kept)}


def _one_of_two(kept: Sequence[Fit], shares: ErrorShares) -> bool:
    """Return whether the only name is a law along the distance, beside which something can be predicted, however little: perhaps a second one."""
    return len(kept) == 1 and shares.believed and along_the_distance(kept[0].effect)


def _certainly_missing(shares: ErrorShares) -> bool:
    """Return whether the reference says for certain that something is missing, where no effect is seen."""
    share = shares.missing / max(shares.base, 1e-300)
    return share > ALONE_SHARE and shares.certainty > (BELIEVED if share > MUCH else ALONE_CERTAIN)
