"""The plate: a half space under a source that moves over it, by Duhamel superposition of the heat of every step.

Heat released on the surface of a half space at one instant spreads as a Gaussian of the variance 2 a t in each direction
(Carslaw and Jaeger, section 10.2). Over square cells its integral is a product of one factor along and one across
the sliding direction. No grid in the plate, no step through its depth, no advection: what the source has
left behind follows from where it was and when.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from scipy.special import erf

from friction_models.loads import FloatArray

from .bodies import Kirchhoff

#: Gauss points in the root of the time of a step: of the step that ends now, and of those before it.
_NOW, _BEFORE = 8, 3
#: Where a Gaussian ends, in standard deviations times sqrt 2.
_END = 3.0


class HalfSpace:
    """Surface of a half space below the cells of a contact, in the frame of the contact; half of it, for symmetry.

    - `size`: width of the square cells [mm].
    - `columns`, `rows`: cells along the sliding direction, and across it from the plane of symmetry.
    - `steel`: transformed temperature of the body.
    """

    def __init__(self, size: float, columns: int, rows: int, steel: Kirchhoff) -> None:
        self.size = size
        self._shape = (columns, rows)
        self._effusivity, self._diffusivity = steel.effusivity, steel.diffusivity
        along, across = np.arange(columns), np.arange(rows)
        self._lag = along[:, None] - along[None, :] + columns - 1
        self._near = across[:, None] - across[None, :] + rows - 1
        self._mirror = across[:, None] + across[None, :] + rows
        self._times, self._places = [0.0], [0.0]
        self._fluxes: list[FloatArray] = []

    def begin(self, dt: float, distance: float) -> FloatArray:
        """Begin a step of `dt` [s] over `distance` [mm].

        Returns the transformed temperature that earlier steps leave at its end, shape (columns, rows).
        """
        self._times.append(self._times[-1] + dt)
        self._places.append(self._places[-1] + distance)
        left = np.zeros(self._shape)
        t, s = np.array(self._times), np.array(self._places)
        first = self._first(t, s)
        if first < len(self._fluxes):
            u, weight, moved = self._points(t[first:-1], s[first:-1], t[-1], s[-1], _BEFORE)
            q = np.repeat(np.array(self._fluxes[first:]), _BEFORE, axis=0) * weight.reshape(-1, 1, 1)
            along, across = self._spread(u.ravel(), moved.ravel())
            left = np.matmul(np.matmul(along, q), across).sum(axis=0)
        u, weight, moved = self._points(t[-2:], s[-2:], t[-1], s[-1], _NOW)
        along, across = self._spread(u.ravel(), moved.ravel())
        self._now = along * weight.reshape(-1, 1, 1), across
        return np.asarray(left)

    def respond(self, flux: FloatArray) -> FloatArray:
        """Return the transformed temperature that a flux [N/(mm s)] of this step gives at its end."""
        along, across = self._now
        return np.asarray(np.matmul(np.matmul(along, flux), across).sum(axis=0))

    def end(self, flux: FloatArray) -> None:
        """End the step with the flux that it had."""
        self._fluxes.append(flux)

    def _first(self, t: FloatArray, s: FloatArray) -> int:
        """Return the first step whose heat is still under the contact, or has come back to it."""
        reach = self._shape[0] * self.size + _END * np.sqrt(4.0 * self._diffusivity * (t[-1] - t[:-2]))
        near = np.flatnonzero(s[-1] - s[1:-1] < reach)
        return int(near[0]) if len(near) else len(t) - 2

    def _points(
        self, t: FloatArray, s: FloatArray, now: float, place: float, count: int
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return roots of the age, weights and ways gone since, each of shape (steps, count).

        The integral of q / (e sqrt(pi age)) over time is that of 2 q / (e sqrt(pi)) over the root of the age.
        """
        nodes, weights = _gauss(count)
        old, young = np.sqrt(now - t[:-1]), np.sqrt(np.maximum(now - t[1:], 0.0))
        u = 0.5 * (old + young)[:, None] + 0.5 * (old - young)[:, None] * nodes
        share = (now - u**2 - t[:-1, None]) / np.diff(t)[:, None]
        moved = place - (s[:-1, None] + share * np.diff(s)[:, None])
        factor = 2.0 / (self._effusivity * math.sqrt(math.pi))
        return u, factor * 0.5 * (old - young)[:, None] * weights, moved

    def _spread(self, u: FloatArray, moved: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return which share of the heat of a cell each cell holds, along (n, columns, columns) and across."""
        columns, rows = self._shape
        width = 2.0 * np.sqrt(self._diffusivity) * u[:, None]
        grid = np.arange(-columns, columns + 1) * self.size
        along = _second_difference(grid - moved[:, None], width, self.size)
        across = _second_difference(
            np.arange(-rows, 2 * rows + 1) * self.size + 0.0 * width, width, self.size
        )
        return along[:, self._lag], across[:, self._near] + across[:, self._mirror]


@cache
def _gauss(count: int) -> tuple[FloatArray, FloatArray]:
    """Return nodes and weights of the rule of Gauss and Legendre; to find them takes longer than to use them."""
    return np.polynomial.legendre.leggauss(count)


def _second_difference(x: FloatArray, width: FloatArray, size: float) -> FloatArray:
    """Return the mean over a cell, at distances `x`, of a unit cell spread by a Gaussian: without the two ends of `x`."""
    z = x / width
    primitive = x * erf(z) + width / math.sqrt(math.pi) * np.exp(-(z**2))
    return (primitive[:, 2:] - 2.0 * primitive[:, 1:-1] + primitive[:, :-2]) / (2.0 * size)
