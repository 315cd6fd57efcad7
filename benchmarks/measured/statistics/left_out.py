"""Errors on groups that were left out: straight lines, forms, curvature, a flexible reference."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import numpy as np
import pandas as pd
from scipy import optimize, stats

Array = np.ndarray
Loads = dict[str, Array]

TWINS = {"pressure_power": "pressure", "pressure_saturation": "pressure", "force_zero": "pressure"}


def forms(loads: Loads) -> dict[str, list[Array]]:
    """Candidate columns of each effect over its shapes, made from the loads that vary.

    Parameters
    ----------
    loads
        ``v``, ``p``, ``T`` as far as they vary, one value a row.

    Returns
    -------
    dict
        Effect name to a list of columns, one a shape. A positive coefficient is the physical sign where one exists
        (``SIGN``).
    """
    found: dict[str, list[Array]] = {}
    p, v, temperature = loads.get("p"), loads.get("v"), loads.get("T")
    if p is not None:
        q = p / np.median(p)
        found["pressure_power"] = [q**-a for a in (0.25, 0.5, 0.75)] + [-np.log(q)]
        found["pressure_saturation"] = [(1 - np.exp(-m * q)) / q for m in (0.5, 1.0, 2.0, 4.0)] + [
            np.minimum(1.0, m / q) for m in (0.4, 0.7, 1.0)
        ]
        found["force_zero"] = [1 / q]
    if v is not None:
        w = v / np.median(v)
        found["stribeck"] = [np.exp(-((w / s) ** k)) for s in (0.2, 0.5, 1.0) for k in (0.5, 1.0)]
        found["speed_log"] = [np.log(w)]
        found["speed_power"] = [w**a for a in (0.2, 0.5, 1.5)]
    if v is not None and p is not None:
        found["hersey"] = [(w / q) ** a for a in (0.25, 0.5, 1.0)] + [np.log(w / q)]
        found["flash_temperature"] = [-q * w**a for a in (0.5, 1.0)] + [
            np.exp(-b * q * np.sqrt(w)) for b in (0.3, 1.0)
        ]
        thin = [np.zeros_like(w)] if temperature is None else [temperature / c for c in (20.0, 50.0)]
        found["viscous"] = [w**a * np.exp(-h) / q**b for a in (0.5, 1.0) for b in (0.0, 1.0) for h in thin]
    if temperature is not None:
        found["thermal_softening"] = [np.exp(-temperature / c) for c in (20.0, 40.0, 80.0)] + [
            1 / (1 + np.exp((temperature - c) / 12)) for c in (40.0, 70.0, 100.0)
        ]
        found["thermal_breakdown"] = [1 / (1 + np.exp(-(temperature - c) / 12)) for c in (60.0, 90.0, 120.0)]
        if p is not None:
            q = p / np.median(p)
            found["breakdown_pressure_temperature"] = [
                1 / (1 + np.exp(-(temperature * q**a - c) / 12)) for a in (0.3, 1.0) for c in (60.0, 90.0)
            ]
    return found


SIGN = dict.fromkeys(
    (
        "pressure_power",
        "pressure_saturation",
        "stribeck",
        "viscous",
        "hersey",
        "flash_temperature",
        "thermal_softening",
        "thermal_breakdown",
        "breakdown_pressure_temperature",
    ),
    1,
)


def straight(loads: Loads) -> Array:
    """Constant and straight lines in the standardised loads."""
    columns = [np.ones(len(next(iter(loads.values()))))]
    columns += [(x - x.mean()) / x.std() for x in loads.values()]
    return np.column_stack(columns)


def curved(loads: Loads) -> Array:
    """All squares and products of the loads, with the logarithm of pressure and speed beside them."""
    extra = dict(loads)
    for name in ("p", "v"):
        if name in loads:
            extra["log" + name] = np.log(loads[name])
    scaled = [(x - x.mean()) / x.std() for x in extra.values()]
    pairs = [a * b for a, b in itertools.combinations_with_replacement(scaled[: len(loads)], 2)]
    return np.column_stack([np.ones(len(scaled[0])), *scaled, *pairs])


def left_out(design: Array, mu: Array, groups: Array) -> Array:
    """Residuals of least squares for groups left out one at a time (exact, by blocks of the hat matrix)."""
    inverse = np.linalg.pinv(design.T @ design)
    residual = mu - design @ (inverse @ (design.T @ mu))
    out: Array = np.empty_like(residual)
    for group in np.unique(groups):
        rows = np.flatnonzero(groups == group)
        block = np.eye(len(rows)) - design[rows] @ inverse @ design[rows].T
        out[rows] = np.linalg.pinv(block) @ residual[rows]
    return out


def rms(values: Array) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def left_out_form(
    base: Array, shapes: Iterable[tuple[Array, ...]], mu: Array, groups: Array, signs: tuple[int, ...] = (0,)
) -> float:
    """Left-out error of base plus a form whose shape is chosen without the left-out group; wrong signs are not used."""
    designs = [np.column_stack([base, *shape]) for shape in shapes]
    errors = np.zeros(len(mu))
    for group in np.unique(groups):
        held = groups == group
        best, chosen = np.inf, None
        for design in designs:
            coefficient = np.linalg.lstsq(design[~held], mu[~held], rcond=None)[0]
            extra = coefficient[base.shape[1] :]
            if any(sign and value * sign < 0 for sign, value in zip(signs, extra, strict=True)):
                continue
            misfit = rms(mu[~held] - design[~held] @ coefficient)
            if misfit < best:
                best, chosen = misfit, mu[held] - design[held] @ coefficient
        if chosen is None:
            coefficient = np.linalg.lstsq(base[~held], mu[~held], rcond=None)[0]
            chosen = mu[held] - base[held] @ coefficient
        errors[held] = chosen
    return rms(errors)


def flexible(loads: Loads, mu: Array, groups: Array) -> tuple[float, float, float]:
    """Left-out error of a Gaussian process with a straight mean, its offset of a group and its noise.

    The process knows the loads (pressure and speed as logarithms) and gives every group an offset of its own.
    """
    scaled = []
    for name, x in loads.items():
        z = np.log(x) if name in ("p", "v") else x
        scaled.append((z - z.mean()) / z.std())
    spread = mu.std()
    y = (mu - mu.mean()) / spread
    base = straight(loads)
    same = (groups[:, None] == groups[None, :]).astype(float)
    several = bool(np.any(np.bincount(np.unique(groups, return_inverse=True)[1]) > 1))
    distance = [np.square(z[:, None] - z[None, :]) for z in scaled]

    def covariance(x: Array) -> tuple[Array, Array]:
        smooth = np.exp(2 * x[0]) * np.exp(
            -0.5 * sum(d * np.exp(-2 * a) for d, a in zip(distance, x[3:], strict=True))
        )
        total = smooth + 25 * base @ base.T + (np.exp(2 * x[1]) * same if several else 0)
        return total + np.exp(2 * x[2]) * np.eye(len(y)), total

    def cost(x: Array) -> float:
        factor = np.linalg.cholesky(covariance(x)[0] + 1e-9 * np.eye(len(y)))
        white = np.linalg.solve(factor, y)
        prior = (
            np.sum(np.square((x[3:] - 0.5) / 1.0)) / 2
            + np.sum(np.square((x[:3] + np.array([0, 2, 2])) / 2)) / 2
        )
        return float(0.5 * white @ white + np.sum(np.log(np.diag(factor))) + prior)

    start = np.array([-1.0, -2.5, -2.5] + [0.5] * len(scaled))
    found = optimize.minimize(
        cost, start, method="L-BFGS-B", bounds=[(-5, 2), (-6, 1), (-6, 1)] + [(-1.5, 3)] * len(scaled)
    )
    precision = np.linalg.inv(covariance(found.x)[0] + 1e-9 * np.eye(len(y)))
    weighted = precision @ y
    out = np.empty_like(y)
    for group in np.unique(groups):
        rows = np.flatnonzero(groups == group)
        out[rows] = np.linalg.solve(precision[np.ix_(rows, rows)], weighted[rows])
    offset = float(np.exp(found.x[1]) * spread) if several else float("nan")
    return rms(out) * spread, offset, float(np.exp(found.x[2]) * spread)


def ladder(loads: Loads, mu: Array, groups: Array, pairs: bool = True) -> dict[str, object]:
    """Left-out errors of constant, straight lines, one form, two forms, all curvature and a flexible reference."""
    base = straight(loads)
    constant = rms(left_out(np.ones((len(mu), 1)), mu, groups))
    lines = rms(left_out(base, mu, groups))
    bent = rms(left_out(curved(loads), mu, groups))
    process, offset, noise = flexible(loads, mu, groups)
    reference = min(bent, process)
    avoidable = lines**2 - reference**2
    shapes = forms(loads)
    single = {
        name: left_out_form(base, [(c,) for c in columns], mu, groups, (SIGN.get(name, 0),))
        for name, columns in shapes.items()
    }
    answer: dict[str, object] = {
        "tests": len(mu),
        "groups": len(np.unique(groups)),
        "constant": constant,
        "straight": lines,
        "all_curvature": bent,
        "flexible": process,
        "group_offset": offset,
        "noise": noise,
        "avoidable_share_of_straight": avoidable / lines**2,
        "rank_correlation": {name: float(stats.spearmanr(x, mu)[0]) for name, x in loads.items()},
        "single": dict(sorted(single.items(), key=lambda item: item[1])),
        "share_single": {
            k: (lines**2 - e**2) / avoidable for k, e in sorted(single.items(), key=lambda item: item[1])
        },
    }
    if pairs:
        double = {}
        for first, second in itertools.combinations(shapes, 2):
            if TWINS.get(first, first) == TWINS.get(second, second):
                continue
            both = list(itertools.product(shapes[first], shapes[second]))
            double[f"{first} + {second}"] = left_out_form(
                base, both, mu, groups, (SIGN.get(first, 0), SIGN.get(second, 0))
            )
        best = sorted(double.items(), key=lambda item: item[1])[:24]
        answer["pairs"] = dict(best)
        answer["share_pairs"] = {k: (lines**2 - e**2) / avoidable for k, e in best}
    return answer


def variance_table(values: Array, factor: Array) -> dict[str, float]:
    """F test of a factor over independent values: share of variance, F, p, pooled scatter within a level."""
    levels = [values[factor == level] for level in np.unique(factor)]
    within = sum(float(np.sum(np.square(x - x.mean()))) for x in levels)
    free = len(values) - len(levels)
    total = float(np.sum(np.square(values - values.mean())))
    found = stats.f_oneway(*levels)
    return {
        "share": 1 - within / total,
        "F": float(found.statistic),
        "p": float(found.pvalue),
        "scatter_within": float(np.sqrt(within / free)),
    }


def common_profile(data: pd.DataFrame, bins: int, by: str) -> dict[str, float]:
    """Find the course inside the tests that all of them share.

    Each test is averaged in bins of its own length and made mean-free; the share is the part of this variation that the
    mean course of the other groups predicts for a group left out (negative: the common course does harm).
    """
    number = data.groupby("test_id").cumcount()
    count = data.groupby("test_id")["mu"].transform("size")
    binned = data.assign(bin=np.minimum(number * bins // count, bins - 1))
    table = binned.pivot_table(index="test_id", columns="bin", values="mu")
    table = table.sub(table.mean(axis=1), axis=0)
    first = data.drop_duplicates("test_id").set_index("test_id", drop=False)
    group = first[by].reindex(table.index).to_numpy()
    error = np.concatenate(
        [(table[group == g] - table[group != g].mean()).to_numpy().ravel() for g in np.unique(group)]
    )
    end = (table.iloc[:, -1] - table.iloc[:, 0]).groupby(group).mean()
    return {
        "groups": len(np.unique(group)),
        "rms_inside_tests": rms(table.to_numpy()),
        "share_predicted_by_other_groups": 1 - rms(error) ** 2 / rms(table.to_numpy()) ** 2,
        "end_minus_start_mean": float(end.mean()),
        "end_minus_start_scatter": float(end.std()),
        "t_of_end_minus_start": float(end.mean() / end.std() * np.sqrt(len(end))),
        "groups_rising": int((end > 0).sum()),
    }
