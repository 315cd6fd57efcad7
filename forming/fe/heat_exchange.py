"""Heat of an increment: plastic work and friction, conduction, exchange between workpiece and tools."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..material import HenselSpittel
from ..tooling import Tool
from .body import Body
from .shape import FloatArray
from .thermal import heat_step


@dataclass(frozen=True)
class HeatExchange:
    """Transfer between workpiece and tools; free surfaces are insulated.

    Attributes
    ----------
    htc : float
        Heat transfer coefficient of the contact [N/(mm s K)], the number in kW/(m2 K).
    friction_share : float
        Share of the frictional power that enters the workpiece.
    """

    htc: float = 35.0
    friction_share: float = 0.5


def exchange_heat(
    body: Body,
    tools: list[Tool],
    tables: list[FloatArray],
    weights: FloatArray,
    source: FloatArray,
    material: HenselSpittel,
    heat: HeatExchange,
    dt: float,
) -> FloatArray:
    """Advance the tools' fields by `dt` [s] and return the workpiece temperatures, shape (n,).

    The workpiece sees the tool surfaces as they were before the increment, the tools see the workpiece as
    it is after it: each half is implicit, so the exchange is stable at any increment.

    Parameters
    ----------
    tables : list of ndarray, shape (n_s, 6)
        Contact tables of the tools.
    weights : ndarray, shape (n_s,)
        Surface area per radian of the surface nodes [mm2].
    source : ndarray, shape (n_e, 4)
        Heat released per volume in the increment [N/mm2].
    """
    surface = body.surface
    nodes, conductance, outside, power = [], [], [], []
    for table, tool in zip(tables, tools):
        on = table[:, 0] > 0.0
        nodes.append(body.chain[on])
        conductance.append(weights[on] * heat.htc)
        outside.append(tool.surface_temperature(surface[on]))
        power.append(heat.friction_share * np.abs(table[on, 1] * table[on, 2]) * weights[on])
    at = np.concatenate(nodes)
    T = heat_step(
        body.x,
        body.quads,
        body.T,
        source,
        material.heat_capacity,
        material.conductivity,
        dt,
        film=(at, np.concatenate(conductance), np.concatenate(outside)),
        flux=(at, np.concatenate(power)),
    )
    for table, tool in zip(tables, tools):
        if tool.heat_field is not None:
            into_tool = (1.0 - heat.friction_share) * np.abs(table[:, 1] * table[:, 2])
            points = surface - tool.offset
            tool.heat_field.step(dt, points, table[:, 0] > 0.0, T[body.chain], into_tool, heat.htc)
    return T
