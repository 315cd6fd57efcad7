"""Parameters of effects as results: fitted values with intervals, a test as the unit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from ...effects.base import Effect
from ...effects.parameters import ShapeParameter
from ...loads import FloatArray
from ..campaign.binned_tests import BinnedTests
from ..campaign.factors import as_fitted
from ..search.base_law import BaseLaw
from ..search.law_signs import largest_amplitudes
from .joint_problem import JointProblem, solve_jointly

#: Step of shape parameters for the derivative, relative to their value.
STEP = 1e-3
#: Correlation of two estimates from which on it is said.
TIED = 0.9
#: Of the squares of what the data tell best: what they tell less of is left open.
OPEN = 1e-10
#: Standard deviations from one end of what a parameter is sought in to the other.
REACHES = 2.0
#: How sure the mean of pooled levels is zero, by what the data say of one level.
MEAN_KNOWN = 1e3


@dataclass(frozen=True)
class FittedTerm:
    """An effect with its fitted parameters."""

    effect: Effect
    #: Fitted parameters by name.
    shape: dict[str, float]
    amplitudes: dict[str, float]
    #: 95 % intervals of those that were fitted; shape parameters stay within their bounds, amplitudes have their physical sign.
    intervals: dict[str, tuple[float, float]]
    binned: FloatArray  #: Its share of mu in the bins, shape (m,).
    #: Between which values the shape parameters were sought: what is allowed, and not too far from what was tested.
    sought: dict[str, tuple[float, float]]
    #: Whether by what the tests tell not all amplitudes may be zero, whatever the levels of their plan leave open.
    sized: bool

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.name

    @property
    def at_bounds(self) -> list[str]:
        """Shape parameters that the fit drove to a bound of what is allowed."""
        return [s.name for s in self._fitted if s.at_bound(self.shape[s.name])]

    @property
    def at_limits(self) -> list[str]:
        """Shape parameters that the fit drove as far from the tests as they were sought, though more is allowed."""
        return [
            s.name
            for s in self._fitted
            if s.name not in self.at_bounds and s.at_bound(self.shape[s.name], self.sought[s.name])
        ]

    @property
    def not_known(self) -> list[str]:
        """Shape parameters of which every value that was sought is possible: their intervals are the bounds of the search."""
        return [
            s.name
            for s in self._fitted
            if all(s.at_bound(edge, self.sought[s.name]) for edge in self.intervals[s.name])
        ]

    @property
    def _fitted(self) -> list[ShapeParameter]:
        return [s for s in self.effect.free_shapes if s.name in self.intervals]


@dataclass(frozen=True)
class FittedTerms:
    """Law and effects fitted together."""

    terms: list[FittedTerm]
    residual: FloatArray  #: Bin means of measured mu minus the whole law, shape (m,).
    #: Pairs of parameters, as ``effect.parameter``, that are tied by more than `TIED`, the strongest first.
    correlations: list[tuple[str, str, float]]

    def base(self, campaign: BinnedTests) -> FloatArray:
        """Return what the law alone, without the effects, has of measured mu in the bins, shape (m,)."""
        effects = np.sum([t.binned for t in self.terms], axis=0)
        return np.asarray(campaign.average(campaign.mu) - self.residual - effects)


def fit_terms(campaign: BinnedTests, law: BaseLaw, effects: list[Effect]) -> FittedTerms:
    """Fit a law together with effects, as `refine` does, and return the effects with intervals.

    The intervals follow from the linearised fit, with the scatter of the tests' own scores as the unit (cluster-robust
    covariance; Liang, Zeger, Biometrika 73 (1986)), and are not narrower than those of independent white residuals. The
    score of a test is that of a fit without it (Bell, McCaffrey, Survey Methodology 28 (2002)): a fit follows the few
    tests that tell of a parameter, so what it leaves of them says too little.

    Offsets of pooled levels are those against the mean of these levels, and what draws them towards zero is part of what is known.
    """
    if not effects:
        return FittedTerms([], np.empty(0), [])
    effects = as_fitted(campaign, effects)
    problem = solve_jointly(campaign, law, effects)
    effects = problem.effects
    coefficients, amplitudes = problem.solve(problem.shapes)
    blocks = problem.columns(problem.shapes)
    residual = problem.y - problem.base @ coefficients
    for block, values in zip(blocks, amplitudes, strict=True):
        residual = residual - block @ values
    names, columns, places = _jacobian(problem, blocks, amplitudes)
    known = _known_before(problem, blocks, columns, places)
    sought = _sought(problem, blocks, columns, places)
    (width, told), covariance = _half_widths(campaign, problem, columns, residual, known, sought)
    terms = []
    for k, (effect, shape, values, block) in enumerate(
        zip(effects, problem.shapes, amplitudes, blocks, strict=True)
    ):
        named = {a.name: float(v) for a, v in zip(effect.amplitudes, values, strict=True)}
        limits, intervals = {s.name: problem.limits(k, s) for s in effect.free_shapes}, {}
        for name, place in places[k].items():
            half = float(width[problem.base.shape[1] + place])
            if name in named:
                low, high = named[name] - half, named[name] + half
                sign = next(a.sign for a in effect.amplitudes if a.name == name)
                intervals[name] = (max(low, 0.0) if sign > 0 else low, min(high, 0.0) if sign < 0 else high)
            else:
                bounds = next(s for s in effect.shapes if s.name == name)
                middle = bounds.inner(shape[name])
                low, high = limits[name]
                intervals[name] = (
                    max(bounds.outer(middle - half), low),
                    min(bounds.outer(middle + half), high),
                )
        sized = any(abs(v) > told[problem.base.shape[1] + places[k][name]] for name, v in named.items())
        terms.append(FittedTerm(effect, dict(shape), named, intervals, block @ values, limits, sized))
    return FittedTerms(
        terms, residual, _tied(names, covariance[problem.base.shape[1] :, problem.base.shape[1] :])
    )


def _jacobian(
    problem: JointProblem, blocks: list[FloatArray], amplitudes: list[FloatArray]
) -> tuple[list[str], FloatArray, list[dict[str, int]]]:
    """Return the parameters, the whitened derivatives of the law by them, base first, and where each effect's stand."""
    names: list[str] = []
    columns = [problem.base]
    places: list[dict[str, int]] = [{} for _ in blocks]
    for k, (effect, block) in enumerate(zip(problem.effects, blocks, strict=True)):
        for j, amplitude in enumerate(effect.amplitudes):
            places[k][amplitude.name] = len(names)
            names.append(f"{effect.name}.{amplitude.name}")
            columns.append(block[:, [j]])
        for s in effect.free_shapes:
            if s.name == "deviating":
                continue
            middle = s.inner(problem.shapes[k][s.name])
            step = STEP if s.logarithmic else STEP * max(abs(middle), 1e-3 * (s.upper - s.lower))
            moved, values = [], []
            for way in (-1.0, 1.0):
                shapes = [dict(shape) for shape in problem.shapes]
                shapes[k][s.name] = s.outer(middle + way * step)  # at a bound one side remains
                moved.append(problem.columns(shapes)[k] @ amplitudes[k])
                values.append(s.inner(shapes[k][s.name]))
            places[k][s.name] = len(names)
            names.append(f"{effect.name}.{s.name}")
            columns.append(((moved[1] - moved[0]) / (values[1] - values[0]))[:, None])
    return names, np.asarray(problem.whiten(np.column_stack(columns))), places


