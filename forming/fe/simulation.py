"""A forming simulation: adaptive increments, heat, remeshing, markers and the energy account."""

from __future__ import annotations

import copy
from collections.abc import Callable

import numpy as np

from friction_models.common.processes.one_blas_thread import one_blas_thread

from .arrival import cut_at_arrival, touching_shares
from .body import Body, WorkpieceMaterial
from .contact import SHEAR, SLIP
from .heat_exchange import HeatExchange, exchange_heat
from .increment import Attempt, Settings, Step, StepError, Workspace, solve_increment
from .markers import SurfaceMarkers
from .mesh.mesh_kernels import qualities
from .mesh.polyline import SizeField, first_crossing
from .mesh.shape import FloatArray, gauss_volumes
from .remesh import remesh
from .state import SCALES, Loading, OldMesh, Record, RemeshPolicy, State, StepControl
from .surface_loads import SurfaceLoads, bore_pressure, surface_loads
from .tooling import Tool

#: Share of the missing expansion that a tool makes up for in one increment. The workpiece pushes back up to
#: three times as hard as the tool, which limits a stable share to 0.5.
EXPANSION_RELAXATION = 0.3
#: A surface node further across the axis than this has met the opposite side of a bore [mm].
ON_AXIS = 1e-9
#: Steepest rise of the force that the spring of punch and press foresees [N/mm].
STEEPEST = 3e6


