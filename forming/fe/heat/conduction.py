"""Heat conduction in an axisymmetric mesh: implicit Euler, lumped capacity, data constant or over temperature."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from ..linear_solver import AT_ONCE, factorise_band, solve_band
from ..mesh.shape import N_GAUSS, FloatArray, IntArray, gradients, half_bandwidth, last_rows
from .properties import Property, mean_between, value_at

#: Iterations of a capacity over temperature end after so many, or when no node changes by more [K].
ITERATIONS, SETTLED = 6, 1e-3
#: The same for heat that enters after the temperatures it leads to.
ROUNDS, REST = 40, 3e-5


class Coupling(NamedTuple):
    """Heat that depends on the temperatures after the step at other nodes than those that it enters."""

    #: Nodes whose temperature matters, shape (m,).
    chain: IntArray
    #: Heat at 0 degC there [N mm/s] per radian, and by how much it falls for each kelvin, shape (m,).
    heat: FloatArray
    slope: FloatArray
    #: Nodes that it enters, and their shares, shape (m, 4).
    nodes: IntArray
    shares: FloatArray


@njit(cache=True)
def add_coupling(
    right: FloatArray,
    T: FloatArray,
    chain: IntArray,
    heat: FloatArray,
    slope: FloatArray,
    nodes: IntArray,
    shares: FloatArray,
) -> FloatArray:
    """Return the right-hand side with the heat of a `Coupling` at the temperatures `T`.

    The factorised matrix holds `slope` at the nodes of `chain`. What it takes away there the right-hand side gives back,
    so the solution does not depend on it: it makes the iteration settle, in two to six rounds.
    """
    x = right.copy()
    for i in range(chain.shape[0]):
        at = T[chain[i]]
        entering = heat[i] - slope[i] * at
        x[chain[i]] += slope[i] * at
        for a in range(4):
            x[nodes[i, a]] += shares[i, a] * entering
    return x


@njit(cache=True)
def add_film(
    band: FloatArray, right: FloatArray, nodes: IntArray, conductance: FloatArray, outside: FloatArray
) -> None:
    """Add the exchange of nodes, which may repeat, with bodies of the temperatures `outside`."""
    for i in range(nodes.shape[0]):
        band[nodes[i], 0] += conductance[i]
        right[nodes[i]] += conductance[i] * outside[i]


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
    triangle, shape (n, b + `AT_ONCE`), quantities per radian.
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
    coupling: Coupling | None = None,
) -> FloatArray:
    """Return the temperatures after `dt`, implicit Euler.

    - `source`, shape (n_e, 4): heat released in `dt` per volume at the Gauss points [N/mm2].
    - `capacity`, `conductivity`: of a volume [N/(mm2 K)], and [N/(s K)]. A capacity over temperature is
      iterated, so that the step conserves enthalpy; a conductivity over temperature is that of the
      temperatures known so far.
    - `film`, (nodes, conductance, temperature): conductance [N mm/(s K)] per radian of each node to a body of
      given temperature; nodes may repeat.
    """
    width, last = half_bandwidth(quads) + AT_ONCE, last_rows(quads, len(x), 1)
    varies = isinstance(capacity, tuple) or isinstance(conductivity, tuple)
    after = T
    for _ in range(ITERATIONS):
        band, right = np.zeros((len(x), width)), np.zeros(len(x))
        at = slice(None if varies else 1)
        mean, k = mean_between(capacity, T[at], after[at]), value_at(conductivity, after[at])
        assemble_heat(x, quads, T, source, mean, k, dt, band, right)
        before, after = after, _solve(band, last, right, film, after, coupling)
        if not isinstance(capacity, tuple) or float(np.abs(after - before).max()) < SETTLED:
            break
    return after


def _solve(
    band: FloatArray,
    last: IntArray,
    right: FloatArray,
    film: tuple[IntArray, FloatArray, FloatArray] | None,
    guess: FloatArray,
    coupling: Coupling | None,
) -> FloatArray:
    """Add the exchange at the surface and return the temperatures."""
    if film is not None:
        add_film(band, right, *film)
    if coupling is not None:
        add_film(band, right, coupling.chain, coupling.slope, np.zeros(len(coupling.slope)))
    if not factorise_band(band, last):
        raise ArithmeticError("the heat matrix is not positive definite")
    if coupling is None:
        solve_band(band, last, right)
        return right
    for _ in range(ROUNDS):
        before, guess = guess, add_coupling(right, guess, *coupling)
        solve_band(band, last, guess)
        if np.abs(guess - before).max() < REST:
            break
    return guess
