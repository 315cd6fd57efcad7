"""One implicit increment: Newton's method with an active set that changes only when the step has settled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dgbsv

from .body import Body, nodal_shear_yield
from .contact import FACING, PRESSURE, add_contact, facing_shares, hold_fixed, start_active
from .element import assemble
from .mesh.shape import FloatArray, IntArray, surface_weights
from .tooling import Tool

#: An increment does not end with a node that the tool pulls at harder than this [MPa].
MOST_TENSION = 100.0
#: Iteration from which an increment that has failed twice keeps its friction limits.
HOLD_LIMITS = 6


@dataclass(frozen=True)
class Settings:
    """Numerical settings of an increment."""

    #: Contact stiffness [MPa/mm].
    penalty: float = 1e5
    #: Norm of the residual over that of the contact forces.
    tolerance: float = 1e-4
    #: Then the increment has failed.
    max_iterations: int = 30
    #: v0 of the friction law as a share of the tool speed.
    slip_regularisation: float = 0.02
    #: Friction stress at most this share of the shear yield stress k. With a large mu the friction is then
    #: tau = m k, m = `shear_cap`: the law of constant shear.
    shear_cap: float = 1.0


@dataclass(frozen=True)
class Attempt:
    """How the active set is treated; a failed increment is repeated with the other choice."""

    separation: float = 2e-3
    light_pressure: float = 300.0
    early_changes: tuple[int, ...] = ()
    max_changes: int = 3
    #: From this iteration on the friction limits keep the pressures of it. Where a steep friction sticks, the limit
    #: rises from 0 to k within a hundredth of a micrometre of the gap, and Newton's method steps over it to and fro.
    hold_limits: int = 1000

    @classmethod
    def number(cls, failures: int) -> Attempt:
        """Return the choice after so many failures in a row."""
        hold = HOLD_LIMITS if failures > 0 else cls.hold_limits
        if failures % 2:
            return cls(separation=1e-4, light_pressure=600.0, hold_limits=hold)
        return cls(early_changes=(2, 5), max_changes=5, hold_limits=hold) if failures > 0 else cls()


@dataclass
class Step:
    """Result of a converged increment, not yet applied to the body."""

    du: FloatArray
    stress: FloatArray
    strain: FloatArray
    work: FloatArray
    tables: list[FloatArray]
    forces: FloatArray
    weights: FloatArray
    shear_yield: FloatArray
    iterations: int
    residual: float


class StepError(Exception):
    """The increment did not converge; the message says why and where."""


class Workspace:
    """Band matrix of one mesh, allocated once and refilled."""

    def __init__(self, body: Body) -> None:
        self.half = 2 * body.half_bandwidth + 1
        self.band = np.zeros((2 * len(body.x), 3 * self.half + 1))
        self.fixed: IntArray = 2 * body.axis

    def clear(self) -> None:
        """Zero what is assembled; the fill-in rows belong to LAPACK."""
        self.band[:, self.half :] = 0.0

    def solve(self, residual: FloatArray) -> FloatArray:
        """Return the solution of band * d = residual; both are overwritten.

        Raises StepError: the matrix is singular.
        """
        _, _, d, info = dgbsv(self.half, self.half, self.band.T, residual, overwrite_ab=1, overwrite_b=1)
        if info != 0:
            raise StepError("the tangent matrix is singular")
        return d


def solve_increment(
    body: Body,
    tools: list[Tool],
    material: FloatArray,
    dt: float,
    mu: FloatArray,
    settings: Settings,
    attempt: Attempt,
    space: Workspace,
    moves: list[FloatArray] | None = None,
    share: float = 1.0,
) -> Step:
    """Solve the increment `dt` [s] with the friction coefficients `mu` of the surface nodes.

    The tools move by `moves` [mm], without them by their velocity; `share` of the body's velocity is the first
    guess.

    Raises StepError: no convergence, an inverted element or a singular matrix.
    """
    chain = body.chain
    n_s = len(chain)
    du = body.velocity * (dt * share)
    stress, strain = np.empty_like(body.stress), np.empty_like(body.strain)
    work = np.empty_like(body.strain)
    weights = np.zeros(n_s)
    shear_yield = nodal_shear_yield(body.quads, body.strain, body.rate, body.T, material)[chain]
    tables = [np.zeros((n_s, 7)) for _ in tools]
    for tool, table in zip(tools, tables):
        table[:, FACING] = facing_shares(body.x, chain, tool.segments, tool.offset)
    most_shear = [settings.shear_cap * shear_yield * table[:, FACING] for table in tables]
    slip_scale = settings.slip_regularisation * max(tool.speed for tool in tools)
    active = [np.zeros(n_s, dtype=np.int64) for _ in tools]
    releases = [np.zeros(n_s, dtype=np.int64) for _ in tools]
    moves = moves or [tool.velocity * dt for tool in tools]
    light = attempt.light_pressure / settings.penalty
    for tool, move, on in zip(tools, moves, active):
        start_active(
            body.x, du, chain, tool.segments, tool.offset, move, tool.reach, light, attempt.separation, on
        )
    held = [np.full(n_s, -1.0) for _ in tools]
    forces = np.zeros((len(tools), 2))
    residual_norm = previous_norm = np.inf
    correction: FloatArray | None = None
    halvings = rounds = 0
    changed_before = pulled = False
    for iteration in range(settings.max_iterations):
        space.clear()
        inner, contact = np.zeros(du.size), np.zeros(du.size)
        inverted = assemble(
            body.x,
            du,
            body.quads,
            body.stress,
            body.strain,
            body.T,
            dt,
            material,
            space.band,
            inner,
            stress,
            strain,
            work,
        )
        if inverted:
            raise StepError(f"{inverted} Gauss points turned inside out in iteration {iteration}")
        surface_weights(body.x + du, chain, weights)
        may_change = (rounds < attempt.max_changes or pulled) and (
            residual_norm < 1e-2 or iteration in attempt.early_changes
        )
        rounds += may_change
        secant = 1.0 if iteration < 1 else (0.0 if iteration < 8 else 0.5)
        changes = 0
        if iteration == attempt.hold_limits:
            for limits, table, most in zip(held, tables, most_shear):
                touches = table[:, PRESSURE] > 0.0
                limits[touches] = np.minimum(mu * table[:, PRESSURE], most)[touches]
        for k, tool in enumerate(tools):
            before = contact.reshape(-1, 2).sum(axis=0)
            changes += add_contact(
                body.x,
                du,
                chain,
                weights,
                tool.segments,
                tool.offset + moves[k],
                moves[k],
                tool.reach,
                mu,
                most_shear[k],
                settings.penalty,
                slip_scale,
                dt,
                secant,
                space.band,
                contact,
                tables[k],
                active[k],
                releases[k],
                may_change,
                held[k],
            )
            forces[k] = (contact.reshape(-1, 2).sum(axis=0) - before) * 2.0 * np.pi
        pulled = any(float(table[:, PRESSURE].min()) < -MOST_TENSION for table in tables)
        residual = -(inner + contact)
        hold_fixed(space.band, residual, space.fixed)
        residual_norm = float(np.sqrt((residual @ residual) / (contact @ contact + 1e-12)))
        if not np.isfinite(residual_norm):
            raise StepError(f"the residual is not finite in iteration {iteration}")
        if (
            residual_norm < settings.tolerance
            and iteration > 0
            and changes == 0
            and not pulled
            and (may_change or rounds >= attempt.max_changes)
        ):
            return Step(
                du, stress, strain, work, tables, forces, weights, shear_yield, iteration, residual_norm
            )
        worse = residual_norm > (1.0 - 0.1 * 0.5**halvings) * previous_norm
        if (
            correction is not None
            and iteration > 1
            and worse
            and residual_norm > 10.0 * settings.tolerance
            and halvings < 4
            and not may_change
            and not changed_before
        ):
            correction = 0.5 * correction
            du = du - correction
            halvings += 1
            continue
        previous_norm, halvings, changed_before = residual_norm, 0, may_change
        correction = space.solve(residual).reshape(-1, 2)
        du = du + correction
    worst = int(np.abs(inner + contact).argmax()) // 2
    r, z = (body.x + du)[worst]
    raise StepError(
        f"no equilibrium after {settings.max_iterations} iterations (residual {residual_norm:.1e} of the "
        f"contact force, worst at r = {r:.2f} mm, z = {z:.2f} mm)"
    )
