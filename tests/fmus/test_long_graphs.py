"""Graphs of thousands of nodes: their C is written in short functions, which compilers take in linear time."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from fmus.interface.friction_source import parse_source
from fmus.native.generate import generate
from tests.fmus.compiled import Compiled
from tests.fmus.graphs import graph_bytes, node, random_loads, runtime

NODES = 1500


def long_bytes(nodes: int, reach: int) -> bytes:
    """Return a chain in which every third node also takes what was computed `reach` nodes before, and a vector."""
    made = [
        node("Gather", "loads i0", "start", axis=1),
        node("Mul", "start small", "v0"),
        node("MatMul", "loads w", "vector"),
    ]
    for k in range(1, nodes):
        if k % 3 == 0:
            made.append(node("Add", f"v{k - 1} v{max(0, k - reach)}", f"v{k}"))
        elif k % 3 == 1:
            made.append(node("Tanh", f"v{k - 1}", f"v{k}"))
        else:
            made.append(node("Mul", f"v{k - 1} c{k % 5}", f"v{k}"))
    made += [node("Tanh", "vector", "bent"), node("ReduceSum", "bent axes", "sum", keepdims=1)]
    made += [node("Add", f"v{nodes - 1} sum", "wide"), node("Add", "wide one", "mu")]
    constants = {f"c{k}": np.array(0.5 + 0.1 * k) for k in range(5)}
    constants |= {"i0": np.array([1]), "small": np.array(1e-2), "axes": np.array([1]), "one": np.array(2.5)}
    return graph_bytes(made, constants | {"w": np.full((5, 3), 1e-4) * [1.0, 2.0, -1.0]})


def lengths(text: str) -> dict[str, int]:
    """Return the statements of every C function that is generated."""
    found = re.findall(r"^TF_INLINE void (tf_model_\w+)_body\(.*?\{\n(.*?)^}", text, flags=re.M | re.S)
    return {name: body.count("\n") for name, body in found}


def test_no_function_is_long() -> None:
    few, many = (
        lengths(generate(source, source.interface(1)))
        for source in (parse_source(long_bytes(n, 40), "x") for n in (2 * NODES, 8 * NODES))
    )
    assert max(few.values()) < 700 and max(many.values()) < 700
    assert len(many) < 5 * len(few)


@pytest.mark.parametrize("reach", [2, 700])
def test_a_long_graph_computes_what_onnx_runtime_does(reach: int, tmp_path: Path) -> None:
    content = long_bytes(NODES, reach)
    long = Compiled({"long": content}, tmp_path)
    assert any("_part3" in name for name in lengths((tmp_path / "model_0.h").read_text()))
    loads = random_loads(40, seed=2)
    expected = runtime(content, loads)
    assert np.ptp(expected) > 1e-3
    for build in long.builds():
        np.testing.assert_allclose(long.mu("long", loads, build=build), expected, rtol=1e-12)
        np.testing.assert_array_equal(
            long.mu("long", loads, build=build), long.mu("long", loads, build=build, first=0)
        )
    along = np.ones_like(loads)
    value, slope = long.derivative("mu", "long", (loads, None, None), (along, np.zeros((40, 0)), np.zeros(0)))
    np.testing.assert_allclose(value, expected, rtol=1e-12)
    h = 1e-4
    central = (runtime(content, loads + h * along) - runtime(content, loads - h * along)) / (2.0 * h)
    np.testing.assert_allclose(slope, central, rtol=1e-6, atol=1e-9)
