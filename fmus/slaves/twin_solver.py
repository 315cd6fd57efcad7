"""The tribometer twin: force, speed, tool temperature and friction in, loads out."""

from __future__ import annotations

from typing import Any

from forming.materials.materials import material_from_dict
from sct_twin.twin.heat.contact_temperature import (
    ContactTemperature,
    SlidingContact,
    ThermalBody,
    ThermalSettings,
)
from sct_twin.twin.process import ProcessSnapshot, SctProcess
from sct_twin.twin.upsetting import ContactState

from .core import Solver


class TwinSolver(Solver):
    """Outputs: the five loads of the contact mean; inputs: F_n, v_slide, T_tool, mu."""

    snapshot_classes = (
        ProcessSnapshot,
        ContactState,
        SlidingContact,
        ThermalSettings,
        ThermalBody,
        ContactTemperature,
    )

    def start(self) -> None:
        F_n, v_slide, T_tool, mu = self.inputs().tolist()
        parameters: Any = self.parameters()
        self.process = SctProcess(
            material=material_from_dict(self.config["material"]),
            T_tool=T_tool,
            T_specimen=self.config["T_specimen"],
            **parameters,
        )
        self.publish(self.process.advance(0.0, F_n, v_slide, T_tool, mu))

    def advance(self, elapsed: float, step: float) -> None:
        self.publish(self.process.advance(step, *self.inputs().tolist()))

    def publish(self, loads: tuple[float, ...]) -> None:
        """Write the outputs."""
        self.values[: self.first_input] = loads
