"""Errors in the loads, honoured by a fit: each point weighs by the variance that its loads give the law beside its scatter.

The weights are those of the effective variance (Orear, Am. J. Phys. 50 (1982) 912), ``1 / (s^2 + sum (dmu/dload u_load)^2)``, kept
while the law is fitted and then computed anew (Clutton-Brock, Technometrics 9 (1967) 261). The scatter s about the law, which holds
all that is not an error of the loads, makes the weighted mean square of the residuals 1 (Paule, Mandel, J. Res. NBS 87 (1982) 377).

Weights say which points to trust. They do not undo what errors in the loads do to all points: slopes come out too flat, as in any
regression on loads with errors, and an error that all tests share (a wrong heat transfer coefficient) shifts the law.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypedDict

import numpy as np
import numpy.typing as npt

from ..common import InputError
from ..loads import QUANTITIES, FloatArray, TriboLoads
from .tangent import polynomial_columns

#: Fits to weights; those of straight laws no longer change after two or three.
ROUNDS = 6
#: Change of a weight, relative to their mean, below which they count as settled.
SETTLED = 1e-4
#: Least share of the squares that counts as scatter. What is stated of the loads is often an estimate on the safe side: where
#: it is too large, weights without such a limit would rest the law on a few points.
LEAST_SCATTER = 0.25
#: Share of the points that weighted ones must be worth for all to weigh alike: nothing is to be won, and the number of trees, for
#: example, changes with the least weight.
ALIKE = 0.99
#: Degree of the polynomial whose slopes stand for those of a flexible family.
DEGREE = 2

#: Fits a law with weights (None: all alike), and returns its mu at each of several sets of loads.
Refit = Callable[[Sequence[TriboLoads], FloatArray | None], Sequence[FloatArray]]


class HonouredUncertainty(TypedDict):
    """What the card says of uncertain loads that a fit has honoured."""

    #: Number of equally good points that know as much (Kish, Survey Sampling, 1965).
    effective_points: float
    #: Scatter about the law beside the errors of the loads.
    scatter: float
    #: Root mean square of mu that each load alone gives the law.
    by_load: dict[str, float]


@dataclass(frozen=True)
class LoadWeights:
    """Weights of points whose loads are uncertain.

    Examples
    --------
    Two points as good as the scatter of 0.001, and one whose loads give three times its variance beside it:

    >>> found = LoadWeights.of(np.array([0.001, -0.001, 0.002]), {"T": np.array([0.0, 0.0, 3e-6]) ** 0.5})
    >>> found.points.round(3).tolist(), round(found.scatter, 6)
    ([1.333, 1.333, 0.333], 0.001)
    """

    #: Mean 1; shape (n,).
    points: FloatArray
    scatter: float
    by_load: dict[str, float]

    @classmethod
    def of(cls, residual: FloatArray, changes: dict[str, FloatArray]) -> LoadWeights:
        """Return the weights from the residuals of a law and its change by the uncertainty of each load, each of shape (n,)."""
        squares = np.sum([c**2 for c in changes.values()], axis=0)
        variance = scatter_beside(residual, squares)
        weights = 1.0 / (variance + squares)
        by_load = {load: float(np.sqrt(np.mean(c**2))) for load, c in changes.items()}
        return cls(weights / weights.mean(), float(np.sqrt(variance)), by_load)

    @property
    def effective(self) -> float:
        """Number of equally good points that know as much."""
        return float(self.points.sum() ** 2 / np.sum(self.points**2))

    @property
    def used(self) -> FloatArray | None:
        """The weights; None where they are so nearly alike that a fit takes all points alike."""
        return None if self.effective >= ALIKE * len(self.points) else self.points

    def to_dict(self) -> HonouredUncertainty:
        """Return what the card says."""
        return {
            "effective_points": self.effective,
            "scatter": self.scatter,
            "by_load": dict(self.by_load),
        }


@dataclass(frozen=True)
class FitWeights:
    """Weights of a fit, and what they honour."""

    #: Mean 1; None: all weigh alike; shape (n,).
    points: FloatArray | None
    #: Where they come from uncertain loads.
    by_loads: LoadWeights | None = None

    @property
    def arguments(self) -> dict[str, FloatArray]:
        """Further arguments for a family's `_fit`; none where all weigh alike."""
        return {} if self.points is None else {"sample_weight": self.points}


