"""Graphs with memory that is an ODE, for the tests of model exchange and of FMI 3.0."""

from __future__ import annotations

import numpy as np

from tests.fmus.graphs import BOX, Array, graph_bytes, node

#: mu = B + K age + R Ra + C T, d(age)/dt = 1 - v_rel age / D.
B, K, R, C, D = 0.05, 0.02, 0.1, 1e-4, 20.0
AGE_0 = 2.0


def ageing_bytes(distance: float = D) -> bytes:
    """Return a rate-and-state model whose memory has a closed form at constant speed; it fades over `distance`."""
    nodes = [
        node("Gather", "loads i0", "v", axis=1),
        node("Gather", "loads i1", "temperature", axis=1),
        node("Mul", "v state", "slip"),
        node("Mul", "slip per_d", "lost"),
        node("Sub", "one lost", "state_der"),
        node("Mul", "state_der dt", "gain"),
        node("Add", "state gain", "state_next"),
        node("Mul", "state k", "m1"),
        node("Mul", "system r", "m2"),
        node("Mul", "temperature c", "m3"),
        node("Add", "m1 m2", "m4"),
        node("Add", "m3 m4", "m5"),
        node("Add", "m5 b", "mu"),
    ]
    constants = {
        "i0": np.array([0]),
        "i1": np.array([1]),
        "per_d": np.array(1.0 / distance),
        "one": np.array(1.0),
        "k": np.array(K),
        "r": np.array(R),
        "c": np.array(C),
        "b": np.array(B),
    }
    return graph_bytes(
        nodes,
        constants,
        {"state": ["n", 1], "dt": [1], "system": [1, 1]},
        {"state_next": ["n", 1], "state_der": ["n", 1]},
        {
            "domain": BOX,
            "model": {"family": "composed", "name": "ageing", "formula": "age"},
            "state": [{"name": "age", "unit": "s", "start": AGE_0, "ode": True}],
            "system": [{"name": "Ra", "unit": "um", "start": 0.2, "min": 0.1, "max": 2.0}],
        },
    )


def age_at(t: Array | float, speed: float, start: float = AGE_0) -> Array:
    """Return the exact age after time `t` at constant speed."""
    steady = D / speed
    return np.asarray(steady + (start - steady) * np.exp(-speed * np.asarray(t) / D))


def mu_at(age: Array | float, temperature: Array | float, roughness: float = 0.2) -> Array:
    """Return the friction coefficient of `ageing_bytes`."""
    return np.asarray(B + K * np.asarray(age) + R * roughness + C * np.asarray(temperature))
