"""Records a forming run step by step: force, work and the contact at the markers."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..fe.mesh.shape import FloatArray
from ..fe.simulation import Simulation
from ..results.contact_history import ContactHistory
from ..results.field_recorder import FieldRecorder
from ..results.fields import FieldHistory
from ..results.result import FormingResult
from ..results.snapshot import CONTACT_FIELDS, surface_contact
from .stepwise import StepwiseProcess

#: Column of the contact fields.
TAU_OVER_K = [f.name for f in CONTACT_FIELDS].index("tau_over_k")


class ContactLog:
    """Records the contact at the material markers, one entry per communication step."""

    def __init__(self, n_points: int) -> None:
        self.n_points = n_points
        self.stroke: list[float] = []
        self.loads: list[FloatArray] = []
        self.active: list[npt.NDArray[np.bool_]] = []
        self.mu: list[FloatArray] = []
        self.position: list[FloatArray] = []
        self.tau_over_k: list[FloatArray] = []
        self._ratio = np.zeros(n_points)

    def read_ratio(self, simulation: Simulation) -> None:
        """Read the friction stress over k; to be called before a remeshing takes the contact away."""
        markers = simulation.state.markers
        ratio = markers.at_markers(surface_contact(simulation)[:, TAU_OVER_K])
        self._ratio = np.where(markers.active, ratio, 0.0)

    def add(self, simulation: Simulation, stroke: float, mu: FloatArray) -> None:
        """Add the end of a communication step during which the coefficients `mu` acted."""
        state = simulation.state
        self.stroke.append(stroke)
        self.loads.append(state.markers.loads())
        self.active.append(state.markers.active.copy())
        self.mu.append(mu.copy())
        self.position.append(state.markers.points(state.body.surface))
        self.tau_over_k.append(self._ratio)

    def cut(self, stroke: float) -> None:
        """Forget what was added after `stroke` [mm]."""
        n = int(np.searchsorted(self.stroke, stroke + 1e-9))
        for entries in (self.stroke, self.loads, self.active, self.mu, self.position, self.tau_over_k):
            del entries[n:]

    def history(self) -> ContactHistory:
        """Return the record so far."""
        n = self.n_points
        return ContactHistory(
            stroke=np.array(self.stroke),
            loads=np.array(self.loads).reshape(-1, n, 5),
            active=np.array(self.active, dtype=bool).reshape(-1, n),
            mu=np.array(self.mu).reshape(-1, n),
            position=np.array(self.position).reshape(-1, n, 2),
            tau_over_k=np.array(self.tau_over_k).reshape(-1, n),
        )


class RunLog:
    """Records a forming stroke."""

    def __init__(self, process: StepwiseProcess, recorder: FieldRecorder | None) -> None:
        self.process = process
        self.recorder = recorder
        self.end = 0.0
        self.contact = ContactLog(process.n_points)
        if recorder is not None:
            recorder.begin(process.simulation)
        self.scalars: list[tuple[float, ...]] = [(0.0,) * 5]

    def observe(self, simulation: Simulation) -> bool:
        """See an increment before a remeshing takes the contact away."""
        if simulation.state.stroke >= self.end - 1e-9:
            self.contact.read_ratio(simulation)
        if self.recorder is not None:
            self.recorder(simulation)
        return False

    def add(self, mu: FloatArray) -> None:
        """Add the end of a communication step during which `mu` acted."""
        p = self.process
        if p.stroke <= self.scalars[-1][0]:
            return
        if p.status != "ok" and p.simulation.state.tables is not None:
            self.contact.read_ratio(p.simulation)
        self.scalars.append((p.stroke, p.force, p.work, p.compression, p.expansion))
        self.contact.add(p.simulation, p.stroke, mu)

    def result(self) -> FormingResult:
        """Return the run so far."""
        state = self.process.simulation.state
        stroke, force, work, compression, expansion = np.array(self.scalars).T
        history = state.history
        travel = np.diff([0.0, *(h.stroke for h in history)])
        area = np.array([h.contact_area for h in history]) * travel
        share = np.array([h.share_above_0_6k for h in history])
        return FormingResult(
            stroke=stroke,
            force=force,
            work=work,
            max_tau_over_k=max((h.max_tau_over_k for h in history), default=0.0),
            share_above_0_6k=float(area @ share / area.sum()) if area.sum() > 0.0 else 0.0,
            energy_balance=state.energy.imbalance,
            volume_change=history[-1].volume_change if history else 0.0,
            increments=state.increments,
            remeshes=state.remeshes,
            failed_increments=state.failures,
            contact=self.contact.history(),
            status=state.status,
            message=state.message,
            compression=compression,
            expansion=expansion,
            fields=FieldHistory(())
            if self.recorder is None
            else self.recorder.finish(self.process.simulation),
            heat_balance=state.energy.heat_imbalance,
            warnings=self.process.warnings,
        )
