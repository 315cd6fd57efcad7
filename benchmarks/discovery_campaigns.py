"""Made-up SCT campaigns with one hidden effect, written in forms that the catalogue does not use.

Loads mimic the factorial plan: pressure nearly constant within a test, a speed ramp at the start, a contact
temperature that rises with pressure, speed and the root of the distance. Every test carries its own offset,
a slow drift and sensor noise; the diagnosis sees loads with the errors of a twin.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
import pandas as pd
from scipy.special import erf

Array = np.ndarray
STEP = 0.1  # mm between points


@dataclass
class Run:
    """One test: true loads, time, metadata."""

    v: Array
    T: Array
    s: Array
    sd: Array
    psi: Array
    t: Array
    T_tool: float
    order: int
    Ra: float
    batch: str


Hidden = Callable[[Run, np.random.Generator], Array]


def _lagged(run: Run, length: float) -> Array:
    """Speed that the contact remembers over a distance."""
    out, memory = np.empty_like(run.v), np.log(run.v[0] + 0.5)
    for i, v in enumerate(run.v):
        memory += (np.log(v + 0.5) - memory) * (1.0 - np.exp(-STEP / length))
        out[i] = memory
    return out


def _work(run: Run, rng: np.random.Generator) -> Array:
    w = np.cumsum(0.06 * run.s * STEP) * 1e-3
    return 0.5 * (1.0 + erf((w - 3.5) / 1.2))


#: Shapes of the hidden effects; each is scaled to the wanted rms over the campaign.
HIDDEN: dict[str, Hidden] = {
    "stribeck": lambda r, g: 1.0 / (1.0 + (r.v / 40.0) ** 1.4),
    "viscous": lambda r, g: (
        np.tanh(r.v / 600.0) / (1.0 + np.maximum(r.T - 20.0, 0) / 90.0) ** 1.5 * (1000.0 / r.s) ** 0.7
    ),
    "thermal_softening": lambda r, g: 1.0 / (1.0 + (np.maximum(r.T - 20.0, 0) / 130.0) ** 1.5),
    "thermal_breakdown": lambda r, g: 0.5 + np.arctan((r.T - 330.0) / 25.0) / np.pi,
    "pressure_saturation": lambda r, g: np.tanh(r.s / 700.0) / (r.s / 700.0),
    "pressure_power": lambda r, g: -np.log(r.s / 400.0),
    "surface_expansion": lambda r, g: (r.psi - 1.0) / (r.psi - 1.0 + 0.25),
    "running_in": lambda r, g: 1.0 / (1.0 + r.sd / 4.0) ** 2,
    "wear_out": lambda r, g: 0.5 * (1.0 + erf((r.sd - 42.0) / 9.0)),
    "work_exhaustion": _work,
    "rate_state": lambda r, g: 0.6 * np.log(r.v + 0.5) - _lagged(r, 2.5),
    "tool_roughness": lambda r, g: np.full_like(r.v, np.sqrt(r.Ra)),
    "batch": lambda r, g: np.full_like(r.v, float(r.batch == "B")),
    "sensor_drift": lambda r, g: np.full_like(r.v, np.sqrt(r.order)),
    "force_zero": lambda r, g: -1000.0 / r.s,
    "twin_heating": lambda r, g: (r.T - r.T_tool) / 300.0,
    "flash_temperature": lambda r, g: 1.0 - np.tanh(0.06 * r.s * np.sqrt(r.v) / 900.0),
    "static_peak": lambda r, g: np.maximum(1.0 - r.sd / 0.6, 0.0),
}


def plan(
    levels: int = 3, extra: int = 0, rng: np.random.Generator | None = None
) -> list[tuple[float, float, float, float]]:
    """Return (v, T_tool, sigma, psi) of the factorial tests and of random ones between."""
    grid = ([5.0, 200.0, 500.0], [20.0, 100.0, 300.0], [500.0, 1750.0, 2750.0], [1.07, 1.4, 1.9])
    points = [
        (v, T, sigma, psi) for v, T, sigma, psi in product(*(g[:: 2 if levels == 2 else 1] for g in grid))
    ]
    rng = rng or np.random.default_rng(0)
    for _ in range(extra):
        v, T, sigma, psi = (float(rng.uniform(g[0], g[-1])) for g in grid)
        points.append((v, T, sigma, psi))
    return points


def campaign(
    hidden: str | None = None,
    seed: int = 0,
    strength: float | None = None,
    scatter: float = 0.005,
    extra: int = 30,
    thin: int = 1,
    twin_errors: float = 1.0,
    noise: float = 1.0,
    shape: Hidden | None = None,
    levels: int = 3,
) -> tuple[pd.DataFrame, pd.DataFrame, Array]:
    """Make a campaign; return points, tests and the hidden contribution at every point.

    Parameters
    ----------
    hidden : str, optional
        Key of `HIDDEN`; ``"a+b"`` hides a pair.
    strength : float, optional
        RMS of the hidden contribution in units of the scatter between tests; drawn from 0.5 to 2 by default.
    thin : int
        Keep every n-th point.
    twin_errors : float
        Scale of the errors of the loads (1: about 1.5 % pressure, 3 % of the temperature rise, 3 % expansion).
    """
    rng = np.random.default_rng([seed, 20])
    setpoints = plan(levels, extra, rng)
    order = rng.permutation(len(setpoints))
    runs = [_run(p, int(o), rng) for p, o in zip(setpoints, order)]
    parts = [np.zeros(len(r.v)) for r in runs]
    names = [n for n in (hidden or "").split("+") if n]
    for form in [*(HIDDEN[n] for n in names), *([shape] if shape else [])]:
        size = (strength if strength is not None else rng.uniform(0.5, 2.0)) * scatter
        values = [form(r, rng) for r in runs]
        rms = np.std(np.concatenate(values))
        parts = [p + v * size / rms for p, v in zip(parts, values)]
    slopes = np.array([1e-5, -3.5e-5, -8e-6, 1e-4, 0.008]) * rng.uniform(0.4, 1.3, 5)
    systematic = rng.normal(0.0, 1.0, 3) * twin_errors
    frames, rows, truth = [], [], []
    for k, (run, part) in enumerate(zip(runs, parts)):
        mu = 0.075 + slopes @ [run.v, run.T, run.s - 1500.0, run.sd, run.psi - 1.0] + part
        mu = (
            mu
            + rng.normal(0, scatter * noise)
            + _drift(run, 0.0015 * noise, rng)
            + _sensor(run, 0.003 * noise, rng)
        )
        own = systematic + rng.normal(0.0, 0.4, 3) * twin_errors
        keep = slice(None, None, thin)
        seen = {
            "test_id": f"t{k:03d}",
            "t": run.t,
            "v_rel": run.v,
            "T": run.T_tool + (run.T - run.T_tool) * (1 + 0.03 * own[0]),
            "sigma_n": run.s * (1 + 0.012 * own[1]),
            "sd": run.sd,
            "psi": 1 + (run.psi - 1) * (1 + 0.03 * own[2]),
            "mu": np.maximum(mu, 0.001),
        }
        frames.append(pd.DataFrame(seen)[keep])
        truth.append(part[keep])
        rows.append(
            {"test_id": f"t{k:03d}", "order": run.order, "T_tool": run.T_tool, "Ra": run.Ra, "batch": run.batch,
             "role": "train" if k < len(runs) - extra else "test"}
        )  # fmt: skip
    return pd.concat(frames, ignore_index=True), pd.DataFrame(rows), np.concatenate(truth)


def _run(setpoint: tuple[float, float, float, float], order: int, rng: np.random.Generator) -> Run:
    v_set, T_tool, sigma, psi = setpoint
    sd = np.arange(0.0, 55.0, STEP)
    ramp = 0.3 + 3.5 * (v_set / 500.0)
    v = v_set * np.sqrt(np.minimum((sd + 0.02) / ramp, 1.0)) * (1 + 0.005 * rng.normal())
    t = np.concatenate([[0.0], np.cumsum(STEP / v[1:])])
    s = sigma * (1 - rng.uniform(0, 0.05) * (1 - np.exp(-sd / 15.0))) * (1 + 0.01 * rng.normal())
    rise = 1.6e-3 * s * np.sqrt(v * sd) + 0.012 * sigma * (psi - 1)
    T = T_tool + 700.0 * (1 - np.exp(-rise / 700.0))
    swell = psi + 0.05 * (psi - 1) * (1 - np.exp(-sd / 20.0)) + 0.01 * abs(rng.normal())
    return Run(
        v,
        T,
        s,
        sd,
        swell,
        t,
        T_tool,
        order,
        float(rng.choice([0.02, 0.05, 0.1, 0.2])),
        str(rng.choice(["A", "A", "B"])),
    )


def _drift(run: Run, sd: float, rng: np.random.Generator) -> Array:
    rho = np.exp(-STEP / 8.0)
    kicks = rng.normal(0, sd * np.sqrt(1 - rho**2), len(run.sd))
    out, value = np.empty(len(run.sd)), rng.normal(0, sd)
    for i, kick in enumerate(kicks):
        value = rho * value + kick
        out[i] = value
    return out


def _sensor(run: Run, sd: float, rng: np.random.Generator) -> Array:
    """White noise at 1 kHz (at most 20 samples a point are averaged), interpolated to the points."""
    per_sample = max(float(run.v[-1]) * 1e-3, STEP)
    samples = np.arange(0.0, run.sd[-1] + 2 * per_sample, per_sample)
    return np.interp(run.sd, samples, rng.normal(0, sd, len(samples)))
