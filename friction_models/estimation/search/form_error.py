"""Evidence for an effect when the formula of the catalogue is only approximately right.

An effect may deviate from its formula by smooth curves along its own loads. They have a Gaussian prior and are small beside
the effect. The marginal likelihood with them judges the mechanism rather than the formula (model discrepancy; Kennedy,
O'Hagan, J. R. Stat. Soc. B 63 (2001)).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...loads import LOAD_NAMES, FloatArray
from ..campaign.binned_tests import BinnedTests
from ..campaign.curves import curve, transformed
from ..noise.noise_floor import Whitener
from .scan import Fit, Projector, drops

#: RMS of the deviation over that of the effect itself.
FORM_ERROR = 0.1
#: Bends of a curve.
KNOTS = 8
#: Effects with less than this share of the largest gain keep the gain as their evidence.
WORTH = 0.1


class FormErrors:
    """Deviations along the loads of a campaign, whitened and without what the base can follow."""

    def __init__(self, campaign: BinnedTests, whiten: Whitener, project: Projector) -> None:
        self.campaign, self.whiten, self.project = campaign, whiten, project
        self.curves: dict[str, FloatArray] = {}

    def ranked(self, ranking: list[Fit], residual: FloatArray) -> list[Fit]:
        """Return the fits by their evidence, the largest first."""
        if not ranking:
            return []
        least = WORTH * max(ranking[0].gain, 0.0)
        weighed = [replace(f, evidence=self.evidence(f, residual)) if f.gain > least else f for f in ranking]
        return sorted(weighed, key=lambda f: -f.evidence)

    def evidence(self, fit: Fit, residual: FloatArray) -> float:
        """Return twice the log marginal likelihood of a fit over that of noise, less its penalty."""
        return evidence(fit, self._basis(fit), residual)

    def _basis(self, fit: Fit) -> FloatArray:
        """Return orthonormal deviations: curves along each load of the effect and of the effect's own value."""
        drivers = fit.effect.driver
        loads = [d for d in drivers if d in LOAD_NAMES and self.campaign.varies(d)]
        blocks = [self._curve(n) for n in loads]
        if len(loads) > 1:
            blocks.append(self.project(self.whiten(bends(fit.binned))))
        if not blocks:
            return np.empty((len(fit.binned), 0))
        return Projector(np.column_stack(blocks)).q

    def _curve(self, name: str) -> FloatArray:
        if name not in self.curves:
            self.curves[name] = self.project(self.whiten(curve(transformed(self.campaign, name), KNOTS)))
        return self.curves[name]


def evidence(fit: Fit, q: FloatArray, residual: FloatArray) -> float:
    """Return twice the log marginal likelihood of a fit over that of noise, less its penalty.

    `q`, shape (m, k), are orthonormal deviations that its form may have, whitened and beside the base; `residual`, shape (m,),
    is whitened, without the base.
    """
    k = q.shape[1]
    if not k:
        return fit.gain
    prepared = fit.prepared
    variance = form_variance(fit, k)
    taken = variance / (1.0 + variance)
    m, sets, amplitudes = prepared.columns.shape
    along = (q.T @ prepared.columns.reshape(m, -1)).reshape(k, sets, amplitudes)
    ahead = q.T @ residual
    gram = prepared.gram - taken * np.einsum("kga,kgb->gab", along, along)
    scores = np.einsum("mga,m->ga", prepared.columns, residual) - taken * np.einsum("kga,k->ga", along, ahead)
    drop = float(drops(replace(prepared, gram=gram), scores)[0].max())
    return drop + taken * float(ahead @ ahead) - k * float(np.log1p(variance)) - prepared.penalty


def form_variance(fit: Fit, count: int) -> float:
    """Return the variance of each of `count` deviations of a fit's form, in units of the noise."""
    signal = fit.signal
    return FORM_ERROR**2 * float(signal @ signal) / count


def bends(contribution: FloatArray) -> FloatArray:
    """Return deviations along the value of an effect itself, shape (m, 2)."""
    value = contribution - contribution.mean()
    value = value / max(float(value.std()), 1e-300)
    return np.column_stack([value**2, value**3])
