"""What else may have made what an answer names, or what it leaves: a wrong test, a jump in the order, a factor that nobody recorded."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.fit.parameters import FittedTerms
from ...estimation.search.scan import Fit
from ...estimation.search.search_round import SearchRound
from ...loads import FloatArray
from ..judge.doubts import EVEN, LIKELY, Doubt
from .another_law import draws_another_law
from .lone_levels import about_lone_levels
from .one_test import resting_on_one
from .run_order import about_jumps, alike_in_order, jumps_in_order, jumps_instead
from .test_groups import TestGroups, unrecorded_factor


@dataclass(frozen=True)
class OtherCauses:
    """Causes beside those of the catalogue, as the tests show them."""

    factor: TestGroups | None  #: Groups of tests that differ by what is left.
    in_order: Sequence[str]  #: What changes with the order of the tests, in words.
    lone_levels: Sequence[str]  #: Levels of a load at which few tests lie far off, in words.
    on_one: Mapping[str, str]  #: The test on which a name rests, by name.
    jumps: Mapping[str, str]  #: By how much and where the tests jump, by the name that only follows it.
    instead: Mapping[str, tuple[str, str]]  #: Tests between which a jump does as well, by name.
    another_law: bool  #: Whether a name draws a law that it is not, by cancelling slopes of the model.

    @classmethod
    def of(
        cls,
        campaign: BinnedTests,
        found: SearchRound,
        chosen: Sequence[Fit],
        fitted: FittedTerms,
        unknown: FloatArray,
        sharper: Collection[str],
    ) -> OtherCauses:
        """Look for them; `unknown`, shape (m,), is what neither names nor anything else that was recorded predicts.

        Some names are `sharper` than any plain bend along their load.
        """
        return cls(
            unrecorded_factor(campaign, unknown),
            alike_in_order(campaign, unknown),
            about_lone_levels(campaign, unknown),
            resting_on_one(campaign, found, chosen),
            jumps_in_order(campaign, fitted),
            jumps_instead(campaign, found, fitted),
            draws_another_law(campaign, fitted, sharper),
        )

    def doubts(self, verdict: str) -> list[Doubt]:
        """Return what of them speaks against a verdict."""
        grouped = self.factor is not None or bool(self.in_order or self.lone_levels)
        found = []
        if grouped and verdict == "nothing_missing":
            found.append(Doubt("tests differ by something that was not recorded", LIKELY))
        # of 37 answers with one of these, to campaigns of three authors, 21 were right
        if self.jumps or self.instead:
            found.append(Doubt("a jump in the order of the tests does as well", EVEN))
        if self.another_law:
            found.append(Doubt("a name draws another law than its own along its load", EVEN))
        if self.on_one:  # of 23 such answers 17 were right
            found.append(Doubt("a name rests on one test", LIKELY))
        return found

    def warnings(self) -> list[str]:
        """Return what there is to say of them, but of the factor and of another law, which have their own places."""
        return [
            *(
                f"{name} rests on one test ({test}), which holds more than half of what it explains: look at its record, and repeat it"
                for name, test in self.on_one.items()
            ),
            *self.in_order,
            *self.lone_levels,
            *about_jumps(self.jumps, self.instead),
        ]