def _known_before(
    problem: JointProblem, blocks: list[FloatArray], columns: FloatArray, places: list[dict[str, int]]
) -> FloatArray:
    """Return what is known of the parameters beside the data, for columns of norm 1, shape (free, free).

    That is what draws offsets of levels towards zero, and that their mean is that of the levels: without it, it is tied to the base.
    """
    known = np.zeros((columns.shape[1], columns.shape[1]))
    if not any(e.pooled for e in problem.effects):
        return known
    p = problem.base.shape[1]
    matrix = np.column_stack([problem.base, *blocks])
    free = np.linalg.lstsq(problem.whiten(matrix), problem.whiten(problem.y), rcond=1e-10)[0]
    pull, first = problem.pull(blocks, free), 0
    for effect, own, block in zip(problem.effects, places, blocks, strict=True):
        if effect.pooled:
            at = p + np.array([own[a.name] for a in effect.amplitudes])
            drawn = pull[first : first + len(at)] ** 2
            known[at, at] += drawn
            mean = drawn * np.linalg.norm(columns[:, at], axis=0)
            known[np.ix_(at, at)] += MEAN_KNOWN * np.outer(mean, mean) / max(float(mean @ mean), 1e-300)
        first += block.shape[1]
    return known


def _sought(
    problem: JointProblem, blocks: list[FloatArray], columns: FloatArray, places: list[dict[str, int]]
) -> FloatArray:
    """Return the standard deviations of parameters that may lie anywhere they are sought, for columns of norm 1; 0 of the base."""
    found = np.zeros(columns.shape[1])
    p = problem.base.shape[1]
    for k, (effect, own, block) in enumerate(zip(problem.effects, places, blocks, strict=True)):
        for amplitude, most in zip(
            effect.amplitudes, largest_amplitudes(problem.campaign, block), strict=True
        ):
            found[p + own[amplitude.name]] = most
        for shape in effect.free_shapes:
            if shape.name in own:
                low, high = (shape.inner(end) for end in problem.limits(k, shape))
                found[p + own[shape.name]] = high - low
    return found * np.linalg.norm(columns, axis=0) / REACHES


