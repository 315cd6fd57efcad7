"""Numbers of printed PLA on silicone and of the aluminium composites."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

from .. import tables
from .left_out import (
    SIGN,
    Array,
    common_profile,
    flexible,
    forms,
    ladder,
    left_out,
    left_out_form,
    rms,
    straight,
    variance_table,
)


def _one_load_out(p: Array, mu: Array) -> dict[str, float]:
    """Errors of lines, one pressure form and the flexible reference for one load left out."""
    groups = np.arange(len(mu))
    loads = {"p": p}
    line = straight(loads)
    found = {"straight": rms(left_out(line, mu, groups)), "flexible": flexible(loads, mu, groups)[0]}
    for name, columns in forms(loads).items():
        found[name] = left_out_form(line, [(column,) for column in columns], mu, groups, (SIGN.get(name, 0),))
    return found


def _pla(folder: Path, make: Callable[..., tables.Table]) -> dict[str, object]:
    data, tests, _ = make(folder)
    order = data.merge(tests).groupby("test_id")["order"].first()
    table = data.groupby("test_id").agg(
        p=("sigma_n", "first"), mu=("mu", "mean"), first=("mu", "first"), n=("mu", "size")
    )
    late = data[data["sd"] > 200].groupby("test_id")["mu"].agg(["mean", "std"])
    table = table.join(late).join(order).sort_values("order")
    mu, p = table["mean"].to_numpy(), table["p"].to_numpy()
    groups = (
        np.arange(len(mu)) // 5
    )  # five loads side by side are left out together: neighbours are nearly copies
    found = ladder({"p": p}, mu, groups, pairs=False)
    for name in ("p", "mu"):
        found["rank_of_order_and_" + name] = float(stats.spearmanr(table["order"], table[name])[0])
    found["one_load_left_out"] = _one_load_out(p, mu)
    found["from_sixth_load_one_left_out"] = _one_load_out(p[5:], mu[5:])
    rise = data.groupby("test_id")["mu"].agg(lambda x: x.iloc[1] - x.iloc[0])
    later = data.groupby("test_id")["mu"].agg(lambda x: x.iloc[-5:].mean() - x.iloc[3:8].mean())
    found["first_to_second_turn_median"] = float(rise.median())
    found["fourth_to_eighth_turn_to_last_five_median"] = float(later.median())
    found["fourth_to_eighth_turn_to_last_five_rising"] = f"{int((later > 0).sum())} of {len(later)}"
    found["inside_tests_without_three_turns"] = common_profile(
        data[data.groupby("test_id").cumcount() >= 3], 8, "test_id"
    )
    jumps = np.diff(mu)
    turns = np.flatnonzero(np.diff(np.sign(jumps)) != 0) + 1
    found |= {
        "mu_at_turning_points_of_means_after_200_mm": {int(k): float(mu[k]) for k in turns},
        "first_and_last": [float(mu[0]), float(mu[-1])],
        "largest_jumps": {int(k): float(jumps[k]) for k in np.argsort(-np.abs(jumps))[:4]},
        "median_jump": float(np.median(np.abs(jumps))),
        "scatter_inside_test_after_200_mm": float(late["std"].median()),
        "first_turn_minus_late": float((table["first"] - table["mean"]).median()),
        "first_turn_lower": f"{int((table['first'] < table['mean']).sum())} of {len(table)}",
        "points_below_0.1": int((data["mu"] < 0.1).sum()),
        "tests_with_points_below_half_of_their_median": int(
            (data["mu"] < 0.5 * data.groupby("test_id")["mu"].transform("median"))
            .groupby(data["test_id"])
            .any()
            .sum()
        ),
        "lag_one_correlation_of_neighbours_after_a_line": float(
            np.corrcoef(*(lambda r: (r[:-1], r[1:]))(mu - np.polyval(np.polyfit(p, mu, 1), p)))[0, 1]
        ),
        "inside_tests": common_profile(data, 8, "test_id"),
    }
    return found


def pla_dragonskin(folder: Path) -> dict[str, object]:
    """Load (or order) and the course inside a load."""
    return _pla(folder, tables.pla_dragonskin)


def pla_sil950(folder: Path) -> dict[str, object]:
    """Load (or order) and the course inside a load."""
    return _pla(folder, tables.pla_sil950)


def al10cu_composites(folder: Path) -> dict[str, object]:
    """Material against scatter of three runs each, and the course along the run."""
    data, tests, _ = tables.al10cu_composites(folder)
    mean = data.groupby("test_id")["mu"].mean()
    batch = tests.set_index("test_id")["batch"].reindex(mean.index).to_numpy()
    alloy = batch == "Al2O3_0"
    values = mean.to_numpy()
    found = stats.ttest_ind(values[~alloy], values[alloy])
    welch = stats.ttest_ind(values[~alloy], values[alloy], equal_var=False)
    one = np.ones((len(values), 1))
    tests_out = np.arange(len(values))
    dummies = pd.get_dummies(batch).to_numpy(float)
    exact = [
        abs(values[list(chosen)].mean() - np.delete(values, list(chosen)).mean())
        for chosen in itertools.combinations(range(12), 3)
    ]
    real = values[~alloy].mean() - values[alloy].mean()
    content = np.array([float(name.split("_")[1]) for name in batch])
    return {
        "means": {str(k): float(values[batch == k].mean()) for k in np.unique(batch)},
        "four_materials": variance_table(values, batch),
        "composites_only": variance_table(values[~alloy], batch[~alloy]),
        "alloy_against_rest": {
            "difference": float(real),
            "t": float(found.statistic),
            "p": float(found.pvalue),
            "p_times_4": float(4 * found.pvalue),
            "t_welch": float(welch.statistic),
            "p_welch": float(welch.pvalue),
        },
        "permutation_p_alloy": float(np.mean(np.array(exact) >= abs(real) - 1e-12)),
        "rank_content": [float(number) for number in stats.spearmanr(content, values)],
        "left_out": {
            "constant": rms(left_out(one, values, tests_out)),
            "four_levels": rms(left_out(dummies, values, tests_out)),
            "alloy_or_not": rms(left_out(np.column_stack([one, alloy]), values, tests_out)),
            "straight_in_content": rms(left_out(np.column_stack([one, content]), values, tests_out)),
        },
        "scatter_of_runs_around_alloy_or_not": float(
            np.sqrt((np.var(values[alloy]) * 3 + np.var(values[~alloy]) * 9) / 10)
        ),
        "inside_runs": common_profile(data, 10, "test_id"),
        "inside_runs_after_60_s": common_profile(data[data["t"] > 60], 10, "test_id"),
        "alloy_inside_runs": common_profile(data[data["test_id"].str.startswith("al0")], 10, "test_id"),
    }
