"""How the contact of a test is found: from its forces, its geometry and, where it was measured, its diameter."""

from __future__ import annotations

from dataclasses import dataclass, replace

from forming.materials.materials import Material
from forming.tools.punch_geometry import PunchGeometry
from friction_models.loads import FloatArray

from .contact_diameter import AREA, FORCE_AND_AREA, READING, USE, read_at_diameter
from .uncertainty import AreaAndPsi, GivenUncertainty, other_dimensions, other_friction
from .upsetting import UpsettingRun, contact_forces, upset_specimen


@dataclass(frozen=True, eq=False)
class FoundContact:
    """The upsetting run as it is to be read, and the columns that a measured diameter adds to the test table."""

    upsetting: UpsettingRun
    summary: dict[str, float | str]

    @property
    def use(self) -> str:
        """How a measured diameter was used; empty without one."""
        return str(self.summary.get(USE, ""))


@dataclass(frozen=True, eq=False)
class ContactReading:
    """What the contact of a test is found from.

    - `t`, `F_n`, shape (n,): loading before the sliding [s], [N].
    - `sliding_F_n`, shape (m,): normal forces of the points [N].
    - `mu`: friction while upsetting.
    - `diameter`: of the contact, as measured after the test [mm]; None: not measured.
    - `where`: the test, for messages.
    """

    punch: PunchGeometry
    t: FloatArray
    F_n: FloatArray
    sliding_F_n: FloatArray
    material: Material
    mu: float
    T_specimen: float
    T_tool: float
    mesh_size: float
    diameter: float | None
    where: str

    @property
    def upset_to(self) -> float:
        """Force of upsetting [N]."""
        return float(self.F_n[-1])

    def read(self) -> FoundContact:
        """Upset the specimen and compare it with the measured diameter, if there is one.

        Raises InputError: the specimen cannot carry the forces.
        """
        highest = float(self.sliding_F_n.max())
        if self.diameter is None:
            return FoundContact(self._run_to(highest), {})
        force = float(contact_forces(self.sliding_F_n, self.upset_to)[-1])
        found = read_at_diameter(lambda to: self._run_to(max(to, highest)), force, self.diameter, self.punch)
        return FoundContact(found.upsetting, found.summary())

    def area_and_psi(self, upsetting: UpsettingRun) -> AreaAndPsi:
        """Return contact area [mm2] and mean surface expansion at the points, both of shape (m,)."""
        return upsetting.area_and_psi(self.sliding_F_n, self.upset_to)

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
            sizes = self.punch.specimen_diameter, self.punch.bore_diameter
            changed.append(harder)
            changed += other_dimensions(usual, self.sliding_F_n, self.upset_to, sizes, given.diameter)
        return changed + other_friction(
            lambda mu: self.area_and_psi(replace(self, mu=mu).read().upsetting), self.mu, given
        )

    def _run_to(self, force: float) -> UpsettingRun:
        return upset_specimen(
            self.punch,
            self.t,
            self.F_n,
            force,
            self.material,
            self.mu,
            self.T_specimen,
            self.T_tool,
            self.mesh_size,
            self.where,
        )
