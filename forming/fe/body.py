"""The deforming workpiece: mesh, state at nodes and Gauss points, properties of its material."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numba import njit

from .flow import flow_stress
from .heat.properties import Property
from .heat.surface_layer import SurfaceLayer
from .mesh.shape import FloatArray, IntArray, gauss_volumes


@dataclass
class Body:
    """Workpiece in the half plane r >= 0, z along the axis."""

    #: Node positions r, z [mm], shape (n, 2).
    x: FloatArray
    #: Elements, counter-clockwise, shape (n_e, 4).
    quads: IntArray
    #: Surface nodes in counter-clockwise order, from the axis to the axis (without the axis between); for a
    #: ring the closed loop, its first node repeated at the end, shape (n_s,).
    chain: IntArray
    #: rr, zz, tt, rz at the Gauss points [MPa], shape (n_e, 4, 4).
    stress: FloatArray
    #: Equivalent plastic strain and its rate in the last increment [1/s], shape (n_e, 4).
    strain: FloatArray
    rate: FloatArray
    #: Temperature [degC], shape (n,): mean of what surrounds the node, which at a surface is less than its own.
    T: FloatArray
    #: Mean velocity of the last increment [mm/s], shape (n, 2).
    velocity: FloatArray
    #: How fast it changes from one increment to the next [mm/s2], shape (n, 2).
    acceleration: FloatArray
    #: Thermal boundary layer; None: no heat has been exchanged.
    layer: SurfaceLayer | None = None
    #: Time of the last increment [s]; 0: there was none, and the velocity is a guess.
    lasted: float = 0.0

    @classmethod
    def at_rest(cls, x: FloatArray, quads: IntArray, chain: IntArray, T: float) -> Body:
        """Return a stress-free body of uniform temperature."""
        n_e = len(quads)
        return cls(
            x,
            quads,
            chain,
            np.zeros((n_e, 4, 4)),
            np.zeros((n_e, 4)),
            np.zeros((n_e, 4)),
            np.full(len(x), float(T)),
            np.zeros_like(x),
            np.zeros_like(x),
        )

    @property
    def surface(self) -> FloatArray:
        """Positions of the surface nodes, shape (n_s, 2) [mm]."""
        return self.x[self.chain]

    @property
    def surface_T(self) -> FloatArray:
        """Temperatures of the surface itself, shape (n_s,) [degC]."""
        return self.T[self.chain] if self.layer is None else self.layer.surface(self.T)

    @property
    def axis(self) -> IntArray:
        """Nodes on the axis of rotation."""
        return np.flatnonzero(self.x[:, 0] < 1e-9)

    def expected(self, dt: float, share: float) -> FloatArray:
        """Return how far the nodes go in the increment `dt` [s] if a share of their acceleration goes on, shape (n, 2) [mm]."""
        return (self.velocity + 0.5 * share * (self.lasted + dt) * self.acceleration) * dt

    def accelerate(self, velocity: FloatArray, dt: float) -> None:
        """Take over the mean velocity of an increment `dt` [s], shape (n, 2) [mm/s]."""
        between = 0.5 * (self.lasted + dt) if self.lasted > 0.0 else np.inf
        self.acceleration = (velocity - self.velocity) / between
        self.velocity, self.lasted = velocity, dt

    def guess(self, velocity: FloatArray) -> None:
        """Expect a velocity, shape (n, 2) [mm/s], that has nothing to do with the last increments."""
        self.velocity, self.acceleration, self.lasted = velocity, np.zeros_like(velocity), 0.0

    def volume(self) -> float:
        """Return the volume as it is [mm3]."""
        return float(gauss_volumes(self.x, self.quads).sum())

    def unloaded_volume(self, bulk_modulus: float) -> float:
        """Return the volume without elastic compression [mm3]: what plastic flow must preserve."""
        return float(_unloaded_volume(self.x, self.quads, self.stress, bulk_modulus))

    def elastic_energy(self, shear_modulus: float, bulk_modulus: float) -> float:
        """Return the elastic energy stored [N mm]."""
        return float(_elastic_energy(self.x, self.quads, self.stress, shear_modulus, bulk_modulus))


@njit(cache=True)
def _unloaded_volume(x: FloatArray, quads: IntArray, stress: FloatArray, bulk_modulus: float) -> float:
    volumes = gauss_volumes(x, quads)
    total = 0.0
    for e in range(quads.shape[0]):
        for g in range(4):
            mean = (stress[e, g, 0] + stress[e, g, 1] + stress[e, g, 2]) / 3.0
            total += volumes[e, g] * np.exp(-mean / bulk_modulus)
    return total


@njit(cache=True)
def _elastic_energy(
    x: FloatArray, quads: IntArray, stress: FloatArray, shear_modulus: float, bulk_modulus: float
) -> float:
    volumes = gauss_volumes(x, quads)
    total = 0.0
    for e in range(quads.shape[0]):
        for g in range(4):
            mean = (stress[e, g, 0] + stress[e, g, 1] + stress[e, g, 2]) / 3.0
            s2 = 2.0 * stress[e, g, 3] ** 2
            for i in range(3):
                s2 += (stress[e, g, i] - mean) ** 2
            density = mean * mean / (2.0 * bulk_modulus) + s2 / (4.0 * shear_modulus)
            total += volumes[e, g] * density
    return total


@njit(cache=True)
def nodal_shear_yield(
    quads: IntArray, strain: FloatArray, rate: FloatArray, T: FloatArray, m: FloatArray
) -> FloatArray:
    """Return the shear yield stress k = kf / sqrt(3) at the nodes, averaged over the elements around [MPa]."""
    total = np.zeros(T.shape[0])
    count = np.zeros(T.shape[0])
    for e in range(quads.shape[0]):
        temperature = 0.25 * (T[quads[e, 0]] + T[quads[e, 1]] + T[quads[e, 2]] + T[quads[e, 3]])
        k = 0.0
        for g in range(4):
            y, _, _ = flow_stress(strain[e, g], rate[e, g], temperature, m)
            k += 0.25 * y / np.sqrt(3.0)
        for a in range(4):
            total[quads[e, a]] += k
            count[quads[e, a]] += 1.0
    for n in range(T.shape[0]):
        if count[n] > 0.0:
            total[n] /= count[n]
    return total


class WorkpieceMaterial(Protocol):
    """Properties that the solver reads; `forming.materials.materials.Material` has them."""

    @property
    def shear_modulus(self) -> float:
        """Shear modulus [MPa]."""

    @property
    def bulk_modulus(self) -> float:
        """Bulk modulus [MPa]."""

    @property
    def heat_capacity(self) -> Property:
        """Heat capacity of a volume [N/(mm2 K)]."""

    @property
    def conductivity(self) -> Property:
        """Heat conductivity [W/(m K)]."""

    @property
    def taylor_quinney(self) -> float:
        """Share of plastic work that becomes heat."""

    @property
    def emissivity(self) -> float:
        """Emissivity of the surface, for radiation."""

    def vector(self) -> FloatArray:
        """Return the flow curve as numbers; see `forming.fe.flow`."""
