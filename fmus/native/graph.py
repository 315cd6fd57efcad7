"""An ONNX graph read as a list of steps on the row vectors of one contact point."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError
from friction_models.loads import LOADS
from friction_models.models.intervals import MARGIN

Array = npt.NDArray[Any]

#: Values of one contact point that a node may have: they stand on the stack of the caller's thread.
MAX_VALUES = 1 << 14
#: Numbers that a graph may hold: twice as many take compilers a minute and gigabytes of memory.
MAX_CONSTANTS = 1 << 21


@dataclass
class Tensor:
    """A value of the graph.

    Attributes
    ----------
    name : str
        Name in the ONNX graph.
    shape : tuple of int
        Shape with the batch dimension set to 1.
    constant : ndarray or None
        Value of an initializer; None for a value that depends on an input.
    """

    name: str
    shape: tuple[int, ...]
    constant: Array | None = None

    @property
    def size(self) -> int:
        """Number of elements."""
        return int(np.prod(self.shape, dtype=int))


@dataclass
class Step:
    """One node: operator, attributes, tensors in and out (None stands for an optional input left out)."""

    op: str
    attributes: dict[str, Any]
    inputs: list[Tensor | None]
    output: Tensor


@dataclass
class Graph:
    """The steps of a model in an order in which they can be run."""

    inputs: dict[str, Tensor]
    outputs: dict[str, Tensor]
    steps: list[Step] = field(default_factory=list)

    def needed_for(self, name: str) -> list[Step]:
        """Return the steps that the output `name` depends on."""
        wanted = {id(self.outputs[name])}
        kept = []
        for step in reversed(self.steps):
            if id(step.output) in wanted:
                kept.append(step)
                wanted |= {id(t) for t in step.inputs if t is not None}
        return kept[::-1]


def refuse(where: str, what: str) -> InputError:
    """Build the error for a graph that the generator does not translate."""
    return InputError(f"{where}: {what}; pack it with --target python, which runs ONNX Runtime")


@contextmanager
def rules_of(where: str) -> Iterator[None]:
    """Turn what a damaged graph raises anywhere (an attribute, operand or index is missing) into one sentence."""
    try:
        yield
    except InputError:
        raise
    except (ArithmeticError, AssertionError, LookupError, MemoryError, TypeError, ValueError) as error:
        text = " ".join(str(error).split())[:100]
        raise InputError(
            f"{where}: the ONNX graph breaks the rules of its operators ({type(error).__name__}: {text})"
        ) from None


def read_graph(content: bytes, where: str, states: int, system: int) -> Graph:
    """Read a serialized model.

    Parameters
    ----------
    content : bytes
        ONNX file.
    where : str
        For messages.
    states, system : int
        Number of states of a point and of system variables, from the metadata.

    Raises
    ------
    InputError
        An operator, a shape or an input outside what can be translated.
    """
    with rules_of(where):
        return _read(content, where, states, system)


def _read(content: bytes, where: str, states: int, system: int) -> Graph:
    import onnx
    from onnx import numpy_helper

    from .ops import infer_shape

    graph = onnx.load_model_from_string(content).graph
    constants = {t.name: np.asarray(numpy_helper.to_array(t)) for t in graph.initializer}
    held = sum(a.size for a in constants.values())
    if held > MAX_CONSTANTS:
        raise refuse(where, f"the graph holds {held} numbers, allowed: {MAX_CONSTANTS}")
    known = {name: Tensor(name, a.shape, a) for name, a in constants.items()}
    real_inputs = [i for i in graph.input if i.name not in constants]
    shapes = {
        "loads": (1, len(LOADS)),
        "state": (1, states),
        "dt": (1,),
        "system": (1, system),
    }
    inputs: dict[str, Tensor] = {}
    for i, value in enumerate(real_inputs):
        # A foreign network has one input of any name: the five loads in the order of the contract.
        role = "loads" if len(real_inputs) == 1 and i == 0 else value.name
        if role not in shapes:
            raise refuse(where, f"the graph has an input {value.name!r}, allowed: {', '.join(shapes)}")
        dims = [d.dim_value for d in value.type.tensor_type.shape.dim]
        if role == "loads" and (len(dims) != 2 or dims[1] not in (0, len(LOADS))):
            raise InputError(f"{where}: input {value.name!r} has shape {dims}, allowed: (n, {len(LOADS)})")
        inputs[role] = known[value.name] = Tensor(value.name, shapes[role])
    if "loads" not in inputs:
        raise InputError(f"{where}: the graph has no input 'loads' of shape (n, {len(LOADS)})")
    result = Graph(inputs, {})
    for node in graph.node:
        attributes = {a.name: _attribute(a) for a in node.attribute}
        if node.op_type == "Constant":
            value_of = next(iter(attributes.values()))
            array = np.asarray(value_of)
            known[node.output[0]] = Tensor(node.output[0], array.shape, array)
            continue
        missing = next((n for n in node.input if n and n not in known), None)
        if missing is not None:
            raise InputError(
                f"{where}: node {node.name or node.op_type!r} uses {missing!r}, which does not exist"
            )
        arguments = [known[n] if n else None for n in node.input]
        shape = infer_shape(node.op_type, node.domain, attributes, arguments, where)
        output = Tensor(node.output[0], shape)
        if output.size > MAX_VALUES:
            name = node.name or node.op_type
            raise refuse(where, f"node {name!r} has {output.size} values a point, allowed: {MAX_VALUES}")
        known[node.output[0]] = output
        result.steps.append(Step(node.op_type, attributes, arguments, output))
    names = [o.name for o in graph.output]
    roles = {"mu": names[0]} if len(names) == 1 else {n: n for n in names}
    if "mu" not in roles:
        raise InputError(
            f"{where}: the graph has outputs {', '.join(names)}, allowed: one of them named 'mu'"
        )
    sizes = {"mu": 1, "state_next": states, "state_der": states, MARGIN: 1}
    for role, name in roles.items():
        tensor = known.get(name)
        if tensor is None or role not in sizes:
            continue
        if tensor.size != sizes[role]:
            raise InputError(
                f"{where}: output {name!r} has {tensor.size} values a point, allowed: {sizes[role]}"
            )
        result.outputs[role] = tensor
    if states and "state_next" not in result.outputs:
        raise InputError(f"{where}: the model declares {states} states but has no output 'state_next'")
    return result


def _attribute(attribute: Any) -> Any:
    from onnx import helper, numpy_helper

    value = helper.get_attribute_value(attribute)
    if hasattr(value, "data_type"):
        return np.asarray(numpy_helper.to_array(value))
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return value


def constant_of(tensor: Tensor | None, what: str, where: str) -> Array:
    """Return the value of a tensor that must be constant (indices, axes, limits)."""
    if tensor is None or tensor.constant is None:
        raise refuse(where, f"{what} is computed in the graph, allowed: a constant")
    return tensor.constant


def broadcast(shapes: Sequence[tuple[int, ...]], op: str, where: str) -> tuple[int, ...]:
    """Return the shape that the operands of an elementwise operator spread to."""
    try:
        return tuple(int(n) for n in np.broadcast_shapes(*shapes))
    except ValueError:
        raise InputError(
            f"{where}: operator {op} has operands of shapes {list(shapes)} that do not fit"
        ) from None
