"""Units of measurement files: the table of the loads for the usual ones, pint for the rest."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from friction_models.common import InputError
from friction_models.common.units import conversion

from .channels import channel

#: Products and quotients of names with one-digit powers; nothing that could be a long computation.
_UNIT = re.compile(r"^[^\W\d_]{1,20}(\^?-?[1-9])?(?:[*·/ ][^\W\d_]{1,20}(\^?-?[1-9])?){0,4}$")
_SCALE = re.compile(r"^([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,2})?)\s*(\S.*)$")
_POWERS = str.maketrans({"²": "2", "³": "3", "·": "*", " ": "*", "µ": "μ"})


@cache
def channel_conversion(quantity: str, unit: str, where: str = "") -> tuple[float, float]:
    """Return (factor, offset) from a unit to the canonical unit of a quantity.

    Raises InputError: no such unit, or it measures something else.

    >>> channel_conversion("F_n", "kN")
    (1000.0, 0.0)
    """
    try:
        return conversion(channel(quantity).unit, unit, quantity, where)
    except InputError as error:
        found = _by_pint(channel(quantity).unit, unit)
        if found is None:
            raise error
        return found


def scale_factor(quantity: str, unit: str, scale: str, inverse: bool, where: str) -> float:
    """Return what a reading in `unit` is multiplied by to be in the canonical unit of a quantity.

    Raises InputError: not a number with a unit, zero, or units that do not give the quantity.

    - `scale`: number and unit: of the quantity a reading (``5 kN/V``), or the inverse of it (``200 mV/kN``).
    - `inverse`: whether `scale` is readings a quantity (a sensitivity).

    A cell of 5 kN/V, read in V, and one of 200 mV/kN, read in mV:

    >>> scale_factor("F_n", "V", "5 kN/V", inverse=False, where="map")
    5000.0
    >>> round(scale_factor("F_n", "mV", "200 mV/kN", inverse=True, where="map"), 9)
    5.0
    """
    key, example = ("sensitivity", "200 mV/kN") if inverse else ("scale", "5 kN/V")
    match = _SCALE.match(scale.strip())
    if match is None or not 0.0 < abs(float(match[1])) < 1e30:
        raise InputError(f"{where}: {key} is {scale!r}; allowed: a number with a unit, such as {example!r}")
    canonical = channel(quantity).unit
    # A slope of temperatures has no zero.
    source, reading = (_pint_text(text) for text in (match[2], unit))
    target = "delta_degC" if canonical == "degC" else _pint_text(canonical)
    factor = None
    if source is not None and reading is not None:
        source = re.sub(r"\b(degC|K)\b", "delta_degC", source)
        form = f"({reading})/({source})" if inverse else f"({reading})*({source})"
        try:
            factor = float(_registry().Quantity(1.0, form).to(target).magnitude)
        except Exception:
            # pint has a dozen ways to say that units do not fit.
            factor = None
    if factor is None:
        raise InputError(
            f"{where}: readings in {unit!r} with {key} {scale!r} do not give {quantity!r}; allowed: units "
            f"whose {'quotient' if inverse else 'product'} is in {canonical}"
        )
    return factor / float(match[1]) if inverse else factor * float(match[1])


def _pint_text(unit: str) -> str | None:
    """Return a unit as pint writes it, None for what cannot be one."""
    text = unit.strip().strip("[]()").strip().translate(_POWERS).replace("°C", "degC")
    if not _UNIT.match(text):
        return None
    # A power stands behind its name in files (mm/s2), behind ** in pint.
    return re.sub(r"(?<=[^\W\d_])\^?(-?[1-9])", r"**\1", text)


def _by_pint(canonical: str, unit: str) -> tuple[float, float] | None:
    source = _pint_text(unit)
    if source is None:
        return None
    try:
        registry = _registry()
    except ImportError:
        return None
    target = _pint_text(canonical)
    try:
        zero = registry.Quantity(0.0, source).to(target).magnitude
        one = registry.Quantity(1.0, source).to(target).magnitude
    except Exception:
        # pint has a dozen ways to say that this is not such a unit.
        return None
    return float(one - zero), float(zero)


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(cache_folder=None)
