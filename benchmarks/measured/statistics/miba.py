"""Numbers of the fourteen friction systems, dynamic and static."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from .. import tables
from .left_out import SIGN, Loads, curved, forms, ladder, left_out, rms, straight, variance_table


def _miba(folder: Path, make: Callable[..., tables.Table], names: list[str]) -> dict[str, object]:
    answer: dict[str, object] = {}
    for system in "abcdefghijklmn":
        data, _, _ = make(folder, system, blocks=True)
        loads = {
            key: data[column].to_numpy()
            for key, column in (("v", "v_rel"), ("p", "sigma_n"), ("T", "T"))
            if key in names
        }
        mu, groups = data["mu"].to_numpy(), data["test_id"].to_numpy()
        found = ladder(loads, mu, groups)
        found["constant_by_reading"] = rms(left_out(np.ones((len(mu), 1)), mu, np.arange(len(mu))))
        found["straight_by_reading"] = rms(left_out(straight(loads), mu, np.arange(len(mu))))
        slope = data.groupby("test_id")["mu"].agg(lambda x: x.iloc[-1] - x.iloc[0])
        found["blocks_where_mu_falls"] = f"{int((slope < 0).sum())} of {len(slope)}"
        reading = data["t"].to_numpy()[:, None]
        base = straight(loads)
        found["straight_and_reading_number"] = rms(
            left_out(np.column_stack([base, np.log1p(reading)]), mu, groups)
        )
        found["curvature_and_reading_number"] = rms(
            left_out(np.column_stack([curved(loads), np.log1p(reading)]), mu, groups)
        )
        warm = data.groupby("test_id")["T"].agg(lambda x: x.iloc[-1] - x.iloc[0])
        found["mean_change_in_block"] = float(slope.mean())
        cold = warm < 2
        found["blocks_that_stay_within_2_degC"] = int(cold.sum())
        found["mean_change_where_T_stays"] = float(slope[cold].mean()) if cold.any() else float("nan")
        found["T_explained_by_p_v_log"] = _explained(loads) if "v" in names else float("nan")
        q = loads["p"] / np.median(loads["p"])
        design = np.column_stack([straight(loads), 1 / q])
        found["coefficient_of_1/p"] = float(np.linalg.lstsq(design, mu, rcond=None)[0][-1])
        answer[system] = found
    data, tests, _ = make(folder)
    systems = data.merge(tests)["system"].to_numpy()
    mu = data["mu"].to_numpy()
    answer["all_system"] = variance_table(mu, systems)
    loads = {
        key: data[column].to_numpy()
        for key, column in (("v", "v_rel"), ("p", "sigma_n"), ("T", "T"))
        if key in names
    }
    blocks, _, _ = make(folder, blocks=True)
    groups = blocks["test_id"].to_numpy()
    level = pd.get_dummies(systems).to_numpy(float)
    base = straight(loads)
    pooled: dict[str, float] = {
        "constant": rms(left_out(base[:, :1], mu, groups)),
        "straight": rms(left_out(base, mu, groups)),
        "levels": rms(left_out(level, mu, groups)),
        "levels_and_straight": rms(left_out(np.column_stack([level, base[:, 1:]]), mu, groups)),
        "levels_and_curved": rms(left_out(np.column_stack([level, curved(loads)[:, 1:]]), mu, groups)),
        "curved": rms(left_out(curved(loads), mu, groups)),
        "straight_for_each_system": rms(
            left_out(np.column_stack([level * c[:, None] for c in base.T]), mu, groups)
        ),
        "curved_for_each_system": rms(
            left_out(np.column_stack([level * c[:, None] for c in curved(loads).T]), mu, groups)
        ),
    }
    both = np.column_stack([level, base[:, 1:]])
    for name, columns in forms(loads).items():
        designs = [np.column_stack([both, column]) for column in columns]
        if SIGN.get(name, 0):
            designs = [design for design in designs if np.linalg.lstsq(design, mu, rcond=None)[0][-1] > 0]
        errors = [rms(left_out(design, mu, groups)) for design in designs]
        pooled["levels_and_straight_and_" + name] = min(errors, default=float("nan"))
    answer["all_pooled"] = pooled
    return answer


def _explained(loads: Loads) -> float:
    design = np.column_stack(
        [np.ones(len(loads["p"])), np.log(loads["p"]), np.log(loads["v"]), loads["p"] * loads["v"]]
    )
    x = loads["T"]
    return float(1 - np.var(x - design @ np.linalg.lstsq(design, x, rcond=None)[0]) / np.var(x))


def miba_dynamic(folder: Path) -> dict[str, object]:
    """Each friction system and all of them, dynamic friction."""
    return _miba(folder, tables.miba_dynamic, ["v", "p", "T"])


def miba_static(folder: Path) -> dict[str, object]:
    """Each friction system and all of them, static friction."""
    return _miba(folder, tables.miba_static, ["p", "T"])
