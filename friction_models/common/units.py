"""Units of columns: from the usual ones of a measurement to those of the contract."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from .errors import unknown_name


class Unit(NamedTuple):
    """What a unit measures, and how it becomes the unit that the project computes with: value * factor + offset.

    Examples
    --------
    >>> kelvin = UNITS["K"]
    >>> kelvin.kind, 293.15 * kelvin.factor + kelvin.offset
    ('temperature', 20.0)
    """

    kind: str
    factor: float = 1.0
    offset: float = 0.0


#: Of each kind, the unit with factor 1 and offset 0 is the project's.
UNITS: dict[str, Unit] = {
    "mm": Unit("length"),
    "um": Unit("length", 1e-3),
    "cm": Unit("length", 10.0),
    "m": Unit("length", 1e3),
    "in": Unit("length", 25.4),
    "mm/s": Unit("speed"),
    "um/s": Unit("speed", 1e-3),
    "cm/s": Unit("speed", 10.0),
    "m/s": Unit("speed", 1e3),
    "mm/min": Unit("speed", 1.0 / 60.0),
    "m/min": Unit("speed", 1e3 / 60.0),
    "in/s": Unit("speed", 25.4),
    "MPa": Unit("pressure"),
    "Pa": Unit("pressure", 1e-6),
    "kPa": Unit("pressure", 1e-3),
    "GPa": Unit("pressure", 1e3),
    "bar": Unit("pressure", 0.1),
    "psi": Unit("pressure", 6.894757293168361e-3),
    "ksi": Unit("pressure", 6.894757293168361),
    "N/mm2": Unit("pressure"),
    "kN/mm2": Unit("pressure", 1e3),
    "degC": Unit("temperature"),
    "K": Unit("temperature", 1.0, -273.15),
    "degF": Unit("temperature", 5.0 / 9.0, -160.0 / 9.0),
    "s": Unit("time"),
    "ms": Unit("time", 1e-3),
    "us": Unit("time", 1e-6),
    "min": Unit("time", 60.0),
    "h": Unit("time", 3600.0),
    "N": Unit("force"),
    "kN": Unit("force", 1e3),
    "MN": Unit("force", 1e6),
    "mm/s2": Unit("acceleration"),
    "m/s2": Unit("acceleration", 1e3),
    "g": Unit("acceleration", 9806.65),
    "1": Unit("number"),
    "%": Unit("number", 1e-2),
}
#: Other spellings, without blanks and brackets.
_SPELLINGS = {
    **dict.fromkeys(("C", "°C", "℃"), "degC"),
    **dict.fromkeys(("F", "°F"), "degF"),
    "kelvin": "K",
    "-": "1",
    "sec": "s",
}
#: Signs that stand in spellings of several units, and what the table has in their place.
_SIGNS = {"µ": "u", "μ": "u", "²": "2", "^2": "2"}


def spelling(unit: str) -> str:
    """Return a unit as this table writes it; what it does not know comes back without brackets.

    Examples
    --------
    >>> spelling(" [N/mm^2] "), spelling("furlong")
    ('N/mm2', 'furlong')
    """
    text = unit.strip().strip("[]()").strip()
    plain = _SPELLINGS.get(text, text)
    for sign, instead in _SIGNS.items():
        plain = plain.replace(sign, instead)
    return plain if plain in UNITS else text


def units_like(canonical: str) -> list[str]:
    """Return the units that measure the same as one of the table.

    Examples
    --------
    >>> units_like("degC")
    ['degC', 'K', 'degF']
    """
    return [name for name, unit in UNITS.items() if unit.kind == UNITS[canonical].kind]


def conversion(canonical: str, unit: str, column: str, where: str = "") -> tuple[float, float]:
    """Return (factor, offset) that turn a value in `unit`, as a file writes it, into the unit `canonical` of the table.

    Raises InputError: no such unit, or it measures something else; names those that fit and the nearest.

    Examples
    --------
    >>> factor, offset = conversion("mm", "m", "stroke")
    >>> factor * 0.02 + offset
    20.0
    >>> conversion("MPa", "degC", "sigma_n")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: ...
    """
    text = spelling(unit)
    if text not in UNITS or UNITS[text].kind != UNITS[canonical].kind:
        raise unknown_name(f"unit of column {column!r}", unit, units_like(canonical), where)
    source, target = UNITS[text], UNITS[canonical]
    return source.factor / target.factor, (source.offset - target.offset) / target.factor


def differs(name: str, unit: str, known: Mapping[str, str]) -> bool:
    """Whether a column of a known quantity stands in another unit than the project's.

    Examples
    --------
    >>> differs("sd", "cm", {"sd": "mm"}), differs("sd", "mm", {"sd": "mm"}), differs("note", "cm", {"sd": "mm"})
    (True, False, False)
    """
    return name in known and bool(unit) and spelling(unit) != known[name]
