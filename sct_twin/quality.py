"""How good a record is: sampling, gaps, clipping, zeros and their drift, spikes, phases, repeats."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from friction_models.loads import FloatArray, InputError

from .channels import CHANNEL_NAMES
from .record import SctRecord
from .signals import TestSignals, process

#: Metadata that says how a test was run: tests that agree in all of them are repeats.
SETTINGS = (
    "v_set",
    "sigma_set",
    "psi_set",
    "sd_set",
    "F_set",
    "T_tool",
    "T_specimen",
    "bore",
    "tip",
    "lubricant",
    "protocol",
    "tool_id",
    "Ra",
)
#: Friction outside of these limits is a unit or a column that was mistaken, not a lubricant.
MU_LIMITS = (0.001, 1.0)
#: Sampling rate at which phases, speed and friction are found [Hz].
ENOUGH_HZ = 2000.0
#: Largest ratio between the measured speed and the one that was set.
SPEED_RATIO = 5.0


def quality_row(record: SctRecord, moving_mass: float = 0.0) -> dict[str, Any]:
    """Return the figures of one test as a row of the quality table (units in the names).

    Parameters
    ----------
    record : SctRecord
        The test.
    moving_mass : float
        Mass between force cell and contact [kg].

    Raises
    ------
    InputError
        The test is never loaded or never slides, or forces or speed say that columns are swapped or a
        unit is wrong.
    """
    _check_columns(record)
    signals = process(thinned(record), moving_mass)
    speed = _check_sliding(record, signals)
    step = np.diff(record.t)
    usual = float(np.median(step))
    before, after = unloaded(record.F_n)
    zeros: dict[str, float | None] = {}
    for name in ("F_n", "F_r"):
        values = getattr(record, name)
        zeros[f"{name}_zero_N"] = round(float(np.median(values[before])), 1) if len(before) >= 5 else None
        zeros[f"{name}_drift_N_per_s"] = drift(record.t, values, np.concatenate([before, after]))
    begin = float(record.t[0])
    return {
        "test_id": record.test_id,
        "rows": len(record),
        "duration_s": round(float(np.ptp(record.t)), 6),
        "sampling_rate_Hz": round(1.0 / usual, 3),
        "gaps": int((step > 1.5 * usual).sum()),
        "largest_gap_s": round(float(step.max()), 6),
        "F_n_max_N": round(float(record.F_n.max()), 1),
        "F_r_max_N": round(float(np.abs(record.F_r).max()), 1),
        **zeros,
        "F_n_clipped": clipped(record.F_n),
        "F_r_clipped": clipped(record.F_r),
        "F_n_spikes": spikes(record.F_n),
        "F_r_spikes": spikes(record.F_r),
        "upsetting_s": round(begin + float(signals.t[signals.load_start]), 4),
        "sliding_s": round(begin + float(signals.t[signals.slide_start]), 4),
        "sliding_stated_s": record.metadata.get("t_sliding"),
        "sliding_mm": round(float(np.ptp(record.s)), 4),
        "speed_mm_s": round(speed, 3),
        "T_plate_mean_degC": round(float(record.T_plate.mean()), 2),
    }


def thinned(record: SctRecord) -> SctRecord:
    """Return the record averaged to about 2 kHz where it is much faster: phases need no more than that."""
    stride = min(int(record.sampling_rate / ENOUGH_HZ), len(record) // 2000)
    if stride < 2:
        return record
    count = len(record) // stride
    means = {
        name: getattr(record, name)[: count * stride].reshape(count, stride).mean(axis=1)
        for name in CHANNEL_NAMES
    }
    return replace(record, **means)


def repeats(tests: pd.DataFrame) -> list[int | None]:
    """Return how many tests were run with the settings of each test; None where no settings are known."""
    names = [name for name in SETTINGS if name in tests.columns]
    if not names:
        return [None] * len(tests)
    keys = tests[names].astype(object).where(tests[names].notna(), "").astype(str).agg("\0".join, axis=1)
    counts = keys.map(keys.value_counts())
    return [int(count) for count in counts]


def unloaded(F_n: FloatArray) -> tuple[np.ndarray, np.ndarray]:
    """Return the samples before the load and those after it, away from its beginning and end."""
    free = F_n < float(F_n.min()) + 0.02 * float(np.ptp(F_n))
    first, last = int(np.argmin(free)), len(free) - int(np.argmin(free[::-1]))
    margin = max(10, first // 10)
    return np.arange(max(0, first - margin)), np.arange(min(len(free), last + 10), len(free))


def drift(t: FloatArray, values: FloatArray, rows: np.ndarray) -> float | None:
    """Return the slope of the unloaded signal [1/s], from a line through its samples; None if too few."""
    if len(rows) < 20:
        return None
    time = t[rows] - t[rows].mean()
    return round(float((time @ (values[rows] - values[rows].mean())) / (time @ time)), 3)


def clipped(values: FloatArray) -> int:
    """Return how many samples sit exactly at the largest magnitude, when at least three in a row do."""
    at_limit = np.abs(values) >= np.abs(values).max()
    runs = at_limit[2:] & at_limit[1:-1] & at_limit[:-2]
    return int(at_limit.sum()) if runs.any() else 0


def spikes(values: FloatArray) -> int:
    """Return how many single samples stand out of both neighbours by ten times the usual noise."""
    bump = values[1:-1] - 0.5 * (values[2:] + values[:-2])
    noise = 1.4826 * float(np.median(np.abs(bump - np.median(bump))))
    return int((np.abs(bump) > 10.0 * noise).sum()) if noise > 0 else 0


def warnings(row: Mapping[str, Any]) -> list[str]:
    """Return what a row of the quality table says against a test that was taken over all the same."""
    said = []
    if row["gaps"]:
        said.append(f"{row['gaps']} gaps, the largest {row['largest_gap_s']:g} s")
    for name in ("F_n", "F_r"):
        if row[f"{name}_clipped"]:
            said.append(f"{name} clipped in {row[f'{name}_clipped']} samples")
        if row[f"{name}_spikes"]:
            said.append(f"{row[f'{name}_spikes']} spikes in {name}")
        if row[f"{name}_zero_N"] is None:
            said.append(f"no unloaded samples: the zero of {name} is unknown")
    stated = row["sliding_stated_s"]
    if stated is not None and abs(stated - row["sliding_s"]) > 0.05:
        said.append(f"sliding is said to begin at {stated:g} s, the signals say {row['sliding_s']:g} s")
    return said


def _check_columns(record: SctRecord) -> None:
    """Refuse columns that cannot be what they are called: wrong sign, swapped, wrong unit."""
    where = record.source or f"test {record.test_id}"
    before = max(5, len(record) // 100)
    F_n = record.F_n - float(np.median(record.F_n[:before]))
    F_r = np.abs(record.F_r - float(np.median(record.F_r[:before])))
    normal = float(np.percentile(F_n, 99.0))
    if -float(np.percentile(F_n, 1.0)) > max(normal, 0.0):
        raise InputError(
            f"{where}: column 'F_n' goes down to {float(record.F_n.min()):g} N under load; "
            "allowed: compression as positive numbers (set sign: -1)"
        )
    friction = float(np.percentile(F_r, 99.0))
    if friction > MU_LIMITS[1] * normal:
        raise InputError(
            f"{where}: 'F_r' reaches {friction:g} N where 'F_n' reaches {normal:g} N; allowed: less friction "
            "than normal force (are the columns swapped, or is a unit wrong?)"
        )
    travel, jitter = float(np.ptp(record.s)), float(np.median(np.abs(np.diff(record.s))))
    if travel < 20.0 * jitter:
        raise InputError(
            f"{where}: column 's' spans {travel:.3g} mm and changes by {jitter:.3g} mm a sample; allowed: a "
            "position that moves (are the columns swapped?)"
        )


def _check_sliding(record: SctRecord, signals: TestSignals) -> float:
    """Return the speed of sliding [mm/s]; refuse friction or a speed that no such test has."""
    where = record.source or f"test {record.test_id}"
    i = signals.slide_start
    moving = signals.v[i:] > 0.5 * float(signals.v[i:].max())
    mu = float(np.median(signals.friction[i:][moving] / np.maximum(signals.F_n[i:][moving], 1.0)))
    if not MU_LIMITS[0] <= mu <= MU_LIMITS[1]:
        raise InputError(
            f"{where}: friction over normal force is {mu:.2g} while sliding; allowed: {MU_LIMITS[0]:g} to "
            f"{MU_LIMITS[1]:g} (are columns swapped, or is a unit of 'F_n' or 'F_r' wrong?)"
        )
    speed = float(np.median(signals.v[i:][moving]))
    try:
        wanted = record.number("v_set", 0.0)
    except InputError:
        wanted = 0.0
    if wanted > 0.0 and not 1.0 / SPEED_RATIO <= speed / wanted <= SPEED_RATIO:
        raise InputError(
            f"{where}: the plate slides at {speed:.3g} mm/s, the test table says v_set {wanted:g} mm/s; "
            f"allowed: within a factor of {SPEED_RATIO:g} (is a unit of 's', 'a' or 't' wrong?)"
        )
    return speed
