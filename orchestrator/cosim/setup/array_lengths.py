"""Lengths of FMI 3.0 arrays: structural parameters take the length of what feeds the arrays they size."""

from __future__ import annotations

import re

from fmus.runtime.fmu_files import FmuDescription
from friction_models.common import InputError

from .connections import split_connection
from .description import SystemDescription

_INDEXED = re.compile(r"^(?P<base>.*)\[(?P<index>\d{1,9})\]$")


def size_arrays(
    system: SystemDescription, descriptions: dict[str, FmuDescription], problems: list[str]
) -> dict[str, int]:
    """Give the arrays of FMI 3.0 components their lengths; return the length by component that was sized here.

    A start value of the structural parameter decides; otherwise the length of what the array is connected
    to. So an FMI 3.0 friction FMU takes the place of an FMI 2.0 one without a change of the system. Sized descriptions
    replace the others; `problems` receives what is wrong.
    """
    sizes: dict[str, int] = {}
    for name, description in list(descriptions.items()):
        if description.version == "2.0":
            continue
        chosen = {k: v for k, v in system.components[name].start.items() if k in description.structure}
        wrong = [k for k, v in chosen.items() if isinstance(v, bool) or not isinstance(v, int)]
        if wrong:
            problems.append(
                f"component {name!r}: structural parameter {wrong[0]!r} = {chosen[wrong[0]]!r}, allowed: a whole number"
            )
        elif chosen:
            _resize(descriptions, name, {k: int(v) for k, v in chosen.items()}, problems)  # type: ignore[arg-type]
    pairs = [split_connection(c) for c in system.connections]
    ends = [pair[:2] for pair in pairs if pair is not None]
    # A length may pass through several components: each pass can settle one more.
    for _ in descriptions:
        before = dict(sizes)
        for left, right in ends:
            for end, other in ((left, right), (right, left)):
                _fit(descriptions, end, _length(descriptions, other), sizes, problems)
        for end in (end for pair in ends for end in pair):
            match = _INDEXED.match(end)
            if match and int(match["index"]) > 1:
                _fit(descriptions, match["base"], int(match["index"]), sizes, problems)
        if sizes == before:
            break
    return sizes


def _length(descriptions: dict[str, FmuDescription], end: str) -> int:
    component, _, name = end.partition(".")
    if component not in descriptions:
        return 0
    description = descriptions[component]
    return len(description.arrays.get(name, ())) or int(name in description.variables)


def _fit(
    descriptions: dict[str, FmuDescription], end: str, length: int, sizes: dict[str, int], problems: list[str]
) -> None:
    """Size the array `end` if its length is open; the longest of what is connected decides."""
    component, _, name = end.partition(".")
    if component not in descriptions or not length or length <= sizes.get(component, 0):
        return
    description = descriptions[component]
    parameter = description.sizing(name)
    if parameter is None or length == len(description.arrays[name]):
        return
    if component not in sizes and parameter in description.sizes:
        return  # a start value says it
    if _resize(descriptions, component, {parameter: length}, problems):
        sizes[component] = length


def _resize(
    descriptions: dict[str, FmuDescription], name: str, sizes: dict[str, int], problems: list[str]
) -> bool:
    try:
        descriptions[name] = descriptions[name].sized(sizes)
    except InputError as error:
        if str(error) not in problems:
            problems.append(str(error))
        return False
    return True
