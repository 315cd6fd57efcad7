"""The twin as an incremental process: normal force, speed and friction in, the five loads out."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

from forming.material import Material, as_material
from forming.upsetting import PunchGeometry
from friction_models.loads import LOAD_NAMES, InputError

from .contact_temperature import SlidingContact, ThermalSettings
from .upsetting import BEYOND, ContactState, robust_upset


class ContactLoads(NamedTuple):
    """Loads of the contact mean, in the order of the contract: mm/s, degC, MPa, mm, 1."""

    v_rel: float
    T: float
    sigma_n: float
    sd: float
    psi: float


@dataclass(frozen=True, eq=False)
class ProcessSnapshot:
    """State of a process at one time; see `SctProcess.snapshot`."""

    time: float
    sd: float
    F_n: float
    v: float
    T_tool: float
    state: ContactState
    contact: SlidingContact


class SctProcess:
    """A sliding compression test that is run step by step, for the twin FMU.

    The specimen is upset once, to `F_max`; the contact under the first normal force with which the plate
    moves stays for the rest of the test.

    Parameters
    ----------
    specimen_diameter, specimen_height : float
        Cylinder before the test [mm].
    bore : float
        Bore of the punch's cavity [mm]; 0: a flat punch.
    tip : float
        Diameter of a reduced first contact [mm]; 0: the whole end face.
    F_max : float
        Largest normal force [N].
    T_tool : float
        Tool temperature before the start [degC]; an input from then on.
    T_specimen : float, optional
        Specimen temperature before upsetting [degC]; that of the tool by default.
    upsetting_mu : float
        Friction while upsetting.
    speed : float
        Typical sliding speed [mm/s].
    material : Material, name or path, optional
        Workpiece; 16MnCr5 by default.
    mesh_size : float
        Elements of the upsetting run [mm].
    thermal : ThermalSettings, optional
        Grid and material data of the sliding phase.

    Raises
    ------
    InputError
        A force the specimen cannot carry, or impossible geometry.
    """

    load_names = LOAD_NAMES

    def __init__(
        self,
        specimen_diameter: float = 15.0,
        specimen_height: float = 15.0,
        bore: float = 15.51,
        tip: float = 0.0,
        F_max: float = 330e3,
        T_tool: float = 20.0,
        T_specimen: float | None = None,
        upsetting_mu: float = 0.07,
        speed: float = 100.0,
        material: Material | str | None = None,
        mesh_size: float = 0.6,
        thermal: ThermalSettings | None = None,
    ) -> None:
        if not (math.isfinite(F_max) and 1e3 <= F_max <= 5e6):
            raise InputError(f"SCT process: F_max = {F_max!r} N; allowed: 1e3 to 5e6 N")
        if not (math.isfinite(speed) and speed > 0.0):
            raise InputError(f"SCT process: speed = {speed!r} mm/s; allowed: a finite number above 0")
        self.punch = PunchGeometry(
            specimen_diameter=specimen_diameter,
            specimen_height=specimen_height,
            bore_diameter=bore or None,
            tip_diameter=tip or None,
        )
        self.F_max, self.speed = float(F_max), float(speed)
        self.thermal = thermal or ThermalSettings()
        self._T_tool = self._T_upset = float(T_tool)
        self._upsetting = robust_upset(
            self.punch,
            BEYOND * self.F_max,
            mesh_size,
            "SCT process",
            material=as_material(material),
            mu=upsetting_mu,
            T0=self._T_tool if T_specimen is None else float(T_specimen),
            T_tool=self._T_tool,
            speed=10.0,
        )
        self.time = 0.0
        self._sd = self._F_n = self._v = 0.0
        self._state, self._contact = self._contact_under(self.F_max, self._T_tool)

    @property
    def loads(self) -> ContactLoads:
        """Loads of the contact mean at the end of the last step."""
        sigma_n = float(self._state.sigma_n(self._F_n))
        return ContactLoads(self._v, self._contact.contact.mean, sigma_n, self._sd, self._state.psi)

    @property
    def T_max(self) -> float:
        """Largest local contact temperature [degC]."""
        return self._contact.contact.maximum

    def advance(self, dt: float, F_n: float, v_slide: float, T_tool: float, mu: float) -> ContactLoads:
        """Go on by `dt` with inputs that hold over the step; return the loads at its end.

        Parameters
        ----------
        dt : float
            Communication step [s].
        F_n : float
            Normal force [N].
        v_slide : float
            Sliding speed [mm/s].
        T_tool : float
            Temperature of punch and fresh plate [degC].
        mu : float
            Coefficient of friction.

        Raises
        ------
        InputError
            An input that is not finite or out of its physical range.
        """
        for name, value, low, high in (
            ("dt", dt, 0.0, 1e6),
            ("F_n", F_n, 0.0, 1e8),
            ("v_slide", v_slide, 0.0, 1e5),
            ("T_tool", T_tool, -273.15, 2000.0),
            ("mu", mu, 0.0, 10.0),
        ):
            if not low <= value <= high:
                raise InputError(f"SCT process: {name} = {value!r}; allowed: {low:g} to {high:g}")
        if self._sd == 0.0 and (F_n != self._F_n or T_tool != self._T_tool) and F_n >= 1e3:
            # Nothing has slid yet: the contact is the one under this force.
            self._state, self._contact = self._contact_under(min(F_n, self.F_max), T_tool)
        self._contact.plate_temperature = self._contact.punch_temperature = self._T_tool = float(T_tool)
        self._F_n, self._v = float(F_n), float(v_slide)
        if dt > 0.0:
            self._contact.advance(float(dt), float(v_slide * dt), float(mu * F_n * v_slide))
            self.time += float(dt)
            self._sd += float(v_slide * dt)
        return self.loads

    def snapshot(self) -> ProcessSnapshot:
        """Return the state, to come back to it with `restore`."""
        return ProcessSnapshot(
            self.time, self._sd, self._F_n, self._v, self._T_tool, self._state, self._contact.copy()
        )

    def restore(self, snapshot: ProcessSnapshot) -> None:
        """Return exactly to a snapshot of this process; it can be used again."""
        self.time, self._sd = snapshot.time, snapshot.sd
        self._F_n, self._v, self._T_tool = snapshot.F_n, snapshot.v, snapshot.T_tool
        self._state, self._contact = snapshot.state, snapshot.contact.copy()

    def _contact_under(self, F_n: float, T_tool: float) -> tuple[ContactState, SlidingContact]:
        state = ContactState.from_result(self._upsetting, F_n, self._T_upset)
        heating = state.T_specimen - self._T_upset
        state = replace(state, T_specimen=T_tool + heating)
        return state, state.sliding(self.speed, T_tool, T_tool, self.thermal)
