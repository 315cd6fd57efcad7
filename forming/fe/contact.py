"""Contact of the surface nodes with rigid tools: penalty pressure, Coulomb friction capped at shear yield."""

from __future__ import annotations

import numpy as np
from numba import njit

from .mesh.shape import FloatArray, IntArray, surface_weights

# Columns of the contact table of one tool, one row a surface node. Pressure and shear stand for nodal forces over the
# whole area of the node, of which only a share faces the tool.
PRESSURE, SHEAR, SLIP, GAP, NORMAL_R, NORMAL_Z, FACING = range(7)
#: A node overlapping by more than this joins the contact at once; others wait until the step has settled [mm].
DEEP = 0.005
#: Overlap at which a node joins, and tension (as a gap) at which it leaves, once the step has settled [mm].
JOIN, LEAVE = 1e-4, 2.5e-4
#: A node that has left so often in an increment joins again only when it overlaps deeply: one that cannot settle
#: stays free with a small overlap, not held by a tool that pulls.
MOST_RELEASES = 2


@njit(cache=True)
def gap_and_normal(
    pr: float, pz: float, segments: FloatArray, off_r: float, off_z: float
) -> tuple[float, float, float]:
    """Return the signed gap (negative: inside the tool) and the tool's outward normal at the closest point."""
    best = 1e30
    gap = 1e30
    nr = 0.0
    nz = 0.0
    for k in range(segments.shape[0]):
        r0 = segments[k, 1] + off_r
        z0 = segments[k, 2] + off_z
        r1 = segments[k, 3] + off_r
        z1 = segments[k, 4] + off_z
        if segments[k, 0] == 0.0:
            tr = r1 - r0
            tz = z1 - z0
            length = np.sqrt(tr * tr + tz * tz)
            tr /= length
            tz /= length
            along = (pr - r0) * tr + (pz - z0) * tz
            t = min(length, max(0.0, along))
            distance = np.hypot(pr - r0 - t * tr, pz - z0 - t * tz)
            if distance < best - 1e-10:
                best = distance
                nr = -tz
                nz = tr
                gap = (pr - r0) * nr + (pz - z0) * nz
                # Beyond the end of a line the normal distance understates the gap.
                if (along <= 0.0 or along >= length) and abs(gap) <= 0.999 * distance:
                    gap = distance if gap > 0.0 else -distance
        else:
            cr = segments[k, 5] + off_r
            cz = segments[k, 6] + off_z
            radius = segments[k, 7]
            dr = pr - cr
            dz = pz - cz
            # The sector test by cross products: the point lies between the arc's two end rays.
            turn = (r0 - cr) * (z1 - cz) - (z0 - cz) * (r1 - cr)
            from_start = (r0 - cr) * dz - (z0 - cz) * dr
            to_end = dr * (z1 - cz) - dz * (r1 - cr)
            if turn < 0.0:
                from_start = -from_start
                to_end = -to_end
            if from_start >= 0.0 and to_end >= 0.0:
                distance = np.sqrt(dr * dr + dz * dz) + 1e-300
                side = 1.0 if radius > 0.0 else -1.0
                value = side * distance - radius
                if abs(value) < best - 1e-10:
                    best = abs(value)
                    gap = value
                    nr = side * dr / distance
                    nz = side * dz / distance
    return gap, nr, nz


@njit(cache=True)
def facing_shares(x: FloatArray, chain: IntArray, segments: FloatArray, offset: FloatArray) -> FloatArray:
    """Return the share of each node's area that faces a tool, shape (n,).

    At the edge of a contact a node also holds half of the free side beside it. Pressure and friction after
    Coulomb are nodal forces and do not mind, but a shear stress limited to k acts on the facing area alone.
    """
    n = chain.shape[0]
    closed = chain[0] == chain[n - 1]
    shares = np.zeros(n)
    for i in range(n):
        a = chain[i]
        _, nr, nz = gap_and_normal(x[a, 0], x[a, 1], segments, offset[0], offset[1])
        total = 1e-300
        facing = 0.0
        for side in range(2):
            j = i - 1 + 2 * side
            if j < 0 or j >= n:
                if not closed:
                    continue
                j = n - 2 if j < 0 else 1
            b = chain[j]
            # Along the chain the body lies on the left; its outward normal is (tz, -tr).
            along = 1.0 if side == 1 else -1.0
            tr = along * (x[b, 0] - x[a, 0])
            tz = along * (x[b, 1] - x[a, 1])
            radius = 2.0 * x[a, 0] + x[b, 0]
            total += np.sqrt(tr * tr + tz * tz) * radius
            facing += max(0.0, -(tz * nr - tr * nz)) * radius
        shares[i] = facing / total
    return shares


