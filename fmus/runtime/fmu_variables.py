"""Scalar variables of an FMU: elements of FMI 2.0 structured names and of FMI 3.0 arrays."""

from __future__ import annotations

import itertools
import math
import operator
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from friction_models.common import InputError

#: What an input or parameter may start at; a list for the elements of an array.
StartValue: TypeAlias = bool | int | float | str | list[float]
_INDEXED = re.compile(r"^(?P<base>.*)\[(?P<index>\d+)\]$")
#: Most elements of all arrays of one FMU.
MAX_ELEMENTS = 2_000_000

#: FMI 2.0 types; enumerations are exchanged as integers.
_TYPES2 = {
    **{name: (name, f"fmi2{name}") for name in ("Real", "Integer", "Boolean", "String")},
    "Enumeration": ("Enumeration", "fmi2Integer"),
}
#: FMI 3.0 types under the names of FMI 2.0, so that FMUs of both connect.
_TYPES3 = {
    **{name: ("Real", f"fmi3{name}") for name in ("Float64", "Float32")},
    **{f"{u}Int{bits}": ("Integer", f"fmi3{u}Int{bits}") for u in ("", "U") for bits in (8, 16, 32, 64)},
    "Enumeration": ("Enumeration", "fmi3Int64"),
    "Boolean": ("Boolean", "fmi3Boolean"),
    "String": ("String", "fmi3String"),
}


@dataclass(frozen=True)
class Variable:
    """One scalar variable of an FMU, or one element of an array, as far as a master needs it."""

    name: str  #: Full name, ``v_rel[3]`` for an element.
    reference: int  #: Value reference; the elements of an FMI 3.0 array share it.
    #: ``Real``, ``Integer``, ``Enumeration``, ``Boolean``, ``String``, or what else FMI 3.0 calls it.
    type: str
    causality: str
    unit: str
    exchange: str = "fmi2Real"  #: What get and set functions call the type: ``fmi2Real``, ``fmi3Float64``.
    element: int = 0  #: Place in the array.
    starts: tuple[float, ...] = (0.0,)  #: Start values of the whole array; zeros where the FMU gives none.
    variability: str = ""
    point: int = 0  #: The contact point whose instance holds it, where an FMU runs once a point.
    #: Name of the FMI 3.0 array, or of the variable of each instance; empty where that is `name`.
    base: str = ""
    start_text: str | None = None  #: The start value as the FMU declares it; None where it does not.

    @property
    def own(self) -> str:
        """Name of the FMU's own variable, of which this may be an element."""
        return self.base or self.name

    @property
    def is_float64(self) -> bool:
        """Whether its values are float64."""
        return self.exchange in {"fmi2Real", "fmi3Float64"}


def expand(
    file: Path, raw: Any, sizes: Mapping[str, int]
) -> tuple[dict[str, Variable], dict[str, list[Variable]]]:
    """Return the variables by full name and the elements of each structured name in index order.

    `sizes` are values of structural parameters that differ from their start values; `file` is for messages, `raw` fmpy's
    model description.
    Raises InputError: a name that stands twice; more than `MAX_ELEMENTS` elements.
    """
    variables: dict[str, Variable] = {}
    indexed: dict[str, list[tuple[int, Variable]]] = {}
    version3 = raw.fmiVersion != "2.0"
    total = 0
    for item in raw.modelVariables:
        shape = _shape(item, sizes)
        total += math.prod(shape)
        if total > MAX_ELEMENTS:
            raise InputError(
                f"{file}: variable {item.name!r} of shape {shape} makes more than {MAX_ELEMENTS} elements"
            )
        for variable, base, index in _elements(item, shape, version3, sizes):
            if variable.name in variables:
                raise InputError(f"{file}: variable {variable.name!r} stands twice in modelDescription.xml")
            variables[variable.name] = variable
            indexed.setdefault(base, []).append((index, variable))
    arrays = {
        base: [v for _, v in sorted(found, key=operator.itemgetter(0))] for base, found in indexed.items()
    }
    return variables, arrays


def integer_limits(exchange: str) -> tuple[int, int]:
    """Return the least and the greatest whole number of a type; values pass through float64 on their way.

    Examples
    --------
    >>> integer_limits("Int8")
    (-128, 127)
    """
    bits = re.search(r"\d+$", exchange)
    size = int(bits[0]) if bits else 32
    low, high = (0, 2**size - 1) if "UInt" in exchange else (-(2 ** (size - 1)), 2 ** (size - 1) - 1)
    return max(low, -(2**53)), min(high, 2**53)


def sizing_parameter(item: Any) -> str | None:
    """Return the structural parameter that alone gives the length of an FMI 3.0 vector, or None."""
    if len(item.dimensions) != 1 or item.dimensions[0].variable is None:
        return None
    parameter = item.dimensions[0].variable
    return str(parameter.name) if parameter.causality == "structuralParameter" else None


def _shape(item: Any, sizes: Mapping[str, int]) -> tuple[int, ...]:
    """Return the dimensions of a variable: fixed ones, and those that structural parameters give."""
    lengths = (
        d.start if d.variable is None else sizes.get(d.variable.name, d.variable.start)
        for d in item.dimensions
    )
    return tuple(max(0, int(length)) for length in lengths)


def _elements(
    item: Any, shape: tuple[int, ...], version3: bool, sizes: Mapping[str, int]
) -> list[tuple[Variable, str, int]]:
    declared = item.declaredType
    unit = item.unit or (declared.unit if declared is not None else None) or ""
    types = _TYPES3 if version3 else _TYPES2
    kind, exchange = types.get(item.type, (item.type, ""))
    count = math.prod(shape)
    starts = (float(sizes[item.name]),) if item.name in sizes else _starts(item.start, count)

    def variable(name: str, element: int) -> Variable:
        return Variable(
            name,
            int(item.valueReference),
            kind,
            item.causality or "local",
            unit,
            exchange,
            element,
            starts,
            item.variability or "",
            base=item.name if shape else "",
            start_text=None if item.start is None else " ".join(f"{item.start} {unit}".split())[:60],
        )

    if count == 1:  # a vector of one has the name of a scalar: the same file serves as a scalar FMU
        match = _INDEXED.match(item.name)
        base, index = (match["base"], int(match["index"])) if match else (item.name, 0)
        return [(variable(item.name, 0), base, index)]
    places = itertools.product(*(range(1, n + 1) for n in shape))
    return [
        (variable(f"{item.name}[{','.join(map(str, place))}]", k), item.name, k)
        for k, place in enumerate(places)
    ]


def _starts(text: Any, count: int) -> tuple[float, ...]:
    """Return start values for a port's buffers; one value serves all elements."""
    values = []
    for word in str(text or "").split():
        try:
            values.append(float({"true": 1, "false": 0}.get(word, word)))
        except ValueError:
            return (0.0,) * count
    if len(values) == count:
        return tuple(values)
    return (values[0] if values else 0.0,) * count
