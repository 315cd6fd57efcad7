"""Heat between workpiece and tool, as the forming simulation exchanges it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..fe.body import Body
from ..fe.contact import FACING, NORMAL_Z, PRESSURE
from ..fe.heat_exchange import HeatExchange, exchange_heat
from ..fe.mesh.mesher import grid_mesh
from ..fe.mesh.shape import FloatArray, surface_weights
from ..fe.tooling import block_field, plate
from ..materials.materials import steel_16MnCr5
from .case import Case, Row, case

GROUP = "Heat"
HOT, COLD = 120.0, 20.0
#: Surface temperatures of workpiece and tool [degC] at instants [s]: two half spaces at 120 and 20 degC (k 42 and
#: 20 W/(m K), rho 7850 and 7700 kg/m3, cp 470 and 460 J/(kg K)) over 35 000 W/(m2 K).
SURFACES = {0.01: (100.92, 48.21), 0.1: (89.15, 65.63), 1.0: (82.89, 74.88)}
SOURCE = "Carslaw and Jaeger: two half spaces over a film"
#: Allowed deviation with fine elements, and with those of the default mesh of an extrusion [%].
FINE, DEFAULT = 1.0, 3.0
CASES: list[Case] = []


@case(CASES, "heat-workpiece-tool", GROUP)
def in_contact() -> list[Row]:
    """Forming: workpiece at 120 degC on a tool at 20 degC, 35 000 W/(m2 K)."""
    # Elements of 0.02 mm below the surface, growing by a tenth.
    z = np.concatenate([[0.0], np.cumsum(0.02 * 1.1 ** np.arange(60))])
    return _rows(np.linspace(0.0, 3.0, 4), z[z < 20.0], 0.025, 0.0005, (0.1, 1.0), FINE)


@case(CASES, "heat-workpiece-tool-coarse", GROUP)
def in_contact_coarse() -> list[Row]:
    """Forming: the same with elements of 0.4 mm, as an extrusion has by default."""
    # The layer is 0.3 mm deep at 0.01 s.
    return _rows(np.linspace(0.0, 3.2, 9), np.linspace(0.0, 20.0, 51), 0.4, 0.001, (0.01, 0.1, 1.0), DEFAULT)


def _rows(
    r: FloatArray, z: FloatArray, below: float, dt: float, times: tuple[float, ...], tolerance: float
) -> list[Row]:
    """Column of 16MnCr5 on a plate of 1.2379."""
    steel = replace(steel_16MnCr5(), conductivity=42.0, cp=470.0)
    mesh = grid_mesh(r, z)
    body = Body.at_rest(mesh.x, mesh.quads, np.ascontiguousarray(mesh.loop[: len(r)]), HOT)

    def size(points: FloatArray) -> FloatArray:
        return np.full(len(points), below)

    tool = plate(0.0, COLD, widest=float(r[-1]))
    tool.heat_field = block_field(float(r[-1]), 0.0, -20.0, size, COLD)
    weights = np.zeros(len(r))
    surface_weights(body.x, body.chain, weights)
    table = np.zeros((len(r), 7))
    table[:, PRESSURE], table[:, FACING], table[:, NORMAL_Z] = 1000.0, 1.0, 1.0
    source = np.zeros((len(body.quads), 4))
    heat = HeatExchange(environment=None)
    rows = []
    for k in range(1, round(times[-1] / dt) + 1):
        body.T = exchange_heat(body, [tool], [table], weights, source, steel, heat, dt)
        for t in times:
            if k == round(t / dt):
                workpiece, surface = SURFACES[t]
                lost, gained = HOT - body.surface_T, tool.surface_temperature(body.surface) - COLD
                for what, reference, ours in (
                    (f"workpiece surface below {HOT:g} degC, {t:g} s", HOT - workpiece, lost),
                    (f"tool surface above {COLD:g} degC, {t:g} s", surface - COLD, gained),
                ):
                    rows.append(Row(what, "K", reference, SOURCE, float(ours.mean()), tolerance))
    return rows
