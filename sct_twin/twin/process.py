"""The twin step by step, for the twin FMU: normal force, speed and friction in, the five loads out."""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

from forming.materials.materials import Material, as_material
from forming.tools.punch_geometry import PunchGeometry
from friction_models.common import InputError
from friction_models.common.ranges import check_range
from friction_models.loads import LOAD_NAMES, MU

from .heat.contact_temperature import SlidingContact, ThermalBody, ThermalSettings
from .heat.sliding import rest
from .upsetting import WOBBLE, ContactState, UpsettingCase, UpsettingRun, known_upset, run_force

#: Least normal force that makes a contact [N].
LOADED = 1e3
#: Change of the tool temperature before sliding that starts the contact anew [K].
TOUCHED = 0.5
#: Highest normal force of a test that the twin computes [N].
F_MAX_LIMITS = (1e3, 5e6)
#: Largest normal force of a step over `F_max`: what `run_force` upsets to.
CARRIED = 1.1
#: Allowed sliding speeds [mm/s], element sizes [mm] and temperatures [degC].
SPEEDS, MESH_SIZES, TEMPERATURES = (1e-6, 1e5), (0.1, 5.0), (-273.15, 2000.0)


class ContactLoads(NamedTuple):
    """Loads of the contact mean, in the order of the contract: mm/s, degC, MPa, mm, 1.

    >>> loads = ContactLoads(v_rel=100.0, T=80.0, sigma_n=900.0, sd=5.0, psi=1.1)
    >>> loads._fields
    ('v_rel', 'T', 'sigma_n', 'sd', 'psi')
    """

    v_rel: float
    T: float
    sigma_n: float
    sd: float
    psi: float


@dataclass(eq=False)
class ProcessSnapshot:
    """State of a process at one time; see `SctProcess.snapshot`."""

    time: float
    sd: float
    F_n: float
    v: float
    T_tool: float
    #: Force that made the contact, and the tool temperature then; a force of 0 is no contact yet.
    highest: float
    seated: float
    state: ContactState
    contact: SlidingContact


