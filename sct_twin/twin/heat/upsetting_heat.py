"""Temperature of a specimen that was upset: from the work that the punch has done, not from that of its surface."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from forming.fe.heat.properties import integral
from forming.materials.materials import Material
from forming.processes.specimen_upsetting import UpsettingResult
from forming.tools.punch_geometry import PunchGeometry


class UpsettingHeat(NamedTuple):
    """Heat of upsetting in a specimen.

    `temperature` [degC] is the one that the specimen would have if all heat were still in it, `age` [s] how long the heat
    has been there, on average over the work.
    """

    temperature: float
    age: float


def heat_of_upsetting(
    result: UpsettingResult, force: float, punch: PunchGeometry, material: Material, T0: float
) -> UpsettingHeat:
    """Return the heat in a specimen that is upset to a force.

    The work of the punch, without what is stored elastically, becomes heat as the material says (Taylor and Quinney).
    The surface of a specimen that lies between cold tools is colder than its inside, so that its temperature
    would tell too little of that.

    - `force`: [N]; `T0`: before upsetting [degC].
    """
    known = np.maximum.accumulate(result.force)
    below = result.force < force
    F, h, t = (
        np.append(values[below], np.interp(force, known, values))
        for values in (result.force, result.height, result.time)
    )
    work = 0.5 * (F[1:] + F[:-1]) * -np.diff(h)
    area = math.pi * float(np.interp(force, known, result.contact_radius)) ** 2
    shear, bulk = material.shear_modulus, material.bulk_modulus
    modulus = 9.0 * bulk * shear / (3.0 * bulk + shear)
    total = float(work.sum())
    if total <= 0.0:
        return UpsettingHeat(T0, 0.0)
    plastic = max(total - 0.5 * force**2 * float(h[-1]) / (modulus * area), 0.0)
    (r0, z0), (r1, z1) = punch.outline()[:-1].T, punch.outline()[1:].T
    volume = math.pi / 3.0 * float(((z1 - z0) * (r0**2 + r0 * r1 + r1**2)).sum())
    heat = material.taylor_quinney * plastic / volume

    def heat_between(low: float, high: float) -> float:
        return float(integral(material.heat_capacity, high) - integral(material.heat_capacity, low))

    # Capacity hardly changes over the rise: its mean over the rise that it gives at T0 will do.
    rise = heat / heat_between(T0 - 0.5, T0 + 0.5)
    if rise > 0.0:
        rise = heat / (heat_between(T0, T0 + rise) / rise)
    age = float((t[-1] - 0.5 * (t[1:] + t[:-1])) @ work) / total
    return UpsettingHeat(T0 + rise, age)
