"""How a fresh mesh is made over the same body: surface sampled anew, fields carried over, heat kept.

When it is due, `simulation.py` decides by the `RemeshPolicy` of the run (`state.py`).
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import QhullError

from .body import Body
from .heat_exchange import keep_heat
from .mesh.mesher import MeshError
from .mesh.polyline import SizeField
from .mesh.shape import FloatArray
from .mesh.transfer import transfer
from .resample import mesh_inside, resample, surface_chain
from .state import SCALES, OldMesh, State
from .workpiece_material import WorkpieceMaterial


def remesh(state: State, size: SizeField, material: WorkpieceMaterial, heat: bool, trial: int = 0) -> bool:
    """Replace the mesh of a state; the mesh before stays in `State.old_mesh`.

    Parameters
    ----------
    state : State
        Changed in place, unless no mesh was found.
    size : callable
        Element size [mm] at points, shape (n, 2) -> (n,).
    material : WorkpieceMaterial
    heat : bool
        Whether temperatures are shifted so that the heat content stays.
    trial : int
        First of `SCALES` that is tried; a mesh that fails is tried finer.

    Returns
    -------
    bool
        False where none of the scales gave a mesh.
    """
    body = state.body
    old_surface = body.surface
    for k in range(trial, len(SCALES)):

        def scaled(points: FloatArray, scale: float = SCALES[k]) -> FloatArray:
            return scale * size(points)

        try:
            surface = resample(old_surface, scaled, state.tools, state.tables)
            mesh = mesh_inside(surface.points, scaled)
            break
        except (MeshError, QhullError, ValueError, IndexError):
            continue
    else:
        return False
    gauss = np.concatenate([body.stress, body.strain[:, :, None], body.rate[:, :, None]], axis=2)
    nodal = np.column_stack([body.T, body.velocity])
    gauss, nodal = transfer(body.x, body.quads, gauss, nodal, mesh.x, mesh.quads)
    state.old_mesh = OldMesh(body, state.tables, state.markers.position.copy(), state.strain_at_remesh, k)
    state.markers.move_to(old_surface, surface.old_arc)
    state.body = Body(
        mesh.x,
        mesh.quads,
        surface_chain(mesh, surface.points),
        np.ascontiguousarray(gauss[:, :, :4]),
        np.maximum(gauss[:, :, 4], 0.0),
        np.maximum(gauss[:, :, 5], 0.0),
        np.ascontiguousarray(nodal[:, 0]),
        np.ascontiguousarray(nodal[:, 1:]),
    )
    state.body.velocity[state.body.axis, 0] = 0.0
    if heat:
        state.body.T = keep_heat(body, state.body, material)
    state.strain_at_remesh = state.body.strain.copy()
    state.tables = None
    state.since_remesh = 0
    state.remeshes += 1
    return True
