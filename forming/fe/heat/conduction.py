"""Heat conduction in an axisymmetric mesh: implicit Euler, lumped capacity, data constant or over temperature."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.linalg.lapack import dpbtrf, dpbtrs

from ..mesh.shape import N_GAUSS, FloatArray, IntArray, gradients
from .properties import Property, mean_between, value_at

#: Iterations of a capacity over temperature end after so many, or when no node changes by more [K].
ITERATIONS, SETTLED = 6, 1e-3
#: The same for heat that enters after the temperatures it leads to.
ROUNDS, REST = 40, 1e-5


class Coupling(NamedTuple):
    """Heat that depends on the temperatures after the step, at other nodes than those that it enters."""

    #: Nodes it depends on, and by about how much it falls for each kelvin there [N mm/(s K)] per radian.
    nodes: IntArray
    conductance: FloatArray
    #: Returns the heat that enters all nodes at given temperatures of them [N mm/s] per radian.
    power: Callable[[FloatArray], FloatArray]


@njit(cache=True)
def assemble_heat(
    x: FloatArray,
    quads: IntArray,
    T: FloatArray,
    source: FloatArray,
    capacity: FloatArray,
    conductivity: FloatArray,
    dt: float,
    band: FloatArray,
    right: FloatArray,
) -> None:
    """Add conduction (implicit), lumped capacity and the heat `source` [N/mm2 in dt] per Gauss point.

    `capacity` and `conductivity` hold one value for all nodes, or one for each. ``band[j, i - j]`` holds the lower
    triangle, shape (n, b + 1), quantities per radian.
    """
    xe = np.empty((4, 2))
    dn = np.empty((4, 2))
    ke = np.empty((4, 4))
    constant = len(capacity) == 1
    for e in range(quads.shape[0]):
        for a in range(4):
            xe[a, 0] = x[quads[e, a], 0]
            xe[a, 1] = x[quads[e, a], 1]
        ke[:] = 0.0
        for g in range(4):
            w, _, _ = gradients(xe, g, dn)
            k = conductivity[0]
            if not constant:
                k = 0.0
                for a in range(4):
                    k += N_GAUSS[g, a] * conductivity[quads[e, a]]
            for a in range(4):
                node = quads[e, a]
                c = capacity[0 if constant else node]
                lump = w * N_GAUSS[g, a]
                band[node, 0] += lump * c / dt
                right[node] += lump * (c * T[node] + source[e, g]) / dt
                for b in range(4):
                    ke[a, b] += w * k * (dn[a, 0] * dn[b, 0] + dn[a, 1] * dn[b, 1])
        for a in range(4):
            for b in range(4):
                row = quads[e, a]
                column = quads[e, b]
                if row >= column:
                    band[column, row - column] += ke[a, b]


def heat_step(
    x: FloatArray,
    quads: IntArray,
    T: FloatArray,
    source: FloatArray,
    capacity: Property,
    conductivity: Property,
    dt: float,
    film: tuple[IntArray, FloatArray, FloatArray] | None = None,
    flux: tuple[IntArray, FloatArray] | None = None,
    coupling: Coupling | None = None,
) -> FloatArray:
    """Return the temperatures after `dt`, implicit Euler.

    - `source`, shape (n_e, 4): heat released in `dt` per volume at the Gauss points [N/mm2].
    - `capacity`, `conductivity`: of a volume [N/(mm2 K)], and [N/(s K)]. A capacity over temperature is
      iterated, so that the step conserves enthalpy; a conductivity over temperature is that of the
      temperatures known so far.
    - `film`, (nodes, conductance, temperature): conductance [N mm/(s K)] per radian of each node to a body of
      given temperature; nodes may repeat.
    - `flux`, (nodes, power): heat flow into nodes [N mm/s] per radian; nodes may repeat.
    """
    half = int((quads.max(axis=1) - quads.min(axis=1)).max())
    varies = isinstance(capacity, tuple) or isinstance(conductivity, tuple)
    after = T
    for _ in range(ITERATIONS):
        band, right = np.zeros((len(x), half + 1)), np.zeros(len(x))
        at = slice(None if varies else 1)
        mean, k = mean_between(capacity, T[at], after[at]), value_at(conductivity, after[at])
        assemble_heat(x, quads, T, source, mean, k, dt, band, right)
        before, after = after, _solve(band, right, film, flux, after, coupling)
        if not isinstance(capacity, tuple) or float(np.abs(after - before).max()) < SETTLED:
            break
    return after


def _solve(
    band: FloatArray,
    right: FloatArray,
    film: tuple[IntArray, FloatArray, FloatArray] | None,
    flux: tuple[IntArray, FloatArray] | None,
    guess: FloatArray,
    coupling: Coupling | None,
) -> FloatArray:
    """Add the exchange at the surface and return the temperatures."""
    if film is not None:
        nodes, conductance, outside = film
        np.add.at(band[:, 0], nodes, conductance)
        np.add.at(right, nodes, conductance * outside)
    if flux is not None:
        np.add.at(right, flux[0], flux[1])
    if coupling is not None:
        np.add.at(band[:, 0], coupling.nodes, coupling.conductance)
    factor, info = dpbtrf(band.T, lower=1, overwrite_ab=1)
    if info != 0:
        raise ArithmeticError("the heat matrix is not positive definite")
    if coupling is None:
        return dpbtrs(factor, right, lower=1, overwrite_b=1)[0]
    T = guess
    for _ in range(ROUNDS):
        # What the matrix takes away at these nodes, the right-hand side gives back: only the speed depends on it.
        entering = right + coupling.power(T)
        np.add.at(entering, coupling.nodes, coupling.conductance * T[coupling.nodes])
        before, T = T, dpbtrs(factor, entering, lower=1, overwrite_b=1)[0]
        if float(np.abs(T - before).max()) < REST:
            break
    return T
