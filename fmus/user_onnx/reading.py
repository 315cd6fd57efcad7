"""Reads a foreign ONNX file with bounds on every size."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from friction_models.common import InputError

from .operators.nodes import KINDS, MAX_ELEMENTS, MAX_RANK, Array, ForeignNode, refuse

if TYPE_CHECKING:
    import onnx


#: Bounds of what is read: nodes, elements of one constant, dimensions, characters of a name.
MAX_NODES = 20_000
MAX_NAME = 1000
#: Oldest operator set: before it, operands spread by attributes instead of by their shapes.
OLDEST_OPSET = 7
#: Operators that hold graphs of their own, call themselves, or give other numbers at every call.
FORBIDDEN = frozenset(
    {"If", "Loop", "Scan", "SequenceMap", "Optional", "Bernoulli", "Multinomial", "RandomNormal"}
    | {"RandomNormalLike", "RandomUniform", "RandomUniformLike"}
)


@dataclass(frozen=True)
class ForeignInput:
    """An input of the graph: name, kind (a value of `KINDS`), shape with None for a free dimension."""

    name: str
    kind: str
    shape: tuple[int | None, ...] | None


@dataclass
class ForeignGraph:
    """What was read: inputs, constants by name (with their kind), nodes in running order."""

    where: str
    opset: int
    inputs: list[ForeignInput]
    constants: dict[str, tuple[Array, str]]
    nodes: list[ForeignNode]


def parse(content: bytes, where: str) -> onnx.ModelProto:
    """Return the message of an ONNX file, refused where it is damaged, incomplete or runs without end.

    Raises InputError: not ONNX, weights in other files, functions of its own, subgraphs, too many nodes.
    """
    import onnx

    try:
        model = onnx.load_model_from_string(content)
    except Exception:  # the parser's errors are of several libraries
        raise InputError(f"{where}: not an ONNX file (it cannot be parsed)") from None
    graph = model.graph
    if not graph.output:
        raise InputError(f"{where}: not an ONNX model (its graph has no output)")
    # The parser gives bytes for what is no UTF-8.
    if not all(isinstance(t, str) and t.isprintable() and len(t) <= MAX_NAME for t in _names(model)):
        raise InputError(
            f"{where}: holds a name that is no text, or a long one; allowed: printable names of at most "
            f"{MAX_NAME} characters"
        )
    if len(graph.node) > MAX_NODES:
        raise InputError(f"{where}: {len(graph.node)} nodes, allowed: at most {MAX_NODES}")
    if model.functions:
        raise InputError(
            f"{where}: the file defines a function of its own ({model.functions[0].name!r:.60}); "
            "allowed: a graph of standard operators (export with optimization, or inline it)"
        )
    for tensor in _tensors(graph, where):
        if tensor.data_location == onnx.TensorProto.EXTERNAL or tensor.external_data:
            raise InputError(
                f"{where}: tensor {tensor.name!r:.60} is stored in another file; allowed: one self-contained file "
                "(torch.onnx.export(..., external_data=False), or onnx.save without external data)"
            )
    if graph.sparse_initializer:
        raise InputError(f"{where}: the file holds sparse tensors; allowed: dense ones")
    for node in graph.node:
        if node.op_type in FORBIDDEN:
            raise InputError(
                f"{where}: operator {node.op_type!r} runs a graph of its own or draws random numbers; "
                "allowed: a closed formula of the loads"
            )
    return model


def _names(model: onnx.ModelProto) -> Iterator[Any]:
    """Yield the names in a file."""
    graph = model.graph
    for node in graph.node:
        yield from (node.op_type, node.domain, node.name, *node.input, *node.output)
        yield from (text for a in node.attribute for text in (a.name, a.ref_attr_name))
    yield from (v.name for v in (*graph.input, *graph.output, *graph.initializer))
    yield from (o.domain for o in model.opset_import)
    yield from (p.key for p in model.metadata_props)
    yield from (f.name for f in model.functions)


def _tensors(graph: onnx.GraphProto, where: str) -> list[onnx.TensorProto]:
    import onnx

    found = list(graph.initializer)
    for node in graph.node:
        for a in node.attribute:
            kind = onnx.AttributeProto
            if a.type in {kind.GRAPH, kind.GRAPHS} or a.HasField("g") or a.graphs:
                raise InputError(
                    f"{where}: operator {node.op_type!r:.60} holds a graph of its own; allowed: a closed formula"
                )
            if a.sparse_tensor.ByteSize() or a.sparse_tensors:
                raise InputError(f"{where}: the file holds sparse tensors; allowed: dense ones")
            if a.HasField("t"):
                found.append(a.t)
            found.extend(a.tensors)
    return found


def array_of(tensor: onnx.TensorProto, where: str) -> tuple[Array, str]:
    """Return a constant as float64, int64 or bool with its kind.

    Raises InputError: a type that is no number, dimensions that do not fit the data, too many elements, or NaN.
    """
    from onnx import numpy_helper

    name = f"constant {tensor.name!r:.60}"
    if tensor.data_type not in KINDS:
        raise InputError(
            f"{where}: {name} has element type {tensor.data_type}, allowed: real, whole or Boolean numbers"
        )
    dims = list(tensor.dims)
    size = math.prod(max(dim, 0) for dim in dims)
    if len(dims) > MAX_RANK or any(d < 0 for d in dims) or size > MAX_ELEMENTS:
        raise InputError(
            f"{where}: {name} has dimensions {dims!r:.80}, allowed: at most {MAX_RANK} and {MAX_ELEMENTS} elements"
        )
    try:
        array = np.asarray(numpy_helper.to_array(tensor))
    except Exception:  # lengths that do not fit end in errors of NumPy, protobuf or onnx
        array = np.empty(0)
    if array.shape != tuple(dims):
        raise InputError(f"{where}: {name} holds other data than its dimensions {dims!r:.80} say")
    kind = KINDS[tensor.data_type]
    if kind.startswith("float"):
        array = array.astype(np.float64)
        if np.isnan(array).any():
            raise InputError(f"{where}: {name} holds NaN; allowed: numbers")
        return array, kind
    return array.astype(np.bool_ if kind == "bool" else np.int64), kind


def read_graph(model: onnx.ModelProto, wanted: str, where: str) -> ForeignGraph:
    """Return the part of the graph that `wanted`, one of its outputs, depends on.

    Raises InputError: a name that is computed twice or never, nodes that need each other, operators of a set that is too old or
    unknown, constants that cannot be used.
    """
    import onnx

    graph = model.graph
    opsets = {"" if o.domain == "ai.onnx" else o.domain: o.version for o in model.opset_import}
    opset, newest = int(opsets.get("", 1)), onnx.defs.onnx_opset_version()
    standard = any(n.domain in {"", "ai.onnx"} for n in graph.node)
    if standard and not OLDEST_OPSET <= opset <= newest:
        raise refuse(where, f"operator set {opset} is not translated, allowed: {OLDEST_OPSET} to {newest}")
    makers: dict[str, int] = {}
    for k, node in enumerate(graph.node):
        for name in node.output:
            if name and name in makers:
                raise InputError(f"{where}: {name!r:.60} is computed by two nodes; allowed: by one")
            if name:
                makers[name] = k
    stored = {t.name: t for t in graph.initializer}
    given = {i.name for i in graph.input} | set(stored)
    order = _order(graph, makers, given, wanted, where)
    used = {name for k in order for name in graph.node[k].input if name} | {wanted}
    return ForeignGraph(
        where,
        opset,
        [_input(i, where) for i in graph.input if i.name not in stored],
        {name: array_of(t, where) for name, t in stored.items() if name in used},
        [_node(graph.node[k], where) for k in order],
    )


def _order(
    graph: onnx.GraphProto, makers: dict[str, int], given: set[str], wanted: str, where: str
) -> list[int]:
    """Return the nodes that `wanted` needs, each behind those it needs itself (no recursion: graphs may be deep)."""
    order: list[int] = []
    done: set[int] = set()
    open_nodes: set[int] = set()
    stack: list[tuple[str, bool]] = [(wanted, False)]
    while stack:
        name, left = stack.pop()
        k = makers.get(name)
        if k is None:
            if name not in given:
                raise InputError(f"{where}: {name!r:.60} is used but never computed")
            continue
        if left:
            open_nodes.discard(k)
            if k not in done:
                done.add(k)
                order.append(k)
            continue
        if k in done:
            continue
        if k in open_nodes:
            raise InputError(f"{where}: the nodes around {name!r:.60} need each other; allowed: no cycles")
        open_nodes.add(k)
        stack.append((name, True))
        for needed in graph.node[k].input:
            m = makers.get(needed)
            if needed and (m is None or m not in done):
                stack.append((needed, False))
    return order


def _input(value: onnx.ValueInfoProto, where: str) -> ForeignInput:
    tensor = value.type.tensor_type
    if not value.type.HasField("tensor_type") or tensor.elem_type not in KINDS:
        raise InputError(
            f"{where}: input {value.name!r:.60} is no tensor of numbers; allowed: float or double"
        )
    if not tensor.HasField("shape"):
        return ForeignInput(value.name, KINDS[tensor.elem_type], None)
    dims = [d.dim_value if d.HasField("dim_value") and d.dim_value > 0 else None for d in tensor.shape.dim]
    return ForeignInput(value.name, KINDS[tensor.elem_type], tuple(dims))


def _attribute(a: onnx.AttributeProto, node: onnx.NodeProto, where: str) -> Any:
    from onnx import helper

    if a.ref_attr_name:
        raise InputError(f"{where}: attribute {a.name!r:.60} refers to a function; allowed: values")
    try:
        value = helper.get_attribute_value(a)
    except ValueError:
        raise InputError(f"{where}: attribute {a.name!r:.60} of {node.op_type!r:.60} has no value") from None
    if hasattr(value, "data_type"):
        return array_of(value, where)[0] if node.op_type != "Constant" else array_of(value, where)
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


def _node(node: onnx.NodeProto, where: str) -> ForeignNode:
    attributes = {a.name: _attribute(a, node, where) for a in node.attribute}
    domain = "" if node.domain == "ai.onnx" else node.domain
    label = node.name or node.op_type
    return ForeignNode(node.op_type, domain, attributes, tuple(node.input), tuple(node.output), label)


def pruned(model: onnx.ModelProto, graph: ForeignGraph, wanted: str) -> bytes:
    """Return the file with nothing but what `wanted` needs: what is not translated is not run either."""
    import onnx

    small = onnx.ModelProto()
    small.CopyFrom(model)
    needed = {name for node in graph.nodes for name in node.outputs if name}
    kept = [n for n in small.graph.node if needed.intersection(n.output)]
    del small.graph.node[:]
    small.graph.node.extend(kept)
    outputs = [o for o in small.graph.output if o.name == wanted]
    del small.graph.output[:]
    small.graph.output.extend(outputs)
    return small.SerializeToString()
