"""Noise recipes: what happens between true friction and the record."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .profiles import Profiles

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Recipe:
    """Scatter, sensor and plan of a campaign.

    Attributes
    ----------
    name : str
        Name of the recipe.
    plan : str
        ``any`` (drawn: full plus random or a cube with repeats), ``half``, ``unbalanced`` or ``lhs30``.
    offset : str
        ``normal`` or ``skewed`` test offsets (and sensor noise).
    hetero : bool
        Scatter grows with pressure and tool temperature.
    quantum : float
        Step of the friction force as a share of its range; 0: none.
    hum : float
        Amplitude of 50 Hz hum against the sensor noise.
    walk : bool
        Drift inside a test is a random walk instead of a stationary process.
    odd : int
        Number of tests that went wrong.
    averaged : bool
        One row a test.
    """

    name: str
    plan: str = "any"
    offset: str = "normal"
    hetero: bool = False
    quantum: float = 0.0
    hum: float = 0.0
    walk: bool = False
    odd: int = 0
    averaged: bool = False


RECIPES: dict[str, Recipe] = {
    r.name: r
    for r in (
        Recipe("plain"),
        Recipe("skewed", offset="skewed"),
        Recipe("heteroscedastic", hetero=True),
        Recipe("quantised", quantum=1.0 / 256.0),
        Recipe("mains_hum", hum=1.5),
        Recipe("random_walk", walk=True),
        Recipe("odd_tests", odd=3),
        Recipe("half_tests", plan="half"),
        Recipe("unbalanced", plan="unbalanced"),
        Recipe("lhs30", plan="lhs30"),
        Recipe("averages", averaged=True),
    )
}
#: The ten recipes besides the plain one.
TEN: tuple[str, ...] = tuple(name for name in RECIPES if name != "plain")


@dataclass(frozen=True)
class Levels:
    """Standard deviations: offset of a test, drift in it, white sensor noise, force noise (share)."""

    test: float
    drift: float
    sensor: float
    force: float


def draw_levels(rng: np.random.Generator, size: float) -> Levels:
    """Levels from the ranges known of sliding compression tests."""
    test = size * rng.uniform(0.003, 0.008)
    return Levels(
        test, test * rng.uniform(0.15, 0.4), size * rng.uniform(0.0008, 0.003), rng.uniform(0.001, 0.004)
    )


def _skewed(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    """Gamma noise with mean 0, standard deviation 1 and skewness about 1.8."""
    k = 1.25
    return (rng.gamma(k, 1.0, shape) - k) / np.sqrt(k)


def physical(
    recipe: Recipe, levels: Levels, loads: Profiles, rng: np.random.Generator
) -> tuple[Array, NDArray[Any]]:
    """Scatter of friction itself: offset of each test and slow drift in it.

    Parameters
    ----------
    recipe : Recipe
        Kind of scatter.
    levels : Levels
        Sizes.
    loads : Profiles
        Loads; pressure and temperature scale heteroscedastic scatter.
    rng : numpy.random.Generator
        Source of randomness.

    Returns
    -------
    scatter : ndarray, shape (n_tests, n_points)
        Added to friction.
    odd : ndarray of int
        Rows of the tests that went wrong.
    """
    n, m = loads.sd.shape
    unit: Array = _skewed(rng, (n,)) if recipe.offset == "skewed" else rng.normal(0.0, 1.0, (n,))
    white = rng.normal(0.0, 1.0, (n, m))
    if recipe.walk:
        slow = np.cumsum(white, axis=1) / np.sqrt(m) * 1.5
        slow -= slow.mean(axis=1, keepdims=True)
    else:
        keep = np.exp(-1.0 / (rng.uniform(0.08, 0.3) * m))
        slow = np.empty((n, m))
        slow[:, 0] = white[:, 0]
        for i in range(1, m):
            slow[:, i] = keep * slow[:, i - 1] + np.sqrt(1.0 - keep**2) * white[:, i]
    factor = np.ones(n)
    if recipe.hetero:
        hard = loads.sigma[:, 0] / loads.sigma[:, 0].max() + loads.T_start / max(loads.T_start.max(), 1.0)
        factor = 0.35 + hard**1.5
        factor /= np.sqrt(np.mean(factor**2))
    scatter = factor[:, None] * (levels.test * unit[:, None] + levels.drift * slow)
    odd = (
        np.sort(rng.choice(n, min(recipe.odd, max(n // 10, 1)), replace=False))
        if recipe.odd
        else np.array([], int)
    )
    for row in odd:
        jump = levels.test * rng.uniform(5.0, 9.0) * rng.choice([-1.0, 1.0])
        place = rng.uniform(0.2, 0.8) * loads.sd[row, -1]
        late = 1.0 / (1.0 + np.exp(-(loads.sd[row] - place) / (0.02 * loads.sd[row, -1])))
        scatter[row] += jump * (late if rng.random() < 0.5 else 1.0)
    return scatter, odd


def _white(recipe: Recipe, loads: Profiles, rng: np.random.Generator) -> Array:
    """White noise of a 1 kHz record, interpolated where the grid is finer than the record."""
    n, m = loads.sd.shape
    draw = (
        (lambda k: _skewed(rng, (k,))) if recipe.offset == "skewed" else (lambda k: rng.normal(0.0, 1.0, k))
    )
    noise = np.empty((n, m))
    for i in range(n):
        count = int(loads.t[i, -1] * 1000.0) + 2
        if count >= m:
            noise[i] = draw(m)
        else:
            noise[i] = np.interp(loads.t[i], np.arange(count) / 1000.0, draw(count))
    return noise


def measure(
    recipe: Recipe,
    levels: Levels,
    loads: Profiles,
    mu: Array,
    rng: np.random.Generator,
) -> tuple[Array, Array]:
    """Record of friction and pressure: both contain the noise of the normal force.

    Parameters
    ----------
    recipe : Recipe
        Kind of sensor noise.
    levels : Levels
        Sizes.
    loads : Profiles
        True loads.
    mu : ndarray, shape (n_tests, n_points)
        Friction with its physical scatter.
    rng : numpy.random.Generator
        Source of randomness.

    Returns
    -------
    mu, sigma : ndarray, shape (n_tests, n_points)
        Measured friction [-] and pressure [MPa].
    """
    force = 1.0 + levels.force * _white(recipe, loads, rng)
    size = levels.sensor * np.ones((len(mu), 1))
    if recipe.hetero:
        size = size * (0.5 + loads.sigma.max() / (loads.sigma[:, :1] + 0.3 * loads.sigma.max()) / 2.0)
    tangential = mu * loads.sigma + size * loads.sigma * _white(recipe, loads, rng)
    if recipe.hum:
        phase = rng.uniform(0.0, 2.0 * np.pi, (len(mu), 1))
        tangential += recipe.hum * levels.sensor * loads.sigma * np.sin(2.0 * np.pi * 50.0 * loads.t + phase)
    if recipe.quantum:
        step = recipe.quantum * np.quantile(np.abs(tangential), 0.98)
        tangential = np.round(tangential / step) * step
    sigma = loads.sigma * force
    return tangential / sigma, sigma
