"""Reading options that came as texts, lists or mappings; every refusal names the option and what is allowed."""

from __future__ import annotations

import contextlib
from collections.abc import Collection, Mapping, Sequence

from friction_models.common import InputError, unknown_name
from friction_models.loads import LOAD_NAMES, QUANTITIES


def number(what: str, value: object, lower: float, upper: float) -> float:
    """Return a number, also from a text such as ``1e-3``.

    Examples
    --------
    >>> number("tolerance", "1e-3", 0.0, 1.0)
    0.001
    """
    read = float("nan")
    if isinstance(value, int | float | str) and not isinstance(value, bool):
        with contextlib.suppress(ValueError, OverflowError):
            read = float(value)
    if not lower <= read <= upper:
        raise InputError(f"{what} = {value!r}, allowed: {lower:g} to {upper:g}")
    return read


def whole(what: str, value: object, lower: int, upper: int) -> int:
    """Return a whole number.

    Examples
    --------
    >>> whole("max_rows", "500", 1, 1000)
    500
    >>> whole("max_rows", 2.5, 1, 1000)
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: max_rows = 2.5, allowed: a whole number from 1 to 1000
    """
    read = number(what, value, lower, upper)
    if read != int(read):
        raise InputError(f"{what} = {value!r}, allowed: a whole number from {lower} to {upper}")
    return int(read)


def axis_names(value: object) -> list[str]:
    """Return different loads from a list or a text with commas.

    Examples
    --------
    >>> axis_names("T, sigma_n")
    ['T', 'sigma_n']
    """
    parts = [p.strip() for p in value.split(",")] if isinstance(value, str) else value
    if not isinstance(parts, Sequence):
        raise InputError(f"axes = {value!r}, allowed: a list of loads")
    for name in parts:
        if name not in LOAD_NAMES:
            raise unknown_name("axis of the table", str(name), LOAD_NAMES)
    if not parts or len(set(parts)) != len(parts):
        raise InputError(
            f"axes = {list(parts)}, allowed: one or more different loads of {', '.join(LOAD_NAMES)}"
        )
    return list(parts)


def mapping(what: str, value: object, names: Collection[str]) -> dict[str, object]:
    """Return a mapping whose keys are all among `names`; empty for None.

    Examples
    --------
    >>> mapping("fixed", {"T": 80.0}, ("T", "psi")), mapping("fixed", None, ("T",))
    ({'T': 80.0}, {})
    """
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise InputError(f"{what} = {value!r}, allowed: a mapping from names to values")
    for name in value:
        if name not in names:
            raise unknown_name(f"name in {what}", str(name), names)
    return dict(value)


def limits(name: str, value: object) -> tuple[float, float]:
    """Return lower and upper end of the axis `name`, inside its physical limits.

    Examples
    --------
    >>> limits("T", (20.0, 200.0))
    (20.0, 200.0)
    >>> limits("T", (200.0, 20.0))
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: limits of 'T' are 200 and 20, allowed: lower <= upper
    """
    quantity = QUANTITIES[name]
    if isinstance(value, str) or not isinstance(value, Sequence) or len(value) != 2:
        raise InputError(f"limits of {name!r} are {value!r}, allowed: two numbers, lower and upper")
    lower, upper = (number(f"limit of {name!r}", x, quantity.lower, quantity.upper) for x in value)
    if lower > upper:
        raise InputError(f"limits of {name!r} are {lower:g} and {upper:g}, allowed: lower <= upper")
    return lower, upper
