"""One implicit increment: Newton's method with an active set that changes only when the step has settled."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .body import Body, nodal_shear_yield
from .contact import FACING, PRESSURE, add_blocks, add_contacts, facing_shares, hold_fixed, start_active
from .element import MODULI, add_stiffness, internal_forces
from .linear_solver import LinearSolver
from .mesh.shape import FloatArray, IntArray
from .tooling import Tool

#: An increment does not end with a node that the tool pulls at harder than this [MPa].
MOST_TENSION = 100.0
#: Iteration from which an increment that has failed twice keeps its friction limits.
HOLD_LIMITS = 6
#: After so many failures in a row a residual may fall slowly, see `Attempt`.
SLOW_AFTER = 1
#: The first guess goes on with this share of the nodes' acceleration: the curved way along a tool is part of it, but so is
#: what differs from node to node by chance.
GOES_ON = 0.35
#: The factors of the last tangent serve again below this residual, as long as it falls by at least this factor, or by as much as
#: is left to do.
REUSE, SLOWEST = 1e-2, 0.3
#: After a tool has let the body go, the tangent of friction is partly the secant for so many iterations.
HELD_BY_FRICTION = 4
#: How much stiffer than consistent the tangent is in the first iteration, and where the residual hardly falls. An element that
#: unloads is elastic; with the soft tangent of its plastic flow before, the iteration leaps to flow in the other direction, and
#: back again.
FIRST_STIFFER, STALLED_STIFFER = 0.3, 0.6


@dataclass(frozen=True)
class Settings:
    """Numerical settings of an increment."""

    #: Contact stiffness [MPa/mm].
    penalty: float = 1e5
    #: Norm of the residual over that of the contact forces.
    tolerance: float = 2e-4
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

    separation: float = 1e-3
    ratio: float = 0.25
    light_pressure: float = 600.0
    early_changes: tuple[int, ...] = ()
    max_changes: int = 3
    #: From this iteration on the friction limits keep the pressures of it. Where a steep friction sticks, the limit
    #: rises from 0 to k within a hundredth of a micrometre of the gap, and Newton's method steps over it to and fro.
    hold_limits: int = 1000
    #: A step of Newton's method is halved where the residual falls by less than this share.
    decrease: float = 0.1
    #: So many times as many iterations are made as by default.
    patience: int = 1

    @classmethod
    def number(cls, failures: int) -> Attempt:
        """Return the choice after so many failures in a row."""
        if failures == 0:
            return cls()
        if failures % 2:
            other = cls(separation=1e-4, ratio=0.0, hold_limits=HOLD_LIMITS)
        else:
            other = cls(early_changes=(2, 5), max_changes=5, hold_limits=HOLD_LIMITS)
        # Where a body that does not harden sticks, surface and tool may slip at the same stress: the residual falls slowly.
        return replace(other, decrease=0.01, patience=4) if failures > SLOW_AFTER else other


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
    """Tangent of one mesh, allocated once and refilled."""

    def __init__(self, body: Body) -> None:
        self.solver = LinearSolver(body.quads, len(body.x))
        self.fixed: IntArray = 2 * body.axis
        self.moduli = np.zeros((len(body.quads), 4, MODULI))


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

    The tools move by `moves` [mm], without them by their velocity. The first guess is how far the body goes in a `share` of the
    increment.

    Raises StepError: no convergence, an inverted element or a singular matrix.
    """
    chain = body.chain
    n_s = len(chain)
    du, expected = share * body.expected(dt, GOES_ON), share * body.expected(dt, 1.0)
    # The search for the plastic strain starts from that of the last rate.
    space.moduli[:] = 0.0
    stress, strain = np.empty_like(body.stress), body.strain + body.rate * dt
    work = np.empty_like(body.strain)
    weights = np.zeros(n_s)
    shear_yield = nodal_shear_yield(body.quads, body.strain, body.rate, body.T, material)[chain]
    n_tools = len(tools)
    travel = np.array(moves or [tool.velocity * dt for tool in tools])
    offsets = np.array([tool.offset for tool in tools])
    segments = np.concatenate([tool.segments for tool in tools])
    first = np.cumsum([0, *(len(tool.segments) for tool in tools)])
    reaches = np.array([tool.reach for tool in tools])
    tables, held = np.zeros((n_tools, n_s, 7)), np.full((n_tools, n_s), -1.0)
    active, releases = np.zeros((2, n_tools, n_s), dtype=np.int64)
    light = attempt.light_pressure / settings.penalty
    for k, tool in enumerate(tools):
        tables[k, :, FACING] = facing_shares(body.x, chain, tool.segments, tool.offset)
        start_active(
            body.x,
            expected,
            chain,
            tool.segments,
            tool.offset,
            travel[k],
            tool.reach,
            light,
            attempt.separation,
            attempt.ratio,
            active[k],
        )
    most_shear = settings.shear_cap * shear_yield * tables[:, :, FACING]
    slip_scale = settings.slip_regularisation * max(tool.speed for tool in tools)
    forces = np.zeros((n_tools, 2))
    residual_norm = previous_norm = np.inf
    correction: FloatArray | None = None
    halvings = rounds = 0
    let_go = -HELD_BY_FRICTION
    changed_before = pulled = reused = factorised = False
    secant, stiffer = 1.0, FIRST_STIFFER
    blocks, contact = np.empty((n_s, 4)), np.zeros(du.size)

    def contacts(may_change: bool, secant: float) -> tuple[int, float]:
        """Fill `contact`, `forces`, `tables` and `blocks`; return the changes of the active set and the lowest pressure."""
        contact[:] = 0.0
        return add_contacts(
            body.x,
            du,
            chain,
            weights,
            segments,
            first,
            offsets + travel,
            travel,
            reaches,
            mu,
            most_shear,
            settings.penalty,
            slip_scale,
            dt,
            secant,
            blocks,
            contact,
            forces,
            tables,
            active,
            releases,
            may_change,
            held,
        )

    def tangent(band: FloatArray, skew: FloatArray) -> None:
        add_stiffness(body.x, du, body.quads, space.moduli, material, stiffer, band)
        add_blocks(chain, blocks, band, skew)
        hold_fixed(band, skew, space.fixed)

    for iteration in range(attempt.patience * settings.max_iterations):
        inner = np.zeros(du.size)
        inverted = internal_forces(
            body.x,
            du,
            body.quads,
            body.stress,
            body.strain,
            body.T,
            dt,
            material,
            inner,
            stress,
            strain,
            work,
            space.moduli,
        )
        if inverted:
            raise StepError(f"{inverted} Gauss points turned inside out in iteration {iteration}")
        may_change = (rounds < attempt.max_changes or pulled) and (
            residual_norm < 1e-2 or iteration in attempt.early_changes
        )
        rounds += may_change
        secant_before, secant = secant, 1.0 if iteration < 1 else (0.0 if iteration < 8 else 0.5)
        if iteration < let_go + HELD_BY_FRICTION:
            secant = 0.5
        if iteration == attempt.hold_limits:
            factorised = False
            held = np.where(
                tables[:, :, PRESSURE] > 0.0, np.minimum(mu * tables[:, :, PRESSURE], most_shear), held
            )
        touching = active.any(axis=1)
        changes, lowest = contacts(may_change, secant)
        if changes > 0 and (touching & ~active.any(axis=1)).any():
            # A body that a tool lets go may be held by friction alone, whose consistent tangent vanishes where it slides.
            let_go = iteration
            contacts(False, secant := 1.0)
        pulled = lowest < -MOST_TENSION
        residual = -(inner + contact)
        residual[space.fixed] = 0.0
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
                du, stress, strain, work, list(tables), forces, weights, shear_yield, iteration, residual_norm
            )
        stalls = residual_norm > 0.5 * previous_norm and not may_change
        worse = residual_norm > (1.0 - attempt.decrease * 0.5**halvings) * previous_norm
        if (
            correction is not None
            and iteration > 1
            and worse
            and residual_norm > 10.0 * settings.tolerance
            and halvings < 4
            and not may_change
            and not changed_before
            and not reused
        ):
            correction = 0.5 * correction
            du = du - correction
            halvings += 1
            continue
        reused = (
            factorised
            and residual_norm < REUSE
            and residual_norm < max(SLOWEST, settings.tolerance / residual_norm) * previous_norm
            and changes == 0
            and secant == secant_before
        )
        if iteration > 0:
            stiffer = STALLED_STIFFER if stalls else 0.0
        previous_norm, halvings, changed_before = residual_norm, 0, may_change
        if not reused:
            factorised = space.solver.factorise(tangent)
            if not factorised:
                raise StepError("the tangent matrix is singular")
        correction = space.solver.solve(residual).reshape(-1, 2)
        du = du + correction
    worst = int(np.abs(inner + contact).argmax()) // 2
    r, z = (body.x + du)[worst]
    raise StepError(
        f"no equilibrium after {attempt.patience * settings.max_iterations} iterations (residual {residual_norm:.1e} of the "
        f"contact force, worst at r = {r:.2f} mm, z = {z:.2f} mm)"
    )