@njit(cache=True)
def start_active(
    x: FloatArray,
    du: FloatArray,
    chain: IntArray,
    segments: FloatArray,
    offset: FloatArray,
    move: FloatArray,
    reach: float,
    light: float,
    separation: float,
    ratio: float,
    active: IntArray,
) -> None:
    """Set the nodes that start the increment in contact.

    A node that overlaps by less than `light` and would separate by more than `separation` and `ratio` times its overlap
    under the predicted displacement is let go at once: waiting for tension costs iterations or the step.
    """
    for i in range(chain.shape[0]):
        n = chain[i]
        active[i] = 0
        gap, _, _ = gap_and_normal(x[n, 0], x[n, 1], segments, offset[0], offset[1])
        if gap <= 1e-7 and gap > -reach:
            active[i] = 1
            if gap > -light:
                least = separation - ratio * gap
                gap, _, _ = gap_and_normal(
                    x[n, 0] + du[n, 0], x[n, 1] + du[n, 1], segments, offset[0] + move[0], offset[1] + move[1]
                )
                if gap > least:
                    active[i] = 0


@njit(cache=True)
def add_contact(
    x0: FloatArray,
    du: FloatArray,
    chain: IntArray,
    weights: FloatArray,
    segments: FloatArray,
    offset: FloatArray,
    move: FloatArray,
    reach: float,
    mu: FloatArray,
    shear_yield: FloatArray,
    penalty: float,
    slip_scale: float,
    dt: float,
    secant: float,
    blocks: FloatArray,
    force: FloatArray,
    on_tool: FloatArray,
    table: FloatArray,
    active: IntArray,
    releases: IntArray,
    may_change: bool,
    held: FloatArray,
) -> int:
    """Add the contact forces of one tool and their tangent; update the active set where allowed.

    Friction is ``min(mu p, k) v / sqrt(v^2 + v0^2)`` against the slip velocity, v0 = `slip_scale`. `secant`
    in 0..1 blends the secant modulus into the friction tangent, for the first iterations. The pressure
    dependence of friction makes the tangent unsymmetric.

    - `blocks`, shape (n, 4), added to: tangent of each node: rr, zz, half the sum of rz and zr, half their difference.
    - `offset`, `move`, shape (2,): position of the tool at the end of the increment, and its displacement in
      it [mm].
    - `force`, shape (n_dof,): contact forces on the nodes per radian are subtracted from it.
    - `on_tool`, shape (2,): force on the tool [N], added to.
    - `table`, shape (n, 7): written: pressure, shear, slip velocity, gap, normal.
    - `held`, shape (n,): friction limits that do not follow the pressure [MPa]; below 0: it does.
    - returns: number of changes in the active set.
    """
    changes = 0
    for i in range(chain.shape[0]):
        n = chain[i]
        gap, nr, nz = gap_and_normal(x0[n, 0] + du[n, 0], x0[n, 1] + du[n, 1], segments, offset[0], offset[1])
        table[i, GAP] = gap
        table[i, NORMAL_R] = nr
        table[i, NORMAL_Z] = nz
        before = active[i]
        if gap <= -reach:
            active[i] = 0
        elif before == 0:
            if gap < -DEEP or (may_change and gap < -JOIN and releases[i] < MOST_RELEASES):
                active[i] = 1
        elif gap > LEAVE and (gap > 0.2 or may_change):
            active[i] = 0
            releases[i] += 1
        if active[i] != before:
            changes += 1
        if active[i] == 0:
            table[i, PRESSURE] = 0.0
            table[i, SHEAR] = 0.0
            table[i, SLIP] = 0.0
            continue
        w = weights[i]
        pressure = -penalty * gap
        tr = nz
        tz = -nr
        slip = ((du[n, 0] - move[0]) * tr + (du[n, 1] - move[1]) * tz) / dt
        limit = mu[i] * max(pressure, 0.0)
        coupling = 0.0
        speed = np.sqrt(slip * slip + slip_scale * slip_scale)
        if held[i] >= 0.0:
            limit = held[i]
        elif limit > shear_yield[i]:
            limit = shear_yield[i]
        elif pressure > 0.0:
            coupling = -mu[i] * (slip / speed) * penalty
        shear = -limit * slip / speed
        tangent = limit * ((1.0 - secant) * slip_scale * slip_scale / speed**3 + secant / speed) / dt
        table[i, PRESSURE] = pressure
        table[i, SHEAR] = shear
        table[i, SLIP] = slip
        row = 2 * n
        on_r = (pressure * nr + shear * tr) * w
        on_z = (pressure * nz + shear * tz) * w
        force[row] -= on_r
        force[row + 1] -= on_z
        on_tool[0] -= 2.0 * np.pi * on_r
        on_tool[1] -= 2.0 * np.pi * on_z
        blocks[i, 0] += w * (penalty * nr * nr + tangent * tr * tr + coupling * tr * nr)
        blocks[i, 1] += w * (penalty * nz * nz + tangent * tz * tz + coupling * tz * nz)
        blocks[i, 2] += w * (penalty * nr * nz + tangent * tr * tz + 0.5 * coupling * (tr * nz + tz * nr))
        blocks[i, 3] += w * 0.5 * coupling * (tr * nz - tz * nr)
    return changes


