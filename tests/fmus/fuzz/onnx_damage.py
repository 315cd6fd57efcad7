"""Ways to damage an ONNX file: in its bytes, or in the graph that they hold."""

from __future__ import annotations

import random
from collections.abc import Callable

import onnx
from onnx import TensorProto, helper

_NUMBERS = (0, 1, -1, 2, 5, 6, 2**31 - 1, 2**31, -(2**31), 2**40, 2**62, 2**63 - 1, -(2**63))
_OPS = (
    "Add",
    "MatMul",
    "Gemm",
    "Reshape",
    "Tile",
    "Expand",
    "ConstantOfShape",
    "Loop",
    "If",
    "Scan",
    "Range",
)
_MORE_OPS = (
    "TreeEnsemble",
    "Conv",
    "LSTM",
    "Pad",
    "Concat",
    "Gather",
    "Einsum",
    "NoSuchOperator",
    "",
    "RandomNormal",
)


def bytes_changed(draw: random.Random, content: bytes) -> bytes:
    """Flip, cut, repeat and insert bytes."""
    data = bytearray(content)
    for _ in range(draw.choice([1, 1, 2, 5, 20])):
        at = draw.randrange(len(data) or 1)
        match draw.randrange(6):
            case 0 | 1:
                data[at : at + 1] = bytes([data[at] ^ (1 << draw.randrange(8))]) if data else b""
            case 2:
                del data[at:]
            case 3:
                del data[at : at + draw.randrange(1, 40)]
            case 4:
                data[at:at] = draw.randbytes(draw.randrange(1, 12))
            case _:
                data[at:at] = data[at : at + draw.randrange(1, 200)]
    return bytes(data)


def graph_changed(draw: random.Random, content: bytes) -> bytes:
    """Change names, shapes, operators, attributes and tensors of a graph that can still be parsed."""
    model = onnx.load_model_from_string(content)
    for _ in range(draw.choice([1, 1, 2, 3])):
        change = draw.choice(_CHANGES)
        try:
            change(draw, model)
        except (IndexError, ValueError, TypeError, AttributeError):
            continue  # this model has nothing to change there
    return bytes(model.SerializeToString())


def _operator(draw: random.Random, model: onnx.ModelProto) -> None:
    draw.choice(model.graph.node).op_type = draw.choice((*_OPS, *_MORE_OPS))


def _wire(draw: random.Random, model: onnx.ModelProto) -> None:
    names = [o for n in model.graph.node for o in n.output] + [i.name for i in model.graph.initializer]
    node = draw.choice(model.graph.node)
    node.input[draw.randrange(len(node.input))] = draw.choice([*names, "nowhere", "", "loads"])


def _cycle(draw: random.Random, model: onnx.ModelProto) -> None:
    first, last = model.graph.node[0], model.graph.node[-1]
    first.input[0] = last.output[0]


def _drop(draw: random.Random, model: onnx.ModelProto) -> None:
    part = draw.choice([model.graph.node, model.graph.initializer, model.graph.input, model.graph.output])
    del part[draw.randrange(len(part))]


def _twice(draw: random.Random, model: onnx.ModelProto) -> None:
    part = draw.choice([model.graph.node, model.graph.initializer, model.graph.input, model.graph.output])
    part.add().CopyFrom(draw.choice(part))


def _dims(draw: random.Random, model: onnx.ModelProto) -> None:
    tensor = draw.choice(model.graph.initializer)
    if draw.random() < 0.3:
        tensor.dims.append(draw.choice(_NUMBERS))
    else:
        tensor.dims[draw.randrange(len(tensor.dims))] = draw.choice(_NUMBERS)


