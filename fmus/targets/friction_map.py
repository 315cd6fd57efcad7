"""``--target map``: a friction model as a map over a few loads, whose sampling points and values are parameters of the FMU.

The map is a friction model of its own, with an ONNX graph: everything that holds for friction FMUs holds for it, derivatives
with respect to the values of the map, too.
"""

from __future__ import annotations

import functools
import hashlib
import json
import operator
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from friction_models.common import InputError
from friction_models.expressions.onnx_graph import GraphBuilder, OnnxOps
from friction_models.loads import LOAD_NAMES, MU, QUANTITIES

from ..exports import options
from ..exports.common import Reference
from ..exports.numbers.deviation import deviation, held_system
from ..exports.numbers.table_target import FrictionTable, tabulate
from ..interface.friction_source import FrictionSource, parse_source
from ..interface.ls_struct import VALUES, axis_name

if TYPE_CHECKING:
    from friction_models.expressions.onnx_graph import Node

#: Most axes: tools for calibration show curves, maps and cuboids.
MAX_AXES = 3
#: Most values of a map: each is a parameter, and takes part in every evaluation.
MAX_VALUES = 4096
#: Points at which the influence of the loads is compared.
_COMPARED = 200


def friction_map(
    source: FrictionSource,
    axes: str | Sequence[str] | None = None,
    limits: Mapping[str, Sequence[float]] | None = None,
    tolerance: float = 1e-3,
    max_rows: int = 512,
    **given: Any,
) -> FrictionSource:
    """Return a friction model that interpolates mu linearly on a grid of one to three loads.

    Beyond its outer sampling points the map keeps their values. Its `note` says how far it is from the model at points of the
    trained domain.
    Raises InputError: what `tabulate` refuses; more than three axes; a load without a range.

    Parameters
    ----------
    source : FrictionSource
        The model that the map is taken from.
    axes : sequence of str, optional
        Loads that the map goes over; by default those that change mu by more than `tolerance`, at most three.
    max_rows : int
        Most values of the map.
    limits, tolerance, **given
        As of `fmus.exports.numbers.table_target.tabulate`.

    Examples
    --------
    >>> from fmus.source.reading import read_source
    >>> from friction_models import ConstantFriction
    >>> law = read_source(ConstantFriction(mu=0.1))
    >>> found = friction_map(law, axes="T", limits={"T": (20.0, 200.0)}, points={"T": 3})
    >>> [p.name for p in found.system][:4]
    ['T_axis[1]', 'T_axis[2]', 'T_axis[3]', 'mu_map[1]']
    """
    chosen = _strongest(source, limits, tolerance) if axes is None else options.axis_names(axes)
    if len(chosen) > MAX_AXES:
        raise InputError(f"axes = {','.join(chosen)}: {len(chosen)} loads, allowed: at most {MAX_AXES}")
    table = tabulate(
        source,
        axes=chosen,
        limits=limits,
        tolerance=tolerance,
        max_rows=options.whole("max_rows", max_rows, 2 ** len(chosen), MAX_VALUES),
        **given,
    )
    for name, lines in table.axes.items():
        if len(lines) < 2:
            raise InputError(
                f"{source.where}: {name!r} has the one value {lines[0]:g} in training, allowed: a load with a range, or limits of {name!r}"
            )
    if table.mu.size > MAX_VALUES:
        shape = " x ".join(str(len(x)) for x in table.axes.values())
        raise InputError(f"points: a map of {shape} values, allowed: at most {MAX_VALUES}")
    return _described(source, table)


def _strongest(source: FrictionSource, limits: object, tolerance: object) -> list[str]:
    """Return the loads that change mu most over their trained range, in the order of the contract."""
    given = options.mapping("limits", limits, LOAD_NAMES)
    ranges = {n: options.limits(n, v) for n, v in given.items()} or source.domain
    ranges = {n: box for n, box in ranges.items() if box[1] > box[0]}
    if not ranges:
        raise InputError(
            f"{source.where}: no trained range is recorded; allowed: give axes, and limits of each of them"
        )
    reference, rng = Reference(source), np.random.default_rng(33)
    starts = {n: source.interface(1).start(QUANTITIES[n]) for n in LOAD_NAMES}
    boxes = [source.domain.get(n, ranges.get(n, (starts[n], starts[n]))) for n in LOAD_NAMES]
    lower, upper = np.array(boxes).T
    loads = rng.uniform(lower, upper, size=(_COMPARED, len(LOAD_NAMES)))
    changes = {}
    for name, (first, last) in ranges.items():
        moved = []
        for value in np.linspace(first, last, 9):
            at = loads.copy()
            at[:, LOAD_NAMES.index(name)] = value
            moved.append(reference.mu(at))
        changes[name] = float(np.ptp(moved, axis=0).max())
    least = options.number("tolerance", tolerance, 1e-9, 1.0)
    order = sorted(changes, key=lambda n: changes[n], reverse=True)
    kept = [n for n in order[:MAX_AXES] if changes[n] > least] or order[:1]
    return [n for n in LOAD_NAMES if n in kept]


