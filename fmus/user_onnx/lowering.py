"""Translates a foreign graph into ours: float64, `loads` [n, 5] to `mu` [n, 1], with the generator's operators only."""

from __future__ import annotations

from typing import Any

import numpy as np

from friction_models.common import InputError
from friction_models.expressions.onnx_graph import GraphBuilder, Node
from friction_models.loads import LOAD_NAMES, MU

from .operators.nodes import NotTranslated, refuse
from .operators.registry import DECIDING, DOMAINS, MOVING, translated
from .operators.tensors import Canvas, Constant, Symbol, Tensor
from .operators.view import View
from .reading import ForeignGraph
from .signature import Feed, Signature


def lower(graph: ForeignGraph, signature: Signature) -> bytes:
    """Return the serialized canonical graph; the same file always gives the same bytes.

    Raises NotTranslated: an operator or a use of it that has no translation; the message lists what has one; InputError: the
    graph is damaged, or mu is not one number a point.
    """
    unknown = next((n for n in graph.nodes if n.op not in DOMAINS.get(n.domain, {})), None)
    if unknown is not None:
        raise refuse(
            graph.where, f"operator {unknown.full:.60} is not translated, allowed: {', '.join(translated())}"
        )
    builder = GraphBuilder("friction")
    canvas = Canvas(builder, graph.where)
    loads = builder.input("loads", ["n", len(LOAD_NAMES)])
    deciding = _before_decisions(graph)
    values: dict[str, Tensor] = {n: Constant(a, kind) for n, (a, kind) in graph.constants.items()}
    for feed in signature.feeds:
        symbol = _entering(canvas, loads, feed)
        values[feed.name] = canvas.rounded(symbol) if feed.name in deciding else symbol
    for node in graph.nodes:
        missing = next((n for n in node.inputs if n and n not in values), None)
        if missing is not None:
            raise InputError(f"{graph.where}: {node.label!r:.60} uses {missing!r:.60}, which does not exist")
        view = View(node, [values[n] if n else None for n in node.inputs], graph.opset, graph.where)
        canvas.exact = any(n in deciding for n in node.outputs) and node.op not in MOVING
        try:
            made = DOMAINS[node.domain][node.op](canvas, view)
        except InputError:
            raise
        except (ValueError, TypeError, IndexError, KeyError, OverflowError, AttributeError) as error:
            raise refuse(
                graph.where, f"{node.full} {node.label!r:.60} cannot be read ({type(error).__name__})"
            ) from None
        results = made if isinstance(made, list) else [made]
        for name, value in zip(node.outputs, results):
            if name:
                values[name] = value
    return _close(canvas, values, signature, loads)


def _before_decisions(graph: ForeignGraph) -> set[str]:
    """Return the values that a branch of a tree depends on."""
    found: set[str] = set()
    for node in reversed(graph.nodes):
        if node.op in DECIDING or found.intersection(node.outputs):
            found.update(n for n in node.inputs if n)
    return found


def _entering(canvas: Canvas, loads: Node, feed: Feed) -> Symbol:
    """Return one input of the graph: its loads, in its units."""
    if feed.loads == tuple(range(len(LOAD_NAMES))):
        node = loads
    else:
        node = canvas.graph.op("Gather", loads, canvas.graph.constant(feed.loads, np.int64), axis=1)
    factor, offset = np.array([feed.factor]), np.array([feed.offset])
    if (factor != 1.0).any():
        node = node * factor
    if (offset != 0.0).any():
        node = node + offset
    symbol = Symbol(node, feed.shape, feed.kind)
    return Symbol(canvas.truncated(node), feed.shape, feed.kind) if feed.kind == "int64" else symbol


def _close(canvas: Canvas, values: dict[str, Tensor], signature: Signature, loads: Node) -> bytes:
    value = values.get(signature.output)
    if value is None:
        raise NotTranslated(f"{canvas.where}: output {signature.output!r:.60} is never computed")
    if value.size != 1:
        raise InputError(
            f"{canvas.where}: output {signature.output!r:.60} has {value.size} values a point, allowed: 1 (mu)"
        )
    if isinstance(value, Constant):
        number = float(np.ravel(value.array)[0])
        if not np.isfinite(number):
            raise InputError(f"{canvas.where}: mu is {number!r} everywhere; allowed: a finite number")
        mu: Any = canvas.x.constant(number, loads)
    else:
        mu = canvas.number(value).node
    if signature.multiply != 1.0:
        mu = mu * signature.multiply
    if signature.add != 0.0:
        mu = mu + signature.add
    canvas.graph.output(MU.name, canvas.x.relu(mu), ["n", 1])
    try:
        return canvas.graph.build({}).SerializeToString(deterministic=True)
    except Exception:  # the checker's errors are of several libraries: arithmetic on Booleans and the like
        raise refuse(canvas.where, "the types of the graph's values do not fit their operators") from None
