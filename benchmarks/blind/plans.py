"""Test plans as laboratories run them: which loads each test has, and how they move along it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product

import numpy as np
import pandas as pd

from benchmarks.blind.campaign import Array, Campaign, Rng

Setting = dict[str, float]
MATERIALS = ("16MnCr5", "C15", "42CrMo4")


def path(length: float) -> Array:
    """Distances of the points: every 0.1 mm at the start, where friction changes fast, then every 0.7 mm."""
    return np.concatenate([np.arange(0.0, 2.0, 0.1), np.arange(2.0, length, 0.7)])


def latin(rng: Rng, n: int, psi_max: float = 20.0) -> list[Setting]:
    """Latin hypercube: speed and expansion on their logarithms."""
    u = np.stack([(rng.permutation(n) + rng.random(n)) / n for _ in range(4)], axis=1)
    return [
        {"v": 5 * 100**a, "T": 20 + 280 * b, "p": 500 + 2250 * c, "psi": 1.07 * (psi_max / 1.07) ** d}
        for a, b, c, d in u
    ]


def factorial(rng: Rng, v: Sequence[float], T: Sequence[float], p: Sequence[float]) -> list[Setting]:
    """All combinations; three expansions are dealt out evenly in random order."""
    grid = list(product(v, T, p))
    psi = rng.permutation(np.resize([1.07, 5.0, 20.0], len(grid)))
    return [{"v": a, "T": b, "p": c, "psi": d} for (a, b, c), d in zip(grid, psi)]


def full81(rng: Rng) -> list[Setting]:
    """The full factorial of four factors on three levels."""
    return [
        {"v": v, "T": T, "p": p, "psi": x}
        for v, T, p, x in product((5, 200, 500), (20, 100, 300), (500, 1750, 2750), (1.07, 5, 20))
    ]


def one_at_a_time(rng: Rng) -> list[Setting]:
    """Eleven runs of one setting, and 21 that change one load of it: the unbalanced plan of an industrial laboratory."""
    centre = {"v": 50.0, "T": 100.0, "p": 1250.0, "psi": 4.0}
    out = [dict(centre) for _ in range(11)]
    for name, levels in {
        "v": (5, 15, 120, 250, 500),
        "T": (20, 60, 160, 220, 300),
        "p": (500, 800, 1700, 2200, 2750),
        "psi": (1.07, 2, 7, 12, 20),
    }.items():
        out += [{**centre, name: float(level)} for level in levels]
    return [*out, {"v": 500.0, "T": 300.0, "p": 2750.0, "psi": 20.0}]


def repeats(rng: Rng) -> list[Setting]:
    """Nine settings (a Latin hypercube), each run four times."""
    return [s for s in latin(rng, 9) for _ in range(4)]


def march(settings: list[Setting], rng: Rng, lengths: Array, jitter: float = 0.015) -> Campaign:
    """Tests at constant loads; no rig meets its set values better than the jitter."""
    frames = []
    for k, s in enumerate(settings):
        sd = path(float(lengths[k]))
        e = 1 + jitter * rng.standard_normal(4)
        v, n = s["v"] * e[0], len(sd)
        frames.append(
            pd.DataFrame(
                {
                    "k": k,
                    "test_id": f"T{k + 1:03d}",
                    "t": sd / v,
                    "v_rel": v,
                    "T": s["T"] * e[1] + 1.5 * (e[2] - 1) / jitter,
                    "sigma_n": s["p"] * e[2] * (1 + 0.003 * np.sin(sd / 9 + 7 * e[1])),
                    "sd": sd,
                    "psi": np.full(n, max(1.0, s["psi"] * e[3])),
                }
            )
        )
    tests = pd.DataFrame(
        {
            "test_id": [f"T{k + 1:03d}" for k in range(len(settings))],
            "T_tool": [round(s["T"], 0) for s in settings],
        }
    )
    return Campaign(pd.concat(frames, ignore_index=True), tests)


def heated(campaign: Campaign, gain: float, along: bool) -> Campaign:
    """The contact warms up by friction power: with the root of the distance along the test, or at once to its mean.

    Flux p v over sqrt(v) of a moving band (Jaeger): the rise goes with p sqrt(v); 40 to 160 K in these plans.
    """
    p = campaign.points
    rise = gain * p["sigma_n"] / 1500 * np.sqrt(p["v_rel"] / 100)
    p["T"] = p["T"] + rise * (np.sqrt(p["sd"] / 50) if along else 1.0)
    return campaign


def speed_steps(rng: Rng) -> Campaign:
    """18 tests with four changes of speed each, at two pressures and three temperatures."""
    settings = [
        {"v": 1.0, "T": T, "p": p, "psi": 2.0}
        for T, p in product((20, 80, 150), (600, 1500))
        for _ in range(3)
    ]
    campaign = march(settings, rng, np.full(len(settings), 58.0))
    for rows in campaign.slices():
        levels = rng.permutation([5.0, 20.0, 80.0, 200.0, 500.0])
        sd = campaign.load("sd")[rows]
        v = levels[np.minimum((sd / 11.7).astype(int), 4)]
        campaign.points.loc[campaign.points.index[rows], "v_rel"] = v
        campaign.points.loc[campaign.points.index[rows], "t"] = np.concatenate(
            [[0.0], np.cumsum(np.diff(sd) / v[:-1])]
        )
    return campaign


def pressure_ramps(rng: Rng) -> Campaign:
    """20 tests in which pressure rises and falls again along the path, at other peaks and speeds."""
    settings = latin(rng, 20, psi_max=6)
    campaign = march(settings, rng, np.full(20, 56.0))
    for rows, s in zip(campaign.slices(), settings):
        sd = campaign.load("sd")[rows]
        shape = 1 - np.abs(sd / 28 - 1)
        campaign.points.loc[campaign.points.index[rows], "sigma_n"] = 300 + (s["p"] - 100) * shape
    return campaign


def averages(campaign: Campaign) -> Campaign:
    """One point a test: means over the path."""
    points = campaign.points.groupby(["k", "test_id"], as_index=False).mean(numeric_only=True)
    return Campaign(points, campaign.tests)


def lengths(rng: Rng, n: int, low: float = 50, high: float = 58) -> Array:
    """Lengths of the tests."""
    return rng.uniform(low, high, n)


def _plain(make: Callable[[Rng], list[Setting]], low: float = 50) -> Callable[[Rng], Campaign]:
    def build(rng: Rng) -> Campaign:
        settings = make(rng)
        return march(settings, rng, lengths(rng, len(settings), low))

    return build


V3, V4, T3, P3 = (5, 100, 500), (5, 50, 200, 500), (20, 120, 280), (500, 1500, 2700)
PLANS: dict[str, Callable[[Rng], Campaign]] = {
    "factorial27": _plain(lambda r: factorial(r, V3, T3, P3)),
    "factorial36": _plain(lambda r: factorial(r, V4, T3, P3)),
    "factorial45": _plain(lambda r: factorial(r, V3, (20, 80, 140, 200, 280), P3)),
    "pressure48": _plain(lambda r: factorial(r, V4, T3[::2], (400, 700, 1100, 1600, 2100, 2700))),
    "full81": _plain(full81),
    "half81": _plain(lambda r: [full81(r)[i] for i in sorted(r.choice(81, 40, replace=False))]),
    "latin30": _plain(lambda r: latin(r, 30), 30),
    "latin60": _plain(lambda r: latin(r, 60), 30),
    "few8": _plain(lambda r: latin(r, 8)),
    "few12": _plain(lambda r: latin(r, 12)),
    "unbalanced32": _plain(one_at_a_time),
    "repeats36": _plain(repeats),
    "averages50": lambda r: averages(_plain(lambda q: latin(q, 50), 20)(r)),
    "averages81": lambda r: averages(_plain(full81)(r)),
    "correlated30": lambda r: heated(
        _plain(lambda q: [{**s, "T": 30 + 0.2 * s["T"]} for s in latin(q, 30)])(r), 60, False
    ),
    "warming30": lambda r: heated(
        _plain(lambda q: [{**s, "T": 20 + 0.6 * s["T"]} for s in latin(q, 30)])(r), 70, True
    ),
    "steps18": speed_steps,
    "ramps20": pressure_ramps,
}


def add_metadata(campaign: Campaign, names: Sequence[str], rng: Rng) -> Campaign:
    """Columns of the test table: dealt out evenly in random order, as a careful laboratory does."""
    n = len(campaign.tests)
    choices: dict[str, list[object]] = {
        "batch": ["L1", "L2", "L3", "L4"],
        "lot": ["0417", "0532", "0533"],
        "material": list(MATERIALS),
        "Ra": [0.02, 0.05, 0.12, 0.3, 0.6],
        "viscosity": [32.0, 68.0, 150.0, 460.0],
        "operator": ["Ott", "Lindner"],
        "humidity": [],
    }
    for name in names:
        if name == "order":
            campaign.tests["order"] = rng.permutation(n) + 1
        elif name == "humidity":
            campaign.tests["humidity"] = np.round(rng.uniform(25, 70, n), 0)
        else:
            options = choices[name]
            campaign.tests[name] = [
                options[i] for i in rng.permutation(np.resize(np.arange(len(options)), n))
            ]
    return campaign