def _described(source: FrictionSource, table: FrictionTable) -> FrictionSource:
    """Return the map with its metadata, and its distance from the model."""
    axes = list(table.axes)
    domain: dict[str, list[float] | None] = {n: list(box) for n, box in source.domain.items()}
    for name, lines in table.axes.items():
        if name in source.domain:  # a narrower map has a narrower domain
            lower, upper = source.domain[name]
            domain[name] = [max(lower, float(lines[0])), min(upper, float(lines[-1]))]
    metadata: dict[str, object] = {
        "tribofmu.model": {
            "family": "map",
            "name": f"map of {source.name}",
            "formula": f"mu = {VALUES}({', '.join(axes)}), linear between the sampling points; taken from: {source.formula or source.name}",
        },
        "tribofmu.system": _entries(table),
    }
    if domain:
        metadata["tribofmu.domain"] = domain | dict.fromkeys(source.absent)
    drawn = _graph(table)
    bare = parse_source(drawn.build(metadata).SerializeToString(deterministic=True), source.where)
    found = deviation(source, Reference(bare).mu, table.system)
    shape = " x ".join(f"{len(x)} {n}" for n, x in table.axes.items())
    summary = f"map of {table.mu.size} values ({shape}), off by at most {found.text()}"
    held = [text for text, name in zip(table.held(), table.fixed) if table.left_out[name] > 1e-12]
    held += held_system(source, table.system)
    metadata["tribofmu.card"] = source.card | {
        "map": {
            "of": {
                "family": source.family,
                "name": source.name,
                "onnx_sha256": hashlib.sha256(source.original or source.onnx).hexdigest(),
            },
            "axes": {n: x.tolist() for n, x in table.axes.items()},
            "held": held,
            "summary": summary,
            "remaining": found.report(),
        }
    }
    content = drawn.build(json.loads(json.dumps(metadata))).SerializeToString(deterministic=True)
    return replace(parse_source(content, source.where), note="\n".join([summary, *held]))


def _entries(table: FrictionTable) -> list[dict[str, object]]:
    """Return the system variables of the map: the sampling points of each axis, then the values."""
    entries: list[dict[str, object]] = []
    for name, lines in table.axes.items():
        about = f"sampling points of {name} of the friction map; they rise"
        entries += [
            {"name": f"{axis_name(name)}[{k}]", "unit": QUANTITIES[name].unit, "start": x, "meaning": about}
            for k, x in enumerate(lines.tolist(), 1)
        ]
    about = f"mu at the sampling points of {', '.join(table.axes)}"
    for place, value in np.ndenumerate(table.mu):
        name = f"{VALUES}[{','.join(str(k + 1) for k in place)}]"
        entries.append({"name": name, "unit": MU.unit, "start": float(value), "min": 0.0, "meaning": about})
    return entries


def _graph(table: FrictionTable) -> GraphBuilder:
    """Return the graph of the map; sampling points and values are its input `system`.

    With f_k the way from sampling point k to the next one, held between 0 and 1, the weight of point k is f_(k-1) - f_k.
    """
    graph = GraphBuilder("friction")
    x = OnnxOps(graph)
    loads = graph.input("loads", ["n", len(LOAD_NAMES)])
    total = sum(len(lines) for lines in table.axes.values())
    system = graph.input("system", [1, total + table.mu.size])

    def part(value: Node, first: int, count: int) -> Node:
        ends = (graph.constant([k], np.int64) for k in (first, first + count, 1))
        return graph.op("Slice", value, *ends)

    weights = []
    offset = 0
    for name, lines in table.axes.items():
        count = len(lines)
        lower = part(system, offset, count - 1)
        width = part(system, offset + 1, count - 1) - lower
        way = (x.column(loads, LOAD_NAMES.index(name)) - lower) / width
        way = graph.op("Clip", way, 0.0, 1.0)
        between = [part(way, 0, count - 2) - part(way, 1, count - 2)] if count > 2 else []
        weights.append(x.concat([1.0 - part(way, 0, 1), *between, part(way, count - 2, 1)]))
        offset += count

    values, size = part(system, total, table.mu.size), table.mu.size
    # Axis after axis from the first on: few long statements compile much faster than many short ones.
    for weight, count in zip(weights[:-1], table.mu.shape):
        size //= count
        terms = (part(values, k * size, size) * x.column(weight, k) for k in range(count))
        values = functools.reduce(operator.add, terms)
    graph.output(MU.name, x.relu(x.reduce_sum(values * weights[-1])), ["n", 1])
    return graph
