"""What campaigns hide: two sets of forms, none of them a form of the catalogue, each with a plan of its own.

Both were used, on seeds of their own, while the diagnosis was developed; the check is a third set (`form_sets`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.special import erfc

Array = np.ndarray


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
    def spacing(self) -> float:
        """Distance between points [mm]."""
        return float(self.sd[1] - self.sd[0])

    @property
    def work(self) -> Array:
        """Friction work at a mu of 0.07 [J/mm2]."""
        return np.cumsum(0.07 * self.sigma * self.spacing) * 1e-3

    def remembered(self, length: float) -> Array:
        """Logarithm of the speed, remembered over a distance."""
        logs = np.log(self.v + 1.0)
        out = np.empty_like(logs)
        out[0] = logs[0] - 1.5
        for k in range(1, len(logs)):
            out[k] = out[k - 1] + (logs[k] - out[k - 1]) * self.spacing / (length + self.spacing)
        return out


Form = Callable[[Test], Array]
#: Pressure [MPa], expansion, speed [mm/s] and tool temperature [degC] of a test.
Setpoint = tuple[float, float, float, float]


def _smooth_step(x: Array) -> Array:
    """From 0 to 1, with tails of the third power."""
    return 0.5 + 0.5 * x / (1.0 + np.abs(x) ** 3) ** (1.0 / 3.0)


def _cubic_step(x: Array) -> Array:
    """From 0 at 0 to 1 at 1, flat outside."""
    z = np.clip(x, 0.0, 1.0)
    return z * z * (3.0 - 2.0 * z)


def _level(r: Test, value: float) -> Array:
    return np.full_like(r.v, value)


@dataclass(frozen=True)
class Forms:
    """Effects under the names of the catalogue, structure outside it, pairs, and what a campaign looks like.

    Attributes
    ----------
    effects, outside : mapping of str to Form
    pairs : tuple of pairs of str
    plan : callable
        Returns the setpoints of the training and of the held-out tests.
    length, spacing : float
        Distance of a test and between its points [mm].
    heating : callable
        Rise of the contact temperature [K] of (pressure, speed, distance).
    batches : tuple of str
        Drawn at random; the first one deviates.
    """

    effects: Mapping[str, Form]
    outside: Mapping[str, Form]
    pairs: tuple[tuple[str, str], ...]
    plan: Callable[[np.random.Generator], tuple[list[Setpoint], list[Setpoint]]]
    length: float
    spacing: float
    heating: Callable[[Array, Array, Array], Array]
    batches: tuple[str, ...] = field(default=("B", "B", "A"))


def _three_levels(rng: np.random.Generator) -> tuple[list[Setpoint], list[Setpoint]]:
    """Return 81 tests on three levels of pressure, expansion, speed and tool temperature, and 30 between."""
    levels = np.meshgrid([520, 1700, 2700], [1.07, 1.35, 1.75], [5, 180, 480], [25, 110, 290])
    grid = np.array(levels).reshape(4, -1).T
    low, high = grid.min(axis=0), grid.max(axis=0)
    between = rng.uniform(low, high, (30, 4))
    slow = rng.random(30) < 0.4
    between[slow, 2] = np.exp(rng.uniform(np.log(5.0), np.log(480.0), slow.sum()))
    return _setpoints(grid), _setpoints(between)


def _latin(rng: np.random.Generator) -> tuple[list[Setpoint], list[Setpoint]]:
    """Return 90 tests of a Latin hypercube, even in the logarithm of the speed, and 30 of another."""
    low = np.array([400.0, 1.03, np.log(8.0), 20.0])
    high = np.array([2500.0, 1.9, np.log(520.0), 260.0])

    def cube(count: int) -> list[Setpoint]:
        places = np.column_stack([rng.permutation(count) for _ in low])
        points = low + (high - low) * (places + rng.random(places.shape)) / count
        points[:, 2] = np.exp(points[:, 2])
        return _setpoints(points)

    return cube(90), cube(30)


def _setpoints(rows: Array) -> list[Setpoint]:
    return [(float(a), float(b), float(c), float(d)) for a, b, c, d in rows]


def _jaeger(sigma: Array, v: Array, sd: Array) -> Array:
    rise = 2.1e-3 * sigma * np.sqrt(v * sd)
    return rise / (1.0 + rise / 650.0)


def _losing(sigma: Array, v: Array, sd: Array) -> Array:
    return 420.0 * (1.0 - np.exp(-(sigma / 1500.0) * (v / 250.0) ** 0.55 * (sd / 25.0) ** 0.45))


FIRST = Forms(
    effects={
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
        "batch": lambda r: _level(r, float(r.batch == "B")),
        "tool_roughness": lambda r: _level(r, np.arctan(r.Ra / 0.08)),
        "sensor_drift": lambda r: _level(r, r.order**1.2 / 200.0),
        "twin_heating": lambda r: np.maximum(r.T - r.T_tool, 0.0) ** 0.95 / 100.0,
        "force_zero": lambda r: -1.0 / (r.sigma * 1e-3 + 0.05),
    },
    outside={
        "hump in temperature": lambda r: 1.0 / (1.0 + ((r.T - 240.0) / 45.0) ** 4),
        "speed by expansion": lambda r: np.tanh((r.v - 220.0) / 150.0) * (r.psi - 1.4),
        "waves along the distance": lambda r: np.cos(r.sd / 2.4),
        "ridge in pressure and speed": lambda r: (
            1.0 / (1.0 + ((r.sigma - 1700.0) / 500.0) ** 2 + ((np.log(r.v) - 4.5) / 0.8) ** 2)
        ),
    },
    pairs=(
        ("stribeck", "wear_out"),
        ("thermal_breakdown", "running_in"),
        ("surface_expansion", "work_exhaustion"),
    ),
    plan=_three_levels,
    length=52.0,
    spacing=0.5,
    heating=_jaeger,
)

SECOND = Forms(
    effects={
        "stribeck": lambda r: erfc(np.log(r.v / 40.0) / 1.2),
        "viscous": lambda r: np.log1p(r.v / 150.0 * (300.0 / (r.T + 280.0)) ** 3 * (1000.0 / r.sigma) ** 0.6),
        "thermal_softening": lambda r: (1.0 + np.maximum(r.T - 20.0, 0.0) / 160.0) ** -2.0,
        "thermal_breakdown": lambda r: _cubic_step((r.T - 255.0) / 90.0),
        "pressure_saturation": lambda r: (1.0 + (r.sigma / 800.0) ** 3) ** (-1.0 / 3.0),
        "pressure_power": lambda r: np.maximum(r.sigma - 120.0, 50.0) ** -0.75 * 100.0,
        "surface_expansion": lambda r: 1.0 - np.maximum(r.psi, 1.0) ** -4.0,
        "running_in": lambda r: -erfc((r.sd - 2.0) / 2.5),
        "wear_out": lambda r: np.exp((r.sd - 40.0) / 6.5),
        "work_exhaustion": lambda r: r.work**4 / (r.work**4 + 2.2**4),
        "flash_temperature": lambda r: np.exp(-((r.sigma * np.sqrt(r.v) / 13000.0) ** 1.4)),
        "static_peak": lambda r: 1.0 / (1.0 + (r.sd / 0.7) ** 4),
        "rate_state": lambda r: 0.75 * np.log(r.v + 1.0) - 0.6 * r.remembered(1.2) - 0.4 * r.remembered(4.0),
        "batch": lambda r: _level(r, float(r.batch == "C")),
        "tool_roughness": lambda r: _level(r, np.log1p(r.Ra / 0.05)),
        "sensor_drift": lambda r: _level(r, 1.0 - np.exp(-r.order / 90.0)),
        "twin_heating": lambda r: np.log1p(np.maximum(r.T - r.T_tool, 0.0) / 500.0),
        "force_zero": lambda r: -1.0 / (r.sigma - 90.0),
    },
    outside={
        "dip in pressure": lambda r: -np.exp(-(((r.sigma - 1450.0) / 320.0) ** 2)),
        "waves in temperature": lambda r: np.sin(r.T / 28.0),
        "temperature by expansion": lambda r: np.arctan((r.T - 220.0) / 60.0) * np.tanh((r.psi - 1.45) / 0.2),
        "saw along the distance": lambda r: (r.sd / 11.0) % 1.0,
    },
    pairs=(
        ("thermal_softening", "wear_out"),
        ("running_in", "tool_roughness"),
        ("stribeck", "surface_expansion"),
    ),
    plan=_latin,
    length=41.0,
    spacing=0.4,
    heating=_losing,
    batches=("C", "A", "D", "A"),
)
