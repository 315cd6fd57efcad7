"""Quality of a record: sampling, gaps, clipping, zeros and their drift, spikes, phases, friction, repeats."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from friction_models.common import InputError
from friction_models.common.wording import counted
from friction_models.loads import FloatArray

from ..records.cells import is_given
from ..records.channels import CHANNEL_NAMES
from ..records.record import SctRecord, usual_step
from ..signals.filters import spike_rows
from ..signals.force_zero import Zeros
from ..signals.phases import TIMES, PhaseTimes
from ..signals.sliding_phase import BREAK_AWAY, TestSignals, process
from ..signals.sliding_series import resample

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
#: Stated and detected beginnings of a phase that differ by more are reported [s].
PHASE_TOLERANCE = 0.05
#: A zero that moves by more of the largest force is reported.
ZERO_SHARE = 0.005
#: Rows that are looked at at once.
_PIECE = 500_000
#: What is lost with a channel.
_LOST = {
    "s": "distance and speed come from v",
    "a": "inertia and fast changes of the speed come from the derivative of the motion",
    "T_plate": "the plate is taken to be at T_tool",
}
#: Largest ratio between the measured speed or force and the one that was set.
SET_RATIO = 5.0
#: Largest ratio between the speed that the acceleration adds up to and that of the plate: a plate that
#: sticks first overshoots when it is released.
ACCELERATED = 30.0
#: A plate whose temperature is so far from the tool's is reported [K].
PLATE_FROM_TOOL = 100.0
#: A test that slides less than this share of what was set is reported.
SLIDING_SHARE = 0.8
#: Pressure of such tests [MPa]; another one is reported.
SIGMA_USUAL = (20.0, 5000.0)


def quality_row(record: SctRecord, moving_mass: float = 0.0) -> dict[str, object]:
    """Return the figures of one test as a row of the quality table (units in the names).

    Raises InputError: the test is never loaded or never slides, or forces or speed say that columns are
    swapped or a unit is wrong. `moving_mass` [kg] is that between force cell and contact.
    """
    _check_columns(record)
    signals = process(record, moving_mass)
    speed = _check_sliding(record, signals)
    try:
        series = resample(signals)
    except InputError as error:
        raise InputError(f"{record.where}: {error}") from None
    usual = usual_step(record.t)
    gaps, largest = _gaps(record.t, usual)
    begin = float(record.t[0])
    # Friction breaks away where sliding begins: what stands out there is no spike.
    outliers, sliding_begins = record.t[spike_rows(record.F_r)], begin + float(signals.t[signals.slide_start])
    times = PhaseTimes.of(record)
    stated = [name for name in TIMES if is_given(record.metadata.get(name))]
    found = _detected(record, moving_mass) if stated else signals
    sliding = slice(signals.slide_start, None)
    F_n = float(np.median(signals.F_n[sliding]))
    diameter = record.number("bore", 0.0) or record.number("specimen_diameter", 15.0)
    return {
        "test_id": record.test_id,
        "rows": len(record),
        "duration_s": round(float(np.ptp(record.t)), 6),
        "sampling_rate_Hz": round(1.0 / usual, 3),
        "gaps": gaps,
        "largest_gap_s": round(largest, 6),
        "not_recorded": " ".join(name for name in CHANNEL_NAMES if name not in (*record.channels, "v")),
        "F_n_max_N": round(float(record.F_n.max()), 1),
        "F_r_max_N": round(max(float(record.F_r.max()), -float(record.F_r.min())), 1),
        **_zeros(signals.zeros),
        "F_n_clipped": clipped(record.F_n),
        "F_r_clipped": clipped(record.F_r),
        "F_n_spikes": len(spike_rows(record.F_n)),
        "F_r_spikes": int((np.abs(outliers - sliding_begins) > BREAK_AWAY).sum()),
        "spikes_removed": signals.spikes,
        "low_pass_Hz": round(signals.low_pass, 3),
        "phases": f"stated: {' '.join(stated)}" if stated else "detected",
        "upsetting_s": round(begin + float(signals.t[signals.load_start]), 4),
        "sliding_s": round(sliding_begins, 4),
        "end_s": round(times.end if times.end is not None else begin + float(signals.t[-1]), 4),
        "upsetting_detected_s": _time(found, "load_start", begin),
        "sliding_detected_s": _time(found, "slide_start", begin),
        "sliding_mm": round(float(signals.sd[-1]), 4),
        "sliding_set_mm": _number(record, "sd_set") or None,
        "speed_mm_s": round(speed, 3),
        "T_plate_degC": round(signals.T_plate, 2),
        "T_tool_degC": record.number("T_tool") if is_given(record.metadata.get("T_tool")) else None,
        "F_n_sliding_N": round(F_n, 1),
        "sigma_guess_MPa": round(F_n / (0.25 * np.pi * diameter**2), 1),
        "mu_mean": round(float(series.mu.mean()), 5),
        "mu_std": round(float(np.sqrt(np.mean(series.mu_std**2))), 6),
    }


def _gaps(t: FloatArray, usual: float) -> tuple[int, float]:
    """Return how many steps are too long for the usual one and for a neighbour, and the longest [s].

    Two files of a test may have two rates: the slower one has no gaps for that.
    """
    count, largest = 0, 0.0
    for start in range(0, len(t) - 1, _PIECE):
        step = np.diff(t[start : start + _PIECE + 1])
        padded = np.pad(step, 1, mode="edge")
        beside = np.minimum(padded[:-2], padded[2:])
        count += int((step > 1.5 * np.maximum(usual, beside)).sum())
        largest = max(largest, float(step.max()))
    return count, largest


def _detected(record: SctRecord, moving_mass: float) -> TestSignals | None:
    """Return what the signals alone say, for a test whose phases are stated; None where they say nothing."""
    silent = {name: value for name, value in record.metadata.items() if name not in TIMES}
    try:
        return process(replace(record, metadata=silent), moving_mass)
    except InputError:
        return None


def _time(signals: TestSignals | None, name: str, begin: float) -> float | None:
    return None if signals is None else round(begin + float(signals.t[getattr(signals, name)]), 4)


def _zeros(zeros: Zeros) -> dict[str, float | None]:
    row: dict[str, float | None] = {}
    for name, zero in (("F_n", zeros.F_n), ("F_r", zeros.F_r)):
        row[f"{name}_zero_N"] = round(zero.before, 1) if len(zeros.rows_before) else None
        row[f"{name}_zero_end_N"] = None if zero.after is None else round(zero.after, 1)
        known = len(zeros.rows_before) or zero.after is not None
        row[f"{name}_zero_std_N"] = round(float(zero.std.max()), 2) if known else None
        row[f"{name}_drift_N_per_s"] = None if zero.drift is None else round(zero.drift, 3)
    return row


def repeats(tests: pd.DataFrame) -> list[int | None]:
    """Return how many tests were run with the settings of each test; None where no settings are known."""
    names = [name for name in SETTINGS if name in tests.columns]
    if not names:
        return [None] * len(tests)
    keys = tests[names].astype(object).where(tests[names].notna(), "").astype(str).agg("\0".join, axis=1)
    counts = keys.map(keys.value_counts())
    return [int(count) for count in counts]


def clipped(values: FloatArray) -> int:
    """Return how many samples sit exactly at the largest magnitude, when at least three in a row do."""
    limit = max(float(values.max()), -float(values.min()))
    at_limit = (values >= limit) | (values <= -limit)
    runs = at_limit[2:] & at_limit[1:-1] & at_limit[:-2]
    return int(at_limit.sum()) if runs.any() else 0


def warnings(row: Mapping[str, Any]) -> list[str]:
    """Return what a row of the quality table says against a test that was taken over all the same."""
    said = []
    if row["gaps"]:
        said.append(f"{counted(row['gaps'], 'gap')}, the largest {row['largest_gap_s']:g} s")
    for name in str(row["not_recorded"] or "").split():
        said.append(f"{name} not recorded: {_LOST[name]}")
    for name in ("F_n", "F_r"):
        if row[f"{name}_clipped"]:
            said.append(f"{name} clipped in {row[f'{name}_clipped']} samples")
        if row[f"{name}_spikes"] and row["spikes_removed"]:
            said.append(f"{counted(row[f'{name}_spikes'], 'spike')} in {name}, replaced")
        before, after = row[f"{name}_zero_N"], row[f"{name}_zero_end_N"]
        if before is None and after is None:
            said.append(f"no unloaded samples: the zero of {name} is unknown, mu_std is without it")
        elif before is None and name == "F_n":
            said.append(
                "the record begins under load, or only just before, and ends without: the zeros of both forces are those "
                "after the test, what was before the record is not known"
            )
        elif before is not None and after is not None:
            moved = after - before
            if abs(moved) > max(ZERO_SHARE * row[f"{name}_max_N"], 4.0 * row[f"{name}_zero_std_N"]):
                said.append(f"the zero of {name} moves by {moved:g} N, corrected linearly")
    for phase in ("upsetting", "sliding"):
        used, found = row[f"{phase}_s"], row[f"{phase}_detected_s"]
        if found is not None and abs(used - found) > PHASE_TOLERANCE:
            said.append(f"{phase} is said to begin at {used:g} s, the signals say {found:g} s")
    said += doubts(row)
    if row["notes"]:
        said.append(str(row["notes"]))
    return said


def doubts(row: Mapping[str, Any]) -> list[str]:
    """Return what a row of the quality table says against the loads that come of a test."""
    said = []
    for name in ("F_n", "F_r"):
        if row[f"{name}_spikes"] and not row["spikes_removed"]:
            said.append(
                f"{counted(row[f'{name}_spikes'], 'spike')} in {name}, left in (despike: true replaces them)"
            )
    wanted = row["sliding_set_mm"]
    if wanted and row["sliding_mm"] < SLIDING_SHARE * wanted:
        said.append(
            f"only {row['sliding_mm']:.3g} mm of sliding under load were found, the test table says sd_set {wanted:g} mm "
            "(does the force fall away, or a spike end it?)"
        )
    if row["T_tool_degC"] is not None and abs(row["T_plate_degC"] - row["T_tool_degC"]) > PLATE_FROM_TOOL:
        said.append(
            f"the plate is at {row['T_plate_degC']:g} degC, T_tool at {row['T_tool_degC']:g} degC (is the unit of "
            "T_plate wrong?)"
        )
    if not SIGMA_USUAL[0] <= row["sigma_guess_MPa"] <= SIGMA_USUAL[1]:
        said.append(
            f"F_n over the bore (or the specimen) is {row['sigma_guess_MPa']:g} MPa; usual are "
            f"{SIGMA_USUAL[0]:g} to {SIGMA_USUAL[1]:g} (is the unit of F_n and F_r wrong?)"
        )
    return said


def _check_columns(record: SctRecord) -> None:
    """Refuse columns that cannot be what they are called: wrong sign, swapped, wrong unit."""
    where = record.where
    some = slice(None, None, max(1, len(record) // _PIECE))
    F_n, F_r = record.F_n[some], record.F_r[some]
    before = max(5, len(F_n) // 100)
    if not _always_loaded(F_n):
        unloaded = F_n[-before:] if begins_loaded(record.F_n) else F_n[:before]
        F_n = F_n - float(np.median(unloaded))
        F_r = F_r - float(np.median(F_r[:before]))
    F_r = np.abs(F_r)
    normal = float(np.percentile(F_n, 99.0))
    if -float(np.percentile(F_n, 1.0)) > max(normal, 0.0):
        raise InputError(
            f"{where}: column 'F_n' goes down to {float(record.F_n.min()):g} N under load; "
            "allowed: compression as positive numbers (set sign: -1 for it in the channel map)"
        )
    friction = float(np.percentile(F_r, 99.0))
    if friction > MU_LIMITS[1] * normal:
        raise InputError(
            f"{where}: 'F_r' reaches {friction:g} N where 'F_n' reaches {normal:g} N; allowed: less friction "
            "than normal force (are the columns swapped, or is a unit wrong?)"
        )
    if record.s is None:
        return
    first = np.arange(0, len(record) - 1, max(1, len(record) // _PIECE))
    travel, jitter = float(np.ptp(record.s)), float(np.median(np.abs(record.s[first + 1] - record.s[first])))
    if travel < 20.0 * jitter:
        raise InputError(
            f"{where}: column 's' spans {travel:.3g} mm and changes by {jitter:.3g} mm a sample; allowed: a "
            "position that moves (are the columns swapped?)"
        )


def _always_loaded(F_n: FloatArray) -> bool:
    """Whether a record of the normal force begins and ends under load: nothing in it tells a zero."""
    low, high = np.percentile(F_n, [1.0, 99.0])
    return bool(low > 0.5 * high > 0.0)


def begins_loaded(F_n: FloatArray) -> bool:
    """Whether a record of the normal force begins under load and ends without."""
    ends = max(5, len(F_n) // 100)
    span = float(np.ptp(F_n))
    first, last = float(np.median(F_n[:ends])), float(np.median(F_n[-ends:]))
    # The cell may show some load without one, but less than half of what it shows in the test.
    return abs(first) > 0.5 * span and abs(last) < 0.2 * span


def _check_sliding(record: SctRecord, signals: TestSignals) -> float:
    """Return the speed of sliding [mm/s]; refuse friction or a speed that no such test has."""
    where = record.where
    i = signals.slide_start
    # Typical by distance: a plate that breaks away jumps, much faster than it then slides, but not far.
    v, sd = signals.v[i:], signals.sd[i:]
    if not sd[-1] > 0.0:
        travel = "" if record.s is None else f", while 's' spans {float(np.ptp(record.s)):.3g} mm"
        raise InputError(
            f"{where}: no sliding under load was found in {float(np.ptp(record.t)):.3g} s{travel}; allowed: a plate that moves after "
            "the force is there (are the units of 't' and 's' right, and is it sampled often enough?)"
        )
    moving = v > 0.5 * float(np.median(np.interp(np.linspace(0.05, 0.95, 91) * sd[-1], sd, v)))
    mu = float(np.median(signals.friction[i:][moving] / np.maximum(signals.F_n[i:][moving], 1.0)))
    if not MU_LIMITS[0] <= mu <= MU_LIMITS[1]:
        raise InputError(
            f"{where}: friction over normal force is {mu:.2g} while sliding; allowed: {MU_LIMITS[0]:g} to "
            f"{MU_LIMITS[1]:g} (are columns swapped, or is a unit of 'F_n' or 'F_r' wrong?)"
        )
    if signals.acceleration_ratio > ACCELERATED:
        raise InputError(
            f"{record.where}: the acceleration adds up to {signals.acceleration_ratio:.3g} times the speed of the "
            f"plate; allowed: up to {ACCELERATED:g} times (is a unit of 'a' or 't' wrong?)"
        )
    speed = float(np.median(v[moving]))
    wanted = _levels(record)
    nearest = min(wanted, key=lambda level: abs(np.log(level / max(speed, 1e-9)))) if wanted else 0.0
    _check_set(record, "v_set", speed, nearest, "the plate slides at", "mm/s", "'s', 'v', 'a' or 't'")
    # Pressure may change while sliding: the set force is the highest.
    highest = float(signals.F_n.max())
    _check_set(record, "F_set", highest, _number(record, "F_set"), "the normal force reaches", "N", "'F_n'")
    return speed


def _number(record: SctRecord, name: str) -> float:
    try:
        return record.number(name, 0.0)
    except InputError:
        # A remark instead of a number says nothing about units.
        return 0.0


def _levels(record: SctRecord) -> list[float]:
    """Return the speeds that were set [mm/s]: those of `v_levels` (``5;50;5``) where a test has steps."""
    try:
        levels = [float(text) for text in str(record.metadata.get("v_levels")).split(";")]
    except ValueError:
        levels = []
    return [v for v in levels or [_number(record, "v_set")] if np.isfinite(v) and v > 0.0]


def _check_set(
    record: SctRecord, name: str, value: float, wanted: float, what: str, unit: str, columns: str
) -> None:
    if wanted > 0.0 and not 1.0 / SET_RATIO <= value / wanted <= SET_RATIO:
        raise InputError(
            f"{record.where}: {what} {value:.3g} {unit}, the test table says {name} {wanted:g} {unit}; "
            f"allowed: within a factor of {SET_RATIO:g} (is a unit of {columns} wrong?)"
        )