@njit(cache=True)
def add_contacts(
    x0: FloatArray,
    du: FloatArray,
    chain: IntArray,
    weights: FloatArray,
    segments: FloatArray,
    first: IntArray,
    offsets: FloatArray,
    moves: FloatArray,
    reaches: FloatArray,
    mu: FloatArray,
    shear_yields: FloatArray,
    penalty: float,
    slip_scale: float,
    dt: float,
    secant: float,
    blocks: FloatArray,
    force: FloatArray,
    forces: FloatArray,
    tables: FloatArray,
    active: IntArray,
    releases: IntArray,
    may_change: bool,
    held: FloatArray,
) -> tuple[int, float]:
    """Do `add_contact` for all tools, whose values stand one behind the other.

    - `weights`, shape (n,), `blocks`, shape (n, 4), `forces`, shape (n_tools, 2): written.
    - `segments`: those of tool k are rows ``first[k]`` to ``first[k + 1]``.
    - returns: number of changes in the active sets, and the lowest pressure [MPa].
    """
    surface_weights(x0 + du, chain, weights)
    blocks[:] = 0.0
    forces[:] = 0.0
    changes = 0
    for k in range(forces.shape[0]):
        changes += add_contact(
            x0,
            du,
            chain,
            weights,
            segments[first[k] : first[k + 1]],
            offsets[k],
            moves[k],
            reaches[k],
            mu,
            shear_yields[k],
            penalty,
            slip_scale,
            dt,
            secant,
            blocks,
            force,
            forces[k],
            tables[k],
            active[k],
            releases[k],
            may_change,
            held[k],
        )
    return changes, tables[:, :, PRESSURE].min()


@njit(cache=True)
def add_blocks(chain: IntArray, blocks: FloatArray, band: FloatArray, skew: FloatArray) -> None:
    """Add the tangent of the contact to the lower triangle `band`, its skew part to `skew`, shape (n_nodes,)."""
    for i in range(chain.shape[0]):
        row = 2 * chain[i]
        band[row, 0] += blocks[i, 0]
        band[row + 1, 0] += blocks[i, 1]
        band[row, 1] += blocks[i, 2]
        skew[chain[i]] += blocks[i, 3]


@njit(cache=True)
def hold_fixed(band: FloatArray, skew: FloatArray, fixed: IntArray) -> None:
    """Keep the displacement of fixed degrees of freedom: clear their rows and columns."""
    width = band.shape[1]
    for d in fixed:
        for k in range(1, width):
            band[d, k] = 0.0
            if d >= k:
                band[d - k, k] = 0.0
        band[d, 0] = 1e6
        skew[d // 2] = 0.0
