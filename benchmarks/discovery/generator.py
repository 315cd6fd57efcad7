"""Synthetic campaigns with hidden effects, nulls of several kinds, and structure outside the catalogue.

Nothing here comes from the diagnosis or its catalogue, nor from the made-up campaigns of the tests: the forms are
sums, ratios and powers of their own (`forms`), loads come from a plan with random held-out tests, and the strength of
what is hidden is drawn at random.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from .form_sets import SETS
from .forms import Array, Forms, Setpoint, Test

#: Scatter between tests, drift within a test and sensor noise of a point, in mu.
SCATTER, DRIFT, SENSOR = 0.005, 0.0015, 0.0025
#: True loads of a test, in the order of the base's coefficients.
LOADS = ("v", "T", "sigma", "sd", "psi")
#: Distance over which a plain drift is remembered [mm].
DRIFT_LENGTH = 9.0
#: Noise levels: factor on all three.
NOISE_LEVELS = (0.6, 1.0, 1.6)
#: Kinds of campaigns in which nothing is missing.
NULLS = ("plain", "wide scatter and slow drift", "curved noise", "heavy tails", "averaged points")
#: mu without noise stays between these where the strength of the lacking part is drawn: lubricated metal, cold forming.
PHYSICAL = (0.02, 0.4)
#: A sensor shows no less than this.
LEAST_MU = 0.002


class Made(NamedTuple):
    """One campaign.

    Attributes
    ----------
    points, tests : pandas.DataFrame
        As a user has them; column `role` marks the held-out tests.
    part : ndarray, shape (n,)
        The hidden part of mu.
    law : ndarray, shape (n,)
        mu without scatter, drift and noise, the hidden part included.
    strength : float
        RMS of the hidden part over the scatter between tests; of what it lacks where that was drawn.
    drawn : float
        The strength before `PHYSICAL` limited it; the same where it did not.
    clipped : float
        Share of the points whose mu was lifted to `LEAST_MU`.
    """

    points: pd.DataFrame
    tests: pd.DataFrame
    part: Array
    law: Array
    strength: float
    drawn: float = 0.0
    clipped: float = 0.0


def campaign(
    seed: int,
    hidden: tuple[str, ...] = (),
    null: str = "plain",
    noise: float = 1.0,
    forms: str = "first",
    lacking: bool = False,
) -> Made:
    """Return one campaign.

    Parameters
    ----------
    seed : int
    hidden : tuple of str
        Names of effects and of structure outside the catalogue; the rms of each is drawn from 0.5 to 2 times the scatter.
    null : str
        How tests scatter, one of `NULLS`: normal offsets; offsets with heavy tails and a drift over half a test; noise
        that grows with pressure; offsets and noise of Student's t with 3 degrees of freedom; one average a test.
    noise : float
        Factor on scatter, drift and sensor noise.
    forms : str
        Which set of forms, with its plan; one of `SETS`.
    lacking : bool
        Draw the rms of what a linear law of the loads, fitted to the hidden part of the training tests, leaves of it,
        instead of that of the whole. The hidden part has no mean then, and it is made smaller where mu without noise
        would leave `PHYSICAL`.
    """
    chosen = SETS[forms]
    rng = np.random.default_rng([seed, 31, 4159])
    train, between = chosen.plan(rng)
    count = len(train) + len(between)
    orders = rng.permutation(count)
    tests = [_test(rng, chosen, p, order) for order, p in zip(orders, [*train, *between], strict=True)]
    lengths = [len(r.v) for r in tests]
    trained = sum(lengths[: len(train)])
    shapes = {**chosen.effects, **chosen.outside}
    strengths = [float(rng.uniform(0.5, 2.0)) for _ in hidden]
    slopes = rng.uniform(0.4, 1.4, 5) * [1.2e-5, -3e-5, -7e-6, 9e-5, 0.007]
    bias = rng.normal(0.0, [0.012, 0.02, 0.02])  # of the twin: pressure, heating, expansion
    loads = np.column_stack([np.concatenate([getattr(r, n) for r in tests]) for n in LOADS])
    level = 0.072 + (loads - [0.0, 0.0, 1500.0, 0.0, 1.0]) @ slopes
    part, drawn = np.zeros(len(level)), strengths[-1] if strengths else 0.0
    for k, name in enumerate(hidden):
        values = np.concatenate([shapes[name](r) for r in tests])
        size = SCATTER * noise * strengths[k]
        if lacking:
            values = values - values[:trained].mean()
            share = _within(level + part, values * size / (rms := _beyond_linear(values, loads, trained)))
            strengths[k] *= share
            part = part + size * share / rms * values
        else:
            part = part + size / float(np.std(values)) * values
    law = level + part
    frames, rows = [], []
    ends = np.cumsum(lengths)
    for k, (r, end) in enumerate(zip(tests, ends, strict=True)):
        mu = law[end - lengths[k] : end] + noise * _noise(r, null, rng)
        own = bias + rng.normal(0.0, [0.006, 0.01, 0.01])
        name = f"b{k:03d}"
        seen = {
            "t": r.t,
            "v_rel": r.v,
            "T": r.T_tool + (r.T - r.T_tool) * (1.0 + own[1]),
            "sigma_n": r.sigma * (1.0 + own[0]),
            "sd": r.sd,
            "psi": 1.0 + (r.psi - 1.0) * (1.0 + own[2]),
            "mu": mu,
        }
        frames.append(pd.DataFrame({"test_id": name, **seen}))
        role = "train" if k < len(train) else "test"
        known = {"order": r.order, "T_tool": r.T_tool, "Ra": r.Ra, "batch": r.batch}
        rows.append({"test_id": name, **known, "role": role})
    points, truth = pd.concat(frames, ignore_index=True), np.column_stack([part, law])
    clipped = float(np.mean(points["mu"] < LEAST_MU))
    points["mu"] = points["mu"].clip(lower=LEAST_MU)
    if null == "averaged points":
        means = pd.DataFrame(truth).groupby(points["test_id"]).mean()
        truth = np.asarray(means, dtype=np.float64)
        points = points.groupby("test_id", as_index=False).mean(numeric_only=True)
    strength = strengths[-1] if strengths else 0.0
    return Made(points, pd.DataFrame(rows), truth[:, 0], truth[:, 1], strength, drawn, clipped)


def _beyond_linear(values: Array, loads: Array, trained: int) -> float:
    """Return the rms over the training tests of what a linear law of the true loads leaves of `values`."""
    own = loads[:trained]
    columns = np.column_stack([np.ones(trained), (own - own.mean(axis=0)) / own.std(axis=0)])
    follow = np.linalg.lstsq(columns, values[:trained], rcond=None)[0]
    return float(np.sqrt(np.mean((values[:trained] - columns @ follow) ** 2)))


def _within(level: Array, part: Array) -> float:
    """Return the largest factor, at most 1, with which a part keeps `level` physical."""
    low, high = PHYSICAL
    room = np.where(part < 0.0, level - low, high - level)
    return float(min(1.0, np.min(room / np.maximum(np.abs(part), 1e-12))))


def _test(rng: np.random.Generator, forms: Forms, setpoint: Setpoint, order: float) -> Test:
    sigma, psi, v_set, T_tool = setpoint
    sd = np.arange(0.5 * forms.spacing, forms.length, forms.spacing)
    share = sd / forms.length
    start = rng.uniform(0.2, 3.0) * (0.2 + v_set / 400.0)
    v = v_set * (1.0 - np.exp(-(sd + 0.05) / start)) * (1.0 + 0.01 * np.sin(sd / rng.uniform(4.0, 9.0)))
    t = np.cumsum(forms.spacing / v)
    pressure = sigma * (1.0 + rng.normal(0.0, 0.01)) * (1.0 - rng.uniform(0.0, 0.06) * share)
    T = T_tool + 18.0 * (psi - 1.0) * sigma / 1700.0 + forms.heating(np.full_like(sd, sigma), v, sd)
    swell = psi + rng.uniform(0.0, 0.04) * share
    Ra = float(rng.choice([0.02, 0.06, 0.12, 0.25]))
    return Test(v, T, pressure, sd, swell, t, T_tool, float(order), Ra, str(rng.choice(forms.batches)))


def _noise(r: Test, null: str, rng: np.random.Generator) -> Array:
    """Return what scatters in one test: its offset, a drift along it, noise of the points."""
    n = len(r.sd)
    offset = SCATTER * rng.standard_normal()
    white = rng.standard_normal(n)
    length, drift, points = DRIFT_LENGTH, DRIFT, np.ones(n)
    if null == "wide scatter and slow drift":
        offset, length, drift = 0.77 * SCATTER * rng.standard_t(5), 26.0, 1.3 * DRIFT
    elif null == "curved noise":
        points = 0.5 + r.sigma / 1700.0
    elif null == "heavy tails":
        offset, white = 0.577 * SCATTER * rng.standard_t(3), 0.577 * rng.standard_t(3, n)
    keep = float(np.exp(-r.spacing / length))
    kicks = rng.standard_normal(n) * drift * np.sqrt(1.0 - keep**2)
    kicks[0] = drift * rng.standard_normal()
    wander = np.empty(n)
    wander[0] = kicks[0]
    for k in range(1, n):
        wander[k] = keep * wander[k - 1] + kicks[k]
    return np.asarray(offset + wander + points * sensor(float(r.v[-1])) * white)


def sensor(speed: float) -> float:
    """Return the noise of a point: at low speed, it is a mean of up to five samples."""
    return float(SENSOR / np.sqrt(max(1.0, min(5.0, 500.0 / speed))))
