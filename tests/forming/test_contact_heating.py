"""Thermal boundary layer at the contact: closed forms at the default mesh, and what is seen without the layer."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from forming import ForwardRodExtrusion, Upsetting
from forming.fe.contact import FACING, NORMAL_Z, PRESSURE, SHEAR, SLIP, facing_shares
from forming.fe.heat import surface_layer
from forming.fe.heat.surface_layer import Exchange, SurfaceLayer
from forming.fe.heat_exchange import HeatExchange, exchange_heat
from forming.fe.mesh.mesher import grid_mesh
from forming.fe.mesh.shape import nodal_volumes, surface_weights
from forming.materials.materials import steel_16MnCr5
from forming.processes import backward_cup_extrusion
from forming.processes.stepwise import too_fast
from forming.verification import contact_heating

#: Heat data and flux of the block: N/(s K), N/(mm2 K), N/(mm s).
K, C, Q = 42.0, 3.69, 1000.0


def surface_rise(h: float, time: float, steps: int) -> tuple[float, float]:
    """Heat the lower face of a block with elements of `h`; return the rise of its surface and the error of its heat."""
    mesh = grid_mesh(np.arange(0.0, 2.1 * h, h), np.arange(0.0, 20.0, h))
    chain = np.ascontiguousarray(mesh.loop[:3])
    layer, T = SurfaceLayer.below(mesh.x, mesh.quads, chain), np.zeros(len(mesh.x))
    none = np.zeros(3)
    for _ in range(steps):
        heat = Exchange(none, none, layer.area * Q)
        source = np.zeros((len(mesh.quads), 4))
        layer, T = layer.step(mesh.x, mesh.quads, T, source, C, K, time / steps, heat)
    content = C * float(nodal_volumes(mesh.x, mesh.quads) @ T)
    return float(layer.surface(T).mean()), content / (Q * time * float(layer.area.sum())) - 1.0


@pytest.mark.parametrize("time", [0.002, 0.005, 0.02, 0.1, 1.0])
@pytest.mark.parametrize("h", [0.4, 0.9])
def test_a_constant_flux_heats_a_coarse_block_like_a_half_space(h, time):
    """2 q sqrt(a t / pi) / k; the layer is 0.15 to 3 mm deep."""
    rise, lost = surface_rise(h, time, 40)
    assert rise == pytest.approx(2.0 * Q / K * math.sqrt(K / C * time / math.pi), rel=0.02)
    assert abs(lost) < 1e-9


def test_without_the_layer_the_block_stays_too_cold(monkeypatch):
    """Columns of no depth leave all to the mesh."""
    monkeypatch.setattr(surface_layer, "ELEMENTS", 1e-3)
    rise, _ = surface_rise(0.9, 0.005, 40)
    assert rise < 0.6 * 2.0 * Q / K * math.sqrt(K / C * 0.005 / math.pi)


@pytest.mark.parametrize("off", [False, True])
def test_rubbing_at_1000_mm_per_s_follows_the_closed_form(monkeypatch, off):
    """Wall and nose of a cup within 5 %; without the layer both are far off."""
    if off:
        monkeypatch.setattr(surface_layer, "ELEMENTS", 1e-3)
    found = contact_heating.cup(1000.0, 4.0)
    errors = {where: ours / expected - 1.0 for where, (expected, ours) in found.items()}
    assert set(errors) == {"wall", "nose"}
    if off:
        assert max(errors.values()) < -0.1
    else:
        assert max(map(abs, errors.values())) < 0.05


def test_the_bore_is_cold_where_the_contact_has_just_come(monkeypatch):
    """100 mm/s: the closed form's places of the bore are 0.2 mm apart; elements of 2.5 mm spread the heat ahead of the contact."""

    def error():
        expected, ours = contact_heating.cup(100.0, 2.0, mesh_size=0.4)["wall"]
        return ours / expected - 1.0

    assert abs(error()) < 0.07
    monkeypatch.setattr(backward_cup_extrusion, "BORE", 5.0)
    assert error() < -0.09


def test_heat_balances_with_the_layer_through_remeshings():
    steel = replace(steel_16MnCr5(), taylor_quinney=0.0)
    process = ForwardRodExtrusion(speed=500.0, mesh_size=0.6, n_points=40, material=steel)
    process.start(0.1)
    assert process.advance(2.0)
    state = process.simulation.state
    assert state.remeshes > 1 and state.body.layer is not None
    assert abs(state.energy.heat_imbalance) < 3.5e-3
    body = state.body
    assert (body.surface_T - body.T[body.chain]).max() > 20.0
    assert process.warnings == ()


def test_a_layer_that_is_too_thin_is_said():
    (warning,) = too_fast(3.0)
    assert "3.0 times" in warning and "mesh_size" in warning
    assert too_fast(1.0) == ()


def test_the_rim_of_an_upset_cylinder_is_as_hot_as_the_face_beside_it():
    """Friction that heats a face up to its edge, the side insulated: no heat flows along the face. Shared with the side it was half."""
    steel = replace(steel_16MnCr5(), taylor_quinney=0.0, conductivity=42.0, cp=470.0)
    process = Upsetting(diameter=30.0, height=20.0, mesh_size=1.5, n_points=40, material=steel, h_ambient=0.0)
    process.start(0.1)
    body, tools = process.simulation.state.body, process.simulation.state.tools
    n = len(body.chain)
    weights, table = np.zeros(n), np.zeros((n, 7))
    surface_weights(body.x, body.chain, weights)
    on = body.surface[:, 1] == 0.0
    table[on, PRESSURE], table[on, NORMAL_Z], table[on, FACING] = 500.0, 1.0, 1.0
    rim = int(np.flatnonzero(on).max())
    table[rim, FACING] = facing_shares(body.x, body.chain, tools[0].segments, np.zeros(2))[rim]
    table[:, SLIP], table[on, SHEAR] = 100.0, table[on, FACING] * 50.0
    none = np.zeros_like(table)
    for _ in range(10):
        body.T = exchange_heat(
            body, tools, [table, none], weights, np.zeros((len(body.quads), 4)), steel, HeatExchange(environment=None), 1e-3
        )  # fmt: skip
    rise = body.surface_T[on] - 20.0
    # The tool goes on behind the rim and is colder there.
    assert rise[-1] == pytest.approx(rise[-3], rel=0.15)
