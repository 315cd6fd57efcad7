"""Heat data of plate and specimen in the laboratory, and the Kirchhoff transform that makes their conduction linear."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from friction_models.common import InputError
from friction_models.loads import FloatArray

#: A number, or pairs (temperature [degC], value) with straight lines between and constant beyond.
Data = float | tuple[tuple[float, float], ...]
#: Temperatures between which the transform is tabulated, and the step of the table [degC].
_LOW, _HIGH, _STEP = -100.0, 2000.0, 0.5


@dataclass(frozen=True)
class HeatBody:
    """Heat data of a body.

    Conduction is linear in the transformed temperature, the integral of k over k at the start (Kirchhoff), where the
    diffusivity k / c does not change. Where it does, its mean over the temperatures of the data is taken.

    Raises InputError: a value that is not positive, or temperatures that do not rise.

    >>> body = HeatBody(((20.0, 40.0), (220.0, 30.0)), ((20.0, 4.0), (220.0, 3.0)))
    >>> body.diffusivity
    10.0
    """

    #: [N/(s K)], the number of W/(m K).
    conductivity: Data
    #: Heat capacity per volume [N/(mm2 K)], the number of MJ/(m3 K).
    capacity: Data

    def __post_init__(self) -> None:
        for name in ("conductivity", "capacity"):
            given = getattr(self, name)
            pairs = _pairs(given)
            rising = all(a[0] < b[0] for a, b in pairwise(pairs))
            if not rising or not all(math.isfinite(T) and 0.0 < value < math.inf for T, value in pairs):
                raise InputError(
                    f"heat body: {name} = {given!r:.60}; allowed: values above 0 at rising temperatures"
                )
            if not isinstance(given, int | float):
                object.__setattr__(self, name, pairs)

    @classmethod
    def alike(cls, conductivity: Data, diffusivity: float) -> HeatBody:
        """Return a body whose capacity changes with temperature as its conductivity does: k / c [mm2/s] stays."""
        if isinstance(conductivity, int | float):
            return cls(conductivity, conductivity / diffusivity)
        return cls(conductivity, tuple((T, k / diffusivity) for T, k in conductivity))

    @property
    def diffusivity(self) -> float:
        """Return the thermal diffusivity [mm2/s]."""
        known = sorted({T for data in (self.conductivity, self.capacity) for T, _ in _pairs(data)})
        T = np.linspace(known[0], known[-1], 101)
        return float(np.mean(_at(self.conductivity, T) / _at(self.capacity, T)))


class Kirchhoff:
    """Transformed temperature of a body [K], 0 at its start temperature; its flux is that of k at the start.

    >>> body = HeatBody(((0.0, 10.0), (1000.0, 20.0)), 3.0)
    >>> transform = Kirchhoff(body, start=0.0)
    >>> round(transform.effusivity, 2), round(float(transform.temperature(np.array([105.0]))[0]), 4)
    (4.47, 100.0)
    """

    def __init__(self, body: HeatBody, start: float) -> None:
        self.start = float(start)
        self.conductivity = float(_at(body.conductivity, np.array([start]))[0])
        self.diffusivity = body.diffusivity
        self.effusivity = self.conductivity / math.sqrt(self.diffusivity)
        self._constant = isinstance(body.conductivity, int | float)
        if not self._constant:
            self._T = np.arange(_LOW, _HIGH + _STEP, _STEP)
            k = _at(body.conductivity, self._T)
            integral = np.concatenate([[0.0], np.cumsum(0.5 * _STEP * (k[1:] + k[:-1]))])
            zero = np.interp(start, self._T, integral)
            self._theta = (integral - zero) / self.conductivity

    def temperature(self, theta: FloatArray) -> FloatArray:
        """Return the temperature [degC] at transformed temperatures."""
        if self._constant:
            return self.start + theta
        return np.interp(theta, self._theta, self._T)

    def transformed(self, T: float) -> float:
        """Return the transformed temperature at a temperature [degC]."""
        return T - self.start if self._constant else float(np.interp(T, self._T, self._theta))


@dataclass(frozen=True)
class LabHeat:
    """Heat data that hold in the laboratory, and into how many cells its contact is divided.

    Raises InputError: a value outside its limits.

    >>> LabHeat(heat_transfer=30.0).cells
    16
    """

    #: Cells across the contact diameter; the plate and the depth of both bodies need no grid.
    cells: int = 16
    #: Heat transfer coefficient of the film [N/(mm s K)]; 33 is 33 000 W/(m2 K).
    heat_transfer: float = 33.0
    #: Of hardened tool steel and of case-hardening steel: other values than in the twin, another dependence on T.
    plate: HeatBody = field(
        default_factory=lambda: HeatBody.alike(((20.0, 20.4), (200.0, 21.07), (400.0, 22.28)), 5.83)
    )
    specimen: HeatBody = field(default_factory=lambda: HeatBody.alike(((20.0, 41.1), (400.0, 41.4)), 11.1))

    def __post_init__(self) -> None:
        for name, low, high in (("cells", 4, 200), ("heat_transfer", 1e-9, 1e6)):
            value = getattr(self, name)
            if not (math.isfinite(value) and low <= value <= high):
                raise InputError(f"laboratory heat: {name} = {value!r}; allowed: {low:g} to {high:g}")

    @classmethod
    def from_dict(cls, content: dict[str, Any]) -> LabHeat:
        """Rebuild from a truth file; what older files say of grids of the laboratory is left out."""
        bodies = {name: HeatBody(**content[name]) for name in ("plate", "specimen")}
        return cls(cells=int(content["cells"]), heat_transfer=float(content["heat_transfer"]), **bodies)


def _pairs(data: Any) -> tuple[tuple[float, float], ...]:
    if isinstance(data, int | float):
        return ((20.0, float(data)),)
    return tuple((float(T), float(value)) for T, value in data)


def _at(data: Data, T: FloatArray) -> FloatArray:
    pairs = _pairs(data)
    return np.interp(T, [pair[0] for pair in pairs], [pair[1] for pair in pairs])
