"""Upsetting in the virtual laboratory: finer mesh, another material and friction than the twin assumes.

The contact is computed once for each specimen shape at two tool temperatures and interpolated over
force and temperature; results are kept in a cache folder, keyed by everything that they depend on.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from forming.materials.materials import HenselSpittel, steel_16MnCr5
from friction_models.loads import FloatArray

from ...twin.heat.thermal_settings import ThermalSettings
from ..contact.contact_state import LabContact, contact_under
from ..contact.specimen_run import SpecimenRun
from ..heat.bodies import LabHeat
from .instruments import Instruments


@dataclass(frozen=True)
class Rig:
    """The laboratory's reality, unknown to the twin.

    Attributes
    ----------
    mesh_size : float
        Elements of the upsetting run [mm].
    flow_stress : float
        True flow stress over the one in the tables.
    flow_exponent : float
        True strain hardening exponent over the one in the tables.
    flow_stress_scatter : float
        Standard deviation between specimens.
    upsetting_mu, upsetting_scatter : float
        Friction while upsetting: mean over the specimens, and its relative standard deviation.
    ram_speed : float
        Punch speed [mm/s].
    compliance : float
        Elastic give of the machine [mm/N].
    diameter_scatter, height_scatter : float
        Standard deviations of the specimens [mm].
    thermal : LabHeat
        Conductivities, capacities and heat transfer of the film.

    Examples
    --------
    >>> from sct_twin.virtual_lab import Rig
    >>> Rig(upsetting_mu=0.1).upsetting_mu
    0.1
    """

    mesh_size: float = 0.45
    flow_stress: float = 1.015
    flow_exponent: float = 1.01
    flow_stress_scatter: float = 0.006
    upsetting_mu: float = 0.074
    upsetting_scatter: float = 0.10
    ram_speed: float = 10.0
    compliance: float = 1.2e-6
    diameter_scatter: float = 0.0
    height_scatter: float = 0.0
    thermal: LabHeat = field(default_factory=LabHeat)

    @classmethod
    def realistic(cls) -> Rig:
        """Return a rig whose specimens are turned within about +-0.05 mm."""
        return cls(diameter_scatter=0.02, height_scatter=0.03)

    @property
    def scattered(self) -> bool:
        """Whether specimens differ in size."""
        return self.diameter_scatter > 0.0 or self.height_scatter > 0.0

    @property
    def material(self) -> HenselSpittel:
        """True workpiece material."""
        return virtual_steel(self.flow_stress, self.flow_exponent)


def virtual_steel(flow_stress: float, flow_exponent: float) -> HenselSpittel:
    """Return 16MnCr5 with factors on flow stress and strain hardening exponent."""
    nominal = steel_16MnCr5()
    return replace(nominal, A=nominal.A * flow_stress, m2=nominal.m2 * flow_exponent, name="16MnCr5, virtual")


#: How heat is conducted in the laboratory.
HEAT_SOLVER = "Duhamel superposition on a half space (plate), eigenfunctions of a cylinder (specimen)"
#: Tool temperatures at which upsetting is computed [degC].
TEMPERATURES = (20.0, 300.0)
#: Specimen as it should be [mm].
DIAMETER, HEIGHT = 15.0, 15.0
#: Friction at which the tables are computed.
TABLE_MU = 0.07
#: What is changed, and by how much, in the runs that tell how a contact depends on diameter [mm], height [mm] and
#: friction while upsetting: much more than the scatter, so that the nodes of the mesh do not matter.
STEPS = {"diameter": -0.4, "height": -0.8, "mu": 0.04}


class _Part(NamedTuple):
    """A run, its weight in a specimen, and run force over specimen force."""

    run: SpecimenRun
    weight: float
    scale: float


@dataclass(frozen=True, eq=False)
class SpecimenTable:
    """Upsetting of one specimen shape, at the two tool temperatures of `TEMPERATURES`."""

    #: At the two temperatures.
    runs: tuple[SpecimenRun, SpecimenRun]
    #: Temperature coefficient of the flow stress [1/K].
    m1: float
    #: At the first temperature, with one thing changed by its step of `STEPS`.
    changed: Mapping[str, SpecimenRun] = field(default_factory=dict)
    #: How this specimen deviates in the same things.
    deviations: Mapping[str, float] = field(default_factory=dict)

    def _parts(self, T_tool: float, flow_stress: float) -> list[_Part]:
        """Return the runs that make up the specimen, all read where they are loaded equally.

        First the runs at the two temperatures, then what the deviations add at the first one. The flow stress
        goes with exp(m1 T) and with the specimen's own factor.
        """
        low, high = TEMPERATURES
        upper = float(np.clip((T_tool - low) / (high - low), 0.0, 1.0))
        scales = [float(np.exp(self.m1 * (level - T_tool))) / flow_stress for level in TEMPERATURES]
        parts = [_Part(*part) for part in zip(self.runs, (1.0 - upper, upper), scales)]
        weights = {name: self.deviations.get(name, 0.0) / STEPS[name] for name in self.changed}
        if any(weights.values()):
            parts += [_Part(self.changed[name], w, scales[0]) for name, w in weights.items() if w]
            parts.append(_Part(self.runs[0], -sum(weights.values()), scales[0]))
        return parts

    def stroke(self, force: FloatArray, T_tool: float, flow_stress: float) -> FloatArray:
        """Return the loss of height [mm] at forces [N]."""
        return self._from_zero(lambda run: HEIGHT - run.height, force, T_tool, flow_stress)

    def rise(self, force: FloatArray, T_tool: float, flow_stress: float) -> FloatArray:
        """Return how far the heat of upsetting to forces [N] would warm the specimen, had it lost none [K]."""
        return self._from_zero(lambda run: run.rise, force, T_tool, flow_stress)

    def _from_zero(
        self, read: Callable[[SpecimenRun], FloatArray], force: FloatArray, T_tool: float, flow_stress: float
    ) -> FloatArray:
        """Return something of the runs that rises from 0 with the force, at forces [N]."""
        total = np.zeros(len(force))
        for run, weight, scale in self._parts(T_tool, flow_stress):
            total += weight * np.interp(force * scale, np.append(0.0, run.force), np.append(0.0, read(run)))
        return np.asarray(np.maximum.accumulate(np.maximum(total, 0.0)))

    def state(self, force: float, T_tool: float, flow_stress: float) -> LabContact:
        """Return the contact at the end of upsetting to a force [N]."""
        parts = [
            (contact_under(run, force * scale), weight)
            for run, weight, scale in self._parts(T_tool, flow_stress)
        ]

        def blend(name: str) -> Any:
            return sum(weight * getattr(contact, name) for contact, weight in parts)

        area = float(blend("area"))
        return LabContact(
            force=force,
            area=area,
            radius=float(np.sqrt(area / np.pi)),
            height=float(blend("height")),
            psi=float(blend("psi")),
            pressure=blend("pressure"),
        )


def perturbations(rig: Rig, instruments: Instruments) -> dict[str, object]:
    """Return what is otherwise in the laboratory: mesh, material, upsetting, heat, scatter, sensors.

    The truth is computed with these, never with the settings of the twin; friction is not among them.
    """
    material, here, usual = rig.material, asdict(rig.thermal), asdict(ThermalSettings())
    return {
        "note": "the truth is computed with these instead of the settings of the twin",
        "upsetting_mesh_mm": rig.mesh_size,
        "flow_stress_factor": rig.flow_stress,
        "flow_stress_exponent_factor": rig.flow_exponent,
        "flow_stress_scatter": rig.flow_stress_scatter,
        "specimen_scatter_mm": {"diameter": rig.diameter_scatter, "height": rig.height_scatter},
        "material": material.name,
        "ram_speed_mm_s": rig.ram_speed,
        "compliance_mm_per_N": rig.compliance,
        "thermal": {name: {"laboratory": here[name], "twin": usual[name]} for name in here},
        "heat_solver": {"laboratory": HEAT_SOLVER, "twin": "implicit, in cells"},
        "sensors": asdict(instruments),
    }
