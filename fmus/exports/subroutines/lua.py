"""An ONNX graph as Lua: one line a step, on small tables of numbers, for hosts whose subroutines are Lua alone.

The graph is the one that the C is generated from (`fmus.native.graph`), with the same operators and rules. The text runs in Lua
5.1 (LuaJIT) to 5.4.
"""

from __future__ import annotations

import math

import numpy as np

from ...interface.friction_source import FrictionSource
from ...native import ops
from ...native.graph import read_graph
from ...native.tensors import Graph, Step, Tensor, constant_of, refuse, rules_of

#: Names of the graph's inputs in Lua.
_INPUTS = {"loads": "L", "state": "S", "system": "P", "dt": "D"}
#: ONNX types that a Cast may go to: int32, int64, bool, double.
_CASTS = {6: "Trunc", 7: "Trunc", 9: "Truth", 11: "Identity"}


def lua_number(value: float) -> str:
    """Return a Lua number that is read back as exactly `value`.

    Examples
    --------
    >>> lua_number(0.1), lua_number(2.0), lua_number(float("inf"))
    ('0.10000000000000001', '2.0', 'math.huge')
    """
    if math.isnan(value):
        return "(0.0/0.0)"
    if math.isinf(value):
        return "math.huge" if value > 0 else "-math.huge"
    text = format(float(value), ".17g")
    return text if any(c in text for c in ".en") else text + ".0"


def lua_list(values: object) -> str:
    """Return a Lua table of numbers, broken into lines."""
    texts = [lua_number(float(x)) for x in np.ravel(np.asarray(values, dtype=float))]
    rows = [", ".join(texts[i : i + 8]) for i in range(0, len(texts), 8)]
    return "{" + ",\n  ".join(rows) + "}"


def lua_functions(source: FrictionSource) -> str:
    """Return the Lua functions ``tf_model_mu(L, S, P)`` and, with memory, ``tf_model_step(L, S, P, dt)``.

    Raises InputError: the graph holds something that is not translated.
    """
    with rules_of(source.where):
        graph = read_graph(source.onnx, source.where, len(source.states), len(source.system))
        writer = _Writer(graph, source.where)
        functions = [writer.function("tf_model_mu", "mu")]
        if source.states:
            functions.append(writer.function("tf_model_step", "state_next"))
    head = "-- ---- the model, a line a step of its graph ----"
    return "\n".join([head, "local C = {}", *writer.constants, *functions]) + "\n"


class _Writer:
    """Writes the steps that an output needs; constants stand once, in the table C."""

    def __init__(self, graph: Graph, where: str) -> None:
        self.graph, self.where = graph, where
        self.constants: list[str] = []
        self._names: dict[str, str] = {}

    def _constant(self, values: object) -> str:
        text = lua_list(values)
        if text not in self._names:
            self._names[text] = f"C[{len(self._names) + 1}]"
            # A function of its own for a long list: a function holds 65 536 numbers in LuaJIT.
            long = len(text) > 4000
            self.constants.append(
                f"{self._names[text]} = " + (f"(function() return {text} end)()" if long else text)
            )
        return self._names[text]

    def function(self, name: str, role: str) -> str:
        """Return a function that computes the output `role`."""
        self._places = {id(t): _INPUTS[n] for n, t in self.graph.inputs.items()}
        lines = [f"local function {name}(L, S, P, dt)", "  local D, v = {dt}, {}"]
        for k, step in enumerate(self.graph.needed_for(role), 1):
            lines.append(f"  v[{k}] = {self._step(step)}")
            self._places[id(step.output)] = f"v[{k}]"
        return "\n".join([*lines, f"  return {self._place(self.graph.outputs[role])}", "end"])

    def _place(self, tensor: Tensor) -> str:
        if tensor.constant is not None:
            return self._constant(tensor.constant)
        return self._places[id(tensor)]

    def _step(self, step: Step) -> str:
        tensors = [t for t in step.inputs if t is not None]
        if step.op in ops.ELEMENTWISE or step.op == "Cast":
            for t in tensors:
                if t.size not in (1, step.output.size):
                    raise refuse(self.where, f"{step.op} spreads {t.shape} over {step.output.shape}")
            places = [self._place(t) for t in tensors]
            name = step.op
            if name == "Cast":
                to = step.attributes.whole("to")
                if to not in _CASTS:
                    raise refuse(self.where, "rounding to single precision has no counterpart in Lua")
                name = _CASTS[to]
            if name == "Clip":
                given = [None if t is None else self._place(t) for t in (*step.inputs, None, None)[:3]]
                places = [str(given[0]), given[1] or "tf_lowest", given[2] or "tf_highest"]
            return f"tf.{name}({step.output.size}, {', '.join(places)})"
        if step.op in {"MatMul", "Gemm"}:
            return self._product(step)
        if step.op == "ReduceSum":
            return f"tf_sum({self._place(tensors[0])})"
        if step.op == "TreeEnsemble":
            return self._trees(step)
        picked = ops.picks(step.op, step.attributes, step.inputs, self.where)
        elements = [f"{self._place(t)}[{i + 1}]" for t, i in picked]
        return "{" + ", ".join(elements) + "}"

    def _product(self, step: Step) -> str:
        weights = constant_of(step.inputs[1], f"the matrix of a {step.op}", self.where).astype(float)
        if step.op == "Gemm" and step.attributes.whole("transB", 0):
            weights = weights.T
        bias = np.zeros(weights.shape[1])
        if step.op == "Gemm":
            weights = weights * step.attributes.number("alpha", 1.0)
            if len(step.inputs) > 2 and step.inputs[2] is not None:
                given = constant_of(step.inputs[2], "the bias of a Gemm", self.where)
                bias = np.broadcast_to(np.ravel(given), bias.shape) * step.attributes.number("beta", 1.0)
        x = step.inputs[0]
        assert x is not None
        return f"tf_dense({self._place(x)}, {self._constant(weights.T)}, {self._constant(bias)})"

    def _trees(self, step: Step) -> str:
        """Write a node as four numbers in a row: feature, split, then where to go, below 0 for a leaf."""
        a, x = step.attributes, step.inputs[0]
        assert x is not None
        columns = [a.array("nodes_featureids") + 1, a.array("nodes_splits")]
        for side in ("true", "false"):
            ids = a.array(f"nodes_{side}nodeids").astype(int) + 1
            columns.append(np.where(a.array(f"nodes_{side}leafs").astype(bool), -ids, ids))
        table = np.column_stack(columns)
        parts = (table, a.array("leaf_weights"), a.array("tree_roots") + 1)
        return f"tf_trees({self._place(x)}, {', '.join(self._constant(p) for p in parts)})"
