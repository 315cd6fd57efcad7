"""Connections as text, such as ``forming.T -> friction.T_contact [K]``."""

from __future__ import annotations

import re

from fmus.interface.quantities import load_conversion
from fmus.runtime.fmu_variables import Variable
from friction_models.common import InputError
from friction_models.loads import LOADS

_UNIT = re.compile(r"\s+\[(?P<unit>[^\[\]]{1,30})\]\s*$")


def split_connection(text: str) -> tuple[str, str, str] | None:
    """Return source, target and the unit behind the target (empty without one); None for a text without ``->``.

    Examples
    --------
    >>> split_connection("forming.T -> friction.T_contact [K]")
    ('forming.T', 'friction.T_contact', 'K')
    """
    left, arrow, right = text.partition("->")
    if not arrow:
        return None
    found = _UNIT.search(right)
    target = right[: found.start()] if found else right
    return left.strip(), target.strip(), found["unit"].strip() if found else ""


def scaling(source: Variable, target: Variable, unit: str) -> tuple[float, float]:
    """Return (factor, offset) that turn values of `source`, a load, into `unit`, as the target expects them.

    Examples
    --------
    >>> from types import SimpleNamespace as Made
    >>> scaling(Made(name="T", unit="degC"), Made(name="T_contact", unit="K"), "K")
    (1.0, 273.15)
    """
    load = next((q for q in LOADS if q.unit == source.unit), None)
    if load is None:
        raise InputError(
            f"{source.name!r} is in {source.unit!r}, which cannot be converted; "
            f"allowed: {', '.join(dict.fromkeys(q.unit for q in LOADS))}"
        )
    if target.unit and target.unit != unit:
        raise InputError(
            f"{target.name!r} is in {target.unit!r} and not in {unit!r}; allowed: {target.unit!r}"
        )
    return load_conversion(load.name, unit, f"[{unit}]")
