"""Heat between workpiece and tool, as the forming simulation exchanges it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..fe.body import Body
from ..fe.heat_exchange import HeatExchange, exchange_heat
from ..fe.mesh.mesher import grid_mesh
from ..fe.mesh.shape import FloatArray, surface_weights
from ..fe.tooling import block_field, plate
from ..materials.materials import steel_16MnCr5
from .case import Case, Row

GROUP = "Heat"
HOT, COLD = 120.0, 20.0
#: Surface temperatures of workpiece and tool [degC] at instants [s]: two half spaces at 120 and 20 degC (k 42 and
#: 20 W/(m K), rho 7850 and 7700 kg/m3, cp 470 and 460 J/(kg K)) over 35 000 W/(m2 K).
SURFACES = {0.1: (89.15, 65.63), 1.0: (82.89, 74.88)}


def in_contact() -> list[Row]:
    """Column of 16MnCr5 on a plate of 1.2379."""
    steel = replace(steel_16MnCr5(), conductivity=42.0, cp=470.0)
    z = np.concatenate([[0.0], np.cumsum(0.02 * 1.1 ** np.arange(60))])
    mesh = grid_mesh(np.linspace(0.0, 3.0, 4), z[z < 20.0])
    body = Body.at_rest(mesh.x, mesh.quads, np.ascontiguousarray(mesh.loop[:8]), HOT)
    tool = plate(0.0, COLD)
    tool.heat_field = block_field(3.0, 0.0, -20.0, _fine, COLD)
    # The first four nodes touch, over the whole lower face of radius 3 mm.
    weights = np.zeros(8)
    surface_weights(body.x, body.chain, weights)
    weights[4:] = 0.0
    weights[3] -= weights[:4].sum() - 4.5
    table = np.zeros((8, 6))
    table[:4, 0] = 1000.0
    source = np.zeros((len(body.quads), 4))
    heat = HeatExchange(environment=None)
    rows = []
    dt = 0.0005
    for k in range(1, round(1.0 / dt) + 1):
        body.T = exchange_heat(body, [tool], [table], weights, source, steel, heat, dt)
        for t, (workpiece, below) in SURFACES.items():
            if k == round(t / dt):
                lost = HOT - body.T[body.chain[:4]]
                gained = tool.surface_temperature(body.surface[:4]) - COLD
                rows.append(_row(f"workpiece surface below {HOT:g} degC, {t:g} s", lost, HOT - workpiece))
                rows.append(_row(f"tool surface above {COLD:g} degC, {t:g} s", gained, below - COLD))
    return rows


def _fine(points: FloatArray) -> FloatArray:
    return np.full(len(points), 0.04)


def _row(quantity: str, ours: FloatArray, reference: float) -> Row:
    return Row(
        quantity, "K", reference, "Carslaw and Jaeger: two half spaces over a film", float(ours.mean()), 1.0
    )


CASES = (
    Case(
        "heat-workpiece-tool",
        GROUP,
        "Forming: workpiece at 120 degC on a tool at 20 degC, 35 000 W/(m2 K).",
        in_contact,
    ),
)
