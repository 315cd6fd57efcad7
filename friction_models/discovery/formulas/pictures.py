"""What a fitted term adds to mu over its first load, with its interval."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from ...effects.base import EffectContext
from ...effects.empirical.effect import Empirical
from ...estimation.search.candidates import OPS
from ...expressions.ops import LoadColumns
from ...loads import LOAD_NAMES, FloatArray
from .bins import Bins
from .fit import Fitted, Shapes, Weigh

#: Places along the load; step of the logarithm of a shape parameter.
PLACES, STEP = 81, 1e-3
#: Where the second load of a term is held: these shares of its values over the tests lie below.
LEVELS = (0.1, 0.5, 0.9)


@dataclass(frozen=True)
class TermCurve:
    """What one term adds to mu, as fitted."""

    term: str  #: Name of the effect.
    load: str  #: Along which it is drawn.
    at: str  #: Where its second load is held, ``psi = 1.4``; empty for a term of one load.
    #: Values of the load within the tests; what is added to mu; 95 % interval of it, tests counting as one observation each.
    #: Shape (places,).
    x: FloatArray
    y: FloatArray
    low: FloatArray
    high: FloatArray


def term_curves(bins: Bins, weigh: Weigh, effects: Sequence[Empirical], fitted: Fitted) -> list[TermCurve]:
    """Return the curves of fitted terms; `weigh` is that of the fit."""

    def in_bins(shapes: Shapes) -> FloatArray:
        return np.column_stack([bins.evaluate(e, s) for e, s in zip(effects, shapes, strict=True)])

    covariance = _covariance(bins, weigh, effects, fitted, in_bins)
    tests = len(bins.campaign.tests)
    factor = float(stdtrit(max(tests - 1, 1), 0.975))
    curves = []
    for k, effect in enumerate(effects):
        load, *other = effect.driver
        low, high, *_ = bins.spans[f"range of {load}"]
        x = np.linspace(low, high, PLACES)
        levels = np.quantile(bins.loads[other[0]], LEVELS) if other else [0.0]
        for level in levels:
            held = {n: np.full((PLACES, 1), bins.spans[f"range of {n}"][0]) for n in LOAD_NAMES}
            held |= {load: x[:, None]} | ({other[0]: np.full((PLACES, 1), level)} if other else {})
            loads = LoadColumns(**held)

            def along(
                shapes: Shapes, k: int = k, effect: Empirical = effect, loads: LoadColumns = loads
            ) -> FloatArray:
                column = np.zeros((PLACES, len(effects)))
                column[:, k] = effect.basis(OPS, loads, shapes[k], EffectContext())[0][:, 0]
                return column

            slopes = _slopes(effects, fitted, along)
            y = along(fitted.shapes) @ fitted.amplitudes
            half = factor * np.sqrt(np.maximum(np.einsum("ni,ij,nj->n", slopes, covariance, slopes), 0.0))
            at = f"{other[0]} = {level:.3g}" if other else ""
            curves.append(TermCurve(effect.name, load, at, x, y, y - half, y + half))
    return curves


def _slopes(
    effects: Sequence[Empirical], fitted: Fitted, columns: Callable[[Shapes], FloatArray]
) -> FloatArray:
    """Return derivatives by the amplitudes and the logarithms of the free shape parameters, one column each."""
    found = [columns(fitted.shapes)]
    for k, effect in enumerate(effects):
        for s in effect.free_shapes:
            moved = []
            for sign in (1.0, -1.0):
                shapes = [dict(values) for values in fitted.shapes]
                shapes[k][s.name] *= float(np.exp(sign * STEP))
                moved.append(columns(shapes) @ fitted.amplitudes)
            found.append((moved[0] - moved[1])[:, None] / (2.0 * STEP))
    return np.column_stack(found)


def _covariance(
    bins: Bins,
    weigh: Weigh,
    effects: Sequence[Empirical],
    fitted: Fitted,
    in_bins: Callable[[Shapes], FloatArray],
) -> FloatArray:
    """Return the covariance of amplitudes and shape parameters by the scatter of whole tests (sandwich estimate)."""
    J = np.column_stack([weigh(bins.columns), weigh(_slopes(effects, fitted, in_bins))])
    scale = np.maximum(np.linalg.norm(J, axis=0), 1e-300)
    J = J / scale
    known = np.column_stack([bins.columns, in_bins(fitted.shapes)])
    white, y = weigh(known), weigh(bins.y)
    rest = y - white @ np.linalg.lstsq(white, y, rcond=1e-9)[0]
    scores = np.add.reduceat(J * rest[:, None], bins.campaign.first_bins, axis=0)
    inverse = np.linalg.pinv(J.T @ J, rcond=1e-8)
    whole = inverse @ (scores.T @ scores) @ inverse / np.outer(scale, scale)
    base = bins.columns.shape[1]
    return np.asarray(whole[base:, base:])
