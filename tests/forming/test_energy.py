"""Energy account: it closes at any stroke, and only with all its terms."""

from __future__ import annotations

import numpy as np
import pytest

from forming import BackwardCupExtrusion, ForwardRodExtrusion
from forming.fe.contact import PRESSURE, SHEAR
from forming.fe.state import Energy, Loading
from forming.processes.upsetting import RingCompression, Upsetting

#: Process, coefficient of friction, strokes at which the account is looked at [mm].
CASES = {
    "rod": (lambda: ForwardRodExtrusion(mesh_size=0.5, n_points=60), 0.1, (0.1, 0.3, 0.6, 1.0, 2.0)),
    "cup": (lambda: BackwardCupExtrusion(n_points=60), 0.0, (0.1, 0.3, 0.6, 1.0, 2.0)),
    "elastic tools": (
        lambda: BackwardCupExtrusion(
            mesh_size=0.6, n_points=40, die_outer_diameter=60.0, punch_length=100.0, press_stiffness=500.0
        ),
        0.08,
        (0.1, 0.3, 0.6, 1.0),
    ),
    "ring": (lambda: RingCompression(mesh_size=0.3), 0.3, (0.05, 0.2, 0.5, 1.0, 2.0)),
    "cylinder": (lambda: Upsetting(mesh_size=1.25), 0.1, (0.1, 0.4, 0.8, 3.0, 7.5)),
}


@pytest.fixture(scope="module", params=CASES)
def accounts(request) -> list[Energy]:
    """The account of a process at its strokes."""
    build, mu, strokes = CASES[request.param]
    process, found = build(), []
    process.start(mu)
    for stroke in strokes:
        assert process.advance(stroke - process.stroke), process.message
        found.append(process.simulation.snapshot().energy)
    return found


def test_the_account_closes_at_any_stroke(accounts):
    """0.5 % of the work, from a tenth of a millimetre on."""
    assert max(abs(account.imbalance) for account in accounts) < 5e-3
    assert all(account.external > 0.0 for account in accounts)


def test_the_account_needs_each_of_its_terms(accounts):
    """A term left out opens the account at one of the strokes, friction (where there is any) at each one."""
    for term in ("plastic", "elastic", "contact"):
        opened = []
        for account in accounts:
            without = Energy(**{**vars(account), term: 0.0})
            opened.append(abs(without.imbalance))
        assert max(opened) > 5e-3, term
    for account in accounts:
        if account.friction != 0.0:
            assert Energy(**{**vars(account), "friction": 0.0}).imbalance < -5e-3


def test_parts_of_a_sliding_node_under_pressure():
    """One node of 2 mm2 per radian, pressed down by 0.01 mm and drawn along 0.1 mm under a tool at rest."""
    table = np.zeros((1, 6))
    # Normal of the tool upward; the friction stress acts against the motion to the left, its tangent is +r.
    table[0] = [1000.0, 50.0, 0.0, -0.01, 0.0, 1.0]
    area = 2.0 * np.pi * 2.0
    end = Loading([table], np.array([2.0]), np.array([[-50.0 * area, -1000.0 * area]]))
    start = Loading([np.zeros((1, 6))], np.array([2.0]), np.zeros((1, 2)))
    account = Energy()
    account.add_contact(np.array([[-0.1, -0.01]]), [np.zeros(2)], [start, end])
    assert account.external == 0.0
    assert account.friction == pytest.approx(0.5 * 50.0 * 0.1 * area)
    assert account.contact == pytest.approx(0.5 * 1000.0 * 0.01 * area)
    moved = Energy()
    moved.add_contact(np.array([[-0.1, -0.01]]), [np.array([-0.1, -0.01])], [end])
    assert moved.friction == moved.contact == 0.0
    assert moved.external == pytest.approx(-(50.0 * 0.1 + 1000.0 * 0.01) * area)


def test_unequal_friction_in_force_and_account_is_found(monkeypatch):
    """A friction stress in the account that is not the one in the force."""
    honest = Energy.add_contact

    def halved(self, du, moves, ends):
        for end in ends:
            for table in end.tables:
                table[:, 1] *= 0.5
        honest(self, du, moves, ends)
        for end in ends:
            for table in end.tables:
                table[:, 1] *= 2.0

    monkeypatch.setattr(Energy, "add_contact", halved)
    process = ForwardRodExtrusion(mesh_size=0.6, n_points=40)
    process.start(0.1)
    process.advance(0.8)
    assert process.simulation.state.energy.imbalance < -0.02


def test_a_remeshing_leaves_the_contact_to_the_account():
    """Friction power and pressing of the increment before, on the new nodes; without them its successor starts from nothing known."""
    process = ForwardRodExtrusion(mesh_size=0.8, n_points=20, tool_heating=False)
    process.start(0.1)
    assert process.advance(1.0) and process.advance(0.01)
    state = process.simulation.state
    assert state.tables is not None
    before = Loading(state.tables, state.weights, state.forces)
    assert process.simulation.remesh() and state.tables is None and state.carried is not None
    for column in (PRESSURE, SHEAR):
        old, new = (load.tables[0][:, column] @ load.weights for load in (before, state.carried))
        assert new == pytest.approx(old, rel=0.03)
    assert state.carried.forces is before.forces
    assert process.advance(0.1) and state.carried is None
