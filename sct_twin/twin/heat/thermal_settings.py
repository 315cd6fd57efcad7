"""Heat data of plate and specimen and the resolution of the sliding model."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from forming.fe.heat.properties import Property, checked_property, integral, value_at
from forming.materials.materials import Material, load
from friction_models.common import InputError
from friction_models.common.ranges import check_range
from friction_models.loads import FloatArray

#: Lowest and highest temperature [degC] and step [K] of the tables of conductivity, capacity and enthalpy that the kernels read.
TABLE_START, TABLE_STEP, _TABLE_END = -273.0, 1.0, 1600.0


@dataclass(frozen=True)
class ThermalBody:
    """Heat data of a body, each a number or pairs (temperature [degC], value) with straight lines between.

    Raises InputError: a value that is not positive, or temperatures that do not rise.

    >>> body = ThermalBody(conductivity=((20.0, 40.0), (220.0, 30.0)), capacity=4.0)
    >>> body.constant(120.0)
    ThermalBody(conductivity=35.0, capacity=4.0)
    >>> body.diffusivity(20.0)
    10.0
    >>> round(float(body.heat(20.0, 120.0)), 6)
    400.0
    """

    #: [N/(s K)], the number of W/(m K).
    conductivity: Property
    #: Heat capacity per volume [N/(mm2 K)], the number of MJ/(m3 K).
    capacity: Property

    def __post_init__(self) -> None:
        for name in ("conductivity", "capacity"):
            object.__setattr__(self, name, checked_property(getattr(self, name), f"thermal body: {name}"))

    @classmethod
    def of(cls, material: Material) -> ThermalBody:
        """Return the heat data of a material of the forming solver."""
        return cls(material.conductivity, material.heat_capacity)

    def constant(self, T: float = 20.0) -> ThermalBody:
        """Return the body with the values that it has at one temperature [degC]."""
        return ThermalBody(float(value_at(self.conductivity, T)), float(value_at(self.capacity, T)))

    def diffusivity(self, T: float = 20.0) -> float:
        """Return the thermal diffusivity [mm2/s] at a temperature."""
        return float(value_at(self.conductivity, T) / value_at(self.capacity, T))

    def effusivity(self) -> float:
        """Return sqrt(conductivity capacity) [N/(mm sqrt(s) K)] at 20 degC."""
        return float(np.sqrt(value_at(self.conductivity, 20.0) * value_at(self.capacity, 20.0)))

    def heat(self, T0: float, T: npt.ArrayLike) -> FloatArray:
        """Return the heat per volume [N/mm2] between a temperature and others."""
        return np.asarray(integral(self.capacity, T) - integral(self.capacity, T0))

    @property
    def keeps_capacity(self) -> bool:
        """Whether the heat capacity does not depend on temperature."""
        return not isinstance(self.capacity, tuple)

    @property
    def table(self) -> FloatArray:
        """Return conductivity, capacity and enthalpy over temperature as the kernels read them, shape (3, n)."""
        return _table(self.conductivity, self.capacity)


@lru_cache(maxsize=64)
def _table(conductivity: Property, capacity: Property) -> FloatArray:
    if not isinstance(conductivity, tuple) and not isinstance(capacity, tuple):
        return np.array([[conductivity], [capacity], [0.0]])
    T = np.arange(TABLE_START, _TABLE_END + TABLE_STEP, TABLE_STEP)
    c = value_at(capacity, T)
    enthalpy = np.concatenate([[0.0], np.cumsum(0.5 * TABLE_STEP * (c[1:] + c[:-1]))])
    return np.array([value_at(conductivity, T), c, enthalpy])


@lru_cache(maxsize=8)
def _shipped(name: str) -> ThermalBody:
    return ThermalBody.of(load(name))


@dataclass(frozen=True)
class ThermalSettings:
    """Numerical and physical settings of the sliding model.

    Raises InputError: a value outside its limits.

    Examples
    --------
    >>> settings = ThermalSettings(cells=12, heat_transfer=20.0)
    >>> settings.cells, settings.depth
    (12, 12.0)
    >>> ThermalSettings(cells=2)
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: thermal settings: cells = 2; allowed: 4 to 400
    """

    #: Plate cells across the contact diameter.
    cells: int = 24
    #: Thickness of the cells at the interface [mm].
    surface_layer: float = 0.05
    #: Ratio of neighbouring layer thicknesses away from the interface.
    growth: float = 1.25
    #: Depth of the plate that is modelled [mm].
    depth: float = 12.0
    #: Interface heat transfer coefficient [N/(mm s K)]; 35 is 35 000 W/(m2 K).
    heat_transfer: float = 35.0
    #: Share of the friction heat that is released on the specimen's side of the film: it then has that part of the
    #: film's resistance to the plate, and the rest to the specimen. 0.5 is the middle.
    friction_heat_share: float = 0.5
    #: Heat data; those of the material files of 1.2379 and 16MnCr5 by default.
    plate: ThermalBody = field(default_factory=lambda: _shipped("1.2379"))
    specimen: ThermalBody = field(default_factory=lambda: _shipped("16MnCr5"))

    def __post_init__(self) -> None:
        for name, low, high in (
            ("cells", 4, 400),
            ("surface_layer", 1e-4, 1.0),
            ("growth", 1.001, 3.0),
            ("depth", 1.0, 200.0),
            ("heat_transfer", 1e-9, 1e6),
            ("friction_heat_share", 0.0, 1.0),
        ):
            check_range("thermal settings", name, getattr(self, name), low, high, "")
        for name in ("plate", "specimen"):
            if not isinstance(body := getattr(self, name), ThermalBody):
                raise InputError(f"thermal settings: {name} = {body!r:.60}; allowed: a ThermalBody")

    def constant(self, T: float = 20.0) -> ThermalSettings:
        """Return the settings with heat data that do not change with temperature."""
        return replace(self, plate=self.plate.constant(T), specimen=self.specimen.constant(T))
