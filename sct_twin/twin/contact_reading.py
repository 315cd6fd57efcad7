"""How the contact of a test is found: from its forces, its geometry and, where it was measured, its diameter."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from friction_models.loads import FloatArray

from .contact_diameter import AREA, FORCE_AND_AREA, READING, FoundContact, read_at_diameter
from .uncertainty import AreaAndPsi, GivenUncertainty, other_dimensions, other_friction
from .upsetting import SPEED, UpsettingCase, UpsettingRun, contact_forces, known_upset, local_fit, run_force


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

    def read(self) -> FoundContact:
        """Upset the specimen and compare it with the measured diameter, if there is one.

        Raises InputError: the specimen cannot carry the forces.
        """
        highest = float(self.sliding_F_n.max())
        if self.diameter is None:
            return FoundContact(self._run_to(highest))
        force = float(contact_forces(self.sliding_F_n, self.case.force)[-1])
        return read_at_diameter(
            lambda to: self._run_to(max(to, highest)), force, self.diameter, self.case.punch
        )

    def area_and_psi(self, upsetting: UpsettingRun) -> AreaAndPsi:
        """Return contact area [mm2] and mean surface expansion at the points, both of shape (m,)."""
        return upsetting.area_and_psi(self.sliding_F_n, self.case.force)

    def others(self, found: FoundContact, given: GivenUncertainty) -> list[AreaAndPsi]:
        """Return the contact after a change of what it depends on, one at a time, each by its uncertainty.

        Flow stress, dimensions and friction while upsetting; a measured diameter takes the place of the first two.
        """
        usual = found.upsetting
        harder = self.area_and_psi(replace(usual, flow_stress=usual.flow_stress * (1.0 + given.flow_stress)))
        changed: list[AreaAndPsi] = []
        if found.use in (FORCE_AND_AREA, AREA):
            assert self.diameter is not None
            again = replace(self, diameter=self.diameter + READING).read()
            changed.append(self.area_and_psi(again.upsetting))
            if found.use == AREA:
                changed.append((self.area_and_psi(usual)[0], harder[1]))
        else:
            changed.append(harder)
            changed += other_dimensions(usual, self.sliding_F_n, self.case.force, given.diameter)

        def at_friction(mu: float) -> AreaAndPsi:
            again = replace(self, case=replace(self.case, mu=mu)).read()
            return self.area_and_psi(again.upsetting)

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
