"""Forward rod extrusion."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..fe.contact import gap_and_normal
from ..fe.markers import EDGE
from ..fe.mesh.polyline import distance_to_arc, distance_to_point, distance_to_segment, turns
from ..fe.mesh.shape import FloatArray
from ..fe.remesh import body_within
from ..fe.simulation import Simulation
from ..fe.state import RemeshPolicy, State, StepControl
from ..fe.tooling import Tool, block_field, flat_punch
from ..materials.materials import MaterialSource
from ..tools.ejection_tools import OPENING, Stage, ejector, opened, withdrawn
from ..tools.elasticity import ElasticTools
from ..tools.extrusion_die import ExtrusionDie
from .base import Extrusion
from .thermal_conditions import TOOLS, ThermalConditions

#: Largest gap between billet and container, so that the first touch is at the die shoulder [mm]; as a share of the container's
#: radius.
CLEARANCE, CLEARANCE_SHARE = 0.05, 0.005

#: Elements on a rounding are smaller than elsewhere below this radius of it and below this reduction of the radius, both
#: as shares of the container's radius; their usual and their smallest size as shares of `mesh_size`.
FINE_RADIUS, FINE_STEP, ROUNDED, FINEST = 0.2, 0.16, 0.7, 0.3
#: Largest `mesh_size` that counts for them, as a share of the container's radius.
COARSEST = 0.04
#: Elements in the corner between punch and container, as a share of those in the die.
IN_CORNER = 0.4
#: Largest increment after a remeshing, as a share of the largest: two of them make a communication step of 0.1 mm.
AFTER_REMESH = 0.5
#: Largest plastic strain between two remeshings. The surface that leaves the die stretches by as much, and a rod whose
#: sides have become long touches the land where shorter ones leave it.
STRAIN = 0.25
#: That in the steepest cones while the die folds the front edge of the billet open, and the travel until it has, as a share of the
#: container's radius. The steeper the cone, the more do elements beside the edge stretch, and psi there grew with each mesh more.
FOLDING_STRAIN, FOLDED_AFTER = 0.12, 0.12
#: Largest sliding in one increment, and in that with which a node arrives on the land, in elements.
SLIDING, ARRIVAL = 0.55, 0.2
#: Longest container [mm].
LONGEST = 1000.0


class FrontSize(NamedTuple):
    """Elements at the edge of the billet that goes ahead."""

    #: As a share of the container's radius.
    share: float
    #: How much they grow per mm away from the edge.
    growth: float


#: While the die folds the edge open, and then. A fold is never sharper than the elements: coarse ones stretch the side beside it
#: too much, and by what each mesh happens to have there.
FOLDING, FOLDED = FrontSize(0.006, 0.25), FrontSize(0.01, 0.15)


@dataclass(frozen=True)
class _DieSize:
    """Element size: fine along cone and land, finest on the roundings at both ends of the cone, coarse elsewhere.

    Small again where punch and container meet, at height `top`: the pressure rises there within a millimetre. And around
    `front`, the edge of the billet that goes ahead: the surface stretches to twice its area on one side of it and hardly on
    the other.
    """

    on_edge: float
    on_entry: float
    base: float
    die: ExtrusionDie
    cone_end_z: float
    top: float = math.inf
    front: tuple[float, float] = (math.inf, math.inf)
    at_front: FrontSize = FOLDING

    def __call__(self, points: FloatArray) -> FloatArray:
        die = self.die
        low = np.array([die.exit_radius, die.land - 0.5])
        high = np.array([die.container_radius, self.cone_end_z])
        along = self.base + 0.12 * np.maximum(0.0, distance_to_segment(points, low, high) - 1.0)
        # Distances from the roundings of cone to land and of container to cone.
        edge = distance_to_arc(
            points,
            (die.exit_radius + die.edge_radius, die.land),
            die.edge_radius,
            180.0 - die.half_angle,
            180.0,
        )
        centre = die.container_radius - die.entry_radius, self.cone_end_z
        entry = distance_to_arc(points, centre, die.entry_radius, -die.half_angle, 0.0)
        fine = np.minimum(
            self.on_edge + 0.2 * np.maximum(0.0, edge - 0.3),
            self.on_entry + 0.2 * np.maximum(0.0, entry - 0.3),
        )
        largest = 2.25 * self.base
        rod = min(largest, max(die.exit_radius / 4.0, self.base))
        corner = distance_to_point(points, die.container_radius, self.top)
        fine = np.minimum(fine, IN_CORNER * self.base + 0.3 * corner)
        at_front = self.at_front
        finest = at_front.share * die.container_radius
        fine = np.minimum(fine, finest + at_front.growth * distance_to_point(points, *self.front))
        return np.minimum(np.minimum(along, fine), np.where(points[:, 1] < die.land, rod, largest))


class ForwardRodExtrusion(Extrusion):
    """Axisymmetric forward rod extrusion with rigid tools that take up heat.

    The parameters of elastic tools are described in `Extrusion`, those of speed, heat, material and markers in `StepwiseProcess`.

    Parameters
    ----------
    diameter : float
        Bore of the container [mm].
    exit_diameter : float
        Land of the die [mm]: the diameter of the rod.
    half_angle : float
        Half the die opening angle [degrees]: 45 for 2 alpha = 90.
    billet_length : float
        Length of the billet [mm].
    T_billet : float
        Temperature of the billet at the start [degC].
    T_tool : float
        Temperature of the tools at the start [degC]. The contact temperature at a marker is the mean of the workpiece and
        the tool surface.
    mesh_size : float
        Element size in the die [mm]; smaller on the roundings of the cone where these or the reduction are small.
    entry_radius : float
        Rounding from container to cone [mm].
    edge_radius : float
        Rounding from cone to land [mm].
    land : float
        Length of the land of the die [mm].
    relief : float
        Radius at the end of the land [mm], behind which the rod runs free.
    container_length : float, optional
        Length of the container above the cone [mm]; by default it ends 2 mm above the billet. The billet must
        stand inside.
    ejector_diameter : float, optional
        Pin under the rod that pushes the product back through the container [mm]; by default 0.95 of
        `exit_diameter`.

    Raises
    ------
    InputError
        A dimension, speed or temperature that cannot be; the message names it, its value and what is allowed.

    Examples
    --------
    >>> from forming import ForwardRodExtrusion
    >>> process = ForwardRodExtrusion(speed=10.0, T_tool=200.0)
    >>> process.units["speed"], process.units["T_tool"]
    ('mm/s', 'degC')
    >>> ForwardRodExtrusion(speed=-1.0)
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: ...: speed = -1.0 mm/s; allowed: ... mm/s
    """

    name = "forward rod extrusion"
    ejections = ("ejector",)

    def __init__(
        self,
        diameter: float = 20.0,
        exit_diameter: float = 14.14,
        half_angle: float = 45.0,
        billet_length: float = 30.0,
        speed: float = 5.0,
        T_billet: float = 20.0,
        T_tool: float = 20.0,
        material: MaterialSource = None,
        mesh_size: float = 0.4,
        n_points: int = 80,
        entry_radius: float = 2.0,
        edge_radius: float = 1.5,
        land: float = 2.0,
        tool_heating: bool = True,
        relief: float = 1.0,
        container_length: float | None = None,
        die_outer_diameter: float | None = None,
        punch_length: float | None = None,
        press_stiffness: float | None = None,
        tool_modulus: float = 210.0,
        tool_material: MaterialSource = TOOLS,
        htc: float = 35.0,
        T_ambient: float = 20.0,
        h_ambient: float = 10.0,
        friction_heat_share: float = 0.5,
        ejector_diameter: float | None = None,
    ) -> None:
        thermal = ThermalConditions(
            T_billet, T_tool, tool_heating, tool_material, htc, T_ambient, h_ambient, friction_heat_share
        )
        super().__init__(speed, material, n_points, thermal)
        self._number("diameter", diameter, 2.0, 200.0, "mm")
        self._number("exit_diameter", exit_diameter, 0.2 * diameter, 0.97 * diameter, "mm")
        self._number("half_angle", half_angle, 10.0, 80.0, "degrees")
        self._number("billet_length", billet_length, 0.5 * diameter, 10.0 * diameter, "mm")
        self._number("mesh_size", mesh_size, 0.005 * diameter, 0.05 * diameter, "mm")
        self._number("entry_radius", entry_radius, 0.05, 0.5 * diameter, "mm")
        self._number("edge_radius", edge_radius, 0.05, 0.5 * diameter, "mm")
        self._number("land", land, 0.1, diameter, "mm")
        self._number("relief", relief, 0.1, diameter, "mm")
        self.die = ExtrusionDie(
            0.5 * diameter, 0.5 * exit_diameter, half_angle, entry_radius, edge_radius, land, relief
        )
        self.billet_length = billet_length
        self.mesh_size = mesh_size
        elastic = ElasticTools(
            self.name, diameter, diameter, die_outer_diameter, punch_length, press_stiffness, tool_modulus
        )
        self._set_tools(elastic, ejector_diameter, exit_diameter)
        self._cone_end = self.die.segments(1.0)[1]
        self._billet_bottom = self._first_touch()
        needed = self._billet_bottom + billet_length - self._cone_end
        self.units["container_length"], self.ranges["container_length"] = "mm", (needed, LONGEST)
        if container_length is not None:
            self._number("container_length", container_length, needed, LONGEST, "mm")
        self.container_length = float(needed + 2.0 if container_length is None else container_length)
        self._check_stroke(billet_length)

    @property
    def max_stroke(self) -> float:
        """Largest stroke [mm]: the punch stays 1 mm above the cone."""
        return self._billet_bottom + self.billet_length - self._cone_end - 1.0

    @property
    def _billet_radius(self) -> float:
        container = self.die.container_radius
        return container - min(CLEARANCE, CLEARANCE_SHARE * container)

    def _first_touch(self) -> float:
        """Return z of the billet's lower end when it touches the die shoulder [mm]."""
        segments, cone_end = self.die.segments(1.0)
        radius = self._billet_radius
        heights = np.linspace(self.die.land, cone_end + 0.5, 6000)
        gaps = np.array([gap_and_normal(radius, z, segments, 0.0, 0.0)[0] for z in heights])
        return float(heights[np.flatnonzero(gaps <= 0.0).max()])

    def _build(self) -> Simulation:
        """Put the billet on the die shoulder."""
        die, radius = self.die, self._billet_radius
        segments, cone_end = die.segments(self.billet_length + 60.0)
        bottom = self._billet_bottom
        top = bottom + self.billet_length
        tools = [
            Tool(
                "die",
                segments,
                reach=0.5,
                temperature=self.T_tool,
                flexibility=self.elasticity.flexibility,
                spread=self.elasticity.spread,
            ),
            flat_punch(top, self.speed, self.T_tool, widest=die.container_radius),
        ]
        base = self.coarsening * min(self.mesh_size, die.exit_radius / 7.0)
        size = _DieSize(
            self._size_on(die.edge_radius, base), self._size_on(die.entry_radius, base), base, die, cone_end
        )
        if self.tool_heating:
            tools[0].heat_field = die.heat_field(cone_end + self.container_length, size, self.T_tool)
            depth = 1.5 * die.container_radius
            tools[1].heat_field = block_field(die.container_radius, top, depth, size, self.T_tool)
        outline = np.array([[0.0, bottom], [radius, bottom], [radius, top], [0.0, top]])

        def size_at(state: State) -> _DieSize:
            below = replace(size, top=top - state.travel)
            surface = state.body.surface
            r, z = state.markers.corners(surface)[0]
            # Behind the die nothing stretches any more.
            if z < -die.relief:
                return below
            near = distance_to_point(surface, r, z) < base
            folds = turns(surface)[near].max(initial=0.0) > EDGE
            return replace(below, front=(r, z), at_front=FOLDING if folds else FOLDED)

        body = body_within(outline, replace(size, top=top, front=(radius, bottom)), tools, self.T_billet)
        body.velocity[:, 1] = -self.speed
        control = StepControl(slip=SLIDING * base, arrival=ARRIVAL * base, after_remesh=AFTER_REMESH)
        arc = self._marker_arc(radius)
        simulation = Simulation(
            body,
            tools,
            self.material,
            arc,
            size=size_at,
            control=control,
            policy=RemeshPolicy(
                strain=STRAIN,
                first_strain=max(FOLDING_STRAIN, 2.0 * STRAIN * np.cos(np.radians(die.half_angle)) ** 2),
                first_travel=FOLDED_AFTER * die.container_radius,
            ),
            compliance=self.elasticity.compliance,
        )
        return self.thermal.apply(simulation)

    def _size_on(self, radius: float, base: float) -> float:
        """Return the element size on a rounding of the die [mm].

        The surface is a polygon, whose sides cut off h^2 / (8 R) of a rounding: as nodes pass, the bore seems to change
        by that, and the force with it, the more so the less the diameter is reduced. Peaks of the pressure are there, too, and
        a rod of long sides touches the land: with large elements elsewhere they stay as small as `COARSEST` asks.
        """
        container = self.die.container_radius
        share = min(radius / (FINE_RADIUS * container), (1.0 - self.die.exit_radius / container) / FINE_STEP)
        mesh_size = self.coarsening * min(self.mesh_size, COARSEST * container)
        return min(ROUNDED * min(base, mesh_size), mesh_size * max(FINEST, ROUNDED * share))

    def ejection_stage(self, how: str, number: int, state: State) -> Stage | None:
        """Withdraw the punch; then the pin pushes rod and head back up, until the head is out of the container."""
        die, surface = state.tools[0], state.body.surface
        if number == 0:
            punch = withdrawn(state.tools[1], self.speed)
            return Stage(
                "withdraw", (die, punch), "punch", longest=1.0 + 0.05 * self.billet_length, clear=0.0
            )
        if number > 1:
            return None
        top, radius = self._cone_end + self.container_length, self.die.container_radius
        # The bore of a die that has widened stands further out; its opening is made in the tool's own frame.
        die = opened(die, radius, top)
        pin = ejector(0.5 * self.ejector_diameter, surface, self.speed, self.T_tool)
        lowest, clear = float(surface[:, 1].min()), top - 2.0 * OPENING * radius
        return Stage("eject", (die, pin), "ejector", longest=top - lowest, opening=clear)

    def _marker_arc(self, radius: float) -> FloatArray:
        """Return where the markers start: densest on the side, which the die works on."""
        corners = np.cumsum([0.0, radius, self.billet_length, radius])
        counted = np.cumsum([0.0, 0.5 * radius, self.billet_length, 0.25 * radius])
        return np.interp(np.linspace(0.0, counted[-1], self.n_points), counted, corners)
