"""Parameters of a process as its class declares them: meaning, unit, range and default, for forms and for FMUs."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from friction_models.common import unknown_name

from .names import PROCESSES

#: Parameters that are the name or the file of a material.
MATERIALS = ("material", "tool_material")


@dataclass(frozen=True)
class Parameter:
    """One parameter of a process.

    Attributes
    ----------
    name, unit, meaning : str
        `unit` is empty for what has none; `meaning` is what the documentation of the class says.
    kind : str
        ``"number"``, ``"count"``, ``"switch"``, ``"material"``, or ``"ejection"`` for a number of the ejection alone.
    default : float, int, bool, str or None
        None: it may be left out.
    low, high : float or None
        What is allowed; None where nothing is known before it is given.

    Examples
    --------
    >>> angle = declared("fre")["half_angle"]
    >>> angle.kind, angle.unit, angle.default, angle.low, angle.high
    ('number', 'degrees', 45.0, 10.0, 80.0)
    """

    name: str
    kind: str
    default: float | int | bool | str | None
    unit: str = ""
    meaning: str = ""
    low: float | None = None
    high: float | None = None


def declared(process: str, values: Mapping[str, Any] | None = None) -> dict[str, Parameter]:
    """Return the parameters of a process, by name; some ranges depend on other parameters, whose `values` may be given.

    Raises
    ------
    InputError
        No such process or parameter, or a value that the process refuses.

    Examples
    --------
    >>> declared("fre")["exit_diameter"].high, declared("fre", {"diameter": 40.0})["exit_diameter"].high
    (19.4, 38.8)
    """
    if process not in PROCESSES:
        raise unknown_name("forming process", process, PROCESSES)
    solver: Any = PROCESSES[process]
    known, told = constructor_parameters(solver), meanings(solver)
    for name in values or {}:
        if name not in known:
            raise unknown_name(f"parameter of the forming process {process!r}", name, known)
    made = solver(**(values or {}))
    return {
        name: Parameter(
            name,
            _kind(name, parameter.default, made.units),
            None if parameter.default is inspect.Parameter.empty else parameter.default,
            made.units.get(name, ""),
            told.get(name, ""),
            *made.ranges.get(name, (None, None)),
        )
        for name, parameter in known.items()
    }


def _kind(name: str, default: object, units: Mapping[str, str]) -> str:
    if name in MATERIALS:
        return "material"
    if isinstance(default, bool):
        return "switch"
    if isinstance(default, int):
        return "count"
    return "number" if name in units else "ejection"


def constructor_parameters(kind: type) -> dict[str, inspect.Parameter]:
    """Return the parameters of a constructor, with those of the class above where it passes them on."""
    found: dict[str, inspect.Parameter] = {}
    for each in kind.__mro__:
        if "__init__" not in vars(each):
            continue
        own = inspect.signature(each).parameters
        passes_on = [p for p in own.values() if p.kind is p.VAR_KEYWORD]
        new = {name: p for name, p in own.items() if name not in found and p not in passes_on}
        found = found | {name: p for name, p in new.items() if name != "self"}
        if not passes_on:
            break
    return found


def meanings(kind: type) -> dict[str, str]:
    """Return what the class documentation (numpydoc) says of each parameter, in one line."""
    found: dict[str, str] = {}
    for each in kind.__mro__:
        text = inspect.cleandoc(vars(each).get("__doc__") or "").partition("Parameters\n-")[2]
        names: list[str] = []
        for line in text.partition("\n\n")[0].splitlines()[1:]:
            if not line.startswith(" "):
                names = [name.strip() for name in line.partition(" : ")[0].split(",")]
                names = [name for name in names if name not in found]
            for name in names if line.startswith(" ") else ():
                found[name] = f"{found.get(name, '')} {line.strip()}".strip()
    return found
