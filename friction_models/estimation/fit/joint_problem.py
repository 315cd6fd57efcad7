"""Least squares of base and effects: linear coefficients inside, shape parameters outside (variable projection).

With enough tests the squares are weighed by the covariance of the noise floor (generalised least squares),
so that the offsets of the tests do not bias what varies within them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from ...effects.base import Effect
from ...effects.empirical.effect import Empirical
from ...effects.parameters import ShapeParameter, Spans
from ...loads import LOAD_NAMES, FloatArray
from ..campaign.binned_tests import BinnedTests
from ..noise.layout import Layout
from ..noise.noise_floor import NoiseFloor, Whitener, estimate
from ..search.base_law import BaseLaw
from ..search.candidates import bin_means, contribution, evaluate, spans_of
from ..search.law_signs import largest_amplitudes
from ..search.search_round import flexible_mean
from .beside_base import BesideBase, Columns
from .pooling import by_test, shrinkage
from .scanned_shapes import scanned_shapes
from .shape_fit import fitted_shapes

LEAST_TESTS = 6
#: Most rounds in which effects get the mu that they depend on, and the change of mu, over the scatter of the data, that calls for
#: no further one.
ROUNDS, SAME_MU = 3, 0.03
#: Of the squares of a column: what one test alone determines is nothing without it.
RIDGE = 1e-10
#: Weights by the covariance are given up only where the error of tests left out falls below this share.
KEEP_WEIGHTS = 0.98
#: The same for empirical terms, which were chosen by the weights: another curve must be better by more.
KEEP_CURVE = 0.95
#: A contribution that scatters as much as all of mu counts like so many residuals of the usual size: where levels of a plan leave
#: open how large effect and base are that cancel each other, they are no larger than it takes.
RESTRAINT = 1.0
#: Columns of size one that differ by less than this are the same.
SCALED = 1e-9
#: Columns of effects that are kept while their shapes are sought.
MOST_KEPT = 32


def solve_jointly(
    campaign: BinnedTests, law: BaseLaw, effects: Sequence[Effect], weights: FloatArray | None = None
) -> JointProblem:
    """Return the least-squares problem of a law and effects with the best shape parameters in it."""
    problem = JointProblem(campaign, law, list(effects), weights)
    problem.weigh()
    problem.scan()
    for k in range(ROUNDS):
        if problem.update_own_mu() < SAME_MU and k:
            break
        problem.weigh()
        problem.optimise()
    problem.choose_weights()
    return problem


class JointProblem:
    """The least-squares problem of one fit."""

    def __init__(
        self, campaign: BinnedTests, law: BaseLaw, effects: list[Effect], weights: FloatArray | None = None
    ) -> None:
        self.campaign, self.law = campaign, law
        coefficients = np.linalg.lstsq(law.columns, campaign.mu - law.offset, rcond=1e-10)[0]
        self.mu = np.maximum(law.columns @ coefficients + law.offset, 0.0)
        self.base = campaign.average(law.columns)
        self.y = campaign.average(campaign.mu - law.offset)
        self.scatter = float(np.std(self.y)) or 1e-6
        self.spans = spans_of(campaign, self.mu)
        self.effects = [e.holding(_only_scaling(e, campaign, self.mu, self.spans)) for e in effects]
        self.grids = [e.grids(self.spans) for e in self.effects]
        self.shapes = [{n: float(g[len(g) // 2]) for n, g in grid.items()} for grid in self.grids]
        self.layout = Layout.of(campaign) if len(campaign.tests) >= LEAST_TESTS and campaign.grouped else None
        self.root = None if weights is None else np.sqrt(campaign.average(weights))
        self.whiten: Any = self._weighted(lambda values: values)
        self._known: tuple[Any, BesideBase] | None = None
        #: Slopes along the shape of one effect need the others as they were.
        self._blocks: dict[tuple[int, tuple[tuple[str, float], ...]], tuple[FloatArray, FloatArray]] = {}
        self.estimated: NoiseFloor | None = None

    def weigh(self) -> None:
        """Estimate the noise floor around base and effects, and weigh by it."""
        if self.layout is None:
            return
        mean = np.column_stack([self._flexible, *self.columns(self.shapes)])
        self.estimated = estimate(self.campaign, self.layout, self.y, mean, self.estimated)
        self.whiten = self._weighted(Whitener(self.layout, self.estimated, self.scatter))

    @cached_property
    def _flexible(self) -> FloatArray:
        """Columns that follow more than the base, the same in every round."""
        return flexible_mean(self.campaign, self.law.columns)

    def _weighted(self, whiten: Any) -> Any:
        """Return what whitens bins that have been multiplied by the roots of their weights."""
        root = self.root
        return whiten if root is None else lambda values: whiten(_rows(values, root))

    def choose_weights(self) -> None:
        """Fall back to ordinary least squares where it predicts tests left out better.

        Generalised least squares relies on what varies within tests. If the formula of an effect is not quite right, this can
        spoil the levels of the tests.
        """
        if self.layout is None:
            return
        keep = KEEP_CURVE if any(isinstance(e, Empirical) for e in self.effects) else KEEP_WEIGHTS
        weighted, shapes = self.whiten, self.shapes
        best = self._left_out()
        root = np.sqrt(self.campaign.count)
        self.whiten = self._weighted(lambda values: _rows(values, root))
        self.optimise()
        if self._left_out() > best * keep:
            self.whiten, self.shapes = weighted, shapes

    def _left_out(self) -> float:
        """Return the mean squared error in mu of tests that are left out one by one, at the shapes found.

        Offsets of levels are drawn towards zero as they are by all tests: without that, they and the level of the base are any.
        """
        blocks = self.columns(self.shapes)
        matrix = np.column_stack([self.base, *blocks])
        pull = np.r_[np.zeros(self.base.shape[1]), self._solved(self.shapes, blocks)[0].pull]
        white, target = self.whiten(matrix), self.whiten(self.y)
        scale = np.maximum(np.linalg.norm(white, axis=0), 1e-300)
        rows = white / scale
        inverse = np.linalg.inv(rows.T @ rows + np.diag(RIDGE + pull**2))
        x = inverse @ (rows.T @ target)
        error = self.y - (matrix / scale) @ x
        for start, end in pairwise([*self.campaign.first_bins, len(target)]):
            own = rows[start:end]
            along = inverse @ own.T
            # what the fit takes from the test itself is taken back (Sherman, Morrison, Woodbury)
            left = np.linalg.solve(np.eye(end - start) - own @ along, target[start:end] - own @ x)
            error[start:end] += (matrix[start:end] / scale) @ (along @ left)
        return float(self.campaign.count @ error**2 / self.campaign.count.sum())

    def columns(self, shapes: Sequence[Mapping[str, float]]) -> list[FloatArray]:
        """Return the basis of every effect in the bins, shape (m, amplitudes) each."""
        return [self._kept_block(k, shape)[0] for k, shape in enumerate(shapes)]

    def _kept_block(self, k: int, shape: Mapping[str, float]) -> tuple[FloatArray, FloatArray]:
        """Return the basis of an effect in the bins, shape (m, amplitudes), and by how much each column goes beyond them at rest."""
        key = k, tuple(shape.items())
        if key not in self._blocks:
            if len(self._blocks) == MOST_KEPT:
                self._blocks.clear()
            block = bin_means(self.effects[k], self.campaign, self.mu, shape)[:, 0]
            self._blocks[key] = block, self._reach(k, shape, block)
        return self._blocks[key]

    def _reach(self, k: int, shape: Mapping[str, float], block: FloatArray) -> FloatArray:
        """Return by how much more each column changes from rest on than it does in the tests, shape (amplitudes,); 0 with memory.

        Every sliding starts from rest, mostly slower than any speed of a plan.
        """
        effect = self.effects[k]
        if effect.states or "v_rel" not in effect.driver:
            return np.zeros(block.shape[1])
        at_rest = bin_means(effect, self._at_rest, self.mu[self.campaign.starts], shape)[:, 0]
        return np.ptp(np.vstack([block, at_rest]), axis=0) - np.ptp(block, axis=0)

    @cached_property
    def _at_rest(self) -> BinnedTests:
        # without its speed one point of a bin tells as much as all
        return self.campaign.first_of_bins.with_load("v_rel", np.zeros(len(self.campaign.starts)))

    def solve(
        self, shapes: Sequence[Mapping[str, float]], blocks: list[FloatArray] | None = None
    ) -> tuple[FloatArray, list[FloatArray]]:
        """Return the base's coefficients and the amplitudes of each effect, signs respected."""
        columns, x = self._solved(shapes, self.columns(shapes) if blocks is None else blocks)
        sizes = np.cumsum([0, *(len(e.amplitudes) for e in self.effects)])
        return columns.base(x), [x[a:b] / columns.scale[a:b] for a, b in pairwise(sizes)]

    def _rest(self, shapes: Sequence[Mapping[str, float]]) -> FloatArray:
        """Return the weighted residual of the best coefficients."""
        columns, x = self._solved(shapes, self.columns(shapes))
        return np.r_[columns.rest(x), columns.drawn(x)]

    def _solved(
        self, shapes: Sequence[Mapping[str, float]], blocks: list[FloatArray]
    ) -> tuple[Columns, FloatArray]:
        """Return the columns of all effects beside the base, and their amplitudes."""
        plain = np.column_stack([self.base[:, :0], *blocks])  # there may be no effects
        columns = self._beside.columns(self.whiten(plain))
        reach = np.concatenate(
            [plain[0, :0], *(self._kept_block(k, shape)[1] for k, shape in enumerate(shapes))]
        )
        columns.restrain(
            np.hypot(RESTRAINT * np.std(plain, axis=0) / self.scatter, reach / self.campaign.largest_mu)
        )
        if any(e.pooled for e in self.effects):
            x = columns.amplitudes()
            columns.draw(self.pull(blocks, np.r_[columns.base(x), x / columns.scale]))
        signs = np.array([a.sign for e in self.effects for a in e.amplitudes], dtype=float)
        most = columns.scale * largest_amplitudes(self.campaign, plain)
        return columns, columns.amplitudes(np.where(signs > 0, 0.0, -most), np.where(signs < 0, 0.0, most))

    @property
    def _beside(self) -> BesideBase:
        """The weighted base: once for all shapes that are tried."""
        if self._known is None or self._known[0] is not self.whiten:
            self._known = self.whiten, BesideBase(self.whiten(self.base), self.whiten(self.y))
        return self._known[1]

    def pull(self, blocks: list[FloatArray], x: FloatArray) -> FloatArray:
        """Return how much each amplitude is drawn towards zero beside a free fit `x`, base first: the offsets of pooled levels.

        In units of the norms of the whitened columns.
        """
        amplitudes, at = x[self.base.shape[1] :], 0
        pull = np.zeros(len(amplitudes))
        free = self.y - np.column_stack([self.base, *blocks]) @ x
        test = self.campaign.test if self.campaign.grouped else np.arange(len(free))
        for effect, block in zip(self.effects, blocks, strict=True):
            own = slice(at, at + block.shape[1])
            at += block.shape[1]
            if effect.pooled:
                level = by_test(free + block @ amplitudes[own], self.campaign.count, test)
                pull[own] = np.sqrt(shrinkage(level, by_test(block, self.campaign.count, test)))
        return pull

    def optimise(self) -> None:
        """Move the shape parameters to the least squares next to where they are."""
        self.shapes = fitted_shapes(
            self.effects,
            self.shapes,
            self.limits,
            self.spans,
            self._rest,
            max_nfev=30,
            xtol=1e-4,
            ftol=3e-5,
        )

    def limits(self, k: int, shape: ShapeParameter) -> tuple[float, float]:
        """Return between which values a shape parameter of effect `k` is sought."""
        return self.effects[k].limits(shape, self.grids[k][shape.name])

    def scan(self) -> None:
        """Take the best set of scan values of every effect beside the others."""
        candidates = [
            evaluate(e, self.campaign, self.mu, g) for e, g in zip(self.effects, self.grids, strict=True)
        ]
        self.shapes = scanned_shapes(candidates, self.base, self.y, self.whiten)

    def contribution(self, amplitudes: Sequence[FloatArray]) -> FloatArray:
        """Return the sum of all effects on the points, shape (n,)."""
        parts = zip(self.effects, self.shapes, amplitudes, strict=True)
        return np.sum([contribution(e, self.campaign, self.mu, s, a) for e, s, a in parts], axis=0)

    def update_own_mu(self) -> float:
        """Give effects that depend on the friction coefficient the one of the present fit; return its change over the scatter of mu."""
        if not any(e.needs_mu for e in self.effects):
            return 0.0
        before = self.mu
        coefficients, amplitudes = self.solve(self.shapes)
        for _ in range(2):
            own = self.law.columns @ coefficients + self.law.offset
            keep = [
                np.zeros_like(a) if e.kind == "fault" else a
                for e, a in zip(self.effects, amplitudes, strict=True)
            ]
            self.mu = np.maximum(own + self.contribution(keep), 0.0)
        self._blocks.clear()
        return float(np.sqrt(np.mean((self.mu - before) ** 2))) / self.scatter


