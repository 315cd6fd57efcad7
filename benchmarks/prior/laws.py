"""Laws with random shapes: which load they follow, whether friction rises or falls with it, and the names that describe it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pandas as pd

Array = npt.NDArray[np.float64]
#: From the points and the test table (one row a point) to a term of any size.
Term = Callable[[pd.DataFrame, np.random.Generator], Array]


@dataclass(frozen=True)
class Law:
    """A family of hidden terms.

    Attributes
    ----------
    key : str
    names : frozenset of str
        Effects that describe it; none for laws outside the catalogue.
    term : callable
        Draws one of them.
    """

    key: str
    names: frozenset[str]
    term: Term

    def alike(self, other: Law) -> bool:
        """Return whether two laws share a name, or follow the same load and may cancel."""
        return bool(self.names & other.names) or self.key.split()[0] == other.key.split()[0]


def monotone(x: Array, rng: np.random.Generator) -> Array:
    """Return a random rising function of a load, 0 to 1 over its range."""
    low, high = float(x.min()), float(x.max())
    u = (x - low) / max(high - low, 1e-12)
    kind = rng.integers(6)
    a = float(np.exp(rng.uniform(np.log(0.15), np.log(1.2))))
    c = float(rng.uniform(0.15, 0.85))
    shapes: list[Callable[[Array], Array]] = [
        lambda s: np.log1p(s / a),
        lambda s: s / (s + a),
        lambda s: np.arctan((s - c) / (0.3 * a)),
        lambda s: np.maximum(s - c, 0.0) ** (1.0 + a),
        lambda s: np.minimum(s, c) ** (0.4 + a),
        lambda s: s**2 / (s**2 + (0.3 + a) ** 2),
    ]
    y = shapes[kind](u)
    return np.asarray((y - y.min()) / max(float(np.ptp(y)), 1e-12))


def logarithm(x: Array) -> Array:
    """Return a load on the scale on which plans are spread."""
    return np.asarray(np.log(np.maximum(x, 1e-3 * float(np.max(x)) + 1e-12)))


def _load(name: str, sign: float, log: bool = False) -> Term:
    def term(points: pd.DataFrame, rng: np.random.Generator) -> Array:
        x = points[name].to_numpy(float)
        return sign * monotone(logarithm(x) if log and rng.random() < 0.7 else x, rng)

    return term


def _decay(points: pd.DataFrame, rng: np.random.Generator) -> Array:
    """Return something that fades at the start of each test."""
    sd = points["sd"].to_numpy(float)
    length = float(np.exp(rng.uniform(np.log(0.02), np.log(0.3)))) * float(sd.max())
    return np.asarray((1.0 + sd / length) ** -float(rng.uniform(1.5, 4.0)))


def _wear(points: pd.DataFrame, rng: np.random.Generator) -> Array:
    sd = points["sd"].to_numpy(float)
    return monotone(sd, rng)


def _work(points: pd.DataFrame, rng: np.random.Generator) -> Array:
    """Return what grows with the pressure that a place has seen along its way."""
    way = points.groupby("test_id")["sd"].diff().fillna(0.0).to_numpy(float)
    load = points["sigma_n"].to_numpy(float) ** float(rng.uniform(0.8, 1.2)) * way
    return monotone(load_sum(points, load), rng)


def load_sum(points: pd.DataFrame, values: Array) -> Array:
    """Return the sum along each test."""
    return np.asarray(pd.Series(values).groupby(points["test_id"].to_numpy()).cumsum().to_numpy(float))


def _heat(points: pd.DataFrame, rng: np.random.Generator) -> Array:
    """Return a fall with the flash temperature of a sliding contact, pressure times a power of speed near one half."""
    heat = points["sigma_n"].to_numpy(float) * points["v_rel"].to_numpy(float) ** float(rng.uniform(0.4, 0.6))
    return -monotone(heat, rng)


def _lubricated(points: pd.DataFrame, rng: np.random.Generator) -> Array:
    """Return a fall with viscosity (Andrade) times speed over pressure."""
    kelvin = points["T"].to_numpy(float) + 273.15
    viscosity = np.exp(rng.uniform(1500.0, 4500.0) * (1.0 / kelvin - 1.0 / 293.15))
    return -monotone(
        logarithm(viscosity * points["v_rel"].to_numpy(float) / points["sigma_n"].to_numpy(float)), rng
    )


def _hot_pressure(points: pd.DataFrame, rng: np.random.Generator) -> Array:
    """Return a rise above a pressure that sinks linearly with temperature."""
    limit = 1.0 - rng.uniform(0.4, 0.9) * points["T"].to_numpy(float) / (1.2 * float(points["T"].max()))
    return monotone(np.maximum(points["sigma_n"].to_numpy(float) / limit, 0.0), rng)


def _levels(column: str) -> Term:
    def term(points: pd.DataFrame, rng: np.random.Generator) -> Array:
        names = sorted(points[column].unique())
        odd = names[rng.integers(len(names))]
        return np.asarray((points[column] == odd).to_numpy(float) * rng.choice([-1.0, 1.0]))

    return term


def _number(column: str) -> Term:
    def term(points: pd.DataFrame, rng: np.random.Generator) -> Array:
        x = points[column].to_numpy(float)
        return np.asarray((x / x.max()) ** float(rng.uniform(0.7, 1.4)))

    return term


def _bump(points: pd.DataFrame, rng: np.random.Generator) -> Array:
    """Return a hump or a hollow in the middle of one load."""
    x = points[str(rng.choice(["v_rel", "T", "sigma_n", "psi"]))].to_numpy(float)
    u = (x - x.min()) / max(float(np.ptp(x)), 1e-12)
    bump = np.exp(-0.5 * ((u - rng.uniform(0.35, 0.65)) / rng.uniform(0.1, 0.2)) ** 2)
    return np.asarray(rng.choice([-1.0, 1.0]) * bump)


def _wave(points: pd.DataFrame, rng: np.random.Generator) -> Array:
    sd = points["sd"].to_numpy(float)
    return np.asarray(np.sin(2 * np.pi * rng.uniform(1.5, 4.0) * sd / sd.max() + rng.uniform(0, 6.3)))


def _product(points: pd.DataFrame, rng: np.random.Generator) -> Array:
    """Return two loads that work against each other: neither has an effect of its own in the middle of the other."""
    pairs = [("psi", "v_rel"), ("psi", "T"), ("psi", "sigma_n"), ("sigma_n", "T")]
    a, b = pairs[rng.integers(len(pairs))]
    z = [points[n].to_numpy(float) for n in (a, b)]
    z = [(x - x.mean()) / max(float(x.std()), 1e-12) for x in z]
    return np.asarray(np.tanh(z[0]) * np.tanh(z[1]))


#: Effects that fall with speed and that no plan of constant speeds tells apart.
FALLING = frozenset({"stribeck", "rate_state", "flash_temperature"})

LAWS = [
    Law("speed falls", FALLING | {"hersey"}, _load("v_rel", -1.0, True)),
    Law("speed rises", frozenset({"rising_speed", "viscous", "rate_state"}), _load("v_rel", 1.0, True)),
    Law("temperature falls", frozenset({"thermal_softening", "twin_heating"}), _load("T", -1.0)),
    Law("temperature rises", frozenset({"thermal_breakdown", "twin_heating"}), _load("T", 1.0)),
    Law("pressure falls", frozenset({"pressure_power", "pressure_saturation", "force_zero"}), _load("sigma_n", -1.0, True)),
    Law("expansion rises", frozenset({"surface_expansion"}), _load("psi", 1.0)),
    Law("start", frozenset({"running_in", "static_peak", "rate_state"}), _decay),
    Law("wear", frozenset({"wear_out", "work_exhaustion", "running_in"}), _wear),
    Law("work", frozenset({"work_exhaustion", "wear_out"}), _work),
    Law("flash", FALLING, _heat),
    Law("lubricated", FALLING | {"hersey", "viscous"}, _lubricated),
    Law("hot pressure", frozenset({"hot_pressure_breakdown"}), _hot_pressure),
    Law("batch", frozenset({"batch"}), _levels("batch")),
    Law("lot", frozenset({"factor:lot"}), _levels("lot")),
    Law("roughness", frozenset({"tool_roughness"}), _number("Ra")),
    Law("order", frozenset({"sensor_drift"}), _number("order")),
]  # fmt: skip

OUTSIDE = [
    Law("bump", frozenset(), _bump),
    Law("wave", frozenset(), _wave),
    Law("product", frozenset(), _product),
]
