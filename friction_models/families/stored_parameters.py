"""Parameters of effects as files hold them: those of earlier versions are taken, and what no fit could have written is refused."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from ..common import InputError, shown, unknown_name
from ..common.json_values import JsonObject
from ..common.ranges import is_number
from ..effects.base import Effect
from ..effects.parameters import ShapeParameter
from ..loads.contract import behind
from ..models.variables import SystemVariable

#: Larger numbers are no friction; bounds from here on are none.
LARGEST = 1e12
#: Names that a message lists.
_LISTED = 12


def stored_levels(stored: object) -> dict[str, list[str]]:
    """Return the labels of each column of texts.

    Raises InputError: no lists of texts, or a label that stands twice.

    Examples
    --------
    >>> stored_levels({"batch": ["A", "A"]})
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: composed: levels of 'batch': label 'A' stands twice; allowed: once
    """
    if not isinstance(stored, dict):
        raise InputError(f"composed: levels {_value(stored)}; allowed: a list of labels for each column")
    for column, labels in stored.items():
        if not isinstance(labels, list) or not all(isinstance(label, str) for label in labels):
            raise InputError(
                f"composed: levels of {column!r}: {_value(labels)}; allowed: a list of labels, each a text"
            )
        twice = next((label for label in labels if labels.count(label) > 1), None)
        if twice is not None:
            raise InputError(
                f"composed: levels of {column!r}: label {shown(twice, 60)!r} stands twice; allowed: once"
            )
    return stored


def stored_effect(effect: Effect, levels: Mapping[str, Sequence[str]], amplitudes: object) -> Effect:
    """Return the effect as it was saved: with an offset for each level, or with one for a single level as earlier versions had it.

    Examples
    --------
    >>> from friction_models.effects import Batch
    >>> levels = {"batch": ["A", "B", "C"]}
    >>> [a.name for a in stored_effect(Batch(), levels, {"c_b": 0.01}).amplitudes]
    ['c_b']
    """
    now = effect.with_levels(levels)
    had = set(amplitudes) if isinstance(amplitudes, dict) else set()
    return effect if now.pooled and had == {a.name for a in effect.amplitudes} else now


def stored_shapes(effect: Effect, stored: object) -> dict[str, float]:
    """Return shape parameters, complete and within their bounds.

    Earlier versions saved the level for columns of numbers, too, and laws have got parameters since.

    Raises InputError.

    Examples
    --------
    >>> from friction_models.effects import SurfaceExpansion
    >>> stored_shapes(SurfaceExpansion(), {"psi_c": 0.5})
    {'psi_c': 0.5, 'n': 1.0}
    >>> stored_shapes(SurfaceExpansion(), {"psi_c": 0.5, "n": -1})
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: composed: parameter 'n' of effect 'surface_expansion' is -1; allowed: a number from 1 to 3
    """
    known = {s.name: s for s in effect.shapes}
    values = _entries(effect, stored)
    got = {s.name: s.earlier for s in effect.shapes if s.earlier is not None}
    values = {**got, **{k: v for k, v in values.items() if k in known or k != "deviating"}}
    _check_names(effect, values, known)
    return {name: _within(effect, shape, values[name]) for name, shape in known.items()}


def stored_amplitudes(effect: Effect, stored: object) -> dict[str, float]:
    """Return amplitudes, complete and numbers.

    Raises InputError.

    Examples
    --------
    >>> from friction_models.effects import ToolRoughness
    >>> stored_amplitudes(ToolRoughness(), {"c_Ra": "0.5"})
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: composed: parameter 'c_Ra' of effect 'tool_roughness' is '0.5'; allowed: a number from -1e+12 to 1e+12 1/um
    """
    units = {a.name: a.unit for a in effect.amplitudes}
    values = _entries(effect, stored)
    _check_names(effect, values, units)
    for name, unit in units.items():
        if not is_number(values[name]) or abs(values[name]) > LARGEST:
            raise _bad(effect, name, values[name], f"a number from {-LARGEST:g} to {LARGEST:g}{behind(unit)}")
    return {name: float(values[name]) for name in units}


def stored_system(
    stored: object, effects: Sequence[Effect], levels: Mapping[str, Sequence[str]]
) -> list[SystemVariable]:
    """Return the system variables that the effects need.

    Models saved before the labels stood with the variable have them in `levels` only.

    Raises InputError: one is missing or needed by no effect, or its numbers are none.

    Examples
    --------
    >>> from friction_models.effects import ToolRoughness
    >>> stored_system([], [ToolRoughness()], {})
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: composed: system variable 'Ra' is missing; allowed: an entry in 'system' with name, unit, start, min, max
    """
    keys = ("name", "unit", "start", "min", "max")
    if not isinstance(stored, list) or not all(isinstance(entry, dict) for entry in stored):
        raise InputError(
            f"composed: system {_value(stored)}; allowed: a list with one entry a system variable"
        )
    needed = list(dict.fromkeys(m for e in effects for m in e.metadata))
    found: dict[str, SystemVariable] = {}
    for entry in stored:
        name = str(entry.get("name"))
        if name not in needed:
            raise unknown_name("system variable", shown(name, 60), needed, "composed")
        if name in found:
            raise InputError(f"composed: system variable {name!r} stands twice; allowed: once")
        for key in entry:
            if key not in (*keys, "labels"):
                raise unknown_name(
                    "key", shown(key, 60), (*keys, "labels"), f"composed: system variable {name!r}"
                )
        for key in ("start", "min", "max"):
            if not is_number(entry.get(key)):
                raise InputError(
                    f"composed: {key!r} of system variable {name!r} is {_value(entry.get(key))}; allowed: a finite number"
                )
        labels = list(levels.get(name, ()))
        if labels and entry["start"] not in range(len(labels)):
            raise InputError(
                f"composed: 'start' of system variable {name!r} is {entry['start']!r}; allowed: the number of a label, 0 to "
                f"{len(labels) - 1}"
            )
        numbers = {key: float(entry[key]) for key in ("start", "min", "max")}
        found[name] = SystemVariable(name, str(entry.get("unit", "1")), **numbers, labels=tuple(labels))
    missing = next((name for name in needed if name not in found), None)
    if missing is not None:
        raise InputError(
            f"composed: system variable {missing!r} is missing; allowed: an entry in 'system' with {', '.join(keys)}"
        )
    return list(found.values())


def _entries(effect: Effect, stored: object) -> JsonObject:
    if not isinstance(stored, dict):
        raise InputError(
            f"composed: parameters {_value(stored)} of effect {effect.name!r}; allowed: numbers by their names"
        )
    return stored


def _check_names(effect: Effect, values: Iterable[str], known: Iterable[str]) -> None:
    given, names = list(values), list(known)
    more = [f"and {len(names) - _LISTED} more"] if len(names) > _LISTED else []
    allowed = f"allowed: {', '.join([*names[:_LISTED], *more]) or 'none'}"
    unknown = next((name for name in given if name not in names), None)
    if unknown is not None:
        raise InputError(
            f"composed: effect {effect.name!r} has no such parameter as {shown(unknown, 60)!r} here; {allowed}"
        )
    missing = next((name for name in names if name not in given), None)
    if missing is not None:
        raise InputError(
            f"composed: parameter {shown(missing, 60)!r} of effect {effect.name!r} is missing; {allowed}"
        )


def _within(effect: Effect, shape: ShapeParameter, value: object) -> float:
    # What takes its scale from a column may be as large as the column.
    low, high = (v if abs(v) < LARGEST else math.copysign(math.inf, v) for v in (shape.lower, shape.upper))
    # A value at its bound may be off by rounding.
    if not is_number(value) or not low - 1e-9 * abs(low) <= value <= high + 1e-9 * abs(high):
        allowed = f"a number from {shape.lower:g} to {shape.upper:g}{behind(shape.unit)}"
        raise _bad(effect, shape.name, value, allowed)
    return float(value)


def _bad(effect: Effect, name: str, value: object, allowed: str) -> InputError:
    return InputError(
        f"composed: parameter {name!r} of effect {effect.name!r} is {_value(value)}; allowed: {allowed}"
    )


def _value(value: object) -> str:
    return shown(repr(value), 60)