def checked_weights(given: npt.ArrayLike, count: int) -> FloatArray:
    """Return weights that somebody gave, scaled to mean 1.

    Raises InputError: not one for each of `count` points, negative, not finite, or all 0.
    """
    weights = np.asarray(given, dtype=np.float64)
    if weights.shape != (count,):
        raise InputError(f"fit: sample_weight has shape {weights.shape}; allowed: ({count},), one a point")
    wrong = ~(np.isfinite(weights) & (weights >= 0.0))
    if wrong.any():
        row = int(np.argmax(wrong))
        raise InputError(f"fit: sample_weight, row {row}: {weights[row]}; allowed: finite numbers from 0 on")
    if not weights.any():
        raise InputError("fit: sample_weight is 0 at all points; allowed: more than 0 at one or more")
    return np.asarray(weights / weights.mean())


def scatter_beside(residual: FloatArray, squares: FloatArray) -> float:
    """Return the variance s^2 beside known variances, shape (n,), with ``mean(residual^2 / (s^2 + squares)) = 1``.

    It is at least `LEAST_SCATTER` of the mean square of the residuals, and of the known variances.

    Examples
    --------
    Residuals of 0.005, of which 0.003 is known to come from the loads:

    >>> round(scatter_beside(np.array([0.005, -0.005]), np.array([9e-6, 9e-6])) ** 0.5, 6)
    0.004
    """
    from scipy.optimize import brentq

    seen = float(np.mean(residual**2))
    least = LEAST_SCATTER * max(seen, float(np.mean(squares)))

    def excess(variance: float) -> float:
        return float(np.mean(residual**2 / (variance + squares))) - 1.0

    if not least > 0.0 or excess(least) <= 0.0:
        return max(least, 1e-300)
    return float(brentq(excess, least, 2.0 * seen, xtol=1e-6 * seen))


def load_weights(loads: TriboLoads, mu: FloatArray, refit: Refit) -> LoadWeights | None:
    """Return the weights by which a fit to `mu`, shape (n,), honours the stated uncertainties of its loads; None without any.

    `refit` fits the law, or what stands for it. Raises InputError: what `TriboLoads.stated_uncertainty` refuses.
    """
    stated = loads.stated_uncertainty()
    if not stated:
        return None
    plain = loads.without_uncertainty()
    places = [plain, *(raised_loads(plain, load, u) for load, u in stated.items())]
    found: LoadWeights | None = None
    for _ in range(ROUNDS):
        usual, *raised = refit(places, None if found is None else found.points)
        changes = {load: there - usual for load, there in zip(stated, raised, strict=True)}
        before, found = found, LoadWeights.of(mu - usual, changes)
        if before is not None and np.max(np.abs(found.points - before.points)) < SETTLED:
            break
    assert found is not None
    return found


def by_polynomial(mu: FloatArray) -> Refit:
    """Return the fit of a second-order polynomial, which stands for a family that is flexible or slow to fit."""

    def refit(places: Sequence[TriboLoads], weights: FloatArray | None) -> list[FloatArray]:
        together = TriboLoads.from_array(np.vstack([p.as_array() for p in places]))
        columns = polynomial_columns(together, DEGREE)
        n = len(mu)
        root = np.ones(n) if weights is None else np.sqrt(weights)
        coefficients = np.linalg.lstsq(root[:, None] * columns[:n], root * mu, rcond=1e-10)[0]
        return np.split(columns @ coefficients, len(places))

    return refit


def honoured_sentence(facts: HonouredUncertainty, points: int) -> str:
    """Return what a fit made of uncertain loads, in one sentence.

    Examples
    --------
    >>> honoured_sentence({"effective_points": 812.4, "scatter": 0.004, "by_load": {"T": 0.002, "psi": 0.0001}}, 1000)
    'Uncertain loads honoured: weights by effective variance, worth 812 equally good points of 1000; mostly T, which gives mu 0.00200 beside a scatter of 0.00400.'
    """
    worst = max(facts["by_load"], key=lambda load: facts["by_load"][load])
    if facts["by_load"][worst] == 0.0:
        return "Uncertain loads change nothing: the law does not depend on them."
    gives = f"mostly {worst}, which gives mu {facts['by_load'][worst]:.5f} beside a scatter of {facts['scatter']:.5f}"
    if facts["effective_points"] >= ALIKE * points:
        return f"Uncertain loads ({gives}) say nearly the same of all points: all weigh alike."
    return (
        f"Uncertain loads honoured: weights by effective variance, worth {facts['effective_points']:.0f} equally good points of "
        f"{points}; {gives}."
    )


def raised_loads(loads: TriboLoads, load: str, by: FloatArray) -> TriboLoads:
    """Return the points with one load raised by `by`, shape (n,), at most to its physical limit."""
    changed: dict[str, Any] = {load: np.minimum(getattr(loads, load) + by, QUANTITIES[load].upper)}
    return replace(loads, **changed)
