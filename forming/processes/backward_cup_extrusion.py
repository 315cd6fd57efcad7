"""Backward cup extrusion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..fe.heat.tool_field import ToolField
from ..fe.mesh.polyline import distance_to_point
from ..fe.mesh.shape import FloatArray
from ..fe.remesh import body_within
from ..fe.simulation import Simulation
from ..fe.state import RemeshPolicy, State, StepControl
from ..fe.tooling import Tool, line, plate
from ..materials.materials import MaterialSource
from ..tools.cup_punch import CupPunch
from ..tools.ejection_tools import OPENING, Stage, ejector, opened, stripper, withdrawn
from ..tools.elasticity import ElasticTools
from .base import Extrusion
from .thermal_conditions import TOOLS, ThermalConditions

#: Elements on the rounding of the punch are smaller than elsewhere below this radius of it and below this wall of the
#: cup, both as shares of the container's radius; their usual and their smallest size as shares of the others and of `mesh_size`.
FINE_RADIUS, FINE_WALL, ROUNDED, FINEST = 0.28, 0.3, 0.7, 0.3
#: Elements of the container's heat field at its bore, as a share of `mesh_size`.
BORE = 1.5
#: Largest sliding in one increment, in elements.
SLIDING = 0.55
#: Largest increment after a remeshing, as a share of the largest: two of them make a communication step of 0.1 mm.
AFTER_REMESH = 0.5
#: Largest plastic strain between two remeshings.
STRAIN = 0.5


@dataclass(frozen=True)
class _CupSize:
    """Element size: `on_edge` on the rounding of the punch, `finest` around it, a few elements through wall and base."""

    finest: float
    nose: float
    punch: CupPunch
    wall: float
    on_edge: float

    def __call__(self, points: FloatArray) -> FloatArray:
        rp, edge = self.punch.radius, self.punch.edge_radius
        shoulder = self.nose + self.punch.nose_height
        distance = distance_to_point(points, rp - 0.3 * edge, shoulder + 0.5 * edge)
        growth = 0.15 * np.maximum(0.0, distance - 1.2 - edge)
        size = np.minimum(self.finest + growth, 2.6 * self.finest)
        off_edge = np.abs(distance_to_point(points, rp - edge, shoulder + edge) - edge)
        size = np.minimum(size, self.on_edge + 0.2 * np.maximum(0.0, off_edge - 0.3))
        above = points[:, 1] > shoulder + edge
        through_wall = max(self.wall / 4.0, self.finest)
        through_base = max(max(self.nose, 0.3) / 4.0, 0.6 * self.finest)
        return np.minimum(size, np.where(above, through_wall, through_base))


class BackwardCupExtrusion(Extrusion):
    """Axisymmetric backward cup extrusion: a punch presses into a billet in a closed container.

    The parameters of elastic tools are described in `Extrusion`, those of speed, temperatures, heat and material in `StepwiseProcess`.

    Parameters
    ----------
    diameter : float
        Bore of the container [mm].
    punch_diameter : float
        Land of the punch [mm]; the wall of the cup is half the difference to `diameter`.
    billet_length : float
        Height of the billet [mm].
    mesh_size : float
        Element size under the punch [mm]; smaller on its rounding and where the wall asks for it.
    n_points : int
        Number of material markers, densest on the face under the punch, which becomes the inner wall.
    edge_radius : float
        Rounding of the punch between nose and land [mm].
    land : float
        Length of the cylindrical part of the punch behind the rounding [mm].
    relief : float
        How far the shaft of the punch steps back behind the land [mm].
    nose_angle : float
        Angle between the nose of the punch and a plane across the axis [degrees], 0 is flat.
    tip_radius : float
        Rounding of a conical nose on the axis [mm].
    ejector_diameter : float, optional
        Ejector under the cup's bottom [mm]; by default 0.95 of `diameter`.

    Raises
    ------
    InputError
        A dimension, speed or temperature that cannot be.

    Examples
    --------
    >>> from forming import BackwardCupExtrusion
    >>> process = BackwardCupExtrusion(speed=10.0, T_tool=200.0)
    >>> process.units["speed"], process.units["T_tool"]
    ('mm/s', 'degC')
    >>> BackwardCupExtrusion(speed=-1.0)
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: ...: speed = -1.0 mm/s; allowed: ... mm/s
    """

    name = "backward cup extrusion"
    ejections = ("stripper", "ejector")

    def __init__(
        self,
        diameter: float = 20.0,
        punch_diameter: float = 14.14,
        billet_length: float = 20.0,
        speed: float = 5.0,
        T_billet: float = 20.0,
        T_tool: float = 20.0,
        material: MaterialSource = None,
        mesh_size: float = 0.35,
        n_points: int = 100,
        edge_radius: float = 1.5,
        land: float = 2.0,
        tool_heating: bool = True,
        nose_angle: float = 0.0,
        tip_radius: float = 2.0,
        relief: float = 0.28,
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
        self._number("punch_diameter", punch_diameter, 0.35 * diameter, 0.92 * diameter, "mm")
        self._number("billet_length", billet_length, 0.3 * diameter, 5.0 * diameter, "mm")
        self._number("mesh_size", mesh_size, 0.005 * diameter, 0.05 * diameter, "mm")
        self._number("edge_radius", edge_radius, 0.01 * diameter, 0.4 * punch_diameter, "mm")
        self._number("land", land, 0.1, diameter, "mm")
        self.container_radius = 0.5 * diameter
        self._number("nose_angle", nose_angle, 0.0, 30.0, "degrees")
        self._number("tip_radius", tip_radius, 0.05, diameter, "mm")
        self._number("relief", relief, 0.02, 0.25 * punch_diameter, "mm")
        self.punch = CupPunch(0.5 * punch_diameter, edge_radius, land, nose_angle, tip_radius, relief)
        elastic = ElasticTools(
            self.name,
            diameter,
            punch_diameter,
            die_outer_diameter,
            punch_length,
            press_stiffness,
            tool_modulus,
        )
        self._set_tools(elastic, ejector_diameter, diameter)
        self.billet_length = billet_length
        self.mesh_size = mesh_size
        self._check_stroke(billet_length)

    @property
    def max_stroke(self) -> float:
        """Largest stroke [mm]: a base of a tenth of the billet, at least 1 mm, stays."""
        return self.billet_length - max(1.0, 0.1 * self.billet_length)

    def _build(self) -> Simulation:
        """Put the billet into the container, the punch on top of it."""
        radius, height = self.container_radius, self.billet_length
        wall = radius - self.punch.radius
        edge = self.punch.edge_radius
        finest = self.coarsening * min(self.mesh_size, wall / 5.0, max(0.57 * self.mesh_size, 0.35 * edge))
        # The surface is a polygon: small sides on the rounding, of which the force ripples with their square.
        share = min(self.punch.edge_radius / (FINE_RADIUS * radius), wall / (FINE_WALL * radius))
        on_edge = min(ROUNDED * finest, self.coarsening * self.mesh_size * max(FINEST, ROUNDED * share))

        def size(stroke: float) -> _CupSize:
            return _CupSize(finest, height - stroke, self.punch, wall, on_edge)

        shaft = height + 40.0
        punch = Tool(
            "punch",
            self.punch.segments(shaft),
            np.array([0.0, -self.speed]),
            np.array([0.0, height - 1e-8]),
            temperature=self.T_tool,
        )
        bore = np.array([line((radius, -5.0), (radius, 10.0 * height + 60.0))])
        container = Tool(
            "container",
            bore,
            temperature=self.T_tool,
            flexibility=self.elasticity.flexibility,
            spread=self.elasticity.spread,
        )
        base = plate(0.0, self.T_tool, widest=radius)
        if self.tool_heating:
            first = size(0.0)
            shift = np.array([0.0, height])
            punch.heat_field = self.punch.heat_field(height, lambda p: first(p + shift), self.T_tool)
            container.heat_field, base.heat_field = self._outer_fields(size(0.5 * height))
        outline = np.array([[0.0, 0.0], [radius, 0.0], [radius, height], [0.0, height]])
        tools = [container, punch, base]
        body = body_within(outline, size(0.0), tools, self.T_billet)
        body.velocity[:, 1] = -self.speed * np.clip(body.x[:, 1] / height, 0.0, 1.0)
        corners = np.cumsum([0.0, radius, height, radius])
        counted = np.cumsum([0.0, 0.3 * radius, 0.5 * height, 3.0 * radius])
        markers = np.interp(np.linspace(0.0, counted[-1], self.n_points), counted, corners)
        control = StepControl(slip=SLIDING * finest, after_remesh=AFTER_REMESH)
        simulation = Simulation(
            body,
            tools,
            self.material,
            markers,
            size=lambda state: size(state.travel),
            control=control,
            policy=RemeshPolicy(strain=STRAIN),
            compliance=self.elasticity.compliance,
        )
        return self.thermal.apply(simulation)

    def ejection_stage(self, how: str, number: int, state: State) -> Stage | None:
        """Withdraw the punch, a stripper on the rim; then take that back and push the cup's bottom up.

        The container is taken to end at the rim of the cup, the shortest that holds it.
        """
        surface, radius = state.body.surface, self.container_radius
        rim = float(surface[:, 1].max())
        if number == 0:
            container, punch, base = state.tools
            wall = radius - self.punch.radius
            plate_on_rim = stripper(self.punch.radius + 0.1 * wall, 0.1 * wall, surface, self.T_tool)
            depth = rim - float(punch.offset[1])
            tools = (container, withdrawn(punch, self.speed), base, plate_on_rim)
            return Stage("withdraw", tools, "punch", longest=depth + 2.0, clear=0.05 * radius)
        if how != "ejector" or number > 2:
            return None
        if number == 1:
            container, _, base, above = state.tools
            held = (container, base, withdrawn(above, self.speed))
            return Stage("release", held, "stripper", longest=0.1 * self.billet_length, clear=0.0)
        container, base = state.tools[:2]
        pin = ejector(0.5 * self.ejector_diameter, surface, self.speed, self.T_tool)
        lowest, clear = float(surface[:, 1].min()), rim - 2.0 * OPENING * radius
        moving = (opened(container, radius, rim), base, pin)
        return Stage("eject", moving, "ejector", longest=rim - lowest, opening=clear)

    def _outer_fields(self, size: _CupSize) -> tuple[ToolField, ToolField]:
        """Return the heat fields of container and base plate."""
        radius, depth = self.container_radius, 1.5 * self.container_radius
        size_there = self.coarsening * self.mesh_size
        coarse = 2.6 * size_there
        top = 3.0 * self.billet_length
        bore = np.array([[radius, top], [radius, 0.0]])
        back = np.array([[radius, 0.0], [radius + depth, 0.0], [radius + depth, top], [radius, top]])

        def even(points: FloatArray) -> FloatArray:
            return np.full(len(points), coarse)

        def at_bore(points: FloatArray) -> FloatArray:
            # The end of the contact runs up the bore: where it has just come, the bore is cold.
            return np.minimum(coarse, BORE * size_there + 0.5 * (points[:, 0] - radius))

        container = ToolField.build([bore], back, at_bore, self.T_tool)
        face = np.array([[radius, 0.0], [0.0, 0.0]])
        below = np.array([[0.0, 0.0], [0.0, -depth], [radius, -depth], [radius, 0.0]])
        return container, ToolField.build([face], below, even, self.T_tool)