def _values(draw: random.Random, model: onnx.ModelProto) -> None:
    tensor = draw.choice(model.graph.initializer)
    data = bytearray(tensor.raw_data)
    at = 8 * draw.randrange(len(data) // 8)
    special = (
        b"\0\0\0\0\0\0\xf8\x7f",
        b"\0\0\0\0\0\0\xf0\x7f",
        b"\xff\xff\xff\xff\xff\xff\xef\x7f",
        draw.randbytes(8),
    )
    data[at : at + 8] = draw.choice(special)
    tensor.raw_data = bytes(data)


def _type(draw: random.Random, model: onnx.ModelProto) -> None:
    draw.choice(model.graph.initializer).data_type = draw.randrange(-1, 30)


def _outside(draw: random.Random, model: onnx.ModelProto) -> None:
    tensor = draw.choice(model.graph.initializer)
    tensor.data_location = TensorProto.EXTERNAL
    for key, value in (
        ("location", draw.choice(["/etc/passwd", "../x", "bad.onnx", "bad.onnx.data", "", "a" * 3000])),
        ("offset", str(draw.choice(_NUMBERS))),
        ("length", str(draw.choice(_NUMBERS))),
    ):
        entry = tensor.external_data.add()
        entry.key, entry.value = key, value


def _shape(draw: random.Random, model: onnx.ModelProto) -> None:
    value = draw.choice([*model.graph.input, *model.graph.output])
    dimension = draw.choice(value.type.tensor_type.shape.dim)
    dimension.dim_value = draw.choice(_NUMBERS)


def _element(draw: random.Random, model: onnx.ModelProto) -> None:
    draw.choice([*model.graph.input, *model.graph.output]).type.tensor_type.elem_type = draw.randrange(0, 25)


def _attribute(draw: random.Random, model: onnx.ModelProto) -> None:
    node = draw.choice([n for n in model.graph.node if n.attribute] or list(model.graph.node))
    if node.attribute and draw.random() < 0.7:
        attribute = draw.choice(node.attribute)
        numbers = attribute.ints or attribute.t.int64_data
        if numbers:
            numbers[draw.randrange(len(numbers))] = draw.choice(_NUMBERS)
        elif attribute.t.raw_data:
            data = bytearray(attribute.t.raw_data)
            data[draw.randrange(len(data))] ^= 1 << draw.randrange(8)
            attribute.t.raw_data = bytes(data)
        else:
            attribute.i = draw.choice(_NUMBERS)
            attribute.type = draw.randrange(0, 15)  # type: ignore[assignment]
    else:
        node.attribute.append(helper.make_attribute("axis", draw.choice(_NUMBERS)))


def _name(draw: random.Random, model: onnx.ModelProto) -> None:
    value = draw.choice([*model.graph.input, *model.graph.output, *model.graph.initializer])
    value.name = draw.choice(["", "mu", "loads", "state", "a" * 5000, '"; system("x"); //', "%s%n", "\0"])


def _nested(draw: random.Random, model: onnx.ModelProto) -> None:
    inner = helper.make_graph([], "g", [], [])
    for _ in range(draw.choice([1, 10, 20])):
        node = helper.make_node(
            "If", ["loads"], ["y"], then_branch=inner, else_branch=helper.make_graph([], "e", [], [])
        )
        inner = helper.make_graph([node], "g", [], [])
    model.graph.node.add().CopyFrom(inner.node[0])


def _metadata(draw: random.Random, model: onnx.ModelProto) -> None:
    values = [
        "",
        "{",
        "[" * 5000,
        "null",
        "[1]",
        '{"a": NaN}',
        '{"T": [1, 2, 3]}',
        '{"T": [5, 1]}',
        '{"T": [1e999, 1]}',
    ]
    values += [
        '[{"name": "mu"}]',
        '[{"name": "a\\u0000"}]',
        '[{"name": "x", "start": 1e400}]',
        "[{}]",
        '[{"name": 5}]',
        "7",
    ]
    entry = draw.choice(list(model.metadata_props)) if model.metadata_props else model.metadata_props.add()
    entry.key = draw.choice(
        ["tribofmu.domain", "tribofmu.state", "tribofmu.system", "tribofmu.model", "tribofmu.card"]
    )
    entry.value = draw.choice(values)


def _version(draw: random.Random, model: onnx.ModelProto) -> None:
    draw.choice(model.opset_import).version = draw.choice(_NUMBERS)


_CHANGES: tuple[Callable[[random.Random, onnx.ModelProto], None], ...] = (
    *(_operator, _wire, _cycle, _drop, _twice, _dims, _values, _type, _outside, _shape, _element),
    *(_attribute, _name, _nested, _metadata, _version),
)  # fmt: skip
