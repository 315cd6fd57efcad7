"""Test plans: set points of whole tests."""

from __future__ import annotations

from itertools import product

import numpy as np
import pandas as pd
from scipy.stats import qmc

from .domains import Domain

SETPOINTS = ("v", "T", "sigma", "psi")


def _levels(domain: Domain) -> dict[str, tuple[float, float, float]]:
    return {"v": domain.v, "T": domain.T, "sigma": domain.sigma, "psi": domain.psi}


def random_loads(domain: Domain, n: int, rng: np.random.Generator, inner: float = 0.0) -> pd.DataFrame:
    """Latin hypercube inside the ranges: speed and surface expansion on a logarithmic scale for half the draws.

    Parameters
    ----------
    domain : Domain
        Load ranges.
    n : int
        Number of tests.
    rng : numpy.random.Generator
        Source of randomness.
    inner : float
        Share of each range that is left out at both ends.

    Returns
    -------
    pandas.DataFrame
        Columns ``v, T, sigma, psi``, one row a test.
    """
    unit = inner + (1.0 - 2.0 * inner) * qmc.LatinHypercube(d=4, rng=rng).random(n)
    log = rng.random((n, 4)) < 0.5
    columns = {}
    for j, load in enumerate(SETPOINTS):
        low, _, high = _levels(domain)[load]
        straight = low + unit[:, j] * (high - low)
        curved = low * (high / low) ** unit[:, j]
        columns[load] = np.where(log[:, j], curved, straight) if load in ("v", "psi") else straight
    return pd.DataFrame(columns)


def inside(rows: pd.DataFrame, table: pd.DataFrame) -> pd.DataFrame:
    """Set points cut to the ranges of a plan: a load that never varied there does not vary in held-out tests."""
    columns = {"v": "v_set", "sigma": "sigma_set", "psi": "psi_set"}
    cut = {load: rows[load].clip(table[name].min(), table[name].max()) for load, name in columns.items()}
    tool = table["T_tool [degC]"].round(-1)
    return rows.assign(**cut, T=rows["T"].clip(tool.min(), tool.max()))


def full_plus_random(domain: Domain, rng: np.random.Generator, n_random: int = 30) -> pd.DataFrame:
    """All 81 combinations of three levels of four loads and `n_random` tests in between (111 tests)."""
    full = pd.DataFrame(list(product(*_levels(domain).values())), columns=list(SETPOINTS))
    full = full.drop_duplicates(ignore_index=True)
    return pd.concat([full, random_loads(domain, n_random, rng)], ignore_index=True)


def cube(domain: Domain, rng: np.random.Generator, factors: tuple[str, ...], repeats: int) -> pd.DataFrame:
    """Three levels of three loads with true repeats; the fourth load stays at its middle level.

    The loads a hidden law needs (`factors`) are among the three; with four needed loads speed, temperature and
    pressure vary over three levels and surface expansion over two, without being balanced.
    """
    others = [f for f in SETPOINTS if f not in factors]
    rng.shuffle(others)
    chosen = (list(dict.fromkeys(factors)) + others)[:3]
    levels = _levels(domain)
    rows = pd.DataFrame(list(product(*(levels[f] for f in chosen))), columns=chosen)
    for load in SETPOINTS:
        if load not in rows:
            rows[load] = levels[load][1]
    rows = pd.concat([rows] * repeats, ignore_index=True)
    extra = [f for f in factors if f not in chosen]
    for load in extra:
        rows[load] = np.where(rng.random(len(rows)) < 0.5, levels[load][0], levels[load][2])
    return rows[list(SETPOINTS)]


def half(domain: Domain, rng: np.random.Generator) -> pd.DataFrame:
    """A random half of the 111 tests."""
    rows = full_plus_random(domain, rng)
    keep = np.sort(rng.choice(len(rows), (len(rows) + 1) // 2, replace=False))
    return rows.iloc[keep].reset_index(drop=True)


def unbalanced(domain: Domain, rng: np.random.Generator, n: int = 90) -> pd.DataFrame:
    """Uneven repeats, missing corners: hard loads were tested less often."""
    full = pd.DataFrame(list(product(*_levels(domain).values())), columns=list(SETPOINTS))
    hard = (full["v"] * full["sigma"]) / (full["v"].max() * full["sigma"].max())
    weight = rng.gamma(0.7, 1.0, len(full)) * (1.15 - hard)
    counts = rng.multinomial(n, weight / weight.sum())
    rows = full.loc[np.repeat(full.index, np.minimum(counts, 6))].reset_index(drop=True)
    return pd.concat([rows, random_loads(domain, max(12, n - len(rows)), rng)], ignore_index=True)


def thin(domain: Domain, rng: np.random.Generator, style: str) -> pd.DataFrame:
    """Plans that are too small for a firm answer.

    Parameters
    ----------
    domain : Domain
        Load ranges.
    rng : numpy.random.Generator
        Source of randomness.
    style : str
        ``four``: four tests; ``eight``: eight random tests; ``one_level``: 12 repeats of one setting;
        ``one_speed``: 18 tests at one speed; ``corner``: 15 tests in a corner of the ranges.

    Raises
    ------
    ValueError
        If `style` is unknown.
    """
    if style == "four":
        return random_loads(domain, 4, rng)
    if style == "eight":
        return random_loads(domain, 8, rng)
    if style == "one_level":
        return pd.concat([random_loads(domain, 1, rng, 0.3)] * 12, ignore_index=True)
    if style == "one_speed":
        rows = random_loads(domain, 18, rng)
        rows["v"] = domain.v[1]
        return rows
    if style == "corner":
        rows = random_loads(domain, 15, rng)
        for load in SETPOINTS:
            low, _, high = _levels(domain)[load]
            rows[load] = low + 0.2 * (rows[load] - low) if high > low else rows[load]
        return rows
    raise ValueError(f"style {style!r} is unknown; use four, eight, one_level, one_speed or corner")
