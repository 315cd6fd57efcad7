"""The contact of a virtual specimen under a force, read from a run by a smooth curve over the force."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from friction_models.loads import FloatArray

from ..heat.bodies import LabHeat
from ..heat.rubbed_contact import RubbedContact
from .specimen_run import FRACTION, SpecimenRun

#: Half the width of the local curve, in the natural logarithm of the force, and the least number of increments in it.
WIDTH, LEAST = 0.2, 9


@dataclass(frozen=True, eq=False)
class LabContact:
    """The contact at the end of upsetting; it stays while the specimen slides."""

    #: Normal force [N].
    force: float
    #: Contact area [mm2], and the radius of a circle of that area [mm].
    area: float
    radius: float
    #: Height of the specimen [mm].
    height: float
    #: Mean surface expansion over the contact as it is.
    psi: float
    #: Contact pressure [MPa] at `FRACTION` of the radius, shape (m,).
    pressure: FloatArray

    def sigma_n(self, F_n: FloatArray | float) -> FloatArray:
        """Return the mean contact pressure [MPa] under a normal force [N]; the area stays."""
        return np.maximum(np.asarray(F_n, dtype=np.float64), 0.0) / self.area

    def rubbed(self, T_tool: float, heat: LabHeat) -> RubbedContact:
        """Return the thermal model of the contact, all of it at one temperature [degC]."""
        return RubbedContact(
            self.radius,
            self.height,
            T_tool,
            T_tool,
            T_tool,
            lambda r: np.interp(r / self.radius, FRACTION, self.pressure),
            heat,
        )


def contact_under(run: SpecimenRun, force: float) -> LabContact:
    """Return the contact of a run under a force [N], at most its highest."""
    force = min(force, float(run.force[-1]))
    figures = np.column_stack([run.area, run.height, run.psi, run.pressure / run.force[:, None]])
    found = smoothed(run.force, figures, force)
    area, height, psi = (float(value) for value in found[:3])
    relative = np.maximum(found[3:], 0.0)
    # By rings half-way between the radii, so that it carries the force.
    edges = np.concatenate([[0.0], 0.5 * (FRACTION[1:] + FRACTION[:-1]), [1.0]])
    mean = float(np.sum(relative * np.diff(edges**2)))
    return LabContact(
        force=force,
        area=area,
        radius=math.sqrt(area / math.pi),
        height=height,
        psi=psi,
        pressure=relative * (force / area / mean),
    )


def smoothed(force: FloatArray, values: FloatArray, at: float) -> FloatArray:
    """Return values at a force, from a parabola over its logarithm that nearby increments weigh in.

    - `force`, shape (n,): rising [N]; `values`, shape (n, m).

    >>> F = np.geomspace(1e4, 4e5, 60)
    >>> parabola = np.column_stack([1.0 + 2.0 * np.log(F / 1e5) - 0.3 * np.log(F / 1e5) ** 2])
    >>> smoothed(F, parabola, 1e5).round(9).tolist()
    [1.0]
    """
    x = np.log(force / at)
    width = max(WIDTH, 1.05 * float(np.sort(np.abs(x))[min(LEAST, len(x)) - 1]))
    weight = np.clip(1.0 - np.abs(x / width) ** 3, 0.0, None) ** 1.5
    near = weight > 0.0
    columns = np.column_stack([np.ones(int(near.sum())), x[near], x[near] ** 2])
    found = np.linalg.lstsq(columns * weight[near, None], values[near] * weight[near, None], rcond=1e-9)[0]
    return np.asarray(found[0])
