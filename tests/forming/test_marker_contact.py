"""Where a contact ends between two nodes, and the area that a marker stands for: closed forms and the solver's own account."""

from __future__ import annotations

import numpy as np
import pytest

from forming import BackwardCupExtrusion
from forming.fe import markers as module
from forming.fe.contact import PRESSURE
from forming.fe.markers import SurfaceMarkers
from forming.fe.surface_loads import SurfaceLoads, recovered
from tests.forming.test_surface_loads import contact, wall

SPACING = 0.5


def end_of_contact(end: float, upwards: bool, fall: float) -> float:
    """Return where markers find the end of a contact that presses up to z = `end` on elements of 0.5 mm.

    The pressure rises by 100 MPa/mm away from its end, or is even (`fall` 0).
    """
    x = wall(np.full(20, SPACING))
    mirrored = x[-1, 1] - x[:, 1]

    def pressure(r, z):
        inside = end - (z if upwards else x[-1, 1] - z)
        return np.where(inside > 0.0, fall * inside + (300.0 if fall == 0.0 else 0.0), 0.0)

    # Edge by edge the test integrates a smooth function: nodes of the integration, but none of the contact, at its end.
    cut = np.sort(np.append(x[:, 1], end if upwards else x[-1, 1] - end))
    fine, areas = contact(np.column_stack([np.full(len(cut), 5.0), cut]), pressure, (-1.0, 0.0))
    force = fine[:, PRESSURE] * areas
    hats = np.array([np.interp(cut, x[:, 1], hat) for hat in np.eye(len(x))])
    table, areas = contact(x, pressure, (-1.0, 0.0))
    table[:, PRESSURE] = hats @ force / areas
    touching = (x[:, 1] if upwards else mirrored) < end
    table[~touching, PRESSURE] = 0.0
    pressures = recovered(x, table, areas, 1)[0][None]
    edges = np.zeros(len(x) - 1, dtype=int)
    loads = SurfaceLoads(pressures, pressures, np.ones_like(pressures), pressures, edges)
    markers = SurfaceMarkers(x, np.linspace(0.0, x[-1, 1], 1001), 20.0)
    markers.update(x, np.full(len(x), 20.0), loads, 0.1)
    z = markers.points(x)[markers.active, 1]
    return float(z.max() if upwards else x[-1, 1] - z.min())


def largest_error(fall: float) -> float:
    ends = 5.0 + SPACING * np.array([0.05, 0.2, 0.4, 0.6, 0.8, 0.95])
    return max(abs(end_of_contact(e, up, fall) - e) for e in ends for up in (True, False))


def test_a_falling_pressure_ends_where_it_is_zero(monkeypatch):
    """Half the edge, as it was, is off by half an element; so is the end of an even pressure, of which nothing is known."""
    assert largest_error(100.0) < 0.1 * SPACING
    assert 0.4 * SPACING < largest_error(0.0) <= 0.5 * SPACING
    monkeypatch.setattr(module, "_reach", lambda k, tool, pressures: 0.5)
    assert largest_error(100.0) > 0.4 * SPACING


def friction_power(markers: SurfaceMarkers, shares) -> float:
    """Return the friction power of the markers at mu 0.08 [N mm/s]."""
    v_rel, _, sigma_n, _, psi = markers.loads().T
    return float((0.08 * sigma_n * v_rel * shares * psi)[markers.active].sum())


def test_markers_do_the_friction_work_of_the_solver():
    """While the contact with container and punch grows; planted: areas that reach half way around the corners."""
    process = BackwardCupExtrusion(mesh_size=0.5)
    process.start(0.08)
    state = process.simulation.state
    own = state.markers.start_shares()
    radius, length = 10.0, 20.0
    assert own.sum() == pytest.approx(2.0 * np.pi * radius * (radius + length), rel=1e-9)
    around = np.diff(module._area_below(state.body.surface, state.markers.position))
    around = 0.5 * np.concatenate([around[:1], around[1:] + around[:-1], around[-1:]])
    work, before, time = np.zeros(2), np.zeros(2), 0.0

    def add(simulation):
        nonlocal work, before, time
        now = simulation.state
        power = np.array([friction_power(now.markers, shares) for shares in (own, around)])
        # The mean of both ends of an increment, as the account takes it.
        work += 0.5 * (before + power) * (now.time - time)
        before, time = power, now.time
        return False

    assert process.advance(2.0, add)
    done = process.simulation.state.energy.friction
    assert work[0] == pytest.approx(done, rel=0.015)
    assert work[1] < 0.975 * done
