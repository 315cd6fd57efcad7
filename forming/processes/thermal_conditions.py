"""Heat as a process is told about it: the steel of the tools, the contact, the environment."""

from __future__ import annotations

from dataclasses import dataclass

from friction_models.common.ranges import check_range

from ..fe.heat.tool_field import ToolSteel
from ..fe.heat_exchange import Environment, HeatExchange
from ..fe.simulation import Simulation
from ..materials.materials import Material, MaterialSource, as_material

#: Steel of the tools unless another is named.
TOOLS = "1.2379"
#: Lowest, highest and unit of the numbers.
RANGES = {
    "htc": (0.01, 1000.0, "kW/(m2 K)"),
    "T_ambient": (-50.0, 700.0, "degC"),
    "h_ambient": (0.0, 10_000.0, "W/(m2 K)"),
}


@dataclass(frozen=True)
class HeatInput:
    """Heat data of a process beside the workpiece's own.

    Attributes
    ----------
    where : str
        For messages.
    tool_material : Material, name or path
        Steel of the tools; it needs no flow curve.
    htc : float
        Heat transfer coefficient of the contact [kW/(m2 K)].
    T_ambient : float
        Temperature of air and walls [degC].
    h_ambient : float
        Heat transfer coefficient to still air [W/(m2 K)]; 0: free surfaces are insulated and do not radiate.

    Raises
    ------
    InputError
        A value outside its range.
    """

    where: str
    tool_material: MaterialSource = TOOLS
    htc: float = 35.0
    T_ambient: float = 20.0
    h_ambient: float = 10.0

    def __post_init__(self) -> None:
        for name, (low, high, unit) in RANGES.items():
            check_range(self.where, name, getattr(self, name), low, high, unit)
        steel = TOOLS if self.tool_material is None else self.tool_material
        object.__setattr__(self, "tool_material", as_material(steel, "tool_material"))

    def apply(self, simulation: Simulation) -> Simulation:
        """Give a simulation at its start these data; return it."""
        assert isinstance(self.tool_material, Material)
        steel = ToolSteel(self.tool_material.conductivity, self.tool_material.rho, self.tool_material.cp)
        for tool in simulation.state.tools:
            if tool.heat_field is not None:
                tool.heat_field.steel = steel
        if simulation.heat is not None:
            air = Environment(float(self.T_ambient), float(self.h_ambient) * 1e-3)
            simulation.heat = HeatExchange(
                float(self.htc), simulation.heat.friction_share, air if self.h_ambient > 0.0 else None
            )
        return simulation
