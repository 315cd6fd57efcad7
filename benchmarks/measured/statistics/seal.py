"""Numbers of the seal rings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

from .. import tables
from .left_out import common_profile, ladder, left_out, rms, straight, variance_table


def pneumatic_seal(folder: Path) -> dict[str, object]:
    """Pressure, ring, speed and stroke; cells of ring and pressure are left out together."""
    data, tests, _ = tables.pneumatic_seal(folder)
    table = (
        data.merge(tests)
        .groupby("test_id")
        .agg(
            p=("sigma_n", "mean"),
            v=("v_rel", "mean"),
            mu=("mu", "mean"),
            w=("mu", "std"),
            batch=("batch", "first"),
            order=("order", "first"),
        )
    )
    table["set"] = table["p"].round(1)
    table["cell"] = table["batch"] + "_" + table["set"].astype(str)
    mu, p, v = (table[name].to_numpy() for name in ("mu", "p", "v"))
    cell, ring = table["cell"].to_numpy(), table["batch"].to_numpy()
    found = ladder({"v": v, "p": p}, mu, cell)
    by_ring = pd.get_dummies(ring).to_numpy(float)
    one = np.ones((len(mu), 1))
    inverse = (0.1 / p)[:, None]
    line = straight({"v": v, "p": p})
    found["models_cell_left_out"] = {
        "constant": rms(left_out(one, mu, cell)),
        "rings": rms(left_out(by_ring, mu, cell)),
        "lines_v_p": rms(left_out(line, mu, cell)),
        "1/p": rms(left_out(np.column_stack([one, inverse]), mu, cell)),
        "1/p_and_lines": rms(left_out(np.column_stack([line, inverse]), mu, cell)),
        "rings_and_lines": rms(left_out(np.column_stack([by_ring, line[:, 1:]]), mu, cell)),
        "1/p_and_rings": rms(left_out(np.column_stack([by_ring, inverse]), mu, cell)),
        "1/p_and_rings_and_lines": rms(left_out(np.column_stack([by_ring, line[:, 1:], inverse]), mu, cell)),
        "1/p_slope_for_each_ring": rms(left_out(np.column_stack([by_ring, by_ring * inverse]), mu, cell)),
        "log_p_slope_for_each_ring": rms(
            left_out(np.column_stack([by_ring, by_ring * np.log(p)[:, None]]), mu, cell)
        ),
        "log_v_and_rings": rms(left_out(np.column_stack([by_ring, np.log(v)]), mu, cell)),
        "log_v_slope_for_each_ring": rms(
            left_out(np.column_stack([by_ring, by_ring * np.log(v)[:, None]]), mu, cell)
        ),
        "1/p_and_lines_ring_left_out": rms(left_out(np.column_stack([line, inverse]), mu, ring)),
        "lines_ring_left_out": rms(left_out(line, mu, ring)),
    }
    rings: dict[str, dict[str, float]] = {}
    for name, part in table.groupby("batch"):
        y, x, w = (part[c].to_numpy() for c in ("mu", "p", "v"))
        unit = np.ones(len(y))
        rings[str(name)] = {
            label: rms(y - design @ np.linalg.lstsq(design, y, rcond=None)[0])
            for label, design in (
                ("constant", unit[:, None]),
                ("line_p", np.column_stack([unit, x])),
                ("1/p", np.column_stack([unit, 1 / x])),
                ("log_p", np.column_stack([unit, np.log(x)])),
                ("line_p_v", np.column_stack([unit, x, w])),
                ("line_v", np.column_stack([unit, w])),
                ("log_v", np.column_stack([unit, np.log(w)])),
            )
        }
    found["one_ring_in_sample"] = rings
    cells = table.groupby("cell")["mu"].agg(["mean", "std"])
    ratio = (
        table[table["set"] == 0.1].groupby("batch")["mu"].mean()
        / table[table["set"] == 0.7].groupby("batch")["mu"].mean()
    )
    drift = pd.Series({k: float(stats.spearmanr(g["order"], g["mu"])[0]) for k, g in table.groupby("cell")})
    level = table.pivot_table(index="batch", columns="set", values="mu")
    speed = table.pivot_table(index="batch", columns="set", values="v")
    last = table[table["order"] == 9].groupby("cell")["mu"].mean()
    first = table[table["order"] == 0].groupby("cell")["mu"].mean()
    rest = mu - by_ring @ np.linalg.lstsq(np.column_stack([by_ring]), mu, rcond=None)[0]
    found |= {
        "repeat_scatter_median": float(cells["std"].median()),
        "repeat_scatter_relative_median": float((cells["std"] / cells["mean"]).median()),
        "scatter_inside_stroke": float(table["w"].median()),
        "ratio_1_to_7_bar": {k: float(x) for k, x in ratio.items()},
        "rings_where_mu_falls_0.5_to_0.7": f"{int((level[0.7] < level[0.5]).sum())} of {len(level)}",
        "rings_where_speed_rises_and_mu_falls_0.5_to_0.7": int(
            ((level[0.7] < level[0.5]) & (speed[0.7] > speed[0.5])).sum()
        ),
        "speed_0.5_and_0.7": {
            str(k): [float(a), float(b)] for k, a, b in zip(speed.index, speed[0.5], speed[0.7], strict=True)
        },
        "order_rank_rising_cells": f"{int((drift > 0.6).sum())} rise, {int((drift < -0.6).sum())} fall, of {len(drift)}",
        "order_of_cells_change_first_to_last": float((last / first - 1).abs().median()),
        "ring_share_of_cell_means": variance_table(
            cells["mean"].to_numpy(), np.array([str(name).rsplit("_", 1)[0] for name in cells.index])
        ),
        "rank_v_p": float(stats.spearmanr(v, p)[0]),
        "rest_after_rings_rank_p": float(stats.spearmanr(p, rest)[0]),
        "inside_strokes_by_cell": common_profile(data.merge(table[["cell"]].reset_index()), 6, "cell"),
    }
    return found
