"""``--target deform``: user routines USRBCC and USRUPD of DEFORM-2D, Fortran around the C export.

Argument list and COMMON blocks: DEFORM manual, "2D User Defined FEM Routines". USRBCC is asked for the coefficient of an
edge in every iteration; USRUPD closes a step node by node and may keep numbers in the node, which DEFORM carries through a remeshing.
"""

from __future__ import annotations

import numpy as np

from friction_models.loads import FloatArray

from ...interface.friction_source import FrictionSource
from ..common import Files, Reference, template, test_box
from ..host_units import HostUnits, host_units
from .ufric_target import depends_on, fortran_number, system_lines

#: Numbers that a node keeps besides the memory of the model.
_KEPT = 7
_AREA_JUMP = 1.3


class Node:
    """What one node keeps between steps, as the export means it; for the self-test."""

    def __init__(self, memory: FloatArray) -> None:
        self.loads = np.zeros(5)
        self.memory, self.area, self.touched = memory, 0.0, False

    def end_step(
        self, reference: Reference, v: float, T: float, sigma_n: float, area: float, dt: float
    ) -> float:
        """Advance the node by a step in contact and return mu there."""
        ratio = area / self.area if self.touched and self.area > 0.0 else 1.0
        if not 1.0 / _AREA_JUMP <= ratio <= _AREA_JUMP:
            ratio = 1.0
        psi = self.loads[4] * ratio if self.touched else 1.0
        self.loads = np.array([v, T, sigma_n, self.loads[3] + v * dt, psi])
        self.area, self.touched = area, True
        self.memory = reference.step(self.loads[None], self.memory[None], dt)[0]
        return float(reference.mu(self.loads[None], self.memory[None])[0])


def history(source: FrictionSource, units: HostUnits, nodes: int = 4, steps: int = 8) -> str:
    """Return the steps of the self-test.

    For each step dt, the numbers of edges and nodes; a row an edge (two nodes, their temperatures, that of the tool, SLDVEL,
    PRESS, expected mu) and a row a node (number, both temperatures, SLDVEL, tangential and normal traction, area, whether it is
    inside, expected mu). Node 2 is out of contact for a while, the area of node 3 jumps as in a remeshing.
    """
    reference = Reference(source)
    lower, upper = test_box(source)
    rng = np.random.default_rng(24)
    kept = [Node(reference.model.start_state(1)[0]) for _ in range(nodes)]
    rows = []
    for step in range(1, steps + 1):
        dt = float(rng.uniform(2e-3, 1e-2))
        edges = [(k, k + 1) for k in range(nodes - 1)]
        rows.append(f"{fortran_number(dt)} {len(edges)} {nodes}")
        for a, b in edges:
            v, T, sigma = rng.uniform(lower[:3], upper[:3])
            loads, memory = np.array([v, T, sigma, 0.0, 1.0]), reference.model.start_state(1)[0]
            found = [kept[k] for k in (a, b) if kept[k].touched]
            if found:
                loads = np.sum([n.loads for n in found], axis=0) / len(found)
                memory = np.sum([n.memory for n in found], axis=0) / len(found)
            mu = float(reference.mu(loads[None], memory[None])[0])
            (v, T, sigma, *_), apart = units.to_host(np.array([[v, T, sigma, 0.0, 1.0]]))[0], 4.0
            numbers = (T - 2 * apart, T, T + apart, v, sigma, mu)  # mean of nodes T - apart, tool T + apart
            rows.append(f"{a + 1} {b + 1} " + " ".join(fortran_number(float(x)) for x in numbers))
        for k, node in enumerate(kept):
            v, T, sigma = rng.uniform(lower[:3], upper[:3])
            area, apart = float(2.0 + 0.05 * step * (k + 1)), float(rng.uniform(-9.0, 9.0))
            if k == 2 and step >= 5:
                area *= 2.0  # another mesh
            away = k == 1 and step in (1, 4, 5)
            mu = -1.0
            if away:
                node.area = area
            else:
                mu = node.end_step(reference, v, T, sigma, area, dt)
            v, T, sigma, *_ = units.to_host(np.array([[v, T, sigma, 0.0, 1.0]]))[0]
            numbers = (T - apart, T + apart, -v, 11.0, 0.0 if away else sigma, area)
            texts = " ".join(fortran_number(float(x)) for x in numbers)
            rows.append(f"{k + 1} {texts} 0 {fortran_number(mu)}")
    return "\n".join(rows) + "\n"


def deform_files(
    source: FrictionSource, prefix: str, values: dict[str, str], units: object = "tonne-mm-s"
) -> Files:
    """Return what a DEFORM export has beside the C text and the documents; `units` are those of the database."""
    host = host_units(units, allowed=("tonne-mm-s", "english"))
    values |= host.fortran() | {
        "NODE_VARIABLES": str(_KEPT + len(source.states)),
        "DEPENDS": ", ".join(depends_on(source)) or "none of the loads",
        "SYSTEM_LINES": system_lines(source),
    }
    return {
        "deform.f": template("deform.f", values),
        "usr_bcc.f": template("usr_bcc.f", values),
        "usr_upd.f": template("usr_upd.f", values),
        "selftest.f90": template("deform_selftest.f90", values),
        "selftest.txt": history(source, host),
    }