def _half_widths(
    campaign: BinnedTests,
    problem: JointProblem,
    columns: FloatArray,
    residual: FloatArray,
    known: FloatArray,
    sought: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return half of the 95 % interval of every parameter, as it is and as it were without what is left open, shape (2, free), and
    their covariance; `known` is that of `_known_before`.

    Along what the levels of a plan leave open a parameter may lie anywhere in what is `sought`, that of `_sought`.
    """
    tests, free = len(campaign.tests), columns.shape[1]
    norms = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    unit = columns / norms
    size, along = np.linalg.eigh(unit.T @ unit + known)
    told = size > OPEN * size[-1]
    inverse = along[:, told] / size[told] @ along[:, told].T
    untold = along[:, ~told] @ along[:, ~told].T
    left_open = untold * sought**2 @ untold
    white = np.asarray(problem.whiten(residual))
    plain = inverse * float(white @ white) / max(len(white) - free, 1)
    scores = np.zeros((tests, free))
    np.add.at(scores, campaign.test, unit * white[:, None])
    for test in range(tests):
        own = unit[campaign.test == test]
        scores[test] = np.linalg.lstsq(np.eye(free) - own.T @ own @ inverse, scores[test], rcond=1e-6)[0]
    clustered = inverse @ (scores.T @ scores) @ inverse * (tests - 1) / tests
    variance = np.maximum(np.maximum(np.diag(clustered), np.diag(plain)), 0.0)
    chosen = (clustered if tests > free else plain) + left_open
    degrees = max(min(tests - 1, len(white) - free), 1)
    both = np.sqrt([variance + np.diag(left_open), variance])
    return float(stdtrit(degrees, 0.975)) * both / norms, chosen / np.maximum(np.outer(norms, norms), 1e-300)


def _tied(names: list[str], covariance: FloatArray) -> list[tuple[str, str, float]]:
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    correlation = covariance / np.outer(size, size)
    pairs = [
        (a, b, float(np.clip(correlation[i, j], -1.0, 1.0)))
        for i, a in enumerate(names)
        for j, b in enumerate(names)
        if i < j and abs(correlation[i, j]) > TIED and not _levels_of_one(a, b)
    ]
    return sorted(pairs, key=lambda p: -abs(p[2]))


def _levels_of_one(first: str, second: str) -> bool:
    """Return whether two parameters are offsets of levels of one effect, which are known to differ by what they are."""
    return "[" in first and first.split("[")[0] == second.split("[")[0]
