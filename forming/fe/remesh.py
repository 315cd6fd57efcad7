"""A fresh mesh over the same body: surface sampled anew with its contact and volume kept, fields carried over.

When it is due, `simulation.py` decides: by the `RemeshPolicy` of the run (`state.py`), and after an increment that failed.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numba import njit
from scipy.spatial import QhullError

from .body import Body, WorkpieceMaterial
from .contact import gap_and_normal
from .heat_exchange import keep_heat
from .mesh.mesher import Mesh, MeshError, quad_mesh
from .mesh.polyline import CORNER, SizeField, arc_length, at_arc_length, enclosed_volume, spaced, turns
from .mesh.shape import FloatArray, IntArray, surface_weights
from .mesh.transfer import transfer
from .state import SCALES, Loading, OldMesh, State
from .tooling import Tool

#: Corrections of the volume, at least and at most; a node goes at most so far in each, as a share of the edges beside it.
CORRECTIONS, FARTHEST = (3, 20), 0.1
#: Volume that may be missing, as a share.
KEPT = 1e-9
#: A body with less of its surface free than this stays as it is.
LEAST_FREE = 4e-4


@dataclass(frozen=True)
class Surface:
    """New surface nodes and the arc length at which each one stood on the old surface."""

    points: FloatArray
    old_arc: FloatArray


def resample_surface(
    chain: FloatArray, size: SizeField, tools: list[Tool], tables: list[FloatArray] | None
) -> Surface:
    """Return new nodes spaced after `size` along the surface `chain`.

    - `chain`, shape (n, 2): old surface nodes from axis to axis, or the closed loop of a ring, its first node
      repeated.
    - `tables`, shape (n, 7): contact tables of the tools; None for a body that has not been in contact: it is
      then only pushed out of the tools and its volume is not corrected.
    """
    lengths = arc_length(chain)
    steps = np.diff(lengths)
    direction = np.diff(chain, axis=0) / steps[:, None]
    anchors = _anchors(turns(chain), lengths, size(chain))
    tangent = np.concatenate([direction[:1], np.empty((len(chain) - 2, 2)), direction[-1:]])
    before, after = steps[:-1, None], steps[1:, None]
    tangent[1:-1] = (direction[:-1] * before + direction[1:] * after) / (before + after)
    arcs = []
    for a, b in pairwise(anchors):
        s = lengths[a] + spaced(chain[a : b + 1], size)
        arcs.append(s if b == anchors[-1] else s[:-1])
    s = np.concatenate(arcs)
    k = np.clip(np.searchsorted(lengths, s, side="right") - 1, 0, len(steps) - 1)
    u = (s - lengths[k]) / steps[k]
    anchored = np.zeros(len(chain), dtype=bool)
    anchored[anchors] = True
    start = np.where(anchored[k][:, None], direction[k], tangent[k])
    end = np.where(anchored[k + 1][:, None], direction[k], tangent[k + 1])
    points = _hermite(chain[k], chain[k + 1], start, end, steps[k][:, None], u[:, None])
    closed = is_closed(chain)
    _join_ends(points, closed)
    held = np.zeros(len(points), dtype=bool)
    for i, tool in enumerate(tools):
        table = np.zeros((len(chain), 6)) if tables is None else tables[i]
        _seat(points, k, u, table, tool.segments, tool.offset, held)
    _join_ends(points, closed)
    if tables is not None:
        _restore_volume(points, enclosed_volume(chain), held, tools)
    return Surface(points, s)


def is_closed(chain: FloatArray) -> bool:
    """Return whether the surface is that of a ring, which ends where it starts."""
    return bool((chain[0] == chain[-1]).all())


def _join_ends(points: FloatArray, closed: bool) -> None:
    """Put the ends of the surface on the axis, or those of a ring on each other."""
    if closed:
        points[-1] = points[0]
    else:
        points[[0, -1], 0] = 0.0


def _anchors(turn: FloatArray, lengths: FloatArray, size: FloatArray) -> list[int]:
    """Return the indices of both ends and of the corners, without corners that make a piece too short."""
    n = len(lengths)
    anchors = [0, *np.flatnonzero(turn > CORNER).tolist(), n - 1]
    while len(anchors) > 2:
        pieces = [(lengths[b] - lengths[a]) / size[a] for a, b in pairwise(anchors)]
        k = int(np.argmin(pieces))
        if pieces[k] > 0.8:
            break
        a, b = anchors[k], anchors[k + 1]
        if a == 0 or (b != n - 1 and turn[b] <= turn[a]):
            anchors.remove(b)
        else:
            anchors.remove(a)
    return anchors


def _hermite(
    p0: FloatArray, p1: FloatArray, t0: FloatArray, t1: FloatArray, h: FloatArray, u: FloatArray
) -> FloatArray:
    """Cubic Hermite interpolation with unit tangents t0, t1 over pieces of length h."""
    return (
        (2 * u**3 - 3 * u**2 + 1) * p0
        + (u**3 - 2 * u**2 + u) * h * t0
        + (3 * u**2 - 2 * u**3) * p1
        + (u**3 - u**2) * h * t1
    )


@njit(cache=True)
def _seat(
    points: FloatArray,
    k: np.ndarray,
    u: FloatArray,
    table: FloatArray,
    segments: FloatArray,
    offset: FloatArray,
    held: np.ndarray,
) -> None:
    """Give points between two contact nodes the penetration of these, and push others out of the tool."""
    for i in range(points.shape[0]):
        gap, nr, nz = gap_and_normal(points[i, 0], points[i, 1], segments, offset[0], offset[1])
        first = table[k[i], 0] != 0.0
        second = table[k[i] + 1, 0] != 0.0
        shift = 0.0
        if (first and second) or (first and u[i] < 1e-6) or (second and u[i] > 1.0 - 1e-6):
            shift = (1.0 - u[i]) * table[k[i], 3] + u[i] * table[k[i] + 1, 3] - gap
            held[i] = True
        elif -0.5 < gap < 0.0:
            shift = -gap
            held[i] = True
        points[i, 0] += nr * shift
        points[i, 1] += nz * shift


def _restore_volume(points: FloatArray, volume: float, held: np.ndarray, tools: list[Tool]) -> None:
    """Move the nodes without contact along their normal until the enclosed volume is as before.

    One beside a tool goes at most half of the way there, the others the more: pushed into a tool, a rod that the land has
    let go would touch it again.
    """
    free = ~held
    free[[0, -1]] = False
    for correction in range(CORRECTIONS[1]):
        along = np.zeros_like(points)
        along[1:-1] = points[2:] - points[:-2]
        length = np.hypot(*along.T) + 1e-30
        normal = np.column_stack([along[:, 1], -along[:, 0]]) / length[:, None]
        areas = 2.0 * np.pi * points[:, 0] * 0.5 * length
        area = float(areas[free].sum())
        if area < LEAST_FREE * areas.sum():
            return
        missing = volume - enclosed_volume(points)
        if correction >= CORRECTIONS[0] and abs(missing) < KEPT * volume:
            return
        farthest = FARTHEST * float(length[free].min())
        shift = np.full(len(points), min(max(missing / area, -farthest), farthest))
        for tool in tools if missing > 0.0 else ():
            _leave_gap(points, tool.segments, tool.offset, shift)
        points[free] += normal[free] * shift[free, None]
        # Who could not go as far as the others stays where it is.
        free &= shift == shift.max()


@njit(cache=True)
def _leave_gap(points: FloatArray, segments: FloatArray, offset: FloatArray, shift: FloatArray) -> None:
    """Shorten `shift`, shape (n,) [mm], to half of the gap between each point and the tool."""
    for i in range(points.shape[0]):
        gap, _, _ = gap_and_normal(points[i, 0], points[i, 1], segments, offset[0], offset[1])
        shift[i] = min(shift[i], max(0.5 * gap, 0.0))


def mesh_inside(surface: FloatArray, size: SizeField) -> Mesh:
    """Mesh a body of revolution; its loop starts with the surface and ends with the nodes on the axis, if any."""
    if is_closed(surface):
        loop = surface[:-1]
    else:
        axis_ends = np.array([surface[-1], surface[0]])
        axis = at_arc_length(spaced(axis_ends, size), arc_length(axis_ends), axis_ends)[1:-1]
        axis[:, 0] = 0.0
        loop = np.concatenate([surface, axis])
    mesh = quad_mesh(loop, size)
    mesh.x[mesh.loop] = loop
    return mesh


def surface_chain(mesh: Mesh, surface: FloatArray) -> IntArray:
    """Return the nodes along the surface that the mesh was made from, in its order."""
    if is_closed(surface):
        return np.append(mesh.loop, mesh.loop[0])
    return np.ascontiguousarray(mesh.loop[: len(surface)])


def body_within(outline: FloatArray, size: SizeField, tools: list[Tool], T: float) -> Body:
    """Return a body at rest of temperature `T` [degC] whose surface follows the corners of an outline.

    Raises MeshError: the region cannot be meshed with elements of this size.
    """
    surface = resample_surface(outline, size, tools, None).points
    mesh = mesh_inside(surface, size)
    return Body.at_rest(mesh.x, mesh.quads, np.ascontiguousarray(mesh.loop[: len(surface)]), T)


def remesh(state: State, size: SizeField, material: WorkpieceMaterial, heat: bool, trial: int = 0) -> bool:
    """Replace the mesh of a state; the mesh before stays in `State.old_mesh`.

    - `state`: changed in place, unless no mesh was found.
    - `size`: element size [mm] at points, shape (n, 2) -> (n,).
    - `heat`: whether temperatures are shifted so that the heat content stays.
    - `trial`: first of `SCALES` that is tried; a mesh that fails is tried finer.
    - returns: False where none of the scales gave a mesh.
    """
    body = state.body
    old_surface = body.surface
    before = state.carried if state.tables is None else Loading(state.tables, state.weights, state.forces)
    tables = None if before is None else before.tables
    for k in range(trial, len(SCALES)):

        def scaled(points: FloatArray, scale: float = SCALES[k]) -> FloatArray:
            return scale * size(points)

        try:
            surface = resample_surface(old_surface, scaled, state.tools, tables)
            mesh = mesh_inside(surface.points, scaled)
            break
        except (MeshError, QhullError, ValueError, IndexError):
            continue
    else:
        return False
    gauss = np.concatenate([body.stress, body.strain[:, :, None], body.rate[:, :, None]], axis=2)
    smooth_T = body.T if body.layer is None else body.T - body.layer.carried
    nodal = np.column_stack([smooth_T, body.velocity, body.acceleration])
    gauss, nodal = transfer(body.x, body.quads, gauss, nodal, mesh.x, mesh.quads)
    state.old_mesh = OldMesh(body, state.tables, state.markers.track.copy(), state.strain_at_remesh, k)
    state.markers.move_to(old_surface, surface.old_arc)
    state.body = Body(
        mesh.x,
        mesh.quads,
        surface_chain(mesh, surface.points),
        np.ascontiguousarray(gauss[:, :, :4]),
        np.maximum(gauss[:, :, 4], 0.0),
        np.maximum(gauss[:, :, 5], 0.0),
        np.ascontiguousarray(nodal[:, 0]),
        np.ascontiguousarray(nodal[:, 1:3]),
        np.ascontiguousarray(nodal[:, 3:]),
        lasted=body.lasted,
    )
    for motion in (state.body.velocity, state.body.acceleration):
        motion[state.body.axis, 0] = 0.0
    if body.layer is not None:
        layer = body.layer.on(old_surface, surface.old_arc, mesh.x, mesh.quads, state.body.chain)
        state.body.layer = layer.settle(mesh.x, mesh.quads, state.body.T, material.heat_capacity)
        state.body.T = state.body.T + state.body.layer.carried
    if heat:
        state.body.T = keep_heat(body, state.body, material)
    state.strain_at_remesh = state.body.strain.copy()
    if before is not None:
        weights = np.zeros(len(state.body.chain))
        surface_weights(mesh.x, state.body.chain, weights)
        state.carried = before.carried_over(arc_length(old_surface), surface.old_arc, weights)
    state.tables = state.loads = None
    state.since_remesh = 0
    state.remeshes += 1
    return True
