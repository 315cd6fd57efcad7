"""A third set of forms that campaigns hide, written by somebody who did not know the diagnosis.

Its author had read the list of effects, their published formulas and the first two sets, but neither the code of the
diagnosis nor that of its catalogue, and no result of either. Nothing was tuned on this set, and it was not tuned on
anything. Each form is what a tribometer could have shown under that name: readings from a made-up diagram with a
smooth curve through them, a rational law, a kink, or two scales side by side. All numbers are invented. One was
redrawn after a look at a picture: the carrying share saturated so late that a linear law followed the form to 6 %.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator

from .forms import Array, Form, Forms, Setpoint, Test, _level, _setpoints


def _readings(x: tuple[float, ...], y: tuple[float, ...]) -> PchipInterpolator:
    """Return a smooth curve through readings; it has no turning points but theirs."""
    return PchipInterpolator(np.array(x), np.array(y), extrapolate=False)


def _read(curve: PchipInterpolator, at: Array) -> Array:
    """Return what a diagram shows, its ends held outside it."""
    return np.asarray(curve(np.clip(at, curve.x[0], curve.x[-1])), dtype=np.float64)


#: Shear strength of a film over its temperature [degC].
FILM_STRENGTH = _readings(
    (20, 60, 100, 150, 200, 300, 420, 600), (1.0, 0.87, 0.74, 0.61, 0.52, 0.4, 0.34, 0.29)
)
#: Share of the surface that carries, from replicas, over the pressure [MPa].
CARRYING = _readings((0, 200, 400, 600, 900, 1300, 1800, 3000), (0, 0.3, 0.56, 0.73, 0.86, 0.93, 0.965, 1))
#: Share of the film that is gone, by weighing, over the friction work [J/mm2].
LOST_FILM = _readings((0, 1, 2, 3, 4, 5, 6.5, 8.5), (0, 0.01, 0.05, 0.18, 0.45, 0.72, 0.93, 0.98))
#: Error in the calibration sheet of a load cell, relative to its largest, over the pressure [MPa].
CALIBRATION = _readings((300, 500, 800, 1200, 1800, 2600), (-1.0, -0.57, -0.36, -0.235, -0.17, -0.12))
#: Friction of batches by the weight of their film: one is too light, the others differ a little.
BATCHES = {"P": 1.0, "Q": 0.12, "R": -0.08, "S": 0.03}


def _two_roughnesses(r: Test) -> Array:
    """Plateaus float up at low speed, the valleys' flanks later."""
    return 0.6 / (1.0 + (r.v / 22.0) ** 1.3) + 0.4 / (1.0 + (r.v / 110.0) ** 2)


def _eyring(r: Test) -> Array:
    """Shear-thinning film with the viscosity of Vogel; its shear strength grows with pressure."""
    viscosity = np.exp(620.0 / (r.T + 105.0) - 620.0 / 185.0)
    return np.arcsinh(r.v / 70.0 * viscosity) * (900.0 + r.sigma) / r.sigma


def _bare_by_heat(r: Test) -> Array:
    """Nothing below 265 degC, then patches fail one after another."""
    excess = np.maximum(r.T - 265.0, 0.0) / 45.0
    return excess / (1.0 + excess)


def _adhesion_and_ploughing(r: Test) -> Array:
    """Junctions carry less of a higher load, furrows get a little deeper."""
    p = r.sigma / 500.0
    return 0.8 * p**-0.8 + 0.2 * p**0.15


def _bare_by_growth(r: Test) -> Array:
    """The coat stretches by 5 %, then it opens."""
    growth = np.maximum(r.psi - 1.05, 0.0)
    return growth / (growth + 0.22)


def _flattening(r: Test) -> Array:
    """Tops flatten in the first millimetres, the texture turns until 10 mm."""
    return 0.5 / (1.0 + (r.sd / 2.2) ** 2) + 0.5 * np.maximum(1.0 - r.sd / 10.0, 0.0) ** 2


def _asperity_heat(r: Test) -> Array:
    """Heat of asperities: as speed while they are slow for conduction, as its root later; they soften."""
    rise = r.sigma * r.v / np.sqrt(r.v + 45.0)
    return -np.arctan((rise / 9000.0) ** 1.3)


def _past_speed(r: Test) -> Array:
    """Friction follows the speed at once and falls with its mean over the last 3 mm; before it, rest."""
    count = max(1, round(3.0 / r.spacing))
    past = np.concatenate([np.full(count - 1, 0.2), r.v])
    mean = np.convolve(past, np.full(count, 1.0 / count), "valid")
    return 0.75 * np.arcsinh(r.v / 2.0) - np.log1p(mean)


