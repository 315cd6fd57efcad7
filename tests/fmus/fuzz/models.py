"""Small models of every kind that the C interface treats differently."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pandas as pd

from friction_models.families.registry import make_model
from tests.fmus.graphs import BOX, campaign, graph_bytes, node


def network() -> bytes:
    """No memory: a dense network of tanh units with random weights; its sum may become negative."""
    rng = np.random.default_rng(4)
    nodes = [
        node("Gemm", "loads w1 b1", "a1"),
        node("Tanh", "a1", "h1"),
        node("Gemm", "h1 w2 b2", "a2"),
        node("Sigmoid", "a2", "h2"),
        node("Gemm", "h2 w3 b3", "mu"),
    ]
    constants = {
        "w1": rng.normal(size=(5, 9)) / np.array([[300.0], [200.0], [1500.0], [30.0], [10.0]]),
        "b1": rng.normal(size=9),
        "w2": rng.normal(size=(9, 7)),
        "b2": rng.normal(size=7),
        "w3": rng.normal(size=(7, 1)) * 0.1,
        "b3": np.array([0.05]),
    }
    return graph_bytes(nodes, constants, metadata={"domain": BOX, "model": {"family": "ffnn", "name": "net"}})


def memory() -> bytes:
    """Memory that is advanced by steps, and a system variable; two states, so that their order counts."""
    nodes = [
        node("Gather", "loads i0", "v", axis=1),
        node("Mul", "v dt", "travel"),
        node("Mul", "travel c", "gain"),
        node("Add", "state gain", "state_next"),
        node("ReduceSum", "state one", "total", keepdims=1),
        node("Mul", "total a", "m1"),
        node("Mul", "system r", "m2"),
        node("Add", "m1 m2", "m3"),
        node("Add", "m3 b", "mu"),
    ]
    constants = {
        "i0": np.array([0]),
        "c": np.array([[0.01, -0.02]]),
        "one": np.array([1]),
        "a": np.array(0.01),
        "r": np.array(0.1),
        "b": np.array(0.05),
    }
    return graph_bytes(
        nodes,
        constants,
        {"state": ["n", 2], "dt": [1], "system": [1, 1]},
        {"state_next": ["n", 2]},
        {
            "domain": BOX,
            "model": {"family": "composed", "name": "memory"},
            "state": [
                {"name": "work", "unit": "mm", "start": 1.0, "ode": False},
                {"name": "wear", "unit": "mm", "start": 0.5, "ode": False},
            ],
            "system": [{"name": "Ra", "unit": "um", "start": 0.2, "min": 0.0, "max": 2.0}],
        },
    )


def wild() -> bytes:
    """No memory, and values that are not finite in the middle of the domain: exp(T) sigma_n / sd."""
    nodes = [
        *(node("Gather", f"loads i{k}", f"x{k}", axis=1) for k in (1, 2, 3)),
        node("Exp", "x1", "e"),
        node("Mul", "e x2", "m"),
        node("Div", "m x3", "mu"),
    ]
    return graph_bytes(
        nodes,
        {f"i{k}": np.array([k]) for k in (1, 2, 3)},
        metadata={"domain": BOX, "model": {"family": "wild", "name": "wild"}},
    )


@cache
def _data() -> tuple[pd.DataFrame, pd.DataFrame]:
    return campaign()


def ode() -> object:
    """Memory as a differential equation, with powers and logarithms around it."""
    return (make_model("power_law") + "rate_state").fit_frame(*_data())


def boosting() -> object:
    """Trees."""
    return make_model("gradient_boosting").fit_frame(*_data())


MODELS: dict[str, Callable[[], object]] = {
    "network": network,
    "memory": memory,
    "wild": wild,
    "ode": ode,
    "boosting": boosting,
}
