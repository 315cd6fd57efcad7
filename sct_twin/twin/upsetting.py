"""The upsetting phase: contact area, pressure, surface expansion and heat from the FE kernel when sliding begins."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from forming.fe.heat.properties import integral
from forming.materials.materials import Material
from forming.processes.plate_contact import ring_shares
from forming.processes.specimen_upsetting import UpsettingResult, upset
from forming.tools.punch_geometry import PunchGeometry
from friction_models.common import InputError
from friction_models.loads import FloatArray

from ..records.record import SctRecord
from .heat.contact_temperature import SlidingContact, ThermalSettings
from .heat.sliding import rest

#: Punch speed [mm/s] where nothing else is measured.
SPEED = 10.0
#: Relative excess of the force over that of upsetting that is taken for a wobble of its control.
WOBBLE = 0.02
#: Diameter of the contact over that of the bore from which on the bore counts as filled.
FILLED = 0.995
#: Width of the local fit over the force (standard deviation, relative).
FIT_WIDTH = 0.1


@dataclass(frozen=True)
class UpsettingCase:
    """Arguments of `forming.upset` for a specimen."""

    punch: PunchGeometry
    #: Highest force [N].
    force: float
    mesh_size: float
    material: Material
    mu: float
    T0: float
    T_tool: float
    speed: float = SPEED


@dataclass(frozen=True, eq=False)
class ContactState:
    """The contact at the end of upsetting; kept while the specimen slides."""

    #: Normal force it belongs to [N].
    force: float
    #: Contact area [mm2] and the radius of the circle of that area [mm].
    area: float
    radius: float
    #: Of the specimen [mm].
    height: float
    #: Area-weighted mean of the local surface expansion dA/dA0.
    psi: float
    #: Temperature of the specimen with all heat of upsetting in it [degC], and how long that has been there on average [s].
    T_specimen: float
    age: float
    #: Contact pressure [MPa] over r / radius, shape (m,).
    radius_fraction: FloatArray
    pressure: FloatArray

    @classmethod
    def from_result(cls, result: UpsettingResult, force: float, case: UpsettingCase) -> ContactState:
        """Read an upsetting run, that of a case, at a force.

        The contact of a mesh grows node by node; area and the other figures are therefore taken from a
        locally linear fit over forces within some 10 % instead of from the nearest increment.
        """
        area = local_fit(result.force, np.pi * result.contact_radius**2, force)
        weights = _weights(result.force, force)
        profile = np.maximum(weights @ result.sigma_n / weights.sum(), 0.0)
        fraction = np.asarray(result.radius_fraction)
        heat = heat_of_upsetting(result, force, case)
        return cls(
            force=float(force),
            area=area,
            radius=float(np.sqrt(area / np.pi)),
            height=local_fit(result.force, result.height, force),
            psi=local_fit(result.force, result.psi_mean, force),
            T_specimen=heat.temperature,
            age=heat.age,
            radius_fraction=fraction,
            pressure=profile * (force / area) / float(ring_shares(fraction) @ profile),
        )

    def sigma_n(self, F_n: FloatArray | float) -> FloatArray:
        """Return the mean contact pressure [MPa] under a normal force [N]; the area stays."""
        return np.maximum(np.asarray(F_n, dtype=np.float64), 0.0) / self.area

    def sliding(
        self, speed: float, T_plate: float, T_tool: float, settings: ThermalSettings, uniform: bool = False
    ) -> SlidingContact:
        """Return the thermal model after upsetting, at the start of the wait; `uniform`: evenly heated."""
        profile = np.ones_like(self.pressure) if uniform else self.pressure
        contact = SlidingContact(
            self.radius,
            self.height,
            speed=speed,
            plate_temperature=T_plate,
            specimen_temperature=self.T_specimen,
            punch_temperature=T_tool,
            pressure=lambda r: np.interp(r / self.radius, self.radius_fraction, profile),
            settings=settings,
        )
        rest(contact, self.age)
        return contact


class UpsettingHeat(NamedTuple):
    """Heat of upsetting in a specimen.

    `temperature` [degC] is the one that the specimen would have if all heat were still in it, `age` [s] how long the heat
    has been there, on average over the work.
    """

    temperature: float
    age: float


def heat_of_upsetting(result: UpsettingResult, force: float, case: UpsettingCase) -> UpsettingHeat:
    """Return the heat in a specimen that is upset to a force [N].

    The work of the punch, without what is stored elastically, becomes heat as the material says (Taylor and Quinney).
    The surface of a specimen that lies between cold tools is colder than its inside, so that its temperature
    would tell too little of that.
    """
    material, T0 = case.material, case.T0
    known = np.maximum.accumulate(result.force)
    below = result.force < force
    F, h, t = (
        np.append(values[below], np.interp(force, known, values))
        for values in (result.force, result.height, result.time)
    )
    work = 0.5 * (F[1:] + F[:-1]) * -np.diff(h)
    area = math.pi * float(np.interp(force, known, result.contact_radius)) ** 2
    shear, bulk = material.shear_modulus, material.bulk_modulus
    modulus = 9.0 * bulk * shear / (3.0 * bulk + shear)
    total = float(work.sum())
    if total <= 0.0:
        return UpsettingHeat(T0, 0.0)
    plastic = max(total - 0.5 * force**2 * float(h[-1]) / (modulus * area), 0.0)
    (r0, z0), (r1, z1) = case.punch.outline()[:-1].T, case.punch.outline()[1:].T
    volume = math.pi / 3.0 * float(((z1 - z0) * (r0**2 + r0 * r1 + r1**2)).sum())
    heat = material.taylor_quinney * plastic / volume

    def heat_between(low: float, high: float) -> float:
        return float(integral(material.heat_capacity, high) - integral(material.heat_capacity, low))

    # Capacity hardly changes over the rise: its mean over the rise that it gives at T0 will do.
    rise = heat / heat_between(T0 - 0.5, T0 + 0.5)
    if rise > 0.0:
        rise = heat / (heat_between(T0, T0 + rise) / rise)
    age = float((t[-1] - 0.5 * (t[1:] + t[:-1])) @ work) / total
    return UpsettingHeat(T0 + rise, age)


def geometry(record: SctRecord) -> PunchGeometry:
    """Return specimen and punch as the test table describes them.

    Read are `specimen_diameter`, `specimen_height` (15 mm where missing), `bore` (none: a flat punch),
    `tip` (none: the whole end face) and `tip_height`, all in mm.
    """
    bore, tip = record.number("bore", 0.0), record.number("tip", 0.0)
    size = record.number("specimen_diameter", 15.0), record.number("specimen_height", 15.0)
    return PunchGeometry(*size, bore or None, tip or None, record.number("tip_height", 2.5))


class ContactAtPoints(NamedTuple):
    """The contact of the points of a test."""

    #: Area [mm2] and mean surface expansion, shape (n,).
    area: FloatArray
    psi: FloatArray
    #: Temperature of the specimen with all heat of upsetting in it [degC].
    T_specimen: float


@dataclass(frozen=True, eq=False)
class UpsettingRun:
    """An upsetting run that is read at forces."""

    result: UpsettingResult
    case: UpsettingCase
    #: Flow stress of the specimen over that of the run: the contact under a force F is that of the run under
    #: F / `flow_stress`, with its pressure and its heat in proportion.
    flow_stress: float = 1.0
    #: Measured contact area over that of the run.
    area_factor: float = 1.0
    #: By how much the specimen is warmer than after the run [K].
    warmer: float = 0.0

    def at(self, force: float) -> ContactState:
        """Return the contact under a force [N]."""
        state = ContactState.from_result(self.result, force / self.flow_stress, self.case)
        T0 = self.case.T0
        return replace(
            state,
            force=float(force),
            area=state.area * self.area_factor,
            radius=state.radius * math.sqrt(self.area_factor),
            pressure=state.pressure * (self.flow_stress / self.area_factor),
            T_specimen=T0 + self.flow_stress * (state.T_specimen - T0) + self.warmer,
        )

    def at_points(self, F_n: FloatArray, upset_to: float) -> ContactAtPoints:
        """Return the contact at `contact_forces` of normal forces [N], shape (n,)."""
        forces = contact_forces(F_n, upset_to)
        first = self.at(upset_to)
        if float(forces[-1]) == upset_to:
            return ContactAtPoints(
                np.full(len(F_n), first.area), np.full(len(F_n), first.psi), first.T_specimen
            )
        nodes = np.linspace(upset_to, float(forces[-1]), 13)
        states = [self.at(float(force)) for force in nodes]
        areas = np.interp(forces, nodes, [state.area for state in states])
        psi = np.interp(forces, nodes, [state.psi for state in states])
        return ContactAtPoints(areas, psi, first.T_specimen)


def contact_forces(F_n: FloatArray, upset_to: float) -> FloatArray:
    """Return the forces [N] that the contact of each point of a sliding phase belongs to.

    It is the contact under the highest force so far: it stays while the force falls, and grows where the force
    exceeds the one of upsetting by more than `WOBBLE`.
    """
    return np.maximum(np.maximum.accumulate(F_n) / (1.0 + WOBBLE), upset_to)


def shear_share(state: ContactState, punch: PunchGeometry, mu: float) -> float:
    """Return by which share of itself the pressure may be lower than stated, through the friction shear.

    A yielding contact that is sheared by tau = mu p yields at p^2 + 3 tau^2 = p0^2 (von Mises), so that the
    contact would grow by sqrt(1 + 3 mu^2) under the same force. One that fills its bore cannot.
    """
    if fills(2.0 * state.radius, punch):
        return 0.0
    return 1.0 - 1.0 / math.sqrt(1.0 + 3.0 * mu * mu)


def fills(diameter: float, punch: PunchGeometry) -> bool:
    """Return whether a contact of this diameter [mm] fills the bore of the punch."""
    return punch.bore_diameter is not None and diameter > FILLED * punch.bore_diameter


def known_upset(case: UpsettingCase, where: str) -> UpsettingResult:
    """Return `robust_upset`, from this process's memory where the same was asked before; its errors begin with `where`."""
    try:
        return _remembered(case)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def run_force(highest: float) -> float:
    """Return how far to upset for a highest force of interest [N]: 10 to 21 % beyond, on a fixed ladder.

    A fit at the end of the run needs some force beyond it, and equal set forces get equal runs.
    """
    return float(1.1 ** math.ceil(math.log(1.1 * highest) / math.log(1.1)))


