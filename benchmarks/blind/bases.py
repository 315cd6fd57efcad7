"""The user's base model: what friction is without the hidden laws, what the user hands over, and what it can follow."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.blind.campaign import LOADS, Array, Campaign, Rng
from friction_models import ConstantFriction, PowerLawFriction

REFERENCE = {
    "v_rel": (150.0, 200.0),
    "T": (120.0, 120.0),
    "sigma_n": (1500.0, 1000.0),
    "sd": (28.0, 25.0),
    "psi": (6.0, 8.0),
}


def _scaled(c: Campaign) -> Array:
    return np.stack([(c.load(n) - REFERENCE[n][0]) / REFERENCE[n][1] for n in LOADS], axis=1)


def true_base(name: str, c: Campaign, rng: Rng) -> Array:
    """Friction without the hidden laws: a law that the base model can follow exactly."""
    level = round(float(rng.uniform(0.055, 0.085)), 3)
    x = _scaled(c)
    flat = np.full(len(x), level)
    if name in ("constant", "number"):
        return flat
    linear = flat + x @ (np.array([0.002, -0.003, -0.003, 0.0015, 0.002]) * rng.uniform(0.3, 1.2, 5))
    if name == "linear":
        return linear
    if name == "polynomial":
        pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 4)]
        return linear + sum(
            a * x[:, i] * x[:, j] for a, (i, j) in zip(0.0015 * rng.standard_normal(6), pairs)
        )
    # What the power law of the project follows exactly is what it predicts itself.
    p = c.points
    grey = (
        level
        * (p["v_rel"] / 100) ** -0.04
        * (p["sigma_n"] / 1500) ** -0.1
        * p["psi"] ** 0.04
        * np.exp(-4e-4 * (p["T"] - 100))
    )
    fitted = PowerLawFriction().fit_frame(c.table(grey.to_numpy(float)))
    return np.asarray(fitted.predict_frame(c.table(grey.to_numpy(float))), float)


def handed_over(name: str, base: Array) -> Any:
    """What the user gives to the diagnosis: the name of a family, or a number that is the true level."""
    return ConstantFriction(round(float(base.mean()), 3)) if name == "number" else name


def design(name: str, c: Campaign, base: Array) -> Array:
    """Columns that the refitted base model can follow (to first order)."""
    ones = np.ones((len(c.points), 1))
    if name in ("constant", "number"):
        return ones
    x = _scaled(c)
    if name == "linear":
        return np.hstack([ones, x])
    if name == "polynomial":
        second = [x[:, i] * x[:, j] for i in range(5) for j in range(i, 5)]
        return np.hstack([ones, x, np.stack(second, axis=1)])
    logs = [
        np.log(c.load("v_rel")),
        np.log(c.load("sigma_n")),
        np.log(c.load("psi")),
        np.log1p(c.load("sd")),
        c.load("T") / 100,
    ]
    return base[:, None] * np.hstack([ones, np.stack(logs, axis=1)])
