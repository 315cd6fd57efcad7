"""From a case to a campaign: data, test table, truth and held-out tests. Everything here is synthetic."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypedDict

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from . import plans, scale
from .case import Case
from .contact import Base, Run, draw_base, march, twin_temperature
from .domains import DOMAINS, Domain
from .foreign import mangle
from .law import REGISTER, Law, Parameters, get
from .metadata import for_laws, test_table
from .noise import RECIPES, Levels, Recipe, draw_levels, measure, physical
from .oracle import fit_predict
from .profiles import Profiles, profiles

Array = NDArray[np.float64]


class HiddenLaw(TypedDict):
    """A hidden law; ``ratio`` is its size over the scatter between tests, as drawn and as it came out."""

    key: str
    equation: str
    parameters: Parameters
    amplitude: float
    ratio_wanted: float
    ratio: float


class Record(TypedDict):
    """What is hidden in a campaign, for the judge and for people; standard deviations are those of the noise in mu."""

    label: str
    case: str
    kind: str
    recipe: str
    domain: str
    style: str
    seed: int
    n_tests: int
    points: int
    laws: list[HiddenLaw]
    test_sd: float
    drift_sd: float
    sensor_sd: float
    force_sd: float
    base: dict[str, float]
    odd_tests: list[str]
    mu_range: list[float]
    T_range: list[float]


@dataclass
class Campaign:
    """A synthetic campaign with its truth.

    Attributes
    ----------
    data, tests : pandas.DataFrame
        What the diagnosis sees; `tests` may be None for foreign tables.
    mu_true : ndarray, shape (n_rows,)
        Friction without any scatter in the rows of `data`.
    heldout_data, heldout_tests : pandas.DataFrame
        Tests at other loads, same law, no noise.
    heldout_mu : ndarray
        True friction of the held-out rows.
    floor_mu, linear_mu : ndarray
        Prediction of the held-out rows by a fit with the true form, and by an ordinary linear fit.
    record : Record
        Parameters, amplitudes, ratios and noise levels.
    """

    data: pd.DataFrame
    tests: pd.DataFrame | None
    mu_true: Array
    heldout_data: pd.DataFrame
    heldout_tests: pd.DataFrame
    heldout_mu: Array
    floor_mu: Array
    linear_mu: Array
    record: Record


def _plan(
    case: Case, domain: Domain, recipe: Recipe, laws: list[Law], rng: np.random.Generator
) -> pd.DataFrame:
    if case.kind == "thin":
        return plans.thin(domain, rng, case.style)
    # Three levels show of one load only its curvature, which cannot tell an unknown shape from a known one.
    if any(law.outside and len(law.factors) == 1 for law in laws):
        count = {"half": 56, "unbalanced": 90, "lhs30": 30}.get(recipe.plan, 111)
        return plans.random_loads(domain, count, rng)
    if recipe.plan == "half":
        return plans.half(domain, rng)
    if recipe.plan == "unbalanced":
        return plans.unbalanced(domain, rng)
    if recipe.plan == "lhs30":
        return plans.random_loads(domain, 30, rng)
    needed = tuple(dict.fromkeys(f for law in laws for f in law.factors))
    if domain.size != 1.0 or len(needed) > 3 or any(law.outside for law in laws) or rng.random() < 0.6:
        return plans.full_plus_random(domain, rng)
    return plans.cube(domain, rng, needed, int(rng.integers(2, 5)))


def _rows(n_points: int, points: int) -> NDArray[np.intp]:
    """Points that are kept: a tenth of them without a gap at the start, the rest evenly."""
    if points >= n_points:
        return np.arange(n_points)
    start = points // 10
    return np.concatenate(
        [np.arange(start), np.linspace(start, n_points - 1, points - start).round()]
    ).astype(np.intp)


def _frame(
    table: pd.DataFrame,
    loads: Profiles,
    T: Array,
    sigma: Array,
    mu: Array,
    extra: list[Array],
    rows: NDArray[np.intp],
    averaged: bool,
) -> tuple[pd.DataFrame, list[Array]]:
    """Long table and the extra arrays in its row order."""
    columns = {
        "t [s]": loads.t,
        "v_rel [mm/s]": loads.v,
        "T [degC]": T,
        "sigma_n [MPa]": sigma,
        "sd [mm]": loads.sd,
        "psi": loads.psi,
        "mu": mu,
    }
    m = mu.shape[1]
    if averaged:
        flat = {k: c[:, m // 10 :].mean(axis=1) for k, c in columns.items()}
        more = [e[:, m // 10 :].mean(axis=1) for e in extra]
        ids = table["test_id"].to_numpy()
    else:
        flat = {k: c[:, rows].ravel() for k, c in columns.items()}
        more = [e[:, rows].ravel() for e in extra]
        ids = np.repeat(table["test_id"].to_numpy(), len(rows))
    return pd.DataFrame({"test_id": ids, **flat}), more


def _amplitudes(laws: list[Law], run: Run, loads: Profiles, wanted: list[float], cap: float) -> list[float]:
    return [scale.amplitude(s, loads, run.T, w, cap) for s, w in zip(run.shapes, wanted, strict=True)]


def make(case: Case, among: Mapping[str, Law] = REGISTER) -> Campaign:
    """Make the campaign of a case.

    Parameters
    ----------
    case : Case
        What to make; equal cases give equal campaigns.
    among : mapping of str to Law
        Where the laws of the case stand; those of this package by default.

    Returns
    -------
    Campaign
        Synthetic data with truth.

    Raises
    ------
    KeyError
        If a law, recipe or domain is unknown.
    """
    rng = np.random.default_rng(case.seed)
    domain, recipe = DOMAINS[case.domain], RECIPES[case.recipe]
    laws = [get(key, among) for key in case.laws]
    table = test_table(_plan(case, domain, recipe, laws, rng), rng)
    loads = profiles(table, domain, rng)
    base, levels = draw_base(domain, rng), draw_levels(rng, domain.size)
    meta, still = for_laws(table), np.zeros_like(loads.sd)
    pilot = march(loads, meta, base, [], [], [], still, domain.heat)
    span = scale.ranges(loads, pilot, table["order"].to_numpy())
    parameters: list[Parameters] = [law.draw(rng, span) for law in laws]
    ratios = [float(np.exp(rng.uniform(*np.log(case.ratio)))) for _ in laws]
    unit = march(loads, meta, base, laws, parameters, [0.0] * len(laws), still, domain.heat)
    cap = 0.08 * domain.size
    amplitudes = _amplitudes(laws, unit, loads, [r * levels.test for r in ratios], cap)
    scatter, odd = physical(recipe, levels, loads, rng)
    if case.kind == "hidden_group":
        group = rng.random(len(table)) < 0.5
        scatter += (np.where(group, 0.5, -0.5) * rng.uniform(3.0, 6.0) * levels.test)[:, None]
    base, run = _march_positive(loads, meta, base, laws, parameters, amplitudes, scatter, domain)
    mu, sigma = measure(recipe, levels, loads, run.mu + scatter, rng)
    T = twin_temperature(loads, mu, sigma, domain.heat)
    rows = _rows(mu.shape[1], case.points)
    data, extra = _frame(table, loads, T, sigma, mu, [run.mu, *run.shapes], rows, recipe.averaged)

    fresh = plans.inside(plans.random_loads(domain, case.n_heldout, rng, 0.03), table)
    new_table = test_table(fresh, rng, first=len(table) + 1, prefix="H")
    new_loads = profiles(new_table, domain, rng)
    new_run = march(
        new_loads,
        for_laws(new_table),
        base,
        laws,
        parameters,
        amplitudes,
        np.zeros_like(new_loads.sd),
        domain.heat,
    )
    new, new_extra = _frame(
        new_table, new_loads, new_run.T, new_loads.sigma, new_run.mu, new_run.shapes, rows, recipe.averaged
    )
    truth = new.pop("mu").to_numpy(float)
    floor, linear = _floors(data, extra[1:], new, new_extra, levels, {str(table["test_id"][i]) for i in odd})
    realised = [
        scale.size(a * scale.missed(s, loads, run.T)) / levels.test
        for a, s in zip(amplitudes, run.shapes, strict=True)
    ]
    record = _record(case, laws, parameters, amplitudes, ratios, realised, levels, base, run, table, odd)
    tests: pd.DataFrame | None = table.sort_values("order").reset_index(drop=True)
    data = data.assign(order_=pd.Categorical(data["test_id"], categories=tests["test_id"]))  # type: ignore[index]
    place = np.argsort(data.pop("order_").cat.codes.to_numpy(), kind="stable")
    data, mu_true = data.iloc[place].reset_index(drop=True), extra[0][place]
    if case.kind == "foreign":
        data, tests, mu_true, new = mangle(case.style, data, tests, mu_true, new, rng)
    data, new = (frame.rename(columns=_plain) for frame in (data, new))
    tests = None if tests is None else tests.rename(columns=_plain)
    new_table = new_table.rename(columns=_plain)
    return Campaign(data, tests, mu_true, new, new_table, truth, floor, linear, record)


def _plain(heading: str) -> str:
    """Return a heading without its unit: data frames have the plain names."""
    return heading.split(" [")[0]


def _march_positive(
    loads: Profiles,
    meta: dict[str, NDArray[Any]],
    base: Base,
    laws: list[Law],
    parameters: list[Parameters],
    amplitudes: list[float],
    scatter: Array,
    domain: Domain,
) -> tuple[Base, Run]:
    """March; raise the base where friction would come too close to zero."""
    for _ in range(3):
        run = march(loads, meta, base, laws, parameters, amplitudes, scatter, domain.heat)
        low = float(np.quantile(run.mu, 0.001)) - 0.02 * domain.size
        if low >= 0.0:
            break
        base = Base(base.mu0 - low, base.slopes)
    return base, run


def _floors(
    data: pd.DataFrame,
    shapes: list[Array],
    new: pd.DataFrame,
    new_shapes: list[Array],
    levels: Levels,
    drop: set[str],
) -> tuple[Array, Array]:
    point = float(np.hypot(levels.drift, levels.sensor))
    none, new_none = np.empty((len(data), 0)), np.empty((len(new), 0))
    known = np.column_stack(shapes) if shapes else none
    new_known = np.column_stack(new_shapes) if new_shapes else new_none
    return (
        fit_predict(data, known, new, new_known, levels.test, point, drop),
        fit_predict(data, none, new, new_none, 0.0, point),
    )


def _record(
    case: Case,
    laws: list[Law],
    parameters: list[Parameters],
    amplitudes: list[float],
    ratios: list[float],
    realised: list[float],
    levels: Levels,
    base: Base,
    run: Run,
    table: pd.DataFrame,
    odd: NDArray[Any],
) -> Record:
    return {
        "label": "SYNTHETIC",
        "case": case.id,
        "kind": case.kind,
        "recipe": case.recipe,
        "domain": case.domain,
        "style": case.style,
        "seed": case.seed,
        "n_tests": len(table),
        "points": case.points,
        "laws": [
            {
                "key": law.key,
                "equation": law.equation,
                "parameters": {k: float(v) for k, v in p.items()},
                "amplitude": float(a),
                "ratio_wanted": w,
                "ratio": float(r),
            }
            for law, p, a, w, r in zip(laws, parameters, amplitudes, ratios, realised, strict=True)
        ],
        "test_sd": levels.test,
        "drift_sd": levels.drift,
        "sensor_sd": levels.sensor,
        "force_sd": levels.force,
        "base": {"mu0": base.mu0, **base.slopes},
        "odd_tests": [str(table["test_id"][i]) for i in odd],
        "mu_range": [float(run.mu.min()), float(run.mu.max())],
        "T_range": [float(run.T.min()), float(run.T.max())],
    }
