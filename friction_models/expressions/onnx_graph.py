"""ONNX graphs in float64 from formulas: `OnnxOps` draws what `Ops` computes.

`Node` stands for a tensor of the graph and overloads the operators, so that a law written against
`Ops` appends nodes while it runs. Equal expressions become one node and equal constants one
initializer; names are counted in order, hence the same model always gives the same bytes.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import onnx
from onnx import TensorProto, helper, numpy_helper

from .ops import Ops, Value

if TYPE_CHECKING:
    from .trees import TreeTable

OPSET = 21
ML_OPSET = 5
IR_VERSION = 10


def _operator(op_type: str, reflected: bool = False) -> Callable[..., Node]:
    """Return the method of an operator; where it is reflected, the node is the second operand."""

    def call(node: Node, *others: Value) -> Node:
        return node.graph.op(op_type, *((*others, node) if reflected else (node, *others)))

    return call


class Node:
    """A tensor of the graph under construction; see `GraphBuilder`."""

    # NumPy must leave `array + node` to `Node.__radd__`.
    __array_ufunc__ = None
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, graph: GraphBuilder, name: str) -> None:
        self.graph = graph
        self.name = name

    __add__, __radd__ = _operator("Add"), _operator("Add", reflected=True)
    __sub__, __rsub__ = _operator("Sub"), _operator("Sub", reflected=True)
    __mul__, __rmul__ = _operator("Mul"), _operator("Mul", reflected=True)
    __truediv__, __rtruediv__ = _operator("Div"), _operator("Div", reflected=True)
    __pow__, __rpow__ = _operator("Pow"), _operator("Pow", reflected=True)
    __neg__ = _operator("Neg")
    __abs__ = _operator("Abs")
    __lt__ = _operator("Less")
    __gt__ = _operator("Greater")
    __and__ = _operator("And")
    __or__ = _operator("Or")
    __invert__ = _operator("Not")

    def __le__(self, other: Value) -> Node:
        return ~(self > other)

    def __ge__(self, other: Value) -> Node:
        return ~(self < other)

    def __eq__(self, other: object) -> bool:
        raise TypeError("two loads cannot be tested for equality in a formula; compare with < or >")

    def __bool__(self) -> bool:
        raise TypeError("a formula cannot branch with if/and/or on a load; use x.where, &, | or ~")

    def __iter__(self) -> Any:
        raise TypeError("a value of a formula cannot be iterated; use x.column")


class GraphBuilder:
    """Collects inputs, constants, nodes and outputs of one float64 ONNX graph."""

    def __init__(self, name: str = "friction") -> None:
        self.name = name
        self._inputs: list[onnx.ValueInfoProto] = []
        self._outputs: list[onnx.ValueInfoProto] = []
        self._nodes: list[onnx.NodeProto] = []
        self._initializers: list[onnx.TensorProto] = []
        self._constants: dict[tuple[str, tuple[int, ...], bytes], str] = {}
        self._known: dict[tuple[Any, ...], Node] = {}
        self._counts: dict[str, int] = {}
        self._ml = False

    def input(self, name: str, shape: Sequence[int | str]) -> Node:
        """Declare a double input; a string in `shape` is a free dimension."""
        self._inputs.append(helper.make_tensor_value_info(name, TensorProto.DOUBLE, shape))
        return Node(self, name)

    def output(self, name: str, value: Value, shape: Sequence[int | str]) -> None:
        """Declare a double output that shows `value`."""
        node = value if isinstance(value, Node) else self.constant(value)
        self._nodes.append(helper.make_node("Identity", [node.name], [name], name=f"out_{name}"))
        self._outputs.append(helper.make_tensor_value_info(name, TensorProto.DOUBLE, shape))

    def constant(self, value: npt.ArrayLike, dtype: npt.DTypeLike = np.float64) -> Node:
        """Return an initializer; equal constants share one."""
        array = np.array(value, dtype=dtype, order="C")
        key = (array.dtype.str, array.shape, array.tobytes())
        if key not in self._constants:
            name = f"c{len(self._constants)}"
            self._initializers.append(numpy_helper.from_array(array, name))
            self._constants[key] = name
        return Node(self, self._constants[key])

    def op(self, op_type: str, *operands: Value, domain: str = "", **attributes: Any) -> Node:
        """Append a node (or return the equal one that is there already)."""
        names = [(v if isinstance(v, Node) else self.constant(v)).name for v in operands]
        shown = tuple((k, repr(v)) for k, v in sorted(attributes.items()))
        key = (domain, op_type, tuple(names), shown)
        if key not in self._known:
            count = self._counts[op_type] = self._counts.get(op_type, 0) + 1
            name = f"{op_type.lower()}_{count}"
            self._nodes.append(
                helper.make_node(op_type, names, [name], name=name, domain=domain, **attributes)
            )
            self._known[key] = Node(self, name)
        self._ml |= bool(domain)
        return self._known[key]

    def build(self, metadata: Mapping[str, object] | None = None) -> onnx.ModelProto:
        """Return the checked model; `metadata` values are stored as JSON strings."""
        graph = helper.make_graph(self._nodes, self.name, self._inputs, self._outputs, self._initializers)
        opsets = [helper.make_opsetid("", OPSET)]
        if self._ml:
            opsets.append(helper.make_opsetid("ai.onnx.ml", ML_OPSET))
        model = helper.make_model(
            graph, opset_imports=opsets, producer_name="tribofmu", ir_version=IR_VERSION
        )
        for key, value in sorted((metadata or {}).items()):
            entry = model.metadata_props.add()
            entry.key, entry.value = key, json.dumps(value, allow_nan=False)
        onnx.checker.check_model(model, full_check=True)
        return model


def _elementwise(op_type: str, plain: str) -> Callable[..., Value]:
    """Return the method that draws an operator, or computes the function of `Ops` where there is no node."""

    def call(x: OnnxOps, *operands: Value) -> Value:
        if any(isinstance(v, Node) for v in operands):
            return x.graph.op(op_type, *operands)
        return getattr(super(OnnxOps, x), plain)(*operands)

    return call


class OnnxOps(Ops):
    """`Ops` that appends to a `GraphBuilder`; values without a node in them are computed at once."""

    def __init__(self, graph: GraphBuilder) -> None:
        self.graph = graph

    exp = _elementwise("Exp", "exp")
    log = _elementwise("Log", "log")
    sqrt = _elementwise("Sqrt", "sqrt")
    tanh = _elementwise("Tanh", "tanh")
    sigmoid = _elementwise("Sigmoid", "sigmoid")
    abs = _elementwise("Abs", "abs")
    relu = _elementwise("Relu", "relu")
    maximum = _elementwise("Max", "maximum")
    minimum = _elementwise("Min", "minimum")
    power = _elementwise("Pow", "power")

    def where(self, condition: Value, a: Value, b: Value) -> Value:
        if isinstance(condition, Node):
            return self.graph.op("Where", condition, a, b)
        if not any(isinstance(v, Node) for v in (a, b)):
            return super().where(condition, a, b)
        return self.graph.op("Where", self.graph.constant(condition, bool), a, b)

    def matmul(self, a: Value, weights: npt.ArrayLike, bias: npt.ArrayLike | None = None) -> Value:
        if not isinstance(a, Node):
            return super().matmul(a, weights, bias)
        if bias is None:
            return self.graph.op("MatMul", a, weights)
        return self.graph.op("Gemm", a, weights, np.ravel(np.asarray(bias, dtype=np.float64)))

    def column(self, a: Value, j: int) -> Value:
        if not isinstance(a, Node):
            return super().column(a, j)
        return self.graph.op("Gather", a, self.graph.constant([j], np.int64), axis=1)

    def concat(self, columns: Sequence[Value]) -> Value:
        if not any(isinstance(v, Node) for v in columns):
            return super().concat(columns)
        return self.graph.op("Concat", *columns, axis=1)

    def reduce_sum(self, a: Value) -> Value:
        if not isinstance(a, Node):
            return super().reduce_sum(a)
        return self.graph.op("ReduceSum", a, self.graph.constant([1], np.int64), keepdims=1)

    def constant(self, value: float, like: Value) -> Value:
        if not isinstance(like, Node):
            return super().constant(value, like)
        # The first column of `like`, times zero, carries the number of rows.
        return self.column(like, 0) * 0.0 + float(value)

    def tree_ensemble(self, a: Value, trees: TreeTable) -> Value:
        if not isinstance(a, Node):
            return super().tree_ensemble(a, trees)
        return self.graph.op("TreeEnsemble", a, domain="ai.onnx.ml", **_tree_attributes(trees))


def _tree_attributes(trees: TreeTable) -> dict[str, int | list[int] | TensorProto]:
    """Return the attributes of an `ai.onnx.ml` TreeEnsemble (opset 5), float64."""
    first = np.repeat(np.cumsum(trees.nodes) - trees.nodes, trees.nodes)
    first_leaf = first + np.repeat(np.arange(len(trees.nodes)), trees.nodes)
    sides = {}
    for name, child in (("true", trees.left), ("false", trees.right)):
        is_leaf = child < 0
        sides[f"nodes_{name}leafs"] = is_leaf.astype(int).tolist()
        sides[f"nodes_{name}nodeids"] = np.where(is_leaf, first_leaf - 1 - child, first + child).tolist()
    count = len(trees.feature)
    tensor = helper.make_tensor
    return {
        **sides,
        "aggregate_function": 1,
        "leaf_targetids": [0] * len(trees.leaf),
        "leaf_weights": tensor("leaf_weights", TensorProto.DOUBLE, (len(trees.leaf),), trees.leaf.tolist()),
        "n_targets": 1,
        "nodes_featureids": trees.feature.tolist(),
        "nodes_modes": tensor("nodes_modes", TensorProto.UINT8, (count,), [0] * count),
        "nodes_splits": tensor("nodes_splits", TensorProto.DOUBLE, (count,), trees.threshold.tolist()),
        "post_transform": 0,
        "tree_roots": (np.cumsum(trees.nodes) - trees.nodes).tolist(),
    }
