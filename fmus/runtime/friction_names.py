"""Variable names and units of friction FMUs that other generators made."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

from friction_models.common import InputError, unknown_name
from friction_models.common.yaml_files import read_yaml
from friction_models.loads import LOAD_NAMES, LOADS, MU

from ..interface.quantities import load_conversion
from .fmu_files import FmuDescription
from .fmu_variables import StartValue

#: A file of names is a page of text.
_MAX_BYTES = 200_000
#: Python types of the values that a variable of an FMU may be set to, where it is no floating-point number.
_VALUES: dict[str, tuple[tuple[type, ...], str]] = {
    "Boolean": ((bool,), "true or false"),
    "Integer": ((int,), "a whole number"),
    "Enumeration": ((int,), "a whole number"),
    "String": ((str,), "a text"),
}
#: An entry of a file of names: a variable, or its parts and unit, by load and for mu; values by name under ``set``.
Entry: TypeAlias = Mapping[str, str | Mapping[str, StartValue]]
#: What the entry of a load may hold.
_KEYS = ("variable", "unit")


@dataclass(frozen=True)
class FrictionNames:
    """Variables of a friction FMU; those of the contract by default.

    Examples
    --------
    >>> names = FrictionNames({"T": ("T_contact", "K"), "v_rel": ("speed", "")}, mu="f")
    >>> list(names.targets())
    [('T', 'T_contact [K]'), ('v_rel', 'speed')]
    >>> FrictionNames.from_dict(names.to_dict()) == names
    True
    """

    #: By load: variable, and the unit that it expects (empty: the contract's). Loads that are not named do not enter the FMU.
    loads: Mapping[str, tuple[str, str]] = field(default_factory=lambda: {n: (n, "") for n in LOAD_NAMES})
    mu: str = MU.name  #: The output.
    #: Start values of other inputs and of parameters.
    start: Mapping[str, StartValue] = field(default_factory=dict)
    #: Whether the FMU is for one contact point, so that many points take many instances.
    each_point: bool = False
    #: Whether it says by ``domain_distance`` how far a point is outside its trained domain.
    has_distance: bool = True

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> FrictionNames:
        """Build from what `to_dict` returned."""
        loads = {str(k): (str(v[0]), str(v[1])) for k, v in content["loads"].items()}
        return cls(**{**content, "loads": loads})

    def to_dict(self) -> dict[str, object]:
        """Return JSON-able data."""
        return asdict(self) | {"loads": {k: list(v) for k, v in self.loads.items()}}

    def targets(self) -> Iterator[tuple[str, str]]:
        """Return each load and the end of its connection, ``T_contact [K]`` with another unit."""
        for load, (variable, unit) in self.loads.items():
            yield load, f"{variable} [{unit}]" if unit else variable

    @classmethod
    def of(cls, description: FmuDescription, entry: Entry) -> FrictionNames:
        """Resolve an entry of a file of names against an FMU.

        By load and for ``mu`` it holds a variable, or ``{variable: ..., unit: ...}``; under ``set`` values of other inputs and
        parameters. A load without an entry takes the variable of its own name, if there is one.
        Raises InputError: unknown keys, variables or units; a variable that is no input or output; another input whose start
        value in the FMU is not finite. One without a start value starts at 0.
        """
        where = str(description.path)
        for key in entry:
            if key not in (*LOAD_NAMES, MU.name, "set"):
                raise unknown_name("key", str(key), (*LOAD_NAMES, MU.name, "set"), where)
        loads: dict[str, tuple[str, str]] = {}
        lengths: set[int] = set()
        for load in LOADS:
            if load.name not in entry and load.name not in description.arrays:
                continue
            name, unit = _named(entry.get(load.name, load.name), load.name, where)
            elements = description.resolve(name, f"input for {load.name!r}", "input")
            if elements[0].causality != "input":
                raise InputError(
                    f"{where}: {name!r} is of causality {elements[0].causality!r}, allowed: input"
                )
            twice = [other for other, (taken, _) in loads.items() if taken == name]
            if twice:
                raise InputError(
                    f"{where}: {name!r} takes {twice[0]!r} and {load.name!r}; allowed: a variable of its own for each load"
                )
            declared = "" if elements[0].unit == "-" else elements[0].unit
            factors = [load_conversion(load.name, u, where) for u in (unit, declared) if u]
            if len(set(factors)) > 1:
                raise InputError(
                    f"{where}: {name!r} is in {declared!r}, not in {unit!r}; allowed: {declared!r}"
                )
            unit = "" if not factors or factors[0] == (1.0, 0.0) else declared or unit
            loads[load.name] = (name, unit)
            lengths.add(len(elements))
        name, unit = _named(entry.get(MU.name, MU.name), MU.name, where)
        elements = description.resolve(name, "output for 'mu'", "output")
        if elements[0].causality != "output" or unit not in {"", "1", "-"}:
            raise InputError(f"{where}: {name!r} cannot be mu; allowed: an output without a unit")
        if len(lengths | {len(elements)}) > 1:
            raise InputError(
                f"{where}: the loads have {sorted(lengths)} elements and mu {len(elements)}; allowed: equally many"
            )
        start = _start(description, entry.get("set", {}), {v for v, _ in loads.values()})
        distance = "domain_distance" in description.arrays
        return cls(loads, name, start, len(elements) == 1 and not description.sizing(name), distance)


def read_names(path: Path) -> dict[str, Entry]:
    """Read a file of names: a mapping from each FMU (as it is called on the command line, or its file name) to its entry.

    Raises InputError: no such file, too large, not YAML, or not a mapping of mappings.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     file = Path(place) / "names.yaml"
    ...     _ = file.write_text("{other.fmu: {mu: f, T: {variable: T_contact, unit: K}}}")
    ...     read_names(file)
    {'other.fmu': {'mu': 'f', 'T': {'variable': 'T_contact', 'unit': 'K'}}}
    """
    content = read_yaml(path, _MAX_BYTES, "a YAML file with the variables of each FMU")
    if not isinstance(content, dict) or not content:
        raise InputError(f"{path}: not a mapping; allowed: for each FMU its variables by load")
    for fmu, entry in content.items():
        if not isinstance(entry, dict):
            raise InputError(
                f"{path}: {str(fmu)[:60]!r} is no mapping; allowed: variables by load, mu and set"
            )
    return {str(fmu): dict(entry) for fmu, entry in content.items()}


def entries_by_model(models: Sequence[str], names: Path) -> dict[str, Entry]:
    """Return the entries of a file of names by the models of a command line.

    Raises InputError: what `read_names` refuses, an entry for no FMU among the models or for several, two for one.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     file = Path(place) / "names.yaml"
    ...     _ = file.write_text("{other.fmu: {mu: f}}")
    ...     entries_by_model(["0.08", "models/other.fmu"], file)
    {'models/other.fmu': {'mu': 'f'}}
    """
    found: dict[str, Entry] = {}
    aliases = {n: (n, Path(n).name, Path(n).stem) for n in models if Path(n).suffix == ".fmu"}
    for key, entry in read_names(names).items():
        meant = [key] if key in aliases else [n for n, several in aliases.items() if key in several]
        if not meant:
            if not aliases:
                raise InputError(f"{names}: there is no FMU among the models; allowed: with one at least")
            known = dict.fromkeys(alias for several in aliases.values() for alias in several)
            raise unknown_name("FMU among the models", key, known, str(names))
        if len(meant) > 1:
            raise InputError(
                f"{names}: {key!r} may be {' or '.join(meant)}; allowed: the path as on the command line"
            )
        if meant[0] in found:
            raise InputError(f"{names}: {meant[0]} has two entries; allowed: one for each FMU")
        found[meant[0]] = entry
    return found


def _named(value: Any, load: str, where: str) -> tuple[str, str]:
    if isinstance(value, str) and value.strip():
        return value.strip(), ""
    if isinstance(value, dict):
        for key in value:
            if key not in _KEYS:
                raise unknown_name("key", str(key), _KEYS, f"{where}: {load}")
        if isinstance(value.get("variable"), str):
            return value["variable"].strip(), str(value.get("unit", "")).strip()
    raise InputError(
        f"{where}: {load}: {str(value)[:60]!r}, allowed: a variable, or {{variable: ..., unit: ...}}"
    )


def _start(description: FmuDescription, given: Any, used: set[str]) -> dict[str, StartValue]:
    """Return values of all inputs that no load feeds: those given, or the FMU's own start values."""
    where = str(description.path)
    if not isinstance(given, dict):
        raise InputError(
            f"{where}: set: {str(given)[:60]!r}, allowed: values of inputs and parameters by name"
        )
    start: dict[str, StartValue] = {}
    free = [
        name
        for name, elements in description.arrays.items()
        if elements[0].causality in {"input", "parameter"} and name not in used
    ]
    for key, value in given.items():
        if str(key) not in free:
            raise unknown_name("free input or parameter", str(key), free, f"{where}: set")
        kind = description.arrays[str(key)][0].type
        types, allowed = _VALUES.get(kind, ((int, float), "a finite number"))
        if not isinstance(value, types) or (isinstance(value, bool) and bool not in types):
            raise InputError(f"{where}: set: {key!r} = {str(value)[:60]!r}, allowed: {allowed}")
        if isinstance(value, float) and not math.isfinite(value):
            raise InputError(f"{where}: set: {key!r} = {value!r}, allowed: {allowed}")
        start[str(key)] = given[key]
    for base, elements in description.arrays.items():
        first = elements[0]
        if first.causality != "input" or base in used or base in start or first.type == "String":
            continue
        values = [v.starts[v.element] for v in elements]
        if not all(map(math.isfinite, values)):
            raise InputError(
                f"{where}: {base!r} starts at {values[0]}; allowed: a finite number (give one by set)"
            )
        kinds: dict[str, type[bool | int | float]] = {"Boolean": bool, "Integer": int, "Enumeration": int}
        whole = kinds.get(first.type, float)
        start[base] = whole(values[0]) if len(set(values)) == 1 else values
    return start
