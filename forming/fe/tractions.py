"""From nodal contact forces to tractions on the surface."""

from __future__ import annotations

import numpy as np

from .contact import FACING, NORMAL_R, PRESSURE, SHEAR, SLIP
from .markers import SurfaceLoads
from .mesh.shape import FloatArray, IntArray
from .tooling import Tool

#: Least share of a nodal area that a contact is taken to have, where its force becomes a traction.
LEAST_SHARE = 0.25


def bore_pressure(table: FloatArray, weights: FloatArray, spread: float = 0.0) -> float:
    """Return the mean contact pressure of a tool over its contact area seen in radial direction [MPa].

    A short contact is carried by the tool around it: the force counts over an area of at least `spread`.
    """
    area = np.where(table[:, PRESSURE] > 0.0, np.abs(table[:, NORMAL_R]) * weights, 0.0)
    total = max(float(area.sum()), spread)
    return float(area @ table[:, PRESSURE]) / total if total > 0.0 else 0.0


def along_contact(values: FloatArray, weights: FloatArray, tool: IntArray) -> FloatArray:
    """Return values of the surface nodes averaged with their neighbours under the same tool (1 : 2 : 1, by area).

    Node-wise contact pressures alternate from node to node by some percent around the traction that they
    stand for; the average takes that away and keeps the resultant force to 0.1 %.

    - `tool`, shape (n,): which tool the node touches; -1: none.
    """
    joined = ((tool[1:] == tool[:-1]) & (tool[1:] >= 0)).astype(np.float64)
    sums = []
    for quantity in (values * weights, weights):
        flow = 0.25 * joined * np.diff(quantity)
        sums.append(quantity + np.append(flow, 0.0) - np.append(0.0, flow))
    return np.where(tool >= 0, sums[0] / np.maximum(sums[1], 1e-300), values)


def surface_loads(
    surface: FloatArray, tables: list[FloatArray], tools: list[Tool], weights: FloatArray
) -> SurfaceLoads:
    """Join the contact tables: at each node the tool that presses hardest counts.

    Nodal forces become tractions over the part of the nodal areas `weights` that faces the tool; at the edge of a
    contact the rest belongs to the free side. The pressure is averaged along the contact.
    """
    pressures = np.array([table[:, PRESSURE] for table in tables])
    hardest = pressures.argmax(axis=0)
    nodes = np.arange(pressures.shape[1])
    joined = np.array(tables)[hardest, nodes]
    temperatures = np.array([tool.surface_temperature(surface) for tool in tools])
    share = np.maximum(joined[:, FACING], LEAST_SHARE)
    pressure = np.maximum(joined[:, PRESSURE], 0.0) / share
    return SurfaceLoads(
        pressure=along_contact(pressure, weights * share, np.where(pressure > 0.0, hardest, -1)),
        shear=joined[:, SHEAR] / share,
        slip=joined[:, SLIP],
        tool_T=temperatures[hardest, nodes],
        active=joined[:, PRESSURE] > 0.0,
    )
