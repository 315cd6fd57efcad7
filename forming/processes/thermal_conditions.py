"""Thermal boundary conditions of a forming process."""

from __future__ import annotations

from dataclasses import dataclass, replace

from friction_models.common.ranges import check_flag

from ..fe.heat.tool_field import ToolSteel
from ..fe.heat_exchange import Environment, HeatExchange
from ..fe.simulation import Simulation
from ..materials.materials import Material, MaterialSource, as_material

#: Steel of the tools unless another is named.
TOOLS = "1.2379"
#: Lowest, highest and unit of the numbers.
RANGES = {
    "T_billet": (-50.0, 700.0, "degC"),
    "T_tool": (-50.0, 700.0, "degC"),
    "htc": (0.01, 1000.0, "kW/(m2 K)"),
    "T_ambient": (-50.0, 700.0, "degC"),
    "h_ambient": (0.0, 10_000.0, "W/(m2 K)"),
    "friction_heat_share": (0.0, 1.0, ""),
}


@dataclass(frozen=True)
class ThermalConditions:
    """Temperatures at the start, and how workpiece, tools and environment exchange heat.

    The attributes are described in `StepwiseProcess`; the material of the tools needs no flow curve.

    Examples
    --------
    >>> from forming.processes.thermal_conditions import ThermalConditions
    >>> warm = ThermalConditions(T_tool=200.0)
    >>> warm.T_tool, warm.T_billet
    (200.0, 20.0)
    >>> warm.resolved("fre").tool_material.name
    '1.2379'
    """

    T_billet: float = 20.0
    T_tool: float = 20.0
    tool_heating: bool = True
    tool_material: MaterialSource = TOOLS
    htc: float = 35.0
    T_ambient: float = 20.0
    h_ambient: float = 10.0
    friction_heat_share: float = 0.5

    def resolved(self, process: str) -> ThermalConditions:
        """Return the conditions with a checked switch and with the material itself instead of its name.

        Raises InputError: the switch or the material of the tools cannot be; `process` is for the message.
        """
        heating = check_flag(process, "tool_heating", self.tool_heating)
        steel = TOOLS if self.tool_material is None else self.tool_material
        return replace(self, tool_heating=heating, tool_material=as_material(steel, "tool_material"))

    def apply(self, simulation: Simulation) -> Simulation:
        """Give a simulation at its start the heat data of tools, contact and environment; return it."""
        assert isinstance(self.tool_material, Material)
        steel = ToolSteel(self.tool_material.conductivity, self.tool_material.heat_capacity)
        for tool in simulation.state.tools:
            if tool.heat_field is not None:
                tool.heat_field.steel = steel
        if simulation.heat is not None:
            air = Environment(float(self.T_ambient), float(self.h_ambient) * 1e-3)
            simulation.heat = HeatExchange(
                float(self.htc), float(self.friction_heat_share), air if self.h_ambient > 0.0 else None
            )
        return simulation
