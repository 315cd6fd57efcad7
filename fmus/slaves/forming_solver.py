"""The forming processes: loads at material markers out, friction in."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from forming.fe.body import Body
from forming.fe.heat.surface_layer import SurfaceLayer
from forming.fe.heat.tool_field import ToolField, ToolSteel
from forming.fe.markers import SurfaceMarkers
from forming.fe.state import Energy, Loading, OldMesh, Record, State
from forming.fe.surface_loads import SurfaceLoads
from forming.fe.tooling import Tool
from forming.materials.materials import material_from_dict
from forming.processes.names import PROCESSES
from forming.results.field_recorder import FieldWriter, writer_from_environment
from forming.results.local_errors import elements_from_environment

from .core import Solver

#: Shortest punch travel that is computed [mm]; what is left over is made up for in the next step.
SHORTEST = 1e-4


class FormingSolver(Solver):
    """Outputs: five loads of n markers, stroke, force, work, max_tau_over_k, r and z of the markers, active; input: mu."""

    snapshot_classes = (
        State,
        Body,
        Tool,
        ToolField,
        ToolSteel,
        SurfaceLayer,
        SurfaceMarkers,
        SurfaceLoads,
        OldMesh,
        Energy,
        Record,
        Loading,
    )
    #: Writes the fields where the environment asks for them; it only looks, and is no part of the state.
    fields: FieldWriter | None = None

    def start(self) -> None:
        material = material_from_dict(self.config["material"])
        # A number that may be left out is 0 in the FMU when it is.
        left_out = {name for name in self.config["optional"] if self.parameters()[name] == 0.0}
        parameters = {name: value for name, value in self.parameters().items() if name not in left_out}
        kind: Any = PROCESSES[self.config.get("process", "fre")]
        self.process = kind(material=material, **self.config["fixed"], **parameters)
        self.process.coarsening = elements_from_environment()
        self.process.start()
        self.process.set_mu(self.inputs())
        if self.fields is None:
            self.fields = writer_from_environment(self.config.get("process", "fre"))
        self.publish()

    def advance(self, elapsed: float, step: float) -> None:
        process = self.process
        process.set_mu(self.inputs())
        travel = process.speed * (elapsed + step) - process.stroke
        if travel < SHORTEST:
            return
        if self.fields is not None and process.stroke == 0.0:
            self.fields.begin(process.simulation)
        if not process.advance(travel, self.fields):
            raise RuntimeError(process.message)
        self.publish()

    def remarks(self) -> Sequence[str]:
        return self.process.warnings if self.process is not None else ()

    def publish(self) -> None:
        """Write the outputs; a marker out of contact has sigma_n = 0, so that friction keeps its memory."""
        process, n = self.process, self.process.n_points
        loads, active = process.loads(), process.active
        loads[:, 2] = np.where(active, loads[:, 2], 0.0)
        self.values[: 5 * n] = loads.T.ravel()
        self.values[5 * n : 5 * n + 4] = process.stroke, process.force, process.work, process.max_tau_over_k
        self.values[5 * n + 4 : 7 * n + 4] = process.marker_position.T.ravel()
        self.flags[:] = active
