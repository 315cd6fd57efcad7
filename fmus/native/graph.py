"""An ONNX graph read as a list of steps on the row vectors of one contact point."""

from __future__ import annotations

from typing import Any

import numpy as np

from friction_models.common import InputError
from friction_models.loads import LOADS
from friction_models.models.intervals.prediction_interval import MARGIN

from .ops import infer_shape
from .tensors import MAX_VALUES, Attributes, Graph, Step, Tensor, refuse

#: Numbers that a graph may hold: twice as many take compilers a minute and gigabytes of memory.
MAX_CONSTANTS = 1 << 21


def read_graph(content: bytes, where: str, states: int, system: int) -> Graph:
    """Read a serialized model with that many states of a point and system variables, as its metadata say.

    What a damaged graph raises anywhere is for `rules_of`.
    Raises InputError: an operator, a shape or an input outside what can be translated.
    """
    import onnx
    from onnx import numpy_helper

    graph = onnx.load_model_from_string(content).graph
    constants = {t.name: np.asarray(numpy_helper.to_array(t)) for t in graph.initializer}
    held = sum(a.size for a in constants.values())
    if held > MAX_CONSTANTS:
        raise refuse(where, f"the graph holds {held} numbers, allowed: {MAX_CONSTANTS}")
    known = {name: Tensor(a.shape, a) for name, a in constants.items()}
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
        inputs[role] = known[value.name] = Tensor(shapes[role])
    if "loads" not in inputs:
        raise InputError(f"{where}: the graph has no input 'loads' of shape (n, {len(LOADS)})")
    result = Graph(inputs, {})
    for node in graph.node:
        if node.op_type == "Constant":
            array = np.asarray(_attribute(node.attribute[0]))
            known[node.output[0]] = Tensor(array.shape, array)
            continue
        missing = next((n for n in node.input if n and n not in known), None)
        if missing is not None:
            raise InputError(
                f"{where}: node {node.name or node.op_type!r} uses {missing!r}, which does not exist"
            )
        attributes = Attributes({a.name: _attribute(a) for a in node.attribute})
        arguments = [known[n] if n else None for n in node.input]
        shape = infer_shape(node.op_type, node.domain, attributes, arguments, where)
        output = Tensor(shape)
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
