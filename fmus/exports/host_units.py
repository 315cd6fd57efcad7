"""The units that a host computes in, and how its numbers become those of the loads contract (mm, s, MPa, degC)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from friction_models.common import unknown_name
from friction_models.common.units import UNITS, Unit
from friction_models.loads import FloatArray

#: Consistent systems of solvers by the names of their base units: length, time, stress.
SYSTEMS: dict[str, tuple[str, str, str]] = {
    "tonne-mm-s": ("mm", "s", "MPa"),
    "kg-mm-ms": ("mm", "ms", "GPa"),
    "g-mm-ms": ("mm", "ms", "MPa"),
    "kg-m-s": ("m", "s", "Pa"),
    "english": ("in", "s", "ksi"),
}
TEMPERATURES = ("degC", "K", "degF")


@dataclass(frozen=True)
class HostUnits:
    """Units of a host.

    Examples
    --------
    >>> units = HostUnits("kg-mm-ms", "K")
    >>> units.length, units.time, units.pressure, units.speed
    (1.0, 0.001, 1000.0, 1000.0)
    >>> units.to_host(np.array([[1000.0, 20.0, 500.0, 3.0, 1.2]])).tolist()
    [[1.0, 293.15, 0.5, 3.0, 1.2]]
    """

    system: str = "tonne-mm-s"  #: Name of the system, one of `SYSTEMS`.
    temperature: str = "degC"  #: ``degC``, ``K`` or ``degF``.

    @property
    def names(self) -> tuple[str, str, str]:
        """Units of length, time and stress."""
        return SYSTEMS[self.system]

    @property
    def length(self) -> float:
        """The host's unit of length in mm."""
        return UNITS[self.names[0]].factor

    @property
    def time(self) -> float:
        """The host's unit of time in s."""
        return UNITS[self.names[1]].factor

    @property
    def pressure(self) -> float:
        """The host's unit of stress in MPa."""
        return UNITS[self.names[2]].factor

    @property
    def speed(self) -> float:
        """The host's unit of speed in mm/s."""
        return self.length / self.time

    @property
    def warmth(self) -> Unit:
        """How a temperature of the host becomes degC: value * factor + offset."""
        return UNITS[self.temperature]

    def to_host(self, loads: FloatArray) -> FloatArray:
        """Return loads of the contract, shape (n, 5), in the host's units."""
        factor, offset = self.warmth.factor, self.warmth.offset
        at = np.array(loads, dtype=float)
        at[:, 1] = (at[:, 1] - offset) / factor
        return at / np.array([self.speed, 1.0, self.pressure, self.length, 1.0])

    def columns(self) -> dict[str, str]:
        """Return the units of the loads in the host."""
        length, time, stress = self.names
        return {
            "v_rel": f"{length}/{time}",
            "T": self.temperature,
            "sigma_n": stress,
            "sd": length,
            "psi": "1",
        }

    def text(self) -> str:
        """Return the units as a phrase.

        Examples
        --------
        >>> HostUnits().text()
        'mm, s, MPa, degC'
        """
        return ", ".join((*self.names, self.temperature))

    def fortran(self) -> dict[str, str]:
        """Return the constants of the Fortran templates."""
        values = {
            "LENGTH": self.length,
            "TIME": self.time,
            "PRESSURE": self.pressure,
            "T_FACTOR": self.warmth.factor,
            "T_OFFSET": self.warmth.offset,
        }
        return {
            k: format(v, ".17g").replace("e", "d") + ("" if "e" in format(v, ".17g") else "d0")
            for k, v in values.items()
        } | {"UNITS": self.text()}


def host_units(
    units: object = "tonne-mm-s", temperature: object = None, allowed: Sequence[str] = tuple(SYSTEMS)
) -> HostUnits:
    """Read the options `units` and `temperature` of an export.

    Raises InputError: a system or a unit that is not known.

    Examples
    --------
    >>> host_units("english").text()
    'in, s, ksi, degF'
    """
    if units not in allowed:
        raise unknown_name("units of the host", str(units), allowed)
    if temperature is None:
        temperature = "degF" if units == "english" else "degC"
    if temperature not in TEMPERATURES:
        raise unknown_name("temperature of the host", str(temperature), TEMPERATURES)
    return HostUnits(str(units), str(temperature))
