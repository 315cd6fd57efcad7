"""Upsetting of a cylinder, and compression of a ring, between flat tools."""

from __future__ import annotations

import math
from typing import TypedDict, Unpack

import numpy as np

from friction_models.common import InputError
from friction_models.common.ranges import check_flag

from ..fe.body import Body
from ..fe.increment import Settings
from ..fe.mesh.mesher import MeshError, grid_mesh
from ..fe.mesh.shape import FloatArray
from ..fe.simulation import Simulation
from ..fe.state import RemeshPolicy, StepControl
from ..fe.tooling import block_field, flat_punch, plate
from ..materials.materials import MaterialSource
from .base import FormingProcess
from .thermal_conditions import TOOLS, ThermalConditions

#: Largest share of the height that a stroke may take.
MOST = 0.8
#: Elements where the side meets the faces, as a share of the others, and by how much the next one is larger.
AT_EDGE, GROWTH = 0.25, 0.2


class Upsetting(FormingProcess):
    """Compression of a cylinder or a ring between a flat plate and a flat punch.

    The mesh is a grid that moves with the material: where the side folds onto the tools it carries further than
    meshes that are replaced, and contact changes less. Its elements are smaller towards faces and side. The
    parameters of speed, heat, material and markers are described in `StepwiseProcess`.

    Parameters
    ----------
    diameter : float
        Outer diameter of the billet [mm].
    height : float
        Height of the billet [mm].
    bore_diameter : float
        Bore of a ring [mm]; 0: a solid cylinder.
    T_billet : float
        Temperature of the billet at the start [degC].
    T_tool : float
        Temperature of the tools at the start [degC].
    mesh_size : float, optional
        Size of the largest elements [mm]; by default the smaller of height and wall, over 12.
    shear_factor : float
        Friction stress at most this share m of the shear yield stress k. With the coefficient of friction
        `forming.processes.friction_input.CONSTANT_SHEAR` the friction is then tau = m k.
    isothermal : bool
        Let no heat arise or flow: the billet stays at `T_billet`.
    remeshing : bool
        Replace the mesh when its elements have become poor.

    Raises
    ------
    InputError
        A dimension, speed, temperature or factor that cannot be; the message names it and what is allowed.

    Examples
    --------
    >>> from forming import Upsetting
    >>> process = Upsetting(diameter=12.0, height=18.0)
    >>> process.mesh_size, round(process.max_stroke, 6)
    (0.5, 14.4)
    """

    name = "upsetting"
    #: As a share of the diameter.
    smallest_bore = 0.0

    def __init__(
        self,
        diameter: float = 15.0,
        height: float = 15.0,
        bore_diameter: float = 0.0,
        speed: float = 5.0,
        T_billet: float = 20.0,
        T_tool: float = 20.0,
        material: MaterialSource = None,
        mesh_size: float | None = None,
        n_points: int = 60,
        shear_factor: float = 1.0,
        tool_heating: bool = True,
        isothermal: bool = False,
        remeshing: bool = False,
        tool_material: MaterialSource = TOOLS,
        htc: float = 35.0,
        T_ambient: float = 20.0,
        h_ambient: float = 10.0,
        friction_heat_share: float = 0.5,
    ) -> None:
        thermal = ThermalConditions(
            T_billet, T_tool, tool_heating, tool_material, htc, T_ambient, h_ambient, friction_heat_share
        )
        super().__init__(speed, material, n_points, thermal)
        self._number("diameter", diameter, 1.0, 300.0, "mm")
        self._number("height", height, 0.1 * diameter, 2.5 * diameter, "mm")
        smallest = self.smallest_bore * diameter
        self._number("bore_diameter", bore_diameter, smallest, 0.9 * diameter, "mm")
        if 0.0 < bore_diameter < 0.05 * diameter:
            raise InputError(
                f"{self.name}: bore_diameter = {bore_diameter!r} mm; allowed: 0 (solid), or "
                f"{0.05 * diameter:g} to {0.9 * diameter:g} mm"
            )
        wall = 0.5 * (diameter - bore_diameter)
        thin = min(wall, height)
        mesh_size = thin / 12.0 if mesh_size is None else mesh_size
        self._number("mesh_size", mesh_size, thin / 60.0, thin / 4.0, "mm")
        self._number("shear_factor", shear_factor, 0.0, 1.0, "")
        self.diameter, self.height, self.bore_diameter = diameter, height, bore_diameter
        self.mesh_size = mesh_size
        self.shear_factor = shear_factor
        self.isothermal = check_flag(self.name, "isothermal", isothermal)
        self.remeshing = check_flag(self.name, "remeshing", remeshing)

    @property
    def max_stroke(self) -> float:
        """Largest stroke [mm]."""
        return MOST * self.height

    def _build(self) -> Simulation:
        inner, outer, height = 0.5 * self.bore_diameter, 0.5 * self.diameter, self.height
        mesh_size = self.coarsening * self.mesh_size
        half = _graded(0.5 * height, mesh_size)
        # Not towards a bore: small elements fold into it where friction closes it.
        r, z = outer - _graded(outer - inner, mesh_size)[::-1], np.concatenate([half, height - half[-2::-1]])
        n_r, n_z = len(r) - 1, len(z) - 1
        mesh = grid_mesh(r, z)
        chain = np.append(mesh.loop, mesh.loop[0]) if inner else mesh.loop[: 2 * n_r + n_z + 1]
        body = Body.at_rest(mesh.x, mesh.quads, np.ascontiguousarray(chain), self.T_billet)
        body.velocity = np.column_stack([0.5 * (body.x[:, 0] - inner), -body.x[:, 1]]) * self.speed / height
        widest = outer / math.sqrt(1.0 - MOST)
        tools = [
            plate(0.0, self.T_tool, widest=widest),
            flat_punch(height, self.speed, self.T_tool, widest=widest),
        ]
        if self.tool_heating and not self.isothermal:
            reach, depth = widest + 2.0, 1.5 * outer
            tools[0].heat_field = block_field(reach, 0.0, -depth, self._size, self.T_tool)
            tools[1].heat_field = block_field(reach, height, depth, self._size, self.T_tool)
        lengths = np.hypot(*np.diff(body.surface, axis=0).T)
        simulation = Simulation(
            body,
            tools,
            self.material,
            np.linspace(0.0, float(lengths.sum()), self.n_points),
            size=(lambda state: self._size) if self.remeshing else None,
            settings=Settings(penalty=2e5, shear_cap=self.shear_factor),
            control=StepControl(
                first=0.005 * height, largest=0.0125 * height, slip=self.coarsening * self.mesh_size
            ),
            policy=RemeshPolicy(every=1_000_000, quality=0.25, strain=math.inf),
            isothermal=self.isothermal,
        )
        return self.thermal.apply(simulation)

    def _size(self, points: FloatArray) -> FloatArray:
        return np.full(len(points), self.coarsening * self.mesh_size)


