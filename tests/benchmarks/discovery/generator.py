"""Synthetic campaigns with hidden effects, nulls of several kinds, and structure outside the catalogue.

Nothing here comes from the diagnosis or its catalogue, nor from the made-up campaigns of the tests: the forms are
sums, ratios and powers of their own, loads come from a plan with random held-out tests, and the strength of what is hidden is
drawn at random.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

Array = np.ndarray
#: Distance between points [mm]; the twin gives one every 0.1 mm, every fifth is enough here.
SPACING = 0.5
LENGTH = 52.0
#: Scatter between tests, drift within a test and sensor noise of a point, in mu.
SCATTER, DRIFT, SENSOR = 0.005, 0.0015, 0.0025
#: Noise levels: factor on all three.
NOISE_LEVELS = (0.6, 1.0, 1.6)


@dataclass
class Test:
    """True loads and metadata of one test."""

    __test__ = False

    v: Array
    T: Array
    sigma: Array
    sd: Array
    psi: Array
    t: Array
    T_tool: float
    order: float
    Ra: float
    batch: str

    @property
    def work(self) -> Array:
        """Friction work at a mu of 0.07 [J/mm2]."""
        return np.cumsum(0.07 * self.sigma * SPACING) * 1e-3

    def remembered(self, length: float) -> Array:
        """Logarithm of the speed, remembered over a distance."""
        logs = np.log(self.v + 1.0)
        out = np.empty_like(logs)
        out[0] = logs[0] - 1.5
        for k in range(1, len(logs)):
            out[k] = out[k - 1] + (logs[k] - out[k - 1]) * SPACING / (length + SPACING)
        return out


Form = Callable[[Test], Array]


def _smooth_step(x: Array) -> Array:
    """From 0 to 1, with tails of the third power."""
    return 0.5 + 0.5 * x / (1.0 + np.abs(x) ** 3) ** (1.0 / 3.0)


EFFECTS: dict[str, Form] = {
    "stribeck": lambda r: (1.0 + r.v / 30.0) ** -0.9,
    "viscous": lambda r: (
        (r.v / 500.0) ** 0.6
        * (60.0 / (60.0 + np.maximum(r.T - 20.0, 0.0)))
        * (1500.0 / (r.sigma + 300.0)) ** 0.5
    ),
    "thermal_softening": lambda r: 1.0 / np.cosh(np.maximum(r.T - 20.0, 0.0) / 150.0),
    "thermal_breakdown": lambda r: _smooth_step((r.T - 310.0) / 22.0),
    "pressure_saturation": lambda r: np.log1p(r.sigma / 350.0) / (r.sigma / 350.0),
    "pressure_power": lambda r: (r.sigma / 600.0) ** -0.45,
    "surface_expansion": lambda r: np.tanh((r.psi - 1.0) / 0.3),
    "running_in": lambda r: 1.0 / (1.0 + (r.sd / 3.0) ** 1.5),
    "wear_out": lambda r: np.maximum(r.sd - 33.0, 0.0) ** 1.7 / 100.0,
    "work_exhaustion": lambda r: _smooth_step((r.work - 3.2) / 0.7),
    "flash_temperature": lambda r: -_smooth_step((r.sigma * np.sqrt(r.v) - 14000.0) / 9000.0),
    "static_peak": lambda r: np.maximum(1.0 - (r.sd / 1.4) ** 2, 0.0),
    "rate_state": lambda r: 0.7 * np.log(r.v + 1.0) - r.remembered(2.0),
    "batch": lambda r: np.full_like(r.v, 1.0 if r.batch == "B" else 0.0),
    "tool_roughness": lambda r: np.full_like(r.v, np.arctan(r.Ra / 0.08)),
    "sensor_drift": lambda r: np.full_like(r.v, r.order**1.2 / 200.0),
    "twin_heating": lambda r: np.maximum(r.T - r.T_tool, 0.0) ** 0.95 / 100.0,
    "force_zero": lambda r: -1.0 / (r.sigma * 1e-3 + 0.05),
}
#: Structure that no effect of the catalogue describes.
OUTSIDE: dict[str, Form] = {
    "hump in temperature": lambda r: 1.0 / (1.0 + ((r.T - 240.0) / 45.0) ** 4),
    "speed by expansion": lambda r: np.tanh((r.v - 220.0) / 150.0) * (r.psi - 1.4),
    "waves along the distance": lambda r: np.cos(r.sd / 2.4),
    "ridge in pressure and speed": lambda r: (
        1.0 / (1.0 + ((r.sigma - 1700.0) / 500.0) ** 2 + ((np.log(r.v) - 4.5) / 0.8) ** 2)
    ),
}
PAIRS: tuple[tuple[str, str], ...] = (
    ("stribeck", "wear_out"),
    ("thermal_breakdown", "running_in"),
    ("surface_expansion", "work_exhaustion"),
)
#: Kinds of campaigns in which nothing is missing.
NULLS = ("plain", "wide scatter and slow drift", "curved noise")


def campaign(
    seed: int, hidden: tuple[str, ...] = (), null: str = "plain", noise: float = 1.0
) -> tuple[pd.DataFrame, pd.DataFrame, Array, float]:
    """Return points, tests, the hidden part of mu at each point, and its strength over the test scatter.

    Parameters
    ----------
    seed : int
    hidden : tuple of str
        Names of `EFFECTS` and `OUTSIDE`; their rms together is drawn from 0.5 to 2 times the scatter each.
    null : {"plain", "wide scatter and slow drift", "curved noise"}
        How tests scatter: normal offsets; offsets with heavy tails and a drift over half a test; noise that grows with
        pressure.
    noise : float
        Factor on scatter, drift and sensor noise.
    """
    rng = np.random.default_rng([seed, 31, 4159])
    tests = [_test(rng, *point, order) for order, point in zip(rng.permutation(111), _plan(rng), strict=True)]
    forms = {**EFFECTS, **OUTSIDE}
    part = [np.zeros(len(r.v)) for r in tests]
    strength = 0.0
    for name in hidden:
        values = [forms[name](r) for r in tests]
        strength = float(rng.uniform(0.5, 2.0))
        size = strength * SCATTER * noise / float(np.std(np.concatenate(values)))
        part = [p + size * v for p, v in zip(part, values, strict=True)]
    slopes = rng.uniform(0.4, 1.4, 5) * [1.2e-5, -3e-5, -7e-6, 9e-5, 0.007]
    bias = rng.normal(0.0, [0.012, 0.02, 0.02])  # of the twin: pressure, heating, expansion
    frames, rows = [], []
    for k, (r, p) in enumerate(zip(tests, part, strict=True)):
        level = 0.072 + slopes @ [r.v, r.T, r.sigma - 1500.0, r.sd, r.psi - 1.0]
        mu = level + p + noise * _noise(r, null, rng)
        own = bias + rng.normal(0.0, [0.006, 0.01, 0.01])
        frames.append(
            pd.DataFrame(
                {
                    "test_id": f"b{k:03d}",
                    "t": r.t,
                    "v_rel": r.v,
                    "T": r.T_tool + (r.T - r.T_tool) * (1.0 + own[1]),
                    "sigma_n": r.sigma * (1.0 + own[0]),
                    "sd": r.sd,
                    "psi": 1.0 + (r.psi - 1.0) * (1.0 + own[2]),
                    "mu": np.maximum(mu, 0.002),
                }
            )
        )
        role = "train" if k < 81 else "test"
        rows.append(
            {
                "test_id": f"b{k:03d}",
                "order": r.order,
                "T_tool": r.T_tool,
                "Ra": r.Ra,
                "batch": r.batch,
                "role": role,
            }
        )
    return pd.concat(frames, ignore_index=True), pd.DataFrame(rows), np.concatenate(part), strength


def _plan(rng: np.random.Generator) -> list[tuple[float, float, float, float]]:
    """Return 81 tests on three levels of pressure, expansion, speed and tool temperature, and 30 between."""
    grid = (
        np.array(np.meshgrid([520, 1700, 2700], [1.07, 1.35, 1.75], [5, 180, 480], [25, 110, 290]))
        .reshape(4, -1)
        .T
    )
    low, high = grid.min(axis=0), grid.max(axis=0)
    between = rng.uniform(low, high, (30, 4))
    slow = rng.random(30) < 0.4
    between[slow, 2] = np.exp(rng.uniform(np.log(5.0), np.log(480.0), slow.sum()))
    return [tuple(map(float, row)) for row in (*grid, *between)]  # type: ignore[misc]


def _test(
    rng: np.random.Generator, sigma: float, psi: float, v_set: float, T_tool: float, order: int
) -> Test:
    sd = np.arange(0.5 * SPACING, LENGTH, SPACING)
    start = rng.uniform(0.2, 3.0) * (0.2 + v_set / 400.0)
    v = v_set * (1.0 - np.exp(-(sd + 0.05) / start)) * (1.0 + 0.01 * np.sin(sd / rng.uniform(4.0, 9.0)))
    t = np.cumsum(SPACING / v)
    pressure = sigma * (1.0 + rng.normal(0.0, 0.01)) * (1.0 - rng.uniform(0.0, 0.06) * sd / LENGTH)
    rise = 2.1e-3 * sigma * np.sqrt(v * sd) / (1.0 + 2.1e-3 * sigma * np.sqrt(v * sd) / 650.0)
    T = T_tool + 18.0 * (psi - 1.0) * sigma / 1700.0 + rise
    swell = psi + rng.uniform(0.0, 0.04) * sd / LENGTH
    return Test(
        v, T, pressure, sd, swell, t, T_tool, float(order), float(rng.choice([0.02, 0.06, 0.12, 0.25])),
        str(rng.choice(["A", "B", "B"])),
    )  # fmt: skip


def _noise(r: Test, null: str, rng: np.random.Generator) -> Array:
    """Return what scatters in one test: its offset, a drift along it, noise of the points."""
    n = len(r.sd)
    offset = SCATTER * rng.standard_normal()
    length, drift, sensor = 9.0, DRIFT, np.full(n, SENSOR)
    if null == "wide scatter and slow drift":
        offset, length, drift = 0.77 * SCATTER * rng.standard_t(5), 26.0, 1.3 * DRIFT
    elif null == "curved noise":
        sensor = SENSOR * (0.5 + r.sigma / 1700.0)
    keep = float(np.exp(-SPACING / length))
    kicks = rng.standard_normal(n) * drift * np.sqrt(1.0 - keep**2)
    kicks[0] = drift * rng.standard_normal()
    wander = np.empty(n)
    wander[0] = kicks[0]
    for k in range(1, n):
        wander[k] = keep * wander[k - 1] + kicks[k]
    return np.asarray(
        offset + wander + sensor * rng.standard_normal(n) / np.sqrt(max(1.0, min(5.0, 500.0 / r.v[-1])))
    )
