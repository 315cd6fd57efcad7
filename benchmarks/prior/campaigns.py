"""Random campaigns: a plan, loads along the tests, a mild known friction, hidden terms and the noise of a random laboratory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from .laws import LAWS, OUTSIDE, Array, Law

#: How often nothing, one effect, two effects, or something outside the catalogue is hidden.
KINDS = {"null": 0.3, "single": 0.46, "pair": 0.12, "outside": 0.12}


@dataclass(frozen=True)
class Made:
    """A campaign and its truth.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    laws : tuple of Law
    points, tests : pandas.DataFrame
    strengths : tuple of float
        Scatter that each hidden part makes in mu beyond straight lines, over the scatter of the noise.
    """

    kind: str
    laws: tuple[Law, ...]
    points: pd.DataFrame
    tests: pd.DataFrame
    strengths: tuple[float, ...]


def campaign(seed: int) -> Made:
    """Draw one campaign."""
    rng = np.random.default_rng([seed, 1717])
    kind = str(rng.choice(list(KINDS), p=list(KINDS.values())))
    points, tests = _loads(rng)
    table = points.merge(tests, on="test_id")
    laws: list[Law] = []
    if kind == "outside":
        laws = [OUTSIDE[rng.integers(len(OUTSIDE))]]
    elif kind != "null":
        count = 2 if kind == "pair" else 1
        while len(laws) < count or any(a.alike(b) for k, a in enumerate(laws) for b in laws[:k]):
            laws = [LAWS[k] for k in rng.choice(len(LAWS), count, replace=False)]
    level = float(np.exp(rng.uniform(np.log(0.03), np.log(0.2))))
    noise = _noise(points, tests, rng) * level * float(np.exp(rng.uniform(np.log(0.005), np.log(0.05))))
    hidden, strengths = np.zeros(len(points)), []
    if laws:
        parts = [law.term(table, rng) for law in laws]
        beyond = [_beyond_lines(points, part) for part in parts]
        strength = float(np.exp(rng.uniform(np.log(0.7), np.log(12.0))))
        size = strength * float(np.std(noise))
        for part, rest in zip(parts, beyond, strict=True):
            share = float(rng.uniform(0.6, 1.4)) if len(parts) > 1 else 1.0
            # a law that straight lines follow nearly is not blown up beyond the known friction
            scale = min(share * size / max(float(np.std(rest)), 1e-12), level / float(np.ptp(part)))
            hidden += scale * part
            strengths.append(scale * float(np.std(rest)) / float(np.std(noise)))
    lines = sum(
        rng.normal(0.0, 0.05) * _standard(points[n].to_numpy(float)) for n in ("v_rel", "T", "sigma_n", "psi")
    )
    mu = level * (1.0 + lines) + hidden + noise
    points["mu"] = np.maximum(mu + max(0.2 * level - float(np.quantile(mu, 0.01)), 0.0), 1e-3)
    return Made(kind, tuple(laws), points, tests, tuple(strengths))


def _standard(x: Array) -> Array:
    return np.asarray((x - x.mean()) / max(float(x.std()), 1e-12))


def _beyond_lines(points: pd.DataFrame, values: Array) -> Array:
    """Return what straight lines in the loads leave of a term."""
    columns = [_standard(points[n].to_numpy(float)) for n in ("v_rel", "T", "sigma_n", "psi", "sd")]
    lines = np.column_stack([np.ones(len(values)), *columns])
    return np.asarray(values - lines @ np.linalg.lstsq(lines, values, rcond=1e-9)[0])


def _loads(rng: np.random.Generator) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return points without mu, and the table of tests."""
    tests = int(np.exp(rng.uniform(np.log(12), np.log(110))))
    steps = int(np.exp(rng.uniform(np.log(8), np.log(60))))
    way = float(rng.uniform(20, 120))
    top = {"v_rel": rng.uniform(50, 600), "sigma_n": rng.uniform(300, 1500), "T_tool": rng.uniform(60, 250)}
    low = {"v_rel": rng.uniform(1, 20), "sigma_n": rng.uniform(30, 150), "T_tool": 20.0}
    design = _design(rng, tests)
    at = {}
    for k, name in enumerate(top):
        if name == "v_rel" or (name == "sigma_n" and rng.random() < 0.5):
            at[name] = low[name] * (top[name] / low[name]) ** design[:, k]
        else:
            at[name] = low[name] + (top[name] - low[name]) * design[:, k]
    expansion = 1.0 + rng.uniform(0.5, 5.0) * (design[:, 1] ** 1.5 if rng.random() < 0.4 else design[:, 3])
    names = [f"t{k:03d}" for k in range(tests)]
    order = rng.permutation(tests) if rng.random() < 0.7 else np.arange(tests)
    table = pd.DataFrame({"test_id": names, "order": order + 1, "T_tool": at["T_tool"]})
    table["batch"] = rng.choice([*"ABC"][: rng.integers(2, 4)], tests)
    table["lot"] = rng.choice(["p", "q", "r", "s"], tests)
    table["Ra"] = rng.choice([0.1, 0.2, 0.4, 0.8], tests)
    heating = rng.uniform(0.0, 60.0)
    u = np.linspace(0.0, 1.0, steps)
    moving = bool(rng.random() < 0.35)
    rows = []
    for k, name in enumerate(names):
        speed = at["v_rel"][k] * (0.4 + 1.2 * u if moving and k % 3 == 0 else np.ones(steps))
        sd = way * u
        t = np.r_[0.0, np.cumsum(np.diff(sd) / (0.5 * (speed[1:] + speed[:-1])))]
        flash = heating * at["sigma_n"][k] / top["sigma_n"] * np.sqrt(speed / top["v_rel"]) * np.sqrt(u)
        rows.append(
            pd.DataFrame(
                {
                    "test_id": name, "t": t, "v_rel": speed, "T": at["T_tool"][k] + flash, "sigma_n": at["sigma_n"][k],
                    "sd": sd, "psi": expansion[k],
                }
            )
        )  # fmt: skip
    return pd.concat(rows, ignore_index=True), table


