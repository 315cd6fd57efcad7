"""Fits of amplitudes alone, with the shapes of the search: quick enough to try many sets of effects on unseen tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from ....estimation.campaign.binned_tests import BinnedTests
from ....estimation.campaign.curves import transformed
from ....estimation.search.candidates import bin_means
from ....estimation.search.scan import Fit, best_fit, prepare_candidate
from ....estimation.search.search_round import SearchRound
from ....loads import FloatArray
from ....loads.splits import Mask
from ..unseen_tests import ErrorsByTest, UnseenTests, errors_of_tests

#: Places and widths of humps along a load, in standard deviations.
PLACES, WIDTHS = (-1.2, -0.6, 0.0, 0.6, 1.2), (0.4, 0.8, 1.6)


@dataclass(frozen=True)
class StraightFits:
    """Base and effects with the shapes of the scan: only their amplitudes are fitted, which is quick enough to try many."""

    campaign: BinnedTests
    unseen: UnseenTests  #: Gives the folds.
    found: SearchRound  #: Gives the base in the bins.
    _kept: dict[tuple[tuple[str, int], ...], ErrorsByTest] = field(default_factory=dict, repr=False)

    def errors(self, fits: Sequence[Fit]) -> ErrorsByTest:
        """Return the errors on unseen tests with amplitudes of the other tests; once for each list of effects."""
        key = tuple((f.name, f.index) for f in fits)
        if key not in self._kept:
            self._kept[key] = self._errors(self._of_unseen(lambda seen: self.residual(fits, seen)))
        return self._kept[key]

    def errors_of_form(self, fit: Fit, beside: Sequence[Fit] = ()) -> ErrorsByTest:
        """Return the errors of an effect whose shape, too, the other tests choose, `beside` others with the shapes of the search.

        The search saw all tests.
        """

        def left(seen: Mask) -> FloatArray:
            columns = fit.prepared.columns[seen]
            gram = np.einsum("mga,mgb->gab", columns, columns)
            others = best_fit(replace(fit.prepared, columns=columns, gram=gram), self.found.residual[seen])
            return self.residual([*beside, replace(fit, index=others.index)], seen)

        return self._errors(self._of_unseen(left))

    def errors_with_held(self, fit: Fit, load: str, beside: Sequence[Fit] = ()) -> ErrorsByTest:
        """Return `errors_of_form` of an effect that sees the mean of a load everywhere."""
        campaign, candidate = self.campaign, fit.prepared.candidate
        column = getattr(campaign.loads, load)
        held = campaign.with_load(load, np.full_like(column, column.mean()))
        shapes = {name: values[None, :] for name, values in candidate.shapes.items()}
        sets = candidate.columns.shape[1]
        columns = bin_means(candidate.effect, held, campaign.mu, shapes, sets)
        prepared = prepare_candidate(
            replace(candidate, columns=columns), self.found.whiten, self.found.project
        )
        return self.errors_of_form(replace(fit, prepared=prepared), beside)

    def errors_of_bends(self, load: str, beside: Sequence[Fit]) -> tuple[ErrorsByTest, ErrorsByTest]:
        """Return the errors of a parabola along a load, and of any plain bend that the other tests choose, humps among them.

        Each along the load itself and along the scale of its curves, `beside` effects.
        """
        campaign = self.campaign
        parabolas, humps = [], []
        for z in (campaign.average(getattr(campaign.loads, load)), transformed(campaign, load)):
            z = (z - z.mean()) / max(float(z.std()), 1e-300)
            base = np.column_stack([self.found.columns_with(beside), z])
            parabolas.append(np.column_stack([base, z**2]))
            places = ((z - place) / width for place in PLACES for width in WIDTHS)
            humps += [np.column_stack([base, np.exp(-(x**2))]) for x in places]

        def left(seen: Mask) -> FloatArray:
            bends = np.array([self._left(columns, seen) for columns in (*parabolas, *humps)])
            chosen = bends[np.argmin(bends[:, seen] ** 2 @ campaign.count[seen])]
            return np.stack([*bends[: len(parabolas)], chosen])

        *of_parabolas, bend = map(self._errors, self._of_unseen(left))
        return min(of_parabolas, key=lambda errors: errors.rms), bend

    def errors_of_product(self, loads: Sequence[str], beside: Sequence[Fit]) -> ErrorsByTest:
        """Return the errors of straight lines along two loads and their product, beside effects; on the better of both scales."""
        errors = [
            self._errors(self._of_unseen(partial(self._left, columns)))
            for columns in self._with_products(loads, beside)
        ]
        return min(errors, key=lambda found: found.rms)

    def left_by_product(self, fit: Fit, loads: Sequence[str]) -> float:
        """Return the share of what an effect changes beside the model that lines along two loads and their product cannot draw."""
        beside = [replace(self.found, columns=columns) for columns in self._with_products(loads, ())]
        *left, whole = (float(self.campaign.count @ f.change(fit) ** 2) for f in (*beside, self.found))
        return min(left) / max(whole, 1e-300)

    def _with_products(self, loads: Sequence[str], beside: Sequence[Fit]) -> Iterator[FloatArray]:
        """Yield base and effects in the bins with lines along two loads and their product, on either scale."""
        campaign = self.campaign
        for values in (
            lambda load: campaign.average(getattr(campaign.loads, load)),
            partial(transformed, campaign),
        ):
            first, second = ((z - z.mean()) / max(float(z.std()), 1e-300) for z in map(values, loads))
            yield np.column_stack([self.found.columns_with(beside), first, second, first * second])

    def _of_unseen(self, left: Callable[[Mask], FloatArray]) -> FloatArray:
        """Return what fits leave in the bins of tests that they did not see, shape (..., m); `left` takes the bins that are seen."""
        fold = self.unseen.fold_of_test[self.campaign.test]
        return np.sum([np.where(fold == k, left(fold != k), 0.0) for k in np.unique(fold)], axis=0)

    def _errors(self, residual: FloatArray) -> ErrorsByTest:
        return errors_of_tests(self.campaign, residual)

    def residual(self, fits: Sequence[Fit], seen: Mask | None = None) -> FloatArray:
        """Return what base and effects leave in the bins, shape (m,), fitted to those seen or to all."""
        return self._left(self.found.columns_with(fits), seen)

    def _left(self, columns: FloatArray, seen: Mask | None) -> FloatArray:
        y, root = self.found.y, np.sqrt(self.campaign.count) * (1.0 if seen is None else seen)
        return np.asarray(y - columns @ np.linalg.lstsq(root[:, None] * columns, root * y, rcond=1e-9)[0])
