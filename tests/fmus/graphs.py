"""ONNX graphs written by hand, and small fitted models, for the tests of the FMUs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import onnx
import onnxruntime
import pandas as pd
from onnx import TensorProto, helper, numpy_helper

Array = npt.NDArray[Any]
BOX = {
    "v_rel": [5.0, 500.0],
    "T": [20.0, 400.0],
    "sigma_n": [500.0, 2750.0],
    "sd": [0.0, 60.0],
    "psi": [1.0, 20.0],
}


def graph_bytes(
    nodes: list[onnx.NodeProto],
    constants: dict[str, Array] | None = None,
    inputs: dict[str, list[Any]] | None = None,
    outputs: dict[str, list[Any]] | None = None,
    metadata: dict[str, Any] | None = None,
) -> bytes:
    """Return an ONNX model with the input `loads`, the output `mu` and more where given."""

    def value(name: str, shape: list[Any]) -> onnx.ValueInfoProto:
        return helper.make_tensor_value_info(name, TensorProto.DOUBLE, shape)

    graph = helper.make_graph(
        nodes,
        "friction",
        [value(n, s) for n, s in ({"loads": ["n", 5]} | (inputs or {})).items()],
        [value(n, s) for n, s in ({"mu": ["n", 1]} | (outputs or {})).items()],
        [numpy_helper.from_array(np.asarray(a), n) for n, a in (constants or {}).items()],
    )
    model = helper.make_model(
        graph,
        opset_imports=[helper.make_opsetid("", 20), helper.make_opsetid("ai.onnx.ml", 5)],
        ir_version=10,
    )
    for key, content in (metadata or {}).items():
        model.metadata_props.add(key=f"tribofmu.{key}", value=json.dumps(content))
    return model.SerializeToString()


def node(op: str, inputs: str, output: str, **attributes: Any) -> onnx.NodeProto:
    """Return a node; inputs are one text with blanks."""
    return helper.make_node(op, inputs.split(" "), [output], **attributes)


def save(content: bytes, path: Path) -> Path:
    path.write_bytes(content)
    return path


def runtime(content: bytes, loads: Array, **more: Array) -> Array:
    """Return mu, shape (n,), from ONNX Runtime."""
    session = onnxruntime.InferenceSession(content, providers=["CPUExecutionProvider"])
    return session.run(["mu"], {"loads": loads} | more)[0][:, 0]


def random_loads(count: int, seed: int = 0, outside: bool = True) -> Array:
    """Return loads, shape (count, 5), by half a range beyond the box too where `outside`."""
    low, high = np.array(list(BOX.values())).T
    beyond = 0.5 * (high - low) if outside else 0.0
    points = np.random.default_rng(seed).uniform(low - beyond, high + beyond, size=(count, 5))
    return np.maximum(points, [0.0, -50.0, 0.0, 0.0, 0.5])


def inside(loads: Array) -> Array:
    low, high = np.array(list(BOX.values())).T
    return np.clip(loads, low, high)


def campaign() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return points and tests of a small made-up campaign with a law, run-in, roughness and a batch."""
    rng = np.random.default_rng(3)
    parts, tests = [], []
    for k in range(10):
        v, T, p = (
            rng.choice([5.0, 200.0, 500.0]),
            rng.choice([20.0, 100.0, 300.0]),
            rng.choice([500.0, 1750.0, 2750.0]),
        )
        t = np.linspace(0.0, 60.0 / v, 25)
        part = pd.DataFrame(
            {
                "test_id": f"m{k}",
                "t": t,
                "v_rel": v,
                "T": T + 30.0 * rng.random(25),
                "sigma_n": p,
                "sd": v * t,
            }
        )
        part["psi"] = rng.uniform(1.0, 20.0)
        part["mu"] = 0.08 + 1e-5 * part["T"] + 0.02 * np.exp(-part["sd"] / 4.0) + 1e-3 * rng.random(25)
        parts.append(part)
        tests.append({"test_id": f"m{k}", "Ra": rng.random(), "batch": "AB"[k % 2]})
    return pd.concat(parts, ignore_index=True), pd.DataFrame(tests)