def _design(rng: np.random.Generator, tests: int) -> Array:
    """Return settings of the tests between 0 and 1, shape (tests, 4)."""
    kind = rng.integers(3)
    if kind == 0:  # Latin hypercube
        return np.column_stack([(rng.permutation(tests) + rng.random(tests)) / tests for _ in range(4)])
    if kind == 1:  # levels
        levels = rng.integers(2, 6, 4)
        return np.column_stack([rng.integers(0, n, tests) / (n - 1) for n in levels])
    design = np.full((tests, 4), 0.3)  # one load after the other around a centre
    for k in range(tests):
        design[k, k % 4] = rng.random()
    return design


def _noise(points: pd.DataFrame, tests: pd.DataFrame, rng: np.random.Generator) -> Array:
    """Return noise of unit size: offsets of tests, drift along them, sensor noise, in random parts and forms."""
    test = points["test_id"].factorize()[0]
    count, n = len(tests), len(points)
    parts = np.exp(rng.normal(0.0, 0.7, 3))
    heavy = float(rng.choice([3.0, 5.0, 50.0]))
    skewed = rng.random() < 0.25
    offsets = rng.gamma(1.5, 1.0, count) - 1.5 if skewed else rng.standard_t(heavy, count)
    if rng.random() < 0.3:  # scatter that grows with a load
        size = points.groupby("test_id", sort=False)["sigma_n"].mean().to_numpy(float)
        offsets = offsets * (0.3 + 1.4 * size / size.max())
    steps = np.bincount(test)[0]
    walk = np.cumsum(rng.standard_normal((count, steps)), axis=1) / np.sqrt(steps)
    walk -= walk.mean(axis=1, keepdims=True) * float(rng.integers(0, 2))
    sensor = rng.standard_t(heavy, n)
    if rng.random() < 0.2:
        sensor = sensor + 1.5 * np.sin(2 * np.pi * rng.uniform(0.05, 0.45) * np.arange(n))
    noise = parts[0] * offsets[test] + parts[1] * walk[test, np.arange(n) % steps] + parts[2] * sensor
    noise = noise / float(np.std(noise))
    if rng.random() < 0.15:  # a coarse resolution
        step = float(rng.uniform(0.5, 1.5))
        noise = np.round(noise / step) * step + 1e-3 * rng.standard_normal(n)
    if rng.random() < 0.1:  # one odd test
        noise = noise + 4.0 * (test == rng.integers(count))
    return np.asarray(noise)
