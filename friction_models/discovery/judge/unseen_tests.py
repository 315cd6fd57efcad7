"""Errors on whole tests that a fit did not see: one judge for `diagnose`, `refine` and all pages."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from sklearn.base import clone

from ...effects.base import Effect
from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.campaign.binning import campaign_of, part_of
from ...estimation.campaign.factors import as_fitted
from ...estimation.campaign.metadata import with_all_metadata
from ...estimation.fit.joint_problem import solve_jointly
from ...estimation.fit.parameters import FittedTerms, fit_terms
from ...estimation.search.base_law import BaseLaw
from ...estimation.search.candidates import contribution
from ...families.composed import ComposedFriction
from ...loads import FloatArray, TriboLoads
from ...loads.splits import Mask
from ...models.base import FrictionModel
from ...models.variables import as_numbers

FOLDS = 4
#: With fewer tests each is left out alone.
FEW = 16
#: What a law says of unseen tests leaves the range of mu in the other tests by this share of it at most.
BEYOND_MEASURED = 0.75
#: Fewest tests of which some can be left out.
LEAST_TESTS = 4


def folds_of(campaign: BinnedTests, seed: int) -> npt.NDArray[np.intp]:
    """Return the fold of each test of a campaign; tests at one setting are left out together."""
    setting = campaign.setting
    return folds_of_tests(int(setting.max()) + 1, seed)[setting]


def folds_of_tests(tests: int, seed: int) -> npt.NDArray[np.intp]:
    """Return the fold of each test; all in fold 0 where there are too few to leave some out.

    Of each `FOLDS` neighbours in an order of the tests every fold holds one, drawn at random: with tests by their loads
    (`BinnedTests.place`), no fold lacks a corner of the plan by chance.

    Examples
    --------
    >>> np.bincount(folds_of_tests(20, seed=0)).tolist()
    [5, 5, 5, 5]
    >>> folds_of_tests(5, seed=0).tolist()
    [0, 1, 2, 3, 4]
    """
    if tests < LEAST_TESTS:
        return np.zeros(tests, dtype=np.intp)
    if tests < FEW:
        return np.arange(tests)
    rng = np.random.default_rng(seed)
    blocks = [rng.permutation(FOLDS) for _ in range(-(-tests // FOLDS))]
    return np.concatenate(blocks)[:tests]


def predicted_unseen(model: FrictionModel, loads: TriboLoads, mu: FloatArray, unseen: Mask) -> FloatArray:
    """Fit a copy of a model to the other points; return what it predicts of the measured mu at the unseen ones."""
    return predicted_measurements(_learned(model, loads, mu, ~unseen), loads.take(unseen))


def _learned(model: FrictionModel, loads: TriboLoads, mu: FloatArray, seen: Mask) -> FrictionModel:
    """Return a copy of a model, fitted to some points."""
    fitted = clone(model)
    fitted._learn(loads.take(seen), mu[seen], names_of(loads, seen))
    return fitted


def predicted_measurements(fitted: FrictionModel, loads: TriboLoads) -> FloatArray:
    """Return what a fitted model predicts of measured mu, shape (n,).

    Faults of the data that the model knows are in the measurements, so they are added to its prediction here.
    """
    return fitted.predict(loads) + _faults_share(fitted, loads)


def near_measured(measured: FloatArray, predicted: FloatArray) -> FloatArray:
    """Return predictions, none of them farther from what was measured than `BEYOND_MEASURED` of its range.

    Tests at an end of the plan that are left out may be the only ones that tell how steep a law is there. What the others say of
    them is held, so that they do not outweigh all others; a fit to all tests does not go astray there.

    Examples
    --------
    >>> near_measured(np.array([0.06, 0.10]), np.array([0.09, 0.31])).tolist()
    [0.09, 0.13]
    """
    low, high = float(measured.min()), float(measured.max())
    margin = BEYOND_MEASURED * (high - low)
    return np.clip(predicted, low - margin, high + margin)


def names_of(loads: TriboLoads, rows: Mask) -> Any:
    """Return the names of the tests of some points, None where tests are not known."""
    return None if loads.test_id is None else loads.test_id[rows]


def _faults_share(model: Any, loads: TriboLoads) -> FloatArray:
    """Return what the faults of the data that a fitted model knows add to measured mu, shape (n,)."""
    share = np.zeros(len(loads))
    known = zip(
        getattr(model, "effects_", []), getattr(model, "shapes_", []), getattr(model, "amplitudes_", [])
    )
    for effect, shape, amplitudes in known:
        if effect.kind != "fault":
            continue
        campaign = campaign_of(loads, share, loads.test_id)
        for name in effect.metadata:
            values = loads.context_column(name)
            if values is not None:
                campaign.system[name] = as_numbers(values, model.levels_.get(name, ()), np.nan)[:, None]
        share = share + contribution(effect, campaign, model.predict(loads), shape, amplitudes.values())
    return share


@dataclass(frozen=True)
class ErrorsByTest:
    """Mean squared error of each test, split in two."""

    #: Square of the mean error of the test: what differs from test to test. Shape (tests,).
    between: FloatArray
    within: FloatArray  #: Mean square about it: what changes along the test. Shape (tests,).
    #: Setting of the test, where several share one, shape (tests,).
    setting: npt.NDArray[np.intp] | None = None

    @property
    def total(self) -> FloatArray:
        """Mean squared error of each test."""
        return self.between + self.within

    @property
    def rms(self) -> float:
        """RMS over all tests, each with the same weight."""
        return float(np.sqrt(np.mean(self.total)))


def errors_of_tests(campaign: BinnedTests, residual: FloatArray) -> ErrorsByTest:
    """Return the errors of the tests from residuals in the bins, shape (m,)."""
    mean, square = campaign.of_tests(residual), campaign.of_tests(residual**2)
    return ErrorsByTest(mean**2, np.maximum(square - mean**2, 0.0), campaign.setting)


def mean_of(errors: Sequence[ErrorsByTest]) -> ErrorsByTest:
    """Return the mean of several errors of the same tests."""
    return ErrorsByTest(
        np.mean([e.between for e in errors], axis=0),
        np.mean([e.within for e in errors], axis=0),
        errors[0].setting,
    )


def refitted(base: BaseLaw) -> bool:
    """Return whether the model itself is fitted anew for every judgement, as `refine` does, and not taken as it is."""
    law = base.model.base if isinstance(base.model, ComposedFriction) else base.model
    return isinstance(law, FrictionModel) and law.form != "flexible" and not base.fixed


@dataclass
class UnseenTests:
    """Residuals of a model, with and without effects, on tests that each fit did not see."""

    campaign: BinnedTests
    base: BaseLaw
    seed: int = 0  #: Of the folds.
    #: Called after each set of effects that was fitted.
    told: Callable[[], None] = field(default=lambda: None, repr=False)
    _kept: dict[tuple[str, ...], FloatArray] = field(default_factory=dict, repr=False)
    _fitted: dict[tuple[str, ...], FittedTerms] = field(default_factory=dict, repr=False)

    @property
    def possible(self) -> bool:
        """Whether there are enough tests to leave some out."""
        return len(self.campaign.tests) >= LEAST_TESTS

    @property
    def fold_of_test(self) -> npt.NDArray[np.intp]:
        """Fold of each test."""
        return folds_of(self.campaign, self.seed)

    def residual(self, effects: Sequence[Effect] = ()) -> FloatArray:
        """Return measured minus predicted mu in the bins, shape (m,), of the model with `effects`."""
        key = tuple(sorted(e.name for e in effects))
        if key not in self._kept:
            pieces = self.campaign.pieces
            self._kept[key] = pieces.average(pieces.mu - self._predicted(effects))
            self.told()
        return self._kept[key]

    def errors(self, effects: Sequence[Effect] = ()) -> ErrorsByTest:
        """Return the errors of the model with `effects`, of averages over the bins."""
        return errors_of_tests(self.campaign, self.residual(effects))

    def fitted(self, effects: Sequence[Effect]) -> FittedTerms:
        """Return the model with `effects` fitted to all tests, once in whatever order."""
        names = [e.name for e in effects]
        key = tuple(sorted(names))
        if key not in self._fitted:
            self._fitted[key] = fit_terms(self.campaign, self.base, list(effects))
        known = self._fitted[key]
        return replace(known, terms=sorted(known.terms, key=lambda t: names.index(t.name)))

    def _predicted(self, effects: Sequence[Effect]) -> FloatArray:
        """Return what fits to all points of the other tests predict of averages of neighbouring points (`BinnedTests.pieces`)."""
        campaign, pieces, fold = self.campaign, self.campaign.pieces, self.fold_of_test
        anew = _with_effects(campaign, self.base, effects) if refitted(self.base) else None
        predicted = np.empty(len(pieces.mu))
        for k in np.unique(fold):
            unseen, held = fold[campaign.point_test] == k, fold[pieces.point_test] == k
            if anew is None:
                at_points = np.zeros(len(campaign.mu))
                at_points[unseen] = _beside(campaign, self.base, effects, unseen)
                found = campaign.over_pieces(at_points)[held]
            else:
                model, loads = anew
                fitted = _learned(model, loads, campaign.mu, ~unseen)
                found = predicted_measurements(
                    fitted, replace(pieces.loads, context=loads.context).take(held)
                )
            predicted[held] = near_measured(campaign.mu[~unseen], found)
        return predicted


def _with_effects(
    campaign: BinnedTests, law: BaseLaw, effects: Sequence[Effect]
) -> tuple[FrictionModel, TriboLoads]:
    """Return a model with further effects, to be fitted, and the loads with the metadata that it needs."""
    model = law.model
    if effects:
        base = model.base if isinstance(model, ComposedFriction) else model
        held = list(model.effects) if isinstance(model, ComposedFriction) else []
        model = ComposedFriction(clone(base), [*held, *effects])
    known = model.effects if isinstance(model, ComposedFriction) else []
    return model, with_all_metadata(campaign.loads, [m for e in known for m in getattr(e, "metadata", ())])


def _beside(campaign: BinnedTests, law: BaseLaw, effects: Sequence[Effect], unseen: Mask) -> FloatArray:
    """Return predictions of a law that is not refitted itself, with a shift and effects that the other tests determine."""
    part, own = _part(campaign, law, ~unseen)
    effects = as_fitted(campaign, effects)
    problem = solve_jointly(part, own, effects)
    coefficients, amplitudes = problem.solve(problem.shapes)
    held, other = _part(campaign, law, unseen)
    predicted = other.offset + other.columns @ coefficients
    mu = np.maximum(predicted, 0.0)
    for effect, shape, values in zip(effects, problem.shapes, amplitudes, strict=True):
        predicted = predicted + contribution(effect, held, mu, shape, values)
    return np.asarray(predicted)


def _part(campaign: BinnedTests, law: BaseLaw, rows: Mask) -> tuple[BinnedTests, BaseLaw]:
    """Return the points of some tests, and the law there."""
    return part_of(campaign, rows), replace(
        law, columns=law.columns[rows], offset=law.offset[rows], beside=()
    )
