"""Units of measurement files: a short table for the usual ones, pint for the rest."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from friction_models.loads import InputError

from .channels import channel

#: Products and quotients of names with one-digit powers; nothing that could be a long computation.
_UNIT = re.compile(r"^[^\W\d_]{1,20}(\^?-?[1-9])?(?:[*·/ ][^\W\d_]{1,20}(\^?-?[1-9])?){0,4}$")
_POWERS = str.maketrans({"²": "2", "³": "3", "·": "*", " ": "*", "µ": "μ"})


@cache
def conversion(quantity: str, unit: str, where: str = "") -> tuple[float, float]:
    """Return (factor, offset) from a unit to the canonical unit of a quantity.

    Raises
    ------
    InputError
        No such unit, or it measures something else.
    """
    try:
        return channel(quantity).factor(unit, where)
    except InputError as error:
        found = _by_pint(channel(quantity).unit, unit)
        if found is None:
            raise error
        return found


def _by_pint(canonical: str, unit: str) -> tuple[float, float] | None:
    text = unit.strip().strip("[]()").strip().translate(_POWERS)
    if not _UNIT.match(text):
        return None
    try:
        registry = _registry()
    except ImportError:
        return None
    # A power stands behind its name in files (mm/s2), behind ** in pint.
    source = re.sub(r"(?<=[^\W\d_])\^?(-?[1-9])", r"**\1", text)
    target = canonical.replace("s2", "s**2")
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
