"""From raw channels to the sliding phase: zeros, phases, speed, inertia, friction at equal distances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfiltfilt

from friction_models.loads import FloatArray, InputError

from .record import SctRecord

#: Corner between the differentiated position (below) and the integrated acceleration (above) [Hz].
CORNER_HZ = 10.0


@dataclass(frozen=True, eq=False)
class TestSignals:
    """Processed channels of one test on a uniform time base.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Time [s] from the first sample.
    F_n, friction : ndarray, shape (n,)
        Zero-corrected normal force and friction force (inertia taken out) [N].
    v, sd : ndarray, shape (n,)
        Plate speed [mm/s] and sliding distance [mm], never decreasing.
    load_start, slide_start : int
        First samples of upsetting and of sliding.
    T_plate : float
        Plate temperature before sliding [degC].
    force_zero : tuple of float
        Zeros taken off F_n and F_r [N].
    """

    t: FloatArray
    F_n: FloatArray
    friction: FloatArray
    v: FloatArray
    sd: FloatArray
    load_start: int
    slide_start: int
    T_plate: float
    force_zero: tuple[float, float]

    @property
    def slide_time(self) -> FloatArray:
        """Time since sliding began [s], of the samples from `slide_start` on."""
        return np.asarray(self.t[self.slide_start :] - self.t[self.slide_start])


@dataclass(frozen=True, eq=False)
class SlidingSeries:
    """Friction at equal distances of sliding; all arrays of shape (n,)."""

    t: FloatArray
    sd: FloatArray
    v_rel: FloatArray
    F_n: FloatArray
    friction: FloatArray

    @property
    def mu(self) -> FloatArray:
        """Coefficient of friction, never negative."""
        return np.maximum(self.friction / self.F_n, 0.0)


def process(record: SctRecord, moving_mass: float = 0.0) -> TestSignals:
    """Find the phases of a test and compute what is measured only indirectly.

    Parameters
    ----------
    record : SctRecord
        Raw channels.
    moving_mass : float
        Mass between force cell and contact [kg]; the cell also accelerates it: F_r - m a is friction.

    Returns
    -------
    TestSignals

    Raises
    ------
    InputError
        The test is never loaded, never slides, or slides before it is loaded.
    """
    where = record.source or f"test {record.test_id}"
    usual = float(np.median(np.diff(record.t)))
    count = round(float(np.ptp(record.t)) / usual) + 1
    if count > 20 * len(record):
        raise InputError(
            f"{where}: column 't' spans {float(np.ptp(record.t)):g} s in {len(record)} rows at {usual:g} s; "
            "allowed: gaps of less than 20 times the record"
        )
    t: FloatArray = (np.arange(count) * usual).astype(np.float64)
    F_n, F_r, s, a = (
        np.interp(t, record.t - record.t[0], column).astype(np.float64)
        for column in (record.F_n, record.F_r, record.s, record.a)
    )
    zero_n, zero_r, load_start = _force_zero(F_n, F_r)
    F_n, F_r = F_n - zero_n, F_r - zero_r
    slide = _first_motion(s, where)
    end = _end_of_sliding(s, F_n, slide)
    t, F_n, F_r, s, a = (column[:end] for column in (t, F_n, F_r, s, a))
    rest = slice(0, max(slide - 1, 5))
    a = a - float(np.median(a[rest]))
    v = _speed(s, a, rest, usual)
    direction = 1.0 if v[slide:].mean() >= 0.0 else -1.0
    v = direction * v
    noise = 1.4826 * float(np.median(np.abs(v[rest] - np.median(v[rest]))))
    threshold = max(5.0 * noise, 0.003 * float(v.max()))
    while slide > 1 and v[slide - 1] > threshold:
        slide -= 1
    if load_start >= slide:
        raise InputError(
            f"{where}: sliding begins at {t[slide]:g} s, before the load; allowed: upsetting first"
        )
    friction = F_r - moving_mass * 1e-3 * a
    if np.median(friction[slide:]) < 0.0:
        # The cell counts pull as negative; friction opposes the sliding whatever the sign.
        friction = -friction
    v = np.maximum(v, 0.0)
    v[:slide] = 0.0
    sd = integral(v, usual)
    measured = direction * (s - float(np.median(s[rest])))
    lag = float(np.median((measured - sd)[-max(5, (end - slide) // 10) :]))
    if sd[-1] > 0:
        sd = sd * max(0.0, 1.0 + lag / sd[-1])
    plate = float(np.median(record.T_plate[: max(5, round(slide * len(record) / count))]))
    return TestSignals(t, F_n, friction, v, sd, load_start, slide, plate, (zero_n, zero_r))


def _end_of_sliding(s: FloatArray, F_n: FloatArray, slide: int) -> int:
    """Return the number of samples up to the farthest point, or up to where the load is taken off before."""
    far = int(np.argmax(np.abs(s - s[:slide].mean()))) + 1
    unloaded = F_n[slide:far] < 0.3 * float(np.median(F_n[slide:far]))
    return slide + int(np.argmax(unloaded)) if unloaded.any() and not unloaded[0] else far


def resample(signals: TestSignals, spacing: float = 0.1) -> SlidingSeries:
    """Average forces and speed over equal distances, one point every `spacing` mm.

    A point at distance x stands for x +- spacing/2, whether that holds one sample in fifty or a part
    of the way between two samples.

    Raises
    ------
    InputError
        Less than ten points of sliding.
    """
    i = signals.slide_start
    t, sd = signals.slide_time, signals.sd[i:]
    last = float(sd[-1])
    count = int(np.floor(last / spacing - 0.5 + 1e-9))
    if count < 10:
        raise InputError(f"the test slides {last:g} mm; allowed: at least {10.5 * spacing:g} mm")
    grid: FloatArray = (spacing * np.arange(1, count + 1)).astype(np.float64)
    moving = np.concatenate([[True], np.diff(sd) > 1e-9])
    x, time = sd[moving], t[moving]
    edges = np.concatenate([[0.5 * spacing], grid + 0.5 * spacing])

    def mean(values: FloatArray) -> FloatArray:
        sums = integral(values[moving], x=x)
        # The integral bends inside a sample interval only as the trapezoid does.
        at = np.clip(np.searchsorted(x, edges) - 1, 0, len(x) - 2)
        w = (edges - x[at]) / (x[at + 1] - x[at])
        left, right = values[moving][at], values[moving][at + 1]
        inside = (edges - x[at]) * (left + 0.5 * w * (right - left))
        return np.asarray(np.diff(sums[at] + inside) / spacing)

    return SlidingSeries(
        np.interp(grid, x, time),
        grid,
        mean(signals.v[i:]),
        mean(signals.F_n[i:]),
        mean(signals.friction[i:]),
    )


def smooth(values: FloatArray, dt: float, corner: float = CORNER_HZ) -> FloatArray:
    """Low-pass without phase shift."""
    if 0.5 / dt <= 1.2 * corner or len(values) < 16:
        return values
    sos = butter(2, corner, fs=1.0 / dt, output="sos")
    return np.asarray(sosfiltfilt(sos, values, padlen=min(len(values) - 1, int(0.5 / (dt * corner)) * 6)))


def _speed(s: FloatArray, a: FloatArray, rest: slice, dt: float) -> FloatArray:
    """Low frequencies from the position, high ones from the acceleration where the plate does accelerate."""
    width = max(1, round(0.01 / dt))
    mean = np.convolve(a, np.full(width, 1.0 / width), mode="same")
    noise = 1.4826 * float(np.median(np.abs(mean[rest])))
    moved = np.convolve((np.abs(mean) > 4.0 * noise).astype(float), np.ones(2 * width + 1), mode="same") > 0.5
    # At constant speed the integrated noise of the acceleration would be all there is above the corner.
    fast = integral(np.where(moved, a, 0.0), dt)
    slow = s - integral(fast, dt)
    # The record ends while the plate moves: go on along a line through its last 60 ms, not from one sample.
    tail = min(len(s), max(8, round(0.06 / dt)))
    count = round(0.4 / dt)
    slope, level = np.polyfit(np.arange(tail) - (tail - 1.0), slow[-tail:], 1)
    before = np.full(count, float(np.median(slow[:tail])))
    extended = np.concatenate([before, slow, level + slope * np.arange(1, count + 1)])
    return fast + np.gradient(smooth(extended, dt), dt)[count:-count]


def integral(values: FloatArray, dx: float | None = None, x: FloatArray | None = None) -> FloatArray:
    """Return the cumulative trapezoidal integral, 0 at the first point."""
    steps = np.diff(x) if x is not None else np.full(len(values) - 1, 1.0 if dx is None else dx)
    return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * steps)])


def _force_zero(F_n: FloatArray, F_r: FloatArray) -> tuple[float, float, int]:
    """Return the zeros of both cells from the samples before the load, and where the load begins."""
    limit = float(F_n.min()) + 0.02 * float(np.ptp(F_n))
    loaded = F_n > limit
    start = int(np.argmax(loaded))
    # A slow start is loaded before the limit: stay well away from it.
    free = slice(0, max(0, start - 10))
    if start - 10 < 20:
        return 0.0, 0.0, start
    return float(np.median(F_n[free])), float(np.median(F_r[free])), start


def _first_motion(s: FloatArray, where: str) -> int:
    """Return a sample at which the plate has begun to move."""
    travel = float(np.ptp(s))
    if travel < 0.5:
        raise InputError(f"{where}: column 's' moves by {travel:g} mm; allowed: at least 0.5 mm of sliding")
    origin = float(np.median(s[: max(5, len(s) // 50)]))
    away = np.abs(s - origin) > max(0.02, 0.001 * travel)
    if not away.any() or away[0]:
        raise InputError(
            f"{where}: the plate moves from the first sample on; allowed: upsetting at rest first"
        )
    return int(np.argmax(away))