class SctProcess:
    """A sliding compression test that is run step by step, for the twin FMU.

    The specimen is upset once, to `F_max`. The contact is the one under the highest normal force so far:
    before the plate moves, a force that exceeds it by more than `WOBBLE` makes a new contact; while it
    moves, area and expansion grow with such a force and the temperatures go on.

    Parameters
    ----------
    specimen_diameter, specimen_height : float
        Cylinder before the test [mm].
    bore : float
        Bore of the punch's cavity [mm]; 0: a flat punch.
    tip : float
        Diameter of a reduced first contact [mm]; 0: the whole end face.
    tip_height : float
        Axial length of the taper above it [mm].
    F_max : float
        Largest normal force [N]; a step with more than `CARRIED` times as much is refused.
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
        Grid and heat data of the sliding phase; by default the specimen's are those of `material`.
    t_wait : float
        How long the specimen lies on the plate under its first force before the time counts [s].

    Raises
    ------
    InputError
        A force the specimen cannot carry, or impossible geometry.

    Examples
    --------
    A process upsets its specimen when it is made; what cannot be is refused before:

    >>> from sct_twin import SctProcess
    >>> SctProcess(F_max=500.0)
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: SCT process: F_max = 500.0 N; allowed: 1000 to 5e+06 N
    >>> SctProcess.load_names
    ('v_rel', 'T', 'sigma_n', 'sd', 'psi')
    """

    load_names = LOAD_NAMES

    def __init__(
        self,
        specimen_diameter: float = 15.0,
        specimen_height: float = 15.0,
        bore: float = 15.51,
        tip: float = 0.0,
        tip_height: float = 2.5,
        F_max: float = 330e3,
        T_tool: float = 20.0,
        T_specimen: float | None = None,
        upsetting_mu: float = 0.07,
        speed: float = 100.0,
        material: Material | str | None = None,
        mesh_size: float = 0.7,
        thermal: ThermalSettings | None = None,
        t_wait: float = 0.0,
    ) -> None:
        for name, value, low, high, unit in (
            ("F_max", F_max, *F_MAX_LIMITS, "N"),
            ("speed", speed, *SPEEDS, "mm/s"),
            ("upsetting_mu", upsetting_mu, MU.lower, MU.upper, ""),
            ("mesh_size", mesh_size, *MESH_SIZES, "mm"),
            ("T_tool", T_tool, *TEMPERATURES, "degC"),
            ("T_specimen", T_tool if T_specimen is None else T_specimen, *TEMPERATURES, "degC"),
            ("t_wait", t_wait, 0.0, 1e5, "s"),
        ):
            check_range("SCT process", name, value, low, high, unit)
        if not (thermal is None or isinstance(thermal, ThermalSettings)):
            raise InputError(f"SCT process: thermal = {thermal!r:.60}; allowed: ThermalSettings, or None")
        self.punch = PunchGeometry(specimen_diameter, specimen_height, bore or None, tip or None, tip_height)
        self.F_max, self.speed = float(F_max), float(speed)
        steel = as_material(material)
        self.thermal = thermal or ThermalSettings(specimen=ThermalBody.of(steel))
        self.t_wait = float(t_wait)
        self._T_upset = T_tool = float(T_tool)
        T0 = T_tool if T_specimen is None else float(T_specimen)
        case = UpsettingCase(self.punch, run_force(self.F_max), mesh_size, steel, upsetting_mu, T0, T_tool)
        self.upsetting = UpsettingRun(known_upset(case, "SCT process"), case)
        self._now = self._start()

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self._now.time

    @property
    def loads(self) -> ContactLoads:
        """Loads of the contact mean at the end of the last step."""
        now = self._now
        sigma_n = float(now.state.sigma_n(now.F_n))
        return ContactLoads(now.v, now.contact.contact.mean, sigma_n, now.sd, now.state.psi)

    @property
    def T_max(self) -> float:
        """Largest local contact temperature [degC]."""
        return self._now.contact.contact.maximum

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
        for name, value, low, high, unit in (
            ("dt", dt, 0.0, 1e6, "s"),
            ("F_n", F_n, 0.0, 1e8, "N"),
            ("v_slide", v_slide, 0.0, 1e5, "mm/s"),
            ("T_tool", T_tool, *TEMPERATURES, "degC"),
            ("mu", mu, 0.0, 10.0, ""),
        ):
            check_range("SCT process", name, value, low, high, unit)
        if F_n > CARRIED * self.F_max:
            raise InputError(
                f"SCT process: F_n = {F_n!r} N; allowed: 0 to {CARRIED * self.F_max:g} N, as the specimen was upset to "
                f"F_max = {self.F_max:g} N"
            )
        self._seat(float(F_n), float(T_tool))
        now = self._now
        now.contact.plate_temperature = now.contact.punch_temperature = now.T_tool = float(T_tool)
        now.F_n, now.v = float(F_n), float(v_slide)
        if dt > 0.0:
            now.contact.advance(float(dt), float(v_slide * dt), float(mu * F_n * v_slide))
            now.time += float(dt)
            now.sd += float(v_slide * dt)
        return self.loads

    def snapshot(self) -> ProcessSnapshot:
        """Return the state, to come back to it with `restore`."""
        return replace(self._now, contact=self._now.contact.copy())

    def restore(self, snapshot: ProcessSnapshot) -> None:
        """Return exactly to a snapshot of this process; it can be used again."""
        self._now = replace(snapshot, contact=snapshot.contact.copy())

    def restarted(self, thermal: ThermalSettings, upsetting: UpsettingRun) -> Self:
        """Return this process at its start with other heat data and another contact."""
        process = copy.copy(self)
        process.thermal, process.upsetting = thermal, upsetting
        process._now = process._start()
        return process

    def _start(self) -> ProcessSnapshot:
        T_tool = self._T_upset
        # hardly pressed: the loads of a force belong to that force
        contact = self._contact_under(LOADED, T_tool)
        return ProcessSnapshot(0.0, 0.0, 0.0, 0.0, T_tool, 0.0, T_tool, *contact)

    def _seat(self, F_n: float, T_tool: float) -> None:
        """Make or enlarge the contact where force or tool temperature ask for it."""
        now = self._now
        more = F_n > (1.0 + WOBBLE) * now.highest
        if now.sd > 0.0:
            if more:
                now.highest = F_n / (1.0 + WOBBLE)
                grown = self.upsetting.at(now.highest)
                now.state = replace(now.state, area=grown.area, psi=grown.psi)
            return
        warmed = now.highest > 0.0 and abs(T_tool - now.seated) > TOUCHED
        if F_n >= LOADED and (more or warmed):
            # Nothing has slid yet: the contact is the one under this force.
            now.highest, now.seated = max(F_n, now.highest), T_tool
            now.state, now.contact = self._contact_under(now.highest, T_tool)
            rest(now.contact, self.t_wait)

    def _contact_under(self, F_n: float, T_tool: float) -> tuple[ContactState, SlidingContact]:
        state = self.upsetting.at(F_n)
        heating = state.T_specimen - self._T_upset
        state = replace(state, T_specimen=T_tool + heating)
        return state, state.sliding(self.speed, T_tool, T_tool, self.thermal)
