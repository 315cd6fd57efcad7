"""The contact of a test: found from its forces, its geometry and, where it was measured after the test, its diameter.

The diameter corrects the flow stress or the area of the upsetting run.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from forming.tools.punch_geometry import PunchGeometry
from friction_models.common import InputError
from friction_models.loads import FloatArray

from ..records.record import SctRecord
from .uncertainty import GivenUncertainty, other_dimensions, other_friction
from .upsetting import (
    SPEED,
    ContactAtPoints,
    UpsettingCase,
    UpsettingRun,
    contact_forces,
    fills,
    known_upset,
    local_fit,
    run_force,
)

#: Column of the test table [mm].
COLUMN = "contact_diameter"
#: Column of the test table that says how it was used, and its values.
USE, FORCE_AND_AREA, AREA = "contact_diameter_use", "force and area", "area"
COMPARED, NOT_USED = "compared", "not used"
#: What a caliper or a microscope is trusted to [mm].
READING = 0.05
#: Least d ln(area) / d ln(force) at which the force is read from the area. Below, `READING` and the mesh, 0.5 % of the
#: area each, are worth more than the few percent of flow stress that they are to correct.
LEAST_GROWTH = 0.4
#: Largest and smallest force at which the run is read, over the measured one.
SHIFTS = (0.85, 1.15)
#: Largest relative difference from the run's diameter where the force is not read from it.
DIFFERS = 0.02


@dataclass(frozen=True, eq=False)
class FoundContact:
    """The upsetting run of a test as it is to be read, and how a measured contact diameter was used for that."""

    upsetting: UpsettingRun
    #: ``"force and area"``: the run is read at the force at which its area is the measured one; ``"area"``:
    #: the area is the measured one, all else is read at the measured force; ``"compared"``: the bore is
    #: filled and the run stays; ``"not used"``; empty: no diameter was measured.
    use: str = ""
    #: Why the diameter does not fit; empty where it does.
    remark: str = ""

    def summary(self) -> dict[str, float | str]:
        """Return the columns that a measured diameter adds to the test table."""
        if not self.use:
            return {}
        return {
            "flow_stress_ratio": round(self.upsetting.flow_stress, 5),
            USE: self.use,
            "contact_diameter_remark": self.remark,
        }


def measured_diameter(record: SctRecord, punch: PunchGeometry) -> float | None:
    """Return the diameter of the contact as the test table says it [mm]; None where it was not measured.

    Raises InputError: no number, or no diameter of a contact of this specimen.
    """
    diameter = record.number(COLUMN, math.inf)
    low, high = 0.1 * punch.specimen_diameter, 2.0 * punch.specimen_diameter
    if diameter == math.inf:
        return None
    if not low <= diameter <= high:
        raise InputError(
            f"{record.where}: metadata {COLUMN!r} is {diameter!r}; allowed: {low:g} to {high:g} mm, "
            "or empty where it was not measured"
        )
    return diameter


def read_at_diameter(
    run_to: Callable[[float], UpsettingRun],
    force: float,
    diameter: float,
    punch: PunchGeometry,
    use: str = "",
) -> FoundContact:
    """Return the run, read so that the contact under a force has the measured diameter.

    A contact under the force F of a specimen whose flow stress is f times that of the run is the contact
    of the run under F / f. With the measured area A this gives F / f = F*, where the run's area is A; the
    relation of area and force is the smoothed one of `UpsettingRun.at`. Where the area hardly depends on the
    force, it replaces that of the run; a filled bore stays.

    - `run_to`: returns the run to somewhat beyond a force [N]; asked for more than `force`, the highest of the test,
      only where the diameter says so.
    - `use`: how to use the diameter, whatever it is; empty: as it fits.
    """
    bore = punch.bore_diameter or math.inf
    upsetting = run_to(force)
    if use in (COMPARED, NOT_USED):
        return FoundContact(upsetting, use)
    expected = 2.0 * upsetting.at(force).radius
    low, high = (1.0 - DIFFERS) * expected, (1.0 + DIFFERS) * expected
    near, filled = use == AREA or low <= diameter <= high, not use and fills(expected, punch)
    if use == FORCE_AND_AREA or (not use and not filled and growth(upsetting, force) >= LEAST_GROWTH):
        if 2.0 * upsetting.at(float(upsetting.result.force.max()) / 1.05).radius < diameter:
            # A specimen that cannot carry so much is read as far as it goes.
            with suppress(InputError):
                upsetting = run_to(SHIFTS[1] * force)
        forces, diameters = _relation(upsetting, force)
        wanted = diameter
        if fills(float(diameters[-1]), punch) and diameter <= bore + 3.0 * READING:
            # The print of a filled bore, read somewhat too large.
            wanted = min(diameter, float(diameters[-1]))
        if use or diameters[0] <= wanted <= diameters[-1]:
            at = float(np.interp(wanted, diameters, forces))
            return FoundContact(replace(upsetting, flow_stress=force / at), FORCE_AND_AREA)
        low, high = min(low, float(diameters[0])), max(high, float(diameters[-1]))
    if not near:
        return FoundContact(
            upsetting,
            NOT_USED,
            f"{COLUMN} = {diameter:g} mm; allowed: {low:.2f} to {high:.2f} mm for this specimen under "
            f"{force * 1e-3:.1f} kN, by which it has {expected:.2f} mm; the measured one was not used",
        )
    if filled:
        return FoundContact(upsetting, COMPARED)
    factor = (min(diameter, bore) / expected) ** 2
    return FoundContact(replace(upsetting, area_factor=factor), AREA)


def _relation(upsetting: UpsettingRun, force: float) -> tuple[FloatArray, FloatArray]:
    """Return forces [N] within `SHIFTS` and the rising diameters [mm] of the run there."""
    forces = force * np.linspace(*SHIFTS, 31)
    forces = forces[forces <= float(upsetting.result.force.max())]
    diameters = np.maximum.accumulate([2.0 * upsetting.at(float(f)).radius for f in forces])
    rising = np.append(True, np.diff(diameters) > 1e-9 * diameters[-1])
    return forces[rising], diameters[rising]


def growth(upsetting: UpsettingRun, force: float) -> float:
    """Return d ln(area) / d ln(force) of the run, over 5 % to either side."""
    ratios: FloatArray = np.array([0.95, 1.05])
    areas = [upsetting.at(float(ratio * force)).area for ratio in ratios]
    return math.log(areas[1] / areas[0]) / math.log(ratios[1] / ratios[0])


@dataclass(frozen=True, eq=False)
class ContactReading:
    """What the contact of a test is found from."""

    #: The specimen, upset to the force before the sliding, and how long that took [s].
    case: UpsettingCase
    seconds: float
    #: Normal forces of the points [N], shape (m,).
    sliding_F_n: FloatArray
    #: Diameter of the contact, as measured after the test [mm]; None: not measured.
    diameter: float | None
    #: The test, for messages.
    where: str

    def read(self, use: str = "") -> FoundContact:
        """Upset the specimen and compare it with the measured diameter, if there is one; `use` as in `read_at_diameter`.

        Raises InputError: the specimen cannot carry the forces.
        """
        highest = float(self.sliding_F_n.max())
        if self.diameter is None:
            return FoundContact(self._run_to(highest))
        force = float(contact_forces(self.sliding_F_n, self.case.force)[-1])
        return read_at_diameter(
            lambda to: self._run_to(max(to, highest)), force, self.diameter, self.case.punch, use
        )

    def at_points(self, upsetting: UpsettingRun) -> ContactAtPoints:
        """Return the contact at the points."""
        return upsetting.at_points(self.sliding_F_n, self.case.force)

    def others(self, found: FoundContact, given: GivenUncertainty) -> list[ContactAtPoints]:
        """Return the contact after a change of what it depends on, one at a time, each by its uncertainty.

        Flow stress, dimensions and friction while upsetting; a measured diameter takes the place of the first two. It is
        used as before the change: one that no longer fits after it would count as a change of several percent.
        """
        usual = found.upsetting
        harder = self.at_points(replace(usual, flow_stress=usual.flow_stress * (1.0 + given.flow_stress)))
        changed: list[ContactAtPoints] = []
        if found.use in (FORCE_AND_AREA, AREA):
            assert self.diameter is not None
            again = replace(self, diameter=self.diameter + READING).read(found.use)
            changed.append(self.at_points(again.upsetting))
            if found.use == AREA:
                changed.append(harder._replace(area=self.at_points(usual).area))
        else:
            changed.append(harder)
            changed += other_dimensions(usual, self.sliding_F_n, self.case.force, given.diameter)

        def at_friction(mu: float) -> ContactAtPoints:
            again = replace(self, case=replace(self.case, mu=mu)).read(found.use)
            return self.at_points(again.upsetting)

        return changed + other_friction(at_friction, self.case.mu, given)

    def _run_to(self, highest: float) -> UpsettingRun:
        """Upset to somewhat beyond the highest force of the test [N].

        The punch speed is the one that makes upsetting last as long as it did, to half a power of two: the
        flow stress knows the history through it (with an exponent of 0.025), everything else is a function of
        the force.
        """
        case = replace(self.case, force=run_force(max(self.case.force, highest)))
        result = known_upset(case, self.where)
        stroke = float(result.height[0] - local_fit(result.force, result.height, self.case.force))
        factor = stroke / max(self.seconds, 1e-3) / SPEED
        if not 0.5 < factor < 2.0:
            speed = SPEED * 2.0 ** float(np.clip(round(math.log2(max(factor, 1e-3))), -6, 6))
            case = replace(case, speed=speed)
            result = known_upset(case, self.where)
        return UpsettingRun(result, case)
