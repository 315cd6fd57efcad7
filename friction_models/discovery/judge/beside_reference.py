"""Error budgets of sets of effects: the model with them, and a flexible reference beside them, on unseen tests."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

from ...effects.base import Effect
from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.noise.reference import Predicted, Reference
from ...estimation.search.scan import Fit
from ...estimation.search.search_round import SearchRound
from ...estimation.search.structure import StructurePlace, places_of
from ...loads import FloatArray
from .error_budget import BELIEVED, ErrorShares, error_shares
from .unseen_tests import ErrorsByTest, UnseenTests, errors_of_tests, mean_of

#: Ways to divide the tests, where the reference alone says that something is missing.
DIVISIONS = 4


class BesideReference:
    """What can be predicted of unseen tests beyond a set of effects, as far as the flexible reference knows."""

    def __init__(self, campaign: BinnedTests, unseen: UnseenTests, found: SearchRound) -> None:
        self.campaign, self.unseen, self.found = campaign, unseen, found
        self._flexible: dict[tuple[tuple[str, int], ...], Predicted] = {}

    @cached_property
    def reference(self) -> Reference:
        """Flexible prediction of the tests from one another."""
        return Reference(self.campaign, self.found.floor, self.found.y)

    @cached_property
    def without_names(self) -> ErrorsByTest:
        """Errors on unseen tests of the model alone, weighed by the noise where that predicts better: what a name has to beat.

        Fits with effects are weighed so, and what the weights do is no merit of the names.
        """
        return min(
            self.unseen.errors(), self._errors(self._predicted([]).alone), key=lambda errors: errors.rms
        )

    def shares(self, kept: Sequence[Fit], alone: float = BELIEVED) -> ErrorShares:
        """Return the budget of the model with effects; where nothing is named, what is missing is `alone` standard errors sure at least."""
        known = [self._errors(self._predicted(fits).flexible) for fits in ([[], kept] if kept else [[]])]
        weighed = self._errors(self._predicted(kept).alone)
        needed = 1.0 if kept else alone
        return error_shares(
            self.unseen.errors(), self.unseen.errors(effects_of(kept)), known, weighed, needed
        )

    def divided(self) -> ErrorShares:
        """Return the budget where nothing is named, on average over several ways to divide the tests: one alone is partly chance."""
        terms, unseen = self.found.columns_with([]), self.unseen
        more = (UnseenTests(unseen.campaign, unseen.base, unseen.seed + k) for k in range(1, DIVISIONS))
        ways = [unseen, *more]
        predicted = [self.reference.out_of_fold(terms, way.fold_of_test, anew=True) for way in ways]
        base = mean_of([way.errors() for way in ways])
        known, weighed = (
            mean_of([self._errors(p.flexible) for p in predicted]),
            mean_of([self._errors(p.alone) for p in predicted]),
        )
        return error_shares(base, base, [known], weighed, BELIEVED)

    def beyond(self, kept: Sequence[Fit]) -> FloatArray:
        """Return what the reference predicts of unseen tests beyond the model with what is named, in the bins, shape (m,)."""
        model = self.found.y - self.unseen.residual(effects_of(kept))
        return self._predicted(kept).flexible - model

    def places(self, kept: Sequence[Fit]) -> list[StructurePlace]:
        """Return where the reference predicts something else than the model with what is named."""
        return places_of(self.campaign, self.beyond(kept), self._predicted(kept).metadata)

    def _errors(self, predicted: FloatArray) -> ErrorsByTest:
        return errors_of_tests(self.campaign, self.found.y - predicted)

    def _predicted(self, kept: Sequence[Fit]) -> Predicted:
        """Return what the reference beside the model and effects predicts of unseen tests; once for each set of effects."""
        key = tuple(sorted((f.name, f.index) for f in kept))
        if key not in self._flexible:
            columns = self.found.columns_with(kept)
            self._flexible[key] = self.reference.out_of_fold(columns, self.unseen.fold_of_test)
        return self._flexible[key]


def effects_of(fits: Sequence[Fit]) -> list[Effect]:
    """Return the effects of fits."""
    return [f.effect for f in fits]
