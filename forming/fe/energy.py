"""Energy account of the workpiece: the work of the tools on it, and where that work went.

Forces and stresses of an increment count with the mean of its two ends (trapezoidal rule), on both sides of the balance.
What is left over is then hardly a matter of the increment's length: it shows forces out of equilibrium, a term that is
missing, and what a remeshing loses.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .contact import NORMAL_R, NORMAL_Z, PRESSURE, SHEAR
from .mesh.shape import FloatArray


class Loading(NamedTuple):
    """Contact at one end of an increment."""

    #: Contact tables of the tools, shape (n_s, 7).
    tables: list[FloatArray]
    #: Surface area per radian of the surface nodes [mm2], shape (n_s,).
    weights: FloatArray
    #: Forces on the tools [N], shape (n_tools, 2).
    forces: FloatArray


@dataclass
class Energy:
    """Energy account of the workpiece [N mm]."""

    #: Work of the tool surfaces on the workpiece; what deforms the tools themselves is no part of it.
    external: float = 0.0
    #: Where it went.
    plastic: float = 0.0
    friction: float = 0.0
    elastic: float = 0.0
    #: Work against the springs that keep the workpiece out of the tools (penalty): some 5 N/mm of contact at
    #: 1000 MPa. It is summed up from the motion, because a contact that grows makes the energy stored in them
    #: grow by itself.
    contact: float = 0.0
    #: Heat released in the workpiece: of plastic work, and its share of the friction.
    heat_generated: float = 0.0
    #: Heat that left it by conduction, and by convection and radiation.
    heat_to_tools: float = 0.0
    heat_to_environment: float = 0.0
    #: Heat in it above `heat_reference` [degC] now and at the start.
    heat_content: float = 0.0
    heat_start: float = 0.0
    heat_reference: float | None = None

    @property
    def heat_imbalance(self) -> float:
        """Heat risen + heat left - heat generated, over the largest of them: what remeshing and compression cost."""
        rise = self.heat_content - self.heat_start
        parts = (rise, self.heat_to_tools, self.heat_to_environment, -self.heat_generated)
        largest = max(map(abs, parts))
        return sum(parts) / largest if largest > 0.0 else 0.0

    @property
    def imbalance(self) -> float:
        """(plastic + friction + elastic + contact) / external - 1."""
        if self.external <= 0.0:
            return 0.0
        return (self.plastic + self.friction + self.elastic + self.contact) / self.external - 1.0

    def add_contact(self, du: FloatArray, moves: list[FloatArray], ends: list[Loading]) -> None:
        """Add the work of the tools in an increment, and what friction and the springs of the contact took of it.

        - `du`, shape (n_s, 2): displacement of the surface nodes [mm].
        - `moves`, shape (2,): displacements of the tools [mm].
        - `ends`: start and end of the increment; after a remeshing, which leaves no start, the end alone.
        """
        for tables, weights, forces in ends:
            share = weights / len(ends)
            for table, force, move in zip(tables, forces, moves):
                relative, normal = du - move, table[:, [NORMAL_R, NORMAL_Z]]
                along = relative[:, 0] * normal[:, 1] - relative[:, 1] * normal[:, 0]
                across = (relative * normal).sum(axis=1)
                self.external -= float(force @ move) / len(ends)
                self.friction -= 2.0 * np.pi * float((table[:, SHEAR] * along) @ share)
                self.contact -= 2.0 * np.pi * float((table[:, PRESSURE] * across) @ share)
