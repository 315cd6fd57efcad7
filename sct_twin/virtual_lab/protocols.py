"""Protocols of a test: steps of speed or pressure, ramps, holds, zero readings; given by columns of the plan."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from friction_models.common import InputError, unknown_name
from friction_models.loads import FloatArray

from ..records.cells import is_given

#: Parameters of each protocol; a column that a protocol does not list means nothing to it.
PROTOCOLS: dict[str, tuple[str, ...]] = {
    "constant": (),
    "speed_step": ("v_levels",),
    "pressure_ramp": ("sigma_end",),
    "pressure_step": ("sigma_levels",),
    "hold": ("hold_at", "hold"),
    "zero_reading": ("zero_reading",),
}
#: Unit and limits of every number of a plan.
LIMITS: dict[str, tuple[float, float, str]] = {
    "sigma_set": (50.0, 2900.0, "MPa"),
    "v_set": (0.5, 1000.0, "mm/s"),
    "T_tool": (0.0, 350.0, "degC"),
    "T_specimen": (0.0, 350.0, "degC"),
    "sd_set": (2.0, 120.0, "mm"),
    "t_wait": (0.05, 600.0, "s"),
    "Ra": (0.0, 10.0, "um"),
    "v_levels": (0.5, 1000.0, "mm/s"),
    "sigma_end": (20.0, 2900.0, "MPa"),
    "sigma_levels": (20.0, 2900.0, "MPa"),
    "hold_at": (0.5, 119.0, "mm"),
    "hold": (0.05, 600.0, "s"),
    "zero_reading": (0.1, 120.0, "s"),
}
#: Time in which the force goes from one level to the next [s].
FORCE_CHANGE = 0.05
_MOST_LEVELS = 50


@dataclass(frozen=True)
class Schedule:
    """Set values of the rig in one test.

    A force that falls to half over 40 mm:

    >>> Schedule(speeds=(50.0,), forces=(1.0, 0.5), ramp=True).force(np.array([0.0, 20.0, 40.0]), 40.0, 50.0).tolist()
    [1.0, 0.75, 0.5]
    """

    #: Set speeds on equal parts of the sliding distance [mm/s].
    speeds: tuple[float, ...]
    #: Forces over the force of upsetting: at the two ends of the distance where `ramp`, else on equal parts.
    forces: tuple[float, ...] = (1.0,)
    #: The force changes linearly with the distance.
    ramp: bool = False
    #: Distance [mm] at which the plate stops, and how long it stands under load [s].
    hold: tuple[float, float] | None = None
    #: Time without load before and after the test [s].
    zero_reading: float = 0.0

    def force(self, sd: FloatArray, distance: float, v: float) -> FloatArray:
        """Return the force over that of upsetting at sliding distances [mm], at about the speed `v` [mm/s]."""
        if self.ramp:
            return np.interp(sd, [0.0, distance], self.forces)
        count = len(self.forces)
        if count == 1:
            return np.full(len(sd), self.forces[0])
        # A change takes its time: so much of the distance goes by.
        width = min(FORCE_CHANGE * v, 0.5 * distance / count)
        x, y = [0.0], [self.forces[0]]
        for k in range(1, count):
            x += [k * distance / count, k * distance / count + width]
            y += [self.forces[k - 1], self.forces[k]]
        return np.interp(sd, x, y)


def schedule(row: Mapping[str, object], where: str) -> Schedule:
    """Return the schedule of a row of the plan.

    Raises InputError: an unknown protocol, a parameter that is missing or outside its limits.

    >>> row = {"sigma_set": 1000.0, "v_set": 50.0, "sd_set": 40.0, "protocol": "speed_step", "v_levels": "5;50;500"}
    >>> schedule(row, "plan: row 0").speeds
    (5.0, 50.0, 500.0)
    """
    name = row.get("protocol")
    protocol = str(name) if is_given(name) else "constant"
    if protocol not in PROTOCOLS:
        raise unknown_name("protocol", protocol, PROTOCOLS, where)
    v_set, sigma = number(row, "v_set", where), number(row, "sigma_set", where)
    distance = number(row, "sd_set", where)
    if protocol == "speed_step":
        return Schedule(numbers(row, "v_levels", where))
    if protocol == "pressure_ramp":
        end = number(row, "sigma_end", where, highest=sigma)
        return Schedule((v_set,), (1.0, end / sigma), ramp=True)
    if protocol == "pressure_step":
        levels = numbers(row, "sigma_levels", where, highest=sigma)
        return Schedule((v_set,), tuple(level / sigma for level in levels))
    if protocol == "hold":
        at = number(row, "hold_at", where, highest=distance - 0.5)
        return Schedule((v_set,), hold=(at, number(row, "hold", where)))
    if protocol == "zero_reading":
        return Schedule((v_set,), zero_reading=number(row, "zero_reading", where))
    return Schedule((v_set,))


def number(row: Mapping[str, object], name: str, where: str, highest: float = math.inf) -> float:
    """Return a number of a row within its limits. Raises InputError: it is missing, not a number, or outside."""
    if not is_given(row.get(name)):
        raise InputError(f"{where}: {name} is missing; allowed: {_allowed(name, highest)}")
    return _checked(row[name], name, where, highest)


def numbers(row: Mapping[str, object], name: str, where: str, highest: float = math.inf) -> tuple[float, ...]:
    """Return the numbers of a text such as ``"5;500;50"``.

    Raises InputError: see `number`; too many or too few of them.
    """
    if not is_given(row.get(name)):
        raise InputError(f"{where}: {name} is missing; allowed: numbers such as '5;500;50'")
    cells = str(row[name]).split(";")
    if not 2 <= len(cells) <= _MOST_LEVELS:
        raise InputError(
            f"{where}: {name} has {len(cells)} values; allowed: 2 to {_MOST_LEVELS}, separated by semicolons"
        )
    return tuple(_checked(cell, name, where, highest) for cell in cells)


def _checked(value: Any, name: str, where: str, highest: float) -> float:
    try:
        result = float(value)
    except (TypeError, ValueError):
        result = math.nan
    low, high, _ = LIMITS[name]
    if not low <= result <= min(high, highest):
        raise InputError(f"{where}: {name} = {value!r}; allowed: {_allowed(name, highest)}")
    return result


def _allowed(name: str, highest: float) -> str:
    low, high, unit = LIMITS[name]
    return f"{low:g} to {min(high, highest):g} {unit}"