def _only_scaling(effect: Effect, campaign: BinnedTests, mu: FloatArray, spans: Spans) -> dict[str, float]:
    """Return shape parameters that only scale an effect in these tests, as the amplitudes do, with the middle of what is sought.

    Where a load stays the same, nothing tells how the effect changes with it. Fitted all the same, such a parameter would leave the
    amplitude open as well.
    """
    if all(campaign.varies(load) for load in effect.driver if load in LOAD_NAMES):
        return {}
    grids = effect.grids(spans)
    middle = {name: float(values[len(values) // 2]) for name, values in grids.items()}
    found = {}
    for shape in effect.free_shapes:
        ends = [{**middle, shape.name: end} for end in effect.limits(shape, grids[shape.name])]
        low, high = (_of_size_one(bin_means(effect, campaign, mu, at)[:, 0]) for at in ends)
        if np.allclose(low, high, rtol=0.0, atol=SCALED):
            found[shape.name] = middle[shape.name]
    return found


def _of_size_one(columns: FloatArray) -> FloatArray:
    """Return columns, shape (m, k), divided by their norms; zeros stay."""
    return columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)


def _rows(values: FloatArray, by: FloatArray) -> FloatArray:
    """Return rows of `values`, shape (m,) or (m, k), multiplied by numbers of shape (m,)."""
    return values * (by if values.ndim == 1 else by[:, None])
