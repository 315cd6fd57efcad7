"""How the five loads enter a foreign graph, and which output is mu."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from friction_models.common import InputError, unknown_name
from friction_models.loads import LOAD_NAMES, LOADS

from ..interface.quantities import load_conversion
from .operators.nodes import Array
from .reading import ForeignInput
from .spec import LoadEntry, Spec


@dataclass(frozen=True)
class Feed:
    """One input of the graph at one point: the loads that fill its columns.

    Examples
    --------
    Temperature goes in as kelvin:

    >>> feed = Feed("x", "float64", (1, 2), True, loads=(1, 2), factor=(1.0, 1.0), offset=(273.15, 0.0))
    >>> feed.fill(np.array([[20.0, 80.0, 600.0, 0.0, 1.0]]))
    array([[353.15, 600.  ]])
    """

    name: str  #: As in the graph.
    kind: str  #: ``float32``, ``float64`` or ``int64``.
    shape: tuple[int, ...]  #: Dimensions at one contact point, for example ``(1, 5)``.
    batch: bool  #: Whether the first dimension is free, so that n points are one call.
    loads: tuple[int, ...]  #: Index in the contract of the load in each column.
    factor: tuple[float, ...]  #: By column: the graph sees ``factor * load + offset``.
    offset: tuple[float, ...]

    def fill(self, points: Array) -> Array:
        """Return what this input is given at loads of shape (n, 5); n is 1 unless `batch`."""
        values = points[:, list(self.loads)] * np.array(self.factor) + np.array(self.offset)
        shape = (len(points), *self.shape[1:]) if self.batch else self.shape
        return np.ascontiguousarray(values.reshape(shape).astype(self.kind))


@dataclass(frozen=True)
class Signature:
    """Inputs, output and the scaling of mu: ``mu = multiply * value + add``."""

    feeds: tuple[Feed, ...]
    output: str
    multiply: float = 1.0
    add: float = 0.0

    @property
    def batch(self) -> bool:
        """Whether many points are one call of the graph."""
        return all(f.batch for f in self.feeds)

    def to_dict(self) -> dict[str, object]:
        """Return plain data, for the Python FMU."""
        inputs = [asdict(feed) for feed in self.feeds]
        return {"inputs": inputs, "output": self.output, "multiply": self.multiply, "add": self.add}

    @classmethod
    def from_dict(cls, entry: Mapping[str, Any]) -> Signature:
        """Build from what `to_dict` returned, also after its way through JSON."""
        feeds: Any = [
            {k: tuple(v) if isinstance(v, list) else v for k, v in f.items()} for f in entry["inputs"]
        ]
        return cls(tuple(Feed(**f) for f in feeds), entry["output"], entry["multiply"], entry["add"])


def choose_output(outputs: list[str], spec: Spec, where: str) -> str:
    """Return the output that is mu: the one named in the YAML, the only one, or the one called mu.

    Raises InputError: no such output, or several to choose from.

    Examples
    --------
    >>> choose_output(["mu", "margin"], Spec(), "law.onnx")
    'mu'
    """
    if spec.output.name is not None:
        if spec.output.name not in outputs:
            raise unknown_name("output", spec.output.name, outputs, where)
        return spec.output.name
    if len(outputs) == 1:
        return outputs[0]
    if "mu" in outputs:
        return "mu"
    raise InputError(
        f"{where}: the graph has outputs {', '.join(outputs)[:200]}; allowed: one, one named 'mu', or the name of "
        "one in the YAML (output: {name: ...})"
    )


def read_signature(inputs: list[ForeignInput], output: str, spec: Spec, where: str) -> Signature:
    """Return which load goes where.

    Without a YAML: inputs that are called like the loads take these, otherwise the five columns (or the
    five inputs) are the loads in the order of the contract.
    Raises InputError: inputs of another form, more or fewer columns than loads, a column fed twice or never, a unit that does
    not measure its load.
    """
    widths = {i.name: _width(i, len(inputs), spec, where) for i in inputs}
    # Sizes are looked at before anything of that size is made.
    total = sum(widths.values()) if len(inputs) <= len(LOADS) else 0
    slots = [(n, j) for n, w in widths.items() for j in range(w)] if 1 <= total <= len(LOADS) else []
    if not slots:
        shown = ", ".join(f"{i.name:.60} {_shown(i)}" for i in inputs[:9])[:200] or "none"
        raise InputError(
            f"{where}: the graph has inputs {shown}; allowed: {len(LOADS)} columns or inputs, or fewer that a YAML names"
        )
    filled = _fill(inputs, slots, spec, where)
    feeds = []
    for i in inputs:
        own = [filled[slot] for slot in slots if slot[0] == i.name]
        scales = [_scale(name, spec.inputs.get(name, LoadEntry()), where) for name in own]
        shape, batch = _at_one_point(i, len(own))
        feeds.append(
            Feed(
                i.name,
                i.kind,
                shape,
                batch,
                tuple(LOAD_NAMES.index(n) for n in own),
                tuple(s[0] for s in scales),
                tuple(s[1] for s in scales),
            )
        )
    return Signature(tuple(feeds), output, spec.output.multiply, spec.output.add)


def _shown(i: ForeignInput) -> str:
    return "of any shape" if i.shape is None else str(["n" if d is None else d for d in i.shape])


def _width(i: ForeignInput, count: int, spec: Spec, where: str) -> int:
    """Return the number of columns of an input."""
    shape = i.shape
    if i.kind == "bool":
        raise InputError(f"{where}: input {i.name!r} is Boolean; allowed: float or double")
    free = 1 if count > 1 else len(LOADS)
    if spec.inputs and count == 1:
        columns = [e.column for e in spec.inputs.values() if e.column is not None]
        if len(columns) == len(spec.inputs):
            free = max(columns) + 1
    if shape is None:
        return free
    if len(shape) == 0 or shape in {(None,), (1,)}:
        return 1
    if len(shape) == 1:
        return int(shape[0] or 1)
    if len(shape) == 2 and shape[0] in {None, 1}:
        return free if shape[1] is None else int(shape[1])
    raise InputError(
        f"{where}: input {i.name!r} has shape {_shown(i)}; allowed: [n, {len(LOADS)}], [1, {len(LOADS)}] or "
        f"{len(LOADS)} inputs [n, 1], [n] or scalars"
    )


def _at_one_point(i: ForeignInput, width: int) -> tuple[tuple[int, ...], bool]:
    shape = i.shape
    if shape is None:
        return (1, width), True
    if len(shape) == 2:
        return (1, width), shape[0] is None
    return (width,) * len(shape), shape == (None,)


def _fill(
    inputs: list[ForeignInput], slots: list[tuple[str, int]], spec: Spec, where: str
) -> dict[tuple[str, int], str]:
    """Return the load in each column."""
    names = [i.name for i in inputs]
    single = {name: (name, 0) for name in names if name in LOAD_NAMES and (name, 1) not in slots}
    named = len(single) == len(slots)
    whole = len(slots) == len(LOADS)
    filled: dict[tuple[str, int], str] = {}
    if not whole and not spec.inputs and not named:
        raise InputError(
            f"{where}: the graph has {len(slots)} columns, allowed: {len(LOADS)} = {', '.join(LOAD_NAMES)}, or a YAML "
            "(--spec) that names the load of each"
        )
    wanted = [n for n in LOAD_NAMES if n in spec.inputs or whole or n in single]
    for name in wanted:
        entry = spec.inputs.get(name, LoadEntry())
        slot = _slot(name, entry, single, slots, names, whole, where)
        if slot in filled:
            raise InputError(
                f"{where}: column {slot[1]} of input {slot[0]!r} is given to {filled[slot]!r} and {name!r}; allowed: one load"
            )
        filled[slot] = name
    empty = [s for s in slots if s not in filled]
    if empty:
        raise InputError(
            f"{where}: column {empty[0][1]} of input {empty[0][0]!r} gets no load; allowed: every column one of {', '.join(LOAD_NAMES)}"
        )
    return filled


def _slot(
    name: str,
    entry: LoadEntry,
    single: dict[str, tuple[str, int]],
    slots: list[tuple[str, int]],
    names: list[str],
    whole: bool,
    where: str,
) -> tuple[str, int]:
    if entry.input is not None and entry.input not in names:
        raise unknown_name(f"input of the graph for {name!r}", entry.input, names, where)
    if entry.input is None and entry.column is None:
        if name in single:
            return single[name]
        if not whole:
            raise InputError(
                f"{where}: {name!r} has no place; allowed: a column or an input of the graph ({', '.join(names)[:200]})"
            )
        return slots[LOAD_NAMES.index(name)]
    if entry.input is None and len(names) > 1 and len(slots) == len(names):
        slot = slots[min(entry.column or 0, len(slots) - 1)]  # inputs of one column each, counted
        return slot if (entry.column or 0) < len(slots) else ("", -1)
    slot = (entry.input or names[0], entry.column or 0)
    if slot not in slots:
        last = max(j for i, j in slots if i == slot[0])
        raise InputError(f"{where}: {name!r} in column {slot[1]} of input {slot[0]!r}, allowed: 0 to {last}")
    return slot


def _scale(name: str, entry: LoadEntry, where: str) -> tuple[float, float]:
    """Return (factor, offset) from the load in the contract's unit to what the graph sees."""
    unit = LOADS[LOAD_NAMES.index(name)].unit if entry.unit is None else entry.unit
    factor, offset = load_conversion(name, unit, where)
    return factor / entry.divide, (offset - entry.subtract) / entry.divide


def domain_of(spec: Spec, where: str) -> dict[str, tuple[float, float]]:
    """Return the trained domain in the contract's units, all five loads; empty where no range is given.

    A load without a range is limited by physics only.
    Raises InputError: a range outside the physical limits; both are named in the unit of the YAML.
    """
    if all(e.range is None for e in spec.inputs.values()):
        return {}
    domain = {}
    for q in LOADS:
        entry = spec.inputs.get(q.name, LoadEntry())
        if entry.range is None:
            domain[q.name] = (q.lower, q.upper)
            continue
        factor, offset = load_conversion(q.name, entry.unit or q.unit, where)
        low, high = ((x - offset) / factor for x in entry.range)
        slack = 1e-9 * max(abs(q.lower), 1.0)
        if not q.lower - slack <= low <= high <= q.upper * (1.0 + 1e-9):
            limits = [factor * x + offset for x in (q.lower, q.upper)]
            raise InputError(
                f"{where}: range of {q.name!r} is {entry.range[0]:g} to {entry.range[1]:g} {entry.unit or q.unit}, "
                f"allowed: within {limits[0]:g} to {limits[1]:g}"
            )
        domain[q.name] = (max(low, q.lower), min(high, q.upper))
    return domain