def _graded(length: float, size: float) -> FloatArray:
    """Return nodes from 0 to `length`: elements of `size`, towards 0 smaller, the first of them `AT_EDGE` of it.

    Raises MeshError: a size that is not above zero.
    """
    if not size > 0.0:
        raise MeshError(f"elements of {size:g} mm")
    shares = np.minimum(1.0, AT_EDGE * (1.0 + GROWTH) ** np.arange(math.ceil(length / (AT_EDGE * size))))
    nodes = np.append(0.0, size * np.cumsum(shares))
    nodes = nodes[: np.searchsorted(nodes, (1.0 - 1e-9) * length) + 1]
    return nodes * length / nodes[-1]


class UpsettingOptions(TypedDict, total=False):
    """Parameters of `Upsetting` besides the dimensions of the billet."""

    speed: float
    T_billet: float
    T_tool: float
    material: MaterialSource
    mesh_size: float | None
    n_points: int
    shear_factor: float
    tool_heating: bool
    isothermal: bool
    remeshing: bool
    tool_material: MaterialSource
    htc: float
    T_ambient: float
    h_ambient: float
    friction_heat_share: float


class RingCompression(Upsetting):
    """Compression of a ring between flat tools, the usual test of friction: 6:3:2 by default.

    The bore grows where friction is low and shrinks where it is high; the parameters are those of `Upsetting`.

    Examples
    --------
    >>> from forming import RingCompression
    >>> ring = RingCompression(diameter=18.0, height=6.0, bore_diameter=9.0)
    >>> round(ring.max_stroke, 6)
    4.8
    """

    name = "ring compression"
    smallest_bore = 0.05

    def __init__(
        self,
        diameter: float = 12.0,
        height: float = 4.0,
        bore_diameter: float = 6.0,
        **more: Unpack[UpsettingOptions],
    ) -> None:
        super().__init__(diameter, height, bore_diameter, **more)

    def bore_profile(self, levels: int = 200) -> FloatArray:
        """Return the radius of the bore at `levels` equal steps of the height, shape (levels,) [mm]."""
        return bore_profile(self.simulation.state.body.surface, levels)

    @property
    def bore_radius(self) -> float:
        """Radius of the straight bore of the same volume [mm]."""
        return float(np.sqrt((self.bore_profile() ** 2).mean()))

    @property
    def bore_change(self) -> float:
        """Change of the bore diameter, that of the straight bore of the same volume, over the one at the start.

        Positive where the bore has grown.
        """
        return 2.0 * self.bore_radius / self.bore_diameter - 1.0


def bore_profile(surface: FloatArray, levels: int) -> FloatArray:
    """Return the smallest radius of a closed outline in the middle of `levels` equal steps of its height."""
    low, high = surface[:, 1].min(), surface[:, 1].max()
    z = low + (high - low) * (np.arange(levels) + 0.5) / levels
    (r0, z0), (r1, z1) = surface[:-1].T, surface[1:].T
    crosses = (z0[None, :] > z[:, None]) != (z1[None, :] > z[:, None])
    share = (z[:, None] - z0) / np.where(z1 == z0, 1.0, z1 - z0)
    return np.where(crosses, r0 + share * (r1 - r0), np.inf).min(axis=1)
