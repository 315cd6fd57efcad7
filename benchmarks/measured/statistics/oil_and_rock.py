"""Numbers of the oil film and of the rock gouge."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

from .. import tables
from .left_out import Array, common_profile, ladder, left_out, rms


def motor_oil(folder: Path) -> dict[str, object]:
    """Load and speed of the oil film; smallest load 1.5 N, 3 N and none."""
    answer: dict[str, object] = {}
    for least in (1.5, 3.0, 0.0):
        data, _, _ = tables.motor_oil(folder, least)
        mu, p, v = (data[name].to_numpy() for name in ("mu", "sigma_n", "v_rel"))
        found = ladder({"v": v, "p": p}, mu, np.arange(len(mu)))
        design = np.column_stack([np.ones(len(mu)), np.log(p), np.log(v)])
        found["log_mu_on_log_p_log_v"] = np.linalg.lstsq(design, np.log(mu), rcond=None)[0].tolist()
        for name, columns in (
            ("constant", [0]),
            ("log_v", [0, 2]),
            ("log_p", [0, 1]),
            ("log_p_log_v", [0, 1, 2]),
        ):
            predicted = np.exp(np.log(mu) - left_out(design[:, columns], np.log(mu), np.arange(len(mu))))
            found["mean_absolute_" + name] = float(np.mean(np.abs(mu - predicted)))
        level = pd.Series(mu * p).groupby(np.round(v)).agg(["mean", "std"])
        found["mu_times_p_by_speed"] = {
            f"{k:g}": [float(a) for a in row] for k, row in zip(level.index, level.to_numpy(), strict=True)
        }
        ranks = [
            stats.spearmanr(v[np.argsort(p)][k : k + 3], mu[np.argsort(p)][k : k + 3])[0]
            for k in range(0, len(mu), 3)
        ]
        found["loads_where_mu_rises_with_every_speed"] = (
            f"{int(np.sum(np.array(ranks) > 0.99))} of {len(ranks)}"
        )
        answer[f"from_{least:g}_N"] = found
    data, _, _ = tables.motor_oil(folder, 1.5, series=True)
    answer["inside_tests"] = common_profile(data, 8, "test_id")
    answer["inside_tests_after_10_s"] = common_profile(data[data["t"] > 10], 8, "test_id")
    summary = pd.read_csv(folder / "stribeck_motor_oil_glass" / "summary.csv")
    uncertain = summary.groupby("load_nominal_N")["mu_baseline_unc"].mean()
    answer["baseline_uncertainty_of_mu_by_load"] = {f"{k:g}": float(x) for k, x in uncertain.items()}
    return answer


def sepiolite(folder: Path) -> dict[str, object]:
    """One speed step: what speed, distance and memory leave."""
    data, _, _ = tables.sepiolite(folder)
    mu, v, s, t = (data[name].to_numpy() for name in ("mu", "v_rel", "sd", "t"))
    one = np.ones(len(mu))
    z = (s - s.mean()) / s.std()
    smooth_v = pd.Series(v).rolling(61, center=True, min_periods=1).median().to_numpy()
    log_v = np.log(smooth_v)

    def fit(*columns: Array) -> float:
        design = np.column_stack([one, *columns])
        return rms(mu - design @ np.linalg.lstsq(design, mu, rcond=None)[0])

    start = s[np.argmax(smooth_v > 0.001)]
    memory = min(
        (fit(log_v, np.where(s > start, np.exp(-(s - start) / d), 0.0)), d)
        for d in (0.02, 0.05, 0.1, 0.17, 0.3, 0.5)
    )
    run_in = min((fit(log_v, np.exp(-s / d)), d) for d in (0.1, 0.3, 1.0, 3.0))
    run_in_base = min((fit(smooth_v, z, np.exp(-(s - s[0]) / d)), d) for d in (0.05, 0.1, 0.3, 1.0, 3.0))
    memory_base = min(
        (fit(smooth_v, z, np.where(s > start, np.exp(-(s - start) / d), 0.0)), d)
        for d in (0.02, 0.05, 0.1, 0.17, 0.3, 0.5)
    )
    before, late = mu[s < start], mu[s > start + 1.0]
    rest = (
        mu - np.column_stack([one, log_v]) @ np.linalg.lstsq(np.column_stack([one, log_v]), mu, rcond=None)[0]
    )
    return {
        "tests": 1,
        "speed_levels_mm_s": [float(np.median(v[s < start])), float(np.median(v[s > start + 0.3]))],
        "step_at_mm": float(start),
        "constant": fit(),
        "sd_line": fit(z),
        "v_line": fit(smooth_v),
        "v_line_raw_speed": fit(v),
        "log_v": fit(log_v),
        "v_power_0.5": fit(np.sqrt(smooth_v)),
        "v_and_sd_lines": fit(smooth_v, z),
        "log_v_raw_speed": fit(np.log(v)),
        "log_v_and_memory": {"rms": memory[0], "length_mm": memory[1]},
        "log_v_and_running_in": {"rms": run_in[0], "length_mm": run_in[1]},
        "v_and_sd_lines_and_running_in_from_first_point": {
            "rms": run_in_base[0],
            "length_mm": run_in_base[1],
        },
        "v_and_sd_lines_and_memory": {"rms": memory_base[0], "length_mm": memory_base[1]},
        "mean_absolute_constant_log_v_memory": [
            float(np.mean(np.abs(mu - d @ np.linalg.lstsq(d, mu, rcond=None)[0])))
            for d in (
                one[:, None],
                np.column_stack([one, log_v]),
                np.column_stack([one, log_v, np.where(s > start, np.exp(-(s - start) / memory[1]), 0.0)]),
            )
        ],
        "noise_from_second_differences": float(np.std(np.diff(mu, 2)) / np.sqrt(6)),
        "mu_before": float(before.mean()),
        "mu_just_after": float(mu[(s > start) & (s < start + 0.03)].mean()),
        "mu_0.1_to_0.15_mm_after": float(mu[(s > start + 0.1) & (s < start + 0.15)].mean()),
        "mu_0.5_to_0.7_mm_after": float(mu[(s > start + 0.5) & (s < start + 0.7)].mean()),
        "mu_last_0.2_mm": float(mu[s > s.max() - 0.2].mean()),
        "mu_late_mean": float(late.mean()),
        "autocorrelation_of_rest_at_20_s": float(np.corrcoef(rest[:-37], rest[37:])[0, 1]),
        "speed_fluctuation_share": float(np.std(v[s < start]) / np.mean(v[s < start])),
        "duration_s": float(t[-1]),
    }
