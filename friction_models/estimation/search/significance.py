"""Significance: family-wise p-values by parametric bootstrap, and rivals that the data cannot rule out."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ...loads import FloatArray
from .scan import Fit, Prepared, Projector, drops

#: Inner products of each effect's columns with simulated noise, shape (g, amplitudes, replicates) each.
Simulated: TypeAlias = dict[str, FloatArray]

REPLICATES = 499
#: Tests from which on the signs of whole tests are drawn, instead of normal noise; settings that tests share always draw theirs.
FLIPPED = 20
#: Where one family of effects gains so many times as much by noise as another, they are judged apart.
DROWNS = 3.0
#: Contributions that correlate by more than this count as one.
TWINS = 0.98
#: A lead below this share of the winner's evidence may come from the formulas rather than from the mechanisms.
SAME = 0.02
#: A rival stays where the winner leads by as much in more than this share of data that hold the rival.
BY_CHANCE = 0.05


class Freedom(NamedTuple):
    """Degrees of freedom with which the scatter between tests, and slow noise along them, are estimated."""

    between: float
    along: float
    #: Whether tests share settings, so that the floor, which knows tests only, is not the noise.
    shared: bool = False


def null_noise(
    residual: FloatArray,
    level: FloatArray,
    test: npt.NDArray[np.intp],
    freedom: Freedom,
    rng: np.random.Generator,
    count: int,
    fitted: FloatArray | None = None,
) -> FloatArray:
    """Return whitened data in which nothing is missing, shape (m, count); `test` numbers the test of each bin, or its setting.

    The residual of every whole test, or setting of several, with a random sign (wild bootstrap; Cameron, Gelbach, Miller, Rev. Econ. Stat. 90
    (2008)): tests that scatter more, skewed noise, heavy tails and single odd tests stay as they are. A residual is smaller than
    the noise by what was `fitted` to it, orthonormal columns of shape (m, k) (MacKinnon, White, J. Econometrics 29 (1985) 305). With
    few tests there are too few signs: normal noise then, whose scale varies as that of a floor that was estimated from so little. What
    a common shift of a whole test, `level` (whitened ones), makes of a bin is known from the tests alone; the rest from all that lies
    along them.
    """
    tests = int(test.max()) + 1
    if tests >= FLIPPED or freedom.shared:
        signs = rng.choice([-1.0, 1.0], (tests, count))
        return _as_large_as_before(residual, level, test, fitted)[:, None] * signs[test]
    along = np.empty((len(residual), count))
    along[np.argsort(test, kind="stable")] = rng.standard_normal(along.shape)
    between = _common_to_tests(along, level, test)
    scales = [np.sqrt(f / rng.chisquare(f, count)) for f in (freedom.between, freedom.along)]
    return np.asarray(between * scales[0] + (along - between) * scales[1])


def _as_large_as_before(
    residual: FloatArray, level: FloatArray, test: npt.NDArray[np.intp], fitted: FloatArray | None
) -> FloatArray:
    """Return a residual as large as it was before columns were fitted, what tests have in common and the rest each by its own numbers."""
    if fitted is None:
        return residual
    tests, rows = int(test.max()) + 1, len(residual)
    between = _common_to_tests(residual[:, None], level, test)[:, 0]
    spent = float(np.sum(_common_to_tests(fitted, level, test) ** 2))
    larger = np.sqrt(tests / max(tests - spent, 1.0))
    along = np.sqrt((rows - tests) / max(rows - tests - (fitted.shape[1] - spent), 1.0))
    return np.asarray(between * larger + (residual - between) * along)


def _common_to_tests(white: FloatArray, level: FloatArray, test: npt.NDArray[np.intp]) -> FloatArray:
    """Return what common shifts of whole tests make of whitened columns, shape (m, k); the rest lies along the tests."""
    shift = np.zeros((int(test.max()) + 1, white.shape[1]))
    np.add.at(shift, test, level[:, None] * white)
    shift /= np.bincount(test, level**2)[:, None]
    return np.asarray(level[:, None] * shift[test])


def simulate(candidates: list[Prepared], project: Projector, noise: FloatArray) -> Simulated:
    """Return what every candidate sees of noise, shape (m, replicates)."""
    noise = project(noise)
    return {c.name: _products(c.columns, noise) for c in candidates}


def _products(columns: FloatArray, noise: FloatArray) -> FloatArray:
    """Return inner products of columns [m, g, amplitudes] with noise [m, replicates], one matrix product."""
    m, sets, amplitudes = columns.shape
    return (columns.reshape(m, -1).T @ noise).reshape(sets, amplitudes, -1)


class Significance:
    """Family-wise p-values of gains, from what every candidate gains in noise alone.

    Effects that show mostly along the tests are a family of their own where noise alone lets them gain far more than those that set
    tests apart, or far less, so that the one does not drown in the other; each family has half of the level then. So it is where
    something happens along the tests that the floor does not describe, and with few tests, which tell little about the scatter
    between them, and much about noise along them.

    `level`, shape (m,), are whitened ones; `test`, shape (m,), numbers the test of each bin, or its setting.
    """

    def __init__(
        self, candidates: list[Prepared], simulated: Simulated, level: FloatArray, test: npt.NDArray[np.intp]
    ) -> None:
        few = len(candidates) > 0 and int(test.max()) + 1 < FLIPPED
        self._along = {c.name: _shows_along(c, level, test) for c in candidates}
        gains: dict[bool, list[FloatArray]] = {}
        for c in candidates:
            own = drops(c, simulated[c.name])[0].max(axis=0) - c.penalty
            gains.setdefault(self._along[c.name], []).append(own)
        self._largest = {along: np.max(own, axis=0) for along, own in gains.items()}
        if len(self._largest) > 1 and not few and not _drown(*self._largest.values()):
            self._along = dict.fromkeys(self._along, False)
            self._largest = {False: np.maximum(*self._largest.values())}

    def p_value(self, name: str, gain: float) -> float:
        """Return the share of noise in which any effect of the family gains as much, times the number of families.

        It is 1 for an effect that these data could not show, as one that has its physical sign beside another one only.
        """
        if name not in self._along:
            return 1.0
        null = self._largest[self._along[name]]
        return min(1.0, len(self._largest) * float((1 + np.sum(null >= gain)) / (1 + null.size)))

    def needed(self, level: float, name: str | None = None) -> float:
        """Return the gain from which on p-values of an effect are below a level.

        Without a name that of all effects, not a number where two families need different ones.
        """
        families = len(self._largest)
        if name is None and families != 1:
            return 0.0 if not families else np.nan
        null = self._largest[self._along[name]] if name is not None else next(iter(self._largest.values()))
        return max(float(np.quantile(null, max(1.0 - level / families, 0.0))), 0.0)


def _drown(some: FloatArray, others: FloatArray) -> bool:
    """Return whether effects of one family need far more to stand out from noise than those of the other."""
    low, high = sorted(max(float(np.quantile(null, 0.95)), 1.0) for null in (some, others))
    return high > DROWNS * low


def _shows_along(candidate: Prepared, level: FloatArray, test: npt.NDArray[np.intp]) -> bool:
    """Return whether most of what a candidate changes differs along the tests, and not from test to test."""
    columns = candidate.columns.reshape(len(test), -1)
    between = np.sum(_common_to_tests(columns, level, test) ** 2, axis=0)
    total = np.sum(columns**2, axis=0)
    seen = total > 0.0
    return bool(seen.any() and np.median(between[seen] / total[seen]) < 0.5)


def confusion_set(ranking: list[Fit], simulated: Simulated) -> list[str]:
    """Return the effects that the data cannot tell from the winner, the winner first.

    For each rival, data are simulated from its own fit. It stays in the set if the winner leads by as much as observed in
    more than `BY_CHANCE` of these data. Noise hardly matters beside a strong effect; a small lead then only shows which formula
    happens to fit better, so it does not count.
    """
    winner = ranking[0]
    kept = [winner.name]
    for rival in ranking[1:]:
        if rival.gain <= 0.25 * winner.gain:
            continue
        if alike(winner, rival) > TWINS or winner.evidence - rival.evidence < SAME * winner.evidence:
            kept.append(rival.name)
            continue
        signal = rival.signal
        lead = _gains(winner.prepared, signal, simulated) - _gains(rival.prepared, signal, simulated)
        if float(np.mean(lead >= winner.gain - rival.gain)) > BY_CHANCE:
            kept.append(rival.name)
    return kept


def alike(first: Fit, second: Fit) -> float:
    """Return the correlation of two fitted contributions in the data, beyond the base."""
    a, b = first.signal, second.signal
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 0 else 0.0


def stays_first(ranking: list[Fit], simulated: Simulated) -> float:
    """Return how often the winner comes first again in data simulated from its own fit."""
    winner = ranking[0]
    own = _gains(winner.prepared, winner.signal, simulated)
    others = [_gains(r.prepared, winner.signal, simulated) for r in ranking[1:8]]
    return float(np.mean(own > np.max(others, axis=0))) if others else 1.0


def _gains(prepared: Prepared, signal: FloatArray, simulated: Simulated) -> FloatArray:
    scores = simulated[prepared.name] + np.einsum("mga,m->ga", prepared.columns, signal)[:, :, None]
    return drops(prepared, scores)[0].max(axis=0) - prepared.penalty