def robust_upset(case: UpsettingCase) -> UpsettingResult:
    """Upset up to the force; where a fold closes badly, another mesh usually gets through.

    Raises InputError: no mesh reaches the force.
    """
    message = ""
    largest = case.punch.specimen_diameter / 8.0
    for factor in (1.0, 1.1, 0.9, 1.25, 0.8):
        result = upset(**vars(case) | {"mesh_size": min(factor * case.mesh_size, largest)})
        if result.status == "ok":
            return result
        message = message or result.message
    raise InputError(
        f"upsetting to {case.force * 1e-3:.1f} kN {message}; allowed: forces the specimen can carry"
    )


_remembered = lru_cache(maxsize=128)(robust_upset)


def local_fit(x: FloatArray, y: FloatArray, at: float) -> float:
    """Return the value at `at` of a straight line fitted to the points nearby."""
    w = _weights(x, at)
    d = x - at
    s0, s1, s2 = float(w.sum()), float(w @ d), float(w @ d**2)
    t0, t1 = float(w @ y), float(w @ (d * y))
    determinant = s0 * s2 - s1 * s1
    if determinant <= 1e-12 * s0 * s2:
        return t0 / s0
    return (s2 * t0 - s1 * t1) / determinant


def _weights(x: FloatArray, at: float) -> FloatArray:
    near = np.sort(np.abs(x - at))[: min(4, len(x))]
    width = max(FIT_WIDTH * abs(at), float(near[-1]), 1e-9)
    return np.asarray(np.exp(-0.5 * ((x - at) / width) ** 2))