def _resonance(r: Test) -> Array:
    """Amplitude of a tool holder shaken once per groove."""
    ratio = r.v / 85.0
    return 1.0 / np.sqrt((1.0 - ratio**2) ** 2 + (0.45 * ratio) ** 2)


def _window(r: Test) -> Array:
    """A phase that exists from 130 to 260 degC, the more the higher the pressure."""
    there = (np.arctan((r.T - 130.0) / 10.0) - np.arctan((r.T - 260.0) / 10.0)) / np.pi
    return there * r.sigma / 1000.0


EFFECTS: dict[str, Form] = {
    "stribeck": _two_roughnesses,
    "viscous": _eyring,
    "thermal_softening": lambda r: _read(FILM_STRENGTH, r.T),
    "thermal_breakdown": _bare_by_heat,
    "pressure_saturation": lambda r: _read(CARRYING, r.sigma) / r.sigma,
    "pressure_power": _adhesion_and_ploughing,
    "surface_expansion": _bare_by_growth,
    "running_in": _flattening,
    # the film gets thinner at a constant rate, friction goes with the inverse of what is left
    "wear_out": lambda r: 1.0 / (1.0 - r.sd / 60.0),
    "work_exhaustion": lambda r: _read(LOST_FILM, r.work),
    "flash_temperature": _asperity_heat,
    "static_peak": lambda r: (1.0 + (r.sd / 0.5) ** 2) ** -1.5,
    "rate_state": _past_speed,
    "batch": lambda r: _level(r, BATCHES[r.batch]),
    # furrows as soon as the tool is rougher than the film is thick
    "tool_roughness": lambda r: _level(r, r.Ra**2 / (r.Ra**2 + 0.1**2)),
    # the glue of strain gauges creeps with the logarithm of time
    "sensor_drift": lambda r: _level(r, np.log1p(r.order / 12.0)),
    # heat losses that the twin leaves out grow faster than the rise
    "twin_heating": lambda r: (
        np.maximum(r.T - r.T_tool, 0.0) * (1.0 + np.maximum(r.T - r.T_tool, 0.0) / 900.0) / 100.0
    ),
    "force_zero": lambda r: _read(CALIBRATION, r.sigma),
}

OUTSIDE: dict[str, Form] = {
    "resonance in speed": _resonance,
    "checkerboard of temperature and expansion": lambda r: (
        np.sin(np.pi * (r.T - 20.0) / 150.0) * np.sin(np.pi * (r.psi - 1.0) / 0.35)
    ),
    "valley in expansion": lambda r: np.minimum(np.abs(r.psi - 1.42), 0.3),
    "window of temperature times pressure": _window,
}


def _factorial(rng: np.random.Generator) -> tuple[list[Setpoint], list[Setpoint]]:
    """Return 76 tests with each level of each load about equally often, in random company, 8 repeats and 30 between."""
    levels = (
        np.array([450.0, 950.0, 1600.0, 2350.0]),
        np.array([1.05, 1.25, 1.5, 1.8]),
        np.geomspace(10.0, 350.0, 7),
        np.array([20.0, 90.0, 160.0, 240.0]),
    )
    grid = np.column_stack([rng.permutation(np.resize(x, 76)) for x in levels])
    repeats = grid[rng.choice(76, 8, replace=False)]
    low, high = np.array([[x[0], x[-1]] for x in levels]).T
    between = rng.uniform(low, high, (30, 4))
    between[:, 2] = np.exp(rng.uniform(np.log(low[2]), np.log(high[2]), 30))
    return _setpoints(np.vstack([grid, repeats])), _setpoints(between)


def _steady(sigma: Array, v: Array, sd: Array) -> Array:
    """Heating that comes to rest, as the tool always meets cold metal."""
    return 75.0 * (sigma / 1000.0) * (v / 100.0) ** 0.7 * sd / (sd + 6.0)


THIRD = Forms(
    effects=EFFECTS,
    outside=OUTSIDE,
    pairs=(
        ("thermal_breakdown", "surface_expansion"),
        ("pressure_saturation", "wear_out"),
        ("stribeck", "running_in"),
    ),
    plan=_factorial,
    length=45.0,
    spacing=0.3,
    heating=_steady,
    batches=("P", "Q", "R", "S"),
)
