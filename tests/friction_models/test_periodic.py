"""Cosines from the functions of every back end."""

from __future__ import annotations

import math

import numpy as np
import onnxruntime
import pytest

from friction_models.expressions.onnx_graph import GraphBuilder, OnnxOps
from friction_models.expressions.ops import NumpyOps
from friction_models.expressions.periodic import cosine


@pytest.mark.parametrize("most", [1, 2, 3, 32, 64])
def test_graphs_and_arrays_give_the_cosine_of_the_mathematical_library(most: int) -> None:
    turns = np.linspace(-most, most, 1001)[:, None]
    exact = np.array([[math.cos(2.0 * math.pi * t)] for t in turns[:, 0]])
    graph = GraphBuilder()
    graph.output("y", cosine(OnnxOps(graph), graph.input("x", ["n", 1]), most), ["n", 1])
    model = graph.build()
    (drawn,) = onnxruntime.InferenceSession(model.SerializeToString()).run(None, {"x": turns})
    np.testing.assert_allclose(drawn, exact, atol=1e-13)
    np.testing.assert_allclose(cosine(NumpyOps(), turns, most), exact, atol=1e-13)
    assert {n.op_type for n in model.graph.node} == {"Abs", "Sub", "Mul", "Add", "Identity"}