class Simulation:
    """An axisymmetric body formed by rigid tools, one of which drives.

    - `body`: mesh and start state; its `velocity` is the first guess.
    - `tools`: tools; those with a velocity share its magnitude. `stroke` is their travel.
    - `material`: workpiece material.
    - `marker_arc`, shape (n,): arc lengths of the material markers on the surface [mm].
    - `mu`: coefficient of friction until `set_mu` is called.
    - `size`: returns the size field for remeshing a state; None: never remesh.
    - `compliance`: shortening of punch and press for the force on the moving tools [mm/N].
    """

    def __init__(
        self,
        body: Body,
        tools: list[Tool],
        material: WorkpieceMaterial,
        marker_arc: FloatArray,
        mu: float = 0.08,
        size: Callable[[State], SizeField] | None = None,
        settings: Settings | None = None,
        control: StepControl | None = None,
        policy: RemeshPolicy | None = None,
        heat: HeatExchange | None = None,
        isothermal: bool = False,
        compliance: float = 0.0,
    ) -> None:
        self.material = material
        self.size = size
        self.settings = settings or Settings()
        self.control = control or StepControl()
        self.policy = policy or RemeshPolicy()
        self.heat = None if isothermal else (heat or HeatExchange())
        self.compliance = compliance
        self.speed = max(tool.speed for tool in tools)
        self._vector = material.vector()
        markers = SurfaceMarkers(body.surface, marker_arc, float(body.T.mean()))
        self.state = State(
            body=body,
            tools=tools,
            markers=markers,
            mu=np.full(len(markers), float(mu)),
            strain_at_remesh=body.strain.copy(),
            next_dt=self.control.first / self.speed,
            forces=np.zeros((len(tools), 2)),
        )
        self._space = Workspace(body)
        self._start_volume = body.volume()

    @property
    def force(self) -> float:
        """Force on the moving tools against their motion [N]."""
        return float(self._resistance(self.state.forces).sum())

    def _resistance(self, forces: FloatArray) -> FloatArray:
        """Return for each tool the force that its drive must overcome [N]."""
        return np.array([-(f @ t.velocity) / self.speed for f, t in zip(forces, self.state.tools)])

    def snapshot(self) -> State:
        """Return a copy of the state."""
        return copy.deepcopy(self.state)

    def restore(self, snapshot: State) -> None:
        """Continue from a snapshot exactly as the run continued after it was taken."""
        self.state = copy.deepcopy(snapshot)
        self._space = Workspace(self.state.body)

    @one_blas_thread()
    def advance_to(
        self,
        stroke: float,
        on_increment: Callable[[Simulation], bool] | None = None,
        limit: Callable[[Simulation], float] | None = None,
    ) -> bool:
        """Move the tools until `stroke` [mm].

        - `on_increment`: called after each increment, before a remeshing; True ends the advance.
        - `limit`: returns the largest next increment [mm].
        - returns: False when the run has stopped; `state.status` and `state.message` then say why.
        """
        state = self.state
        while state.status == "ok" and state.stroke < stroke - 1e-9:
            if state.increments + state.failures >= self.control.attempts:
                self._stop(
                    f"{state.increments} increments and {state.failures} failed ones; "
                    f"allowed: {self.control.attempts} in all"
                )
                break
            dt = state.next_dt
            if limit is not None:
                dt = min(dt, limit(self) / self.speed)
            remaining = (stroke - state.stroke) / self.speed
            dt = remaining / max(1, int(np.ceil(remaining / dt - 1e-6)))
            if self.control.arrival > 0.0:
                body = state.body
                dt = cut_at_arrival(body.x, body.velocity, body.chain, state.tools, self.control.arrival, dt)
            try:
                step = self._increment(dt)
            except (ArithmeticError, ValueError, IndexError) as error:
                reason = " ".join(str(error).split())[:200]
                self._stop(f"{type(error).__name__} in the next increment ({reason})")
                break
            if step is None:
                continue
            if state.status != "ok":
                break
            done = on_increment is not None and on_increment(self)
            self._choose_next(step, dt)
            if done:
                break
        return state.status == "ok"

    def _stop(self, reason: str) -> None:
        """End the run, keeping what it has."""
        self.state.status = "stopped"
        self.state.message = f"stopped at stroke {self.state.stroke:.3f} mm: {reason}"

    def _increment(self, dt: float) -> Step | None:
        state = self.state
        mu = state.markers.at_nodes(state.mu, len(state.body.chain))
        share = self._share(dt)
        moves = self._moves(dt, share)
        try:
            step = solve_increment(
                state.body,
                state.tools,
                self._vector,
                dt,
                mu,
                self.settings,
                Attempt.number(state.failures_in_row),
                self._space,
                moves,
                share,
            )
        except StepError as error:
            self._recover(dt, str(error))
            return None
        change = abs(float(self._resistance(step.forces).sum()) - self.force)
        if change > self.control.force_change and dt * self.speed > 8.0 * self.control.smallest:
            state.next_dt = 0.5 * dt
            return None
        surface = (state.body.x + step.du)[state.body.chain]
        if float(surface[:, 0].min()) < -ON_AXIS:
            z = float(surface[surface[:, 0].argmin(), 1])
            self._stop(
                f"in the next increment the bore of the workpiece closes at z = {z:.2f} mm; contact of the workpiece "
                "with itself is not computed"
            )
            return None
        self._accept(step, dt, moves, share)
        return step

    def _moves(self, dt: float, share: float) -> list[FloatArray]:
        """Return the displacements of the tools in an increment [mm], elastic ones included."""
        state = self.state
        moves = [tool.velocity * (dt * share) for tool in state.tools]
        for move, tool in zip(moves, state.tools):
            if tool.flexibility > 0.0:
                move[0] += EXPANSION_RELAXATION * (tool.flexibility * tool.pressure - tool.offset[0])
        return moves

    def _share(self, dt: float) -> float:
        """Return the travel of the tools as a share of the ram's; the rest shortens punch and press.

        The force at the end is foreseen with the slope of the last increments, so that the spring does not
        lag behind a rising force; of what is missing at a steady force, half is made up for, because the
        force depends on the speed of the punch, too. The punch never runs back.
        """
        state, c, travel = self.state, self.compliance, self.speed * dt
        if c == 0.0:
            return 1.0
        foreseen = self.force + state.resistance_slope * travel
        change = (c * foreseen - state.compression) / (1.0 + max(c * state.resistance_slope, 1.0))
        return 1.0 - min(max(change / travel, -0.8), 0.8)

    def _recover(self, dt: float, reason: str) -> None:
        """Halve the increment, on a fresh mesh; a fresh mesh that fails twice is replaced by another one."""
        state = self.state
        state.failures += 1
        state.failures_in_row += 1
        state.next_dt = 0.5 * dt
        if state.since_remesh > 0:
            self.remesh()
        elif state.old_mesh is not None and state.failures_in_row in (2, 4, 6):
            self._try_another_mesh(state.old_mesh)
            state.next_dt = self.control.after_remesh * self.control.largest / self.speed
        if state.next_dt * self.speed < self.control.smallest:
            self._stop(
                f"no increment converged down to {dt * self.speed:.1e} mm; last reason: {reason}; another mesh_size or a shorter "
                "communication step may get past it"
            )

    def _try_another_mesh(self, old: OldMesh) -> None:
        """Go back to the mesh before the last remeshing, and remesh finer from there if that is left to try."""
        state = self.state
        state.body, state.tables = old.body, old.tables
        state.carried = state.loads = None
        state.markers.track = old.marker_track
        state.strain_at_remesh = old.strain_at_remesh
        state.old_mesh = None
        state.since_remesh = self.policy.every - 2
        self._space = Workspace(state.body)
        if old.trial + 1 < len(SCALES):
            self.remesh(old.trial + 1)

    def _accept(self, step: Step, dt: float, moves: list[FloatArray], share: float) -> None:
        state, body = self.state, self.state.body
        before, heat_before, surface = self.force, (body.T, body.layer), body.surface
        ends, shares = self._ends(step), self._touching_shares(moves, dt)
        body.rate = (step.strain - body.strain) / dt
        body.x = body.x + step.du
        body.accelerate(step.du / (dt * share), dt)
        body.stress, body.strain = step.stress, step.strain
        for tool, move, table in zip(state.tools, moves, step.tables):
            tool.offset = tool.offset + move
            tool.pressure = bore_pressure(table, step.weights, tool.spread)
        state.tables, state.forces, state.weights = step.tables, step.forces, step.weights
        state.carried = None
        state.stroke += self.speed * dt
        state.time += dt
        state.increments += 1
        state.iterations += step.iterations
        state.since_remesh += 1
        state.failures_in_row = 0
        state.old_mesh = None
        volumes = gauss_volumes(body.x, body.quads)
        energy, friction = state.energy, state.energy.friction
        energy.add_contact(step.du[body.chain], moves, ends)
        travel = self.speed * dt
        state.ram_work += 0.5 * (before + self.force) * travel
        if self.compliance > 0.0:
            state.compression += (1.0 - share) * travel
            slope = (self.force - before) / (share * travel)
            state.resistance_slope = 0.5 * (state.resistance_slope + min(max(slope, 0.0), STEEPEST))
        energy.plastic += float((step.work * volumes).sum())
        energy.elastic = body.elastic_energy(self.material.shear_modulus, self.material.bulk_modulus)
        if self.heat is not None:
            body.T = self._heat(step, dt, energy.friction - friction)
        loads = surface_loads(body.surface, step.tables, state.tools, step.weights)
        if not (np.isfinite(body.T).all() and np.isfinite(loads.tool_T).all()):
            # What markers and history hold stays as it was before this increment.
            body.T, body.layer = heat_before
            self._stop("a temperature is not finite; allowed: finite material and heat data")
            return
        state.loads = loads
        state.markers.follow(surface, body.surface)
        state.markers.update(body.surface, body.surface_T, loads, dt, shares)
        state.history.append(self._record(step, loads, dt))
        fold = first_crossing(body.surface)
        if fold >= 0:
            r, z = body.surface[fold]
            self._stop(
                f"the surface of the workpiece has folded onto itself at r = {r:.2f} mm, z = {z:.2f} mm; contact of the "
                "workpiece with itself is not computed"
            )

    def _ends(self, step: Step) -> list[Loading]:
        """Return the contact at the start, where it is known, and at the end of an increment not yet accepted."""
        state, end = self.state, Loading(step.tables, step.weights, step.forces)
        if state.tables is not None:
            return [Loading(state.tables, state.weights, state.forces), end]
        if state.carried is not None:
            return [state.carried, end]
        if state.increments > 0:
            return [end]
        return [Loading([np.zeros_like(table) for table in step.tables], step.weights, state.forces), end]

    def _touching_shares(self, moves: list[FloatArray], dt: float) -> FloatArray:
        """Return for how much of the increment to come each marker touches each tool if it comes to it, shape (n_tools, n)."""
        body, markers = self.state.body, self.state.markers
        on, points, velocity = (
            markers.active,
            markers.points(body.surface),
            markers.points(body.velocity[body.chain]),
        )
        return np.array(
            [
                touching_shares(points, velocity - move / dt, on, tool.segments, tool.offset, dt)
                for tool, move in zip(self.state.tools, moves)
            ]
        )

    def _heat(self, step: Step, dt: float, friction: float) -> FloatArray:
        """Return the temperatures after an increment in which `friction` [N mm] became heat."""
        assert self.heat is not None
        power = sum(float(np.abs(table[:, SHEAR] * table[:, SLIP]) @ step.weights) for table in step.tables)
        at_end = 2.0 * np.pi * power * dt
        state, body, material = self.state, self.state.body, self.material
        return exchange_heat(
            body,
            state.tools,
            step.tables,
            step.weights,
            step.work * material.taylor_quinney,
            material,
            self.heat,
            dt,
            state.energy,
            max(friction, 0.0) / at_end if at_end > 0.0 else 1.0,
        )

    def _record(self, step: Step, loads: SurfaceLoads, dt: float) -> Record:
        state, body, m = self.state, self.state.body, self.material
        ratio = np.abs(loads.shear) / step.shear_yield
        on = loads.active
        area = 2.0 * np.pi * step.weights
        contact = float(area[on].sum())
        high = float(area[on & (ratio > 0.6)].sum())
        unloaded = body.unloaded_volume(self.material.bulk_modulus)
        return Record(
            stroke=state.stroke,
            time=state.time,
            force=self.force,
            iterations=step.iterations,
            residual=step.residual,
            T_max=max(float(body.T.max()), float(body.surface_T.max())),
            strain_max=float(body.strain.max()),
            volume_change=unloaded / self._start_volume - 1.0,
            max_tau_over_k=float(ratio[on].max(initial=0.0)),
            share_above_0_6k=high / contact if contact > 0.0 else 0.0,
            contact_area=contact,
            nodes=len(body.x),
            rate_max=float(body.rate.max()),
            layer_cell=0.0
            if body.layer is None
            else body.layer.coarseness(m.heat_capacity, m.conductivity, body.surface_T, dt),
        )

    def _choose_next(self, step: Step, dt: float) -> None:
        state, control = self.state, self.control
        largest = control.largest / self.speed
        state.next_dt = min(largest, 1.5 * max(dt, min(state.next_dt, largest)))
        slip = max(float(np.abs(table[:, SLIP]).max()) for table in step.tables)
        if slip > 0.0:
            state.next_dt = min(state.next_dt, max(control.slip / slip, largest / 20.0))
        if self._remesh_due() and self.remesh():
            state.next_dt = min(state.next_dt, largest * control.after_remesh)

    def _remesh_due(self) -> bool:
        state, policy = self.state, self.policy
        if self.size is None:
            return False
        return (
            state.since_remesh >= policy.every
            or float((state.body.strain - state.strain_at_remesh).max()) > policy.largest_strain(state.travel)
            or float(qualities(state.body.x, state.body.quads).min()) < policy.quality
        )

    def remesh(self, trial: int = 0) -> bool:
        """Replace the mesh over the same body, at scale ``SCALES[trial]`` or finer; return whether it worked."""
        state = self.state
        if self.size is None:
            return False
        if not remesh(state, self.size(state), self.material, self.heat is not None, trial):
            return False
        self._space = Workspace(state.body)
        return True
