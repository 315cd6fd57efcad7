"""From raw channels to the sliding phase: phases, zeros, speed, inertia, friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from friction_models.common import InputError
from friction_models.loads import FloatArray

from ..records.cells import is_given
from ..records.record import SctRecord
from .clock import Clock
from .filters import can_smooth, smooth, spike_rows, without
from .force_zero import ForceZero, Zeros, force_zeros
from .motion import Motion
from .phases import PhaseTimes

#: Samples around the start of sliding [s] that are never taken for spikes: friction breaks away there.
BREAK_AWAY = 0.02
#: Corner of the low-pass ``auto``, over the sampling rate.
AUTO_CORNER = 0.1


@dataclass(frozen=True, eq=False)
class TestSignals:
    """Processed channels of one test on a uniform time base."""

    #: Time [s] from the first sample, shape (n,).
    t: FloatArray
    #: Zero-corrected normal force and friction force (inertia taken out) [N], shape (n,).
    F_n: FloatArray
    friction: FloatArray
    #: Plate speed [mm/s] and sliding distance [mm], never decreasing, shape (n,).
    v: FloatArray
    sd: FloatArray
    #: First samples of upsetting and of sliding.
    load_start: int
    slide_start: int
    #: Plate temperature before sliding [degC].
    T_plate: float
    #: Unloaded readings of both cells, before the load and (where recorded) after the test: then they go
    #: linearly from one end to the other.
    zeros: Zeros
    #: Standard uncertainties that the samples share [N]: of the zeros, and what the metadata states about the
    #: cells (`F_n_std`, `F_r_std`), shape (n,).
    F_n_std: FloatArray
    friction_std: FloatArray
    #: Samples that were replaced (metadata `despike`).
    spikes: int = 0
    #: Corner of the low-pass of the forces [Hz]; 0 without.
    low_pass: float = 0.0
    #: Largest speed by the acceleration alone over that by the position alone; 0 without acceleration.
    acceleration_ratio: float = 0.0


def process(record: SctRecord, moving_mass: float = 0.0) -> TestSignals:
    """Find the phases of a test and compute what is measured only indirectly.

    Raises InputError: the test is never loaded, never slides, or slides before it is loaded; stated times
    contradict each other or the record; a plate temperature is neither recorded nor stated.

    - `record`: raw channels. Its metadata may state `t_upsetting`, `t_sliding`, `t_end` [s] (what is stated
      is not detected), `despike` (replace spikes), `low_pass` ([Hz], or ``auto``: a tenth of the sampling
      rate; for the forces), `F_n_std`, `F_r_std` [N], and `T_tool` [degC] where no plate temperature was
      recorded.
    - `moving_mass`: mass between force cell and contact [kg]; the cell also accelerates it: F_r - m a is
      friction.
    """
    where = record.where
    times = PhaseTimes.of(record)
    clock = Clock.of(record, times.sliding)
    repair = _despikes(record)
    removed = 0

    def column(name: str, protected: tuple[float, float] | None = None) -> FloatArray:
        nonlocal removed
        values: FloatArray = getattr(record, name)
        if repair:
            rows = spike_rows(values)
            if protected is not None:
                rows = rows[(record.t[rows] < protected[0]) | (record.t[rows] > protected[1])]
            removed += len(rows)
            values = without(values, rows)
        return clock.column(values)

    t, dt = clock.t, clock.dt
    F_n = column("F_n")
    s, v, a = (None if getattr(record, name) is None else column(name) for name in ("s", "v", "a"))
    motion = Motion(s, v, a, dt, where)
    load_start = _load_start(F_n) if times.upsetting is None else clock.row(times.upsetting)
    slide = motion.first() if times.sliding is None else clock.row(times.sliding)
    begin = clock.start + float(t[slide])
    F_r = column("F_r", (begin - BREAK_AWAY, begin + BREAK_AWAY))
    end = _end_of_sliding(motion.s, F_n, slide) if times.end is None else clock.row(times.end) + 1
    if end - slide < 2:
        raise InputError(f"{where}: sliding lasts {end - slide} samples; allowed: at least 2")
    zero = force_zeros(t, F_n, F_r, motion, load_start, end, stated=times.upsetting is not None)
    F_n, F_r = F_n - zero.F_n.values, F_r - zero.F_r.values
    speed, acceleration, sd, slide = motion.slide(slide, end, times.sliding is not None)
    t, F_n, F_r = t[:end], F_n[:end], F_r[:end]
    if load_start >= slide == 0:
        raise InputError(
            f"{where}: the record begins under load with the plate moving; allowed: a record from before sliding on"
        )
    if load_start >= slide:
        raise InputError(f"{where}: sliding begins at {begin:g} s, before the load; allowed: upsetting first")
    friction = F_r - moving_mass * 1e-3 * acceleration
    if np.median(friction[slide:]) < 0.0:
        # The cell counts pull as negative; friction opposes the sliding whatever the sign.
        friction = -friction
    corner = _corner(record, dt)
    if corner > 0.0:
        F_n, friction = smooth(F_n, dt, corner), smooth(friction, dt, corner)
    return TestSignals(
        t,
        F_n,
        friction,
        speed,
        sd,
        load_start,
        slide,
        _plate_temperature(record, begin),
        zero,
        _shared(record, "F_n", zero.F_n, end),
        _shared(record, "F_r", zero.F_r, end),
        removed,
        corner,
        motion.acceleration_ratio(slide, end),
    )


def _load_start(F_n: FloatArray) -> int:
    """Return the first sample under load; 0 where the record begins under load."""
    # A median of five: a spike is not a load.
    steady = median_filter(F_n, 5, mode="nearest")
    top = float(steady.max())
    level = float(np.median(steady[: max(5, len(steady) // 200)]))
    if level > float(steady.min()) + 0.2 * (top - float(steady.min())):
        return 0
    return int(np.argmax(steady > level + 0.02 * (top - level)))


def _end_of_sliding(s: FloatArray, F_n: FloatArray, slide: int) -> int:
    """Return the number of samples up to the farthest point, or up to where the load is taken off before."""
    steady = median_filter(s, 5, mode="nearest")
    far = int(np.argmax(np.abs(steady - steady[:slide].mean()))) + 1
    unloaded = F_n[slide:far] < 0.3 * float(np.median(F_n[slide:far]))
    return slide + int(np.argmax(unloaded)) if unloaded.any() and not unloaded[0] else far


def _plate_temperature(record: SctRecord, begin: float) -> float:
    """Return the plate temperature before sliding, or the stated one where none was recorded [degC]."""
    if record.T_plate is not None:
        rows = max(5, int(np.searchsorted(record.t, begin)))
        return float(np.median(record.T_plate[:rows]))
    if not is_given(record.metadata.get("T_tool")):
        raise InputError(
            f"{record.where}: no plate temperature 'T_plate' and no 'T_tool' in the test table; "
            "allowed: one of both at least (metadata: {T_tool: 20} in the channel map holds for all tests)"
        )
    return record.number("T_tool")


def _shared(record: SctRecord, name: str, zero: ForceZero, end: int) -> FloatArray:
    stated = record.number(f"{name}_std", 0.0)
    if stated < 0.0:
        raise InputError(f"{record.where}: metadata '{name}_std' is {stated:g}; allowed: 0 N and more")
    return np.hypot(zero.std[:end], stated)


def _corner(record: SctRecord, dt: float) -> float:
    """Return the corner of the low-pass of the forces [Hz]; 0 where none is stated or the rate is too low."""
    stated = record.metadata.get("low_pass")
    if not is_given(stated):
        return 0.0
    corner = AUTO_CORNER / dt if stated == "auto" else record.number("low_pass")
    if corner <= 0.0:
        raise InputError(f"{record.where}: metadata 'low_pass' is {corner:g}; allowed: above 0 Hz, or auto")
    return corner if can_smooth(len(record), dt, corner) else 0.0


def _despikes(record: SctRecord) -> bool:
    value = record.metadata.get("despike")
    if not is_given(value):
        return False
    text = str(value).strip().lower()
    if text not in {"true", "false", "1", "0", "1.0", "0.0", "yes", "no"}:
        raise InputError(f"{record.where}: metadata 'despike' is {value!r}; allowed: true or false")
    return text in {"true", "1", "1.0", "yes"}
