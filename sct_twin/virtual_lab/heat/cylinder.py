"""The specimen: an insulated cylinder between contact and punch, by its eigenfunctions.

Across the section they are Bessel functions of the radius times cosines of the angle, along the axis cosines that fit
the film at the punch (Carslaw and Jaeger, chapters III and VIII). Under a flux that is constant over a step the
amplitude of each goes on in closed form, so no step is too long and no layer too thick.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from scipy.special import jnp_zeros, jv, polygamma

from friction_models.loads import FloatArray

from .bodies import Kirchhoff

#: Axial eigenfunctions; what the others would add is taken to be in balance with the flux.
AXIAL = 96
#: Eigenfunctions across: orders in the angle, and roots of each. What they do not hold does not spread sideways.
ORDERS, ROOTS = 6, 6


class Cylinder:
    """The face of a cylinder, in cells; half of it, for symmetry.

    - `x`, `y`, shape (n,): centres of the cells, which are equally large [mm].
    - `radius`, `height` [mm].
    - `steel`: transformed temperature of the body; that of the punch is 0.
    - `transfer`: of the film at the far end [N/(mm s K)].
    - `start`: temperature at the start [degC].
    """

    def __init__(
        self,
        x: FloatArray,
        y: FloatArray,
        radius: float,
        height: float,
        steel: Kirchhoff,
        transfer: float,
        start: float,
    ) -> None:
        modes, squares = _across(x / radius, y / radius)
        self._to = modes.T
        self._from = modes
        lateral = squares / radius**2
        # What is left over spreads sideways at least as fast as the last of them; it is next to nothing.
        self._lateral = np.append(lateral, lateral[-1])
        self._diffusivity = steel.diffusivity
        beta = _axial_roots(transfer * height / steel.conductivity) / height
        norm = 0.5 * height + np.sin(2.0 * beta * height) / (4.0 * beta)
        self._beta2 = beta**2
        capacity = steel.conductivity / steel.diffusivity
        self._gain = 1.0 / (capacity * norm)
        self._rest = 2.0 * height / (steel.conductivity * math.pi**2) * float(polygamma(1, AXIAL))
        self._one = np.outer(self._to.sum(axis=1), np.sin(beta * height) / (beta * norm))
        self._held = steel.transformed(start) * self._one
        self._left = np.zeros((len(x), AXIAL))

    def warm(self, rise: float) -> None:
        """Raise the transformed temperature everywhere by the same amount [K]."""
        self._held = self._held + rise * self._one

    def begin(self, dt: float) -> FloatArray:
        """Begin a step of `dt` [s]; return the transformed temperature at its end without flux, shape (n,)."""
        rate = self._diffusivity * (self._lateral[:, None] + self._beta2)
        decay = np.exp(-rate * dt)
        self._grow = self._gain * -np.expm1(-rate * dt) / rate
        self._held = self._held * decay[:-1]
        self._left = self._left * decay[-1]
        self._response = self._grow.sum(axis=1) + self._rest
        return np.asarray(self._from @ self._held.sum(axis=1) + self._left.sum(axis=1))

    def respond(self, flux: FloatArray) -> FloatArray:
        """Return what a flux [N/(mm s)] of this step adds to the transformed temperature at its end."""
        amplitude = self._to @ flux
        rest = flux - self._from @ amplitude
        return np.asarray(self._from @ (self._response[:-1] * amplitude) + self._response[-1] * rest)

    def end(self, flux: FloatArray) -> None:
        """End the step with the flux that it had."""
        amplitude = self._to @ flux
        rest = flux - self._from @ amplitude
        self._held += amplitude[:, None] * self._grow[:-1]
        self._left += rest[:, None] * self._grow[-1]

    @property
    def stiffest(self) -> float:
        """Return the largest response to a unit of flux in this step."""
        return float(self._response[0])


def _across(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return eigenfunctions of the unit circle at points, orthonormal over the cells, and their squared roots."""
    roots = [(float(root), order) for order in range(ORDERS) for root in jnp_zeros(order, ROOTS)]
    found = sorted([(0.0, 0), *roots])[: max(1, len(x) // 3)]
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    columns = np.column_stack([jv(order, root * r) * np.cos(order * angle) for root, order in found])
    q, triangle = np.linalg.qr(columns)
    kept = np.abs(np.diag(triangle)) > 1e-3 * np.abs(np.diag(triangle)).max()
    return q[:, kept], np.array([root**2 for root, _ in found])[kept]


@lru_cache(maxsize=64)
def _axial_roots(biot: float) -> FloatArray:
    """Return the first roots of b tan b = `biot`, by bisection."""
    low = np.arange(AXIAL) * math.pi
    high = low + 0.5 * math.pi
    # Sine and cosine change their sign from branch to branch.
    sign = (-1.0) ** np.arange(AXIAL)
    for _ in range(60):
        middle = 0.5 * (low + high)
        below = sign * (middle * np.sin(middle) - biot * np.cos(middle)) < 0.0
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return 0.5 * (low + high)
