"""The uniform time base on which a record is processed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from friction_models.common import InputError
from friction_models.loads import FloatArray

from ..records.record import SctRecord, usual_step

#: Sampling rate beyond which samples are averaged before anything is computed [Hz]: at 500 mm/s still
#: four samples to 0.1 mm.
ENOUGH_HZ = 20_000.0
#: A uniform base may be longer than the record by this factor, or have so many samples.
_STRETCH, _SAMPLES = 20, 2_000_000


@dataclass(frozen=True, eq=False)
class Clock:
    """Uniform time base of a record.

    >>> t = np.arange(100) / 100
    >>> clock = Clock.of(SctRecord("sct001", 5.0 + t, F_n=90e3 + t, F_r=7e3 + t, s=20 * t))
    >>> clock.uniform, clock.start, round(clock.dt, 6)
    (True, 5.0, 0.01)
    >>> clock.row(5.5)
    50
    """

    #: Time [s] from `start`, shape (n,).
    t: FloatArray
    #: Step [s].
    dt: float
    #: Time of the first sample on the record's own clock [s].
    start: float
    #: Times of the (averaged) samples, from `start` [s], shape (m,).
    source: FloatArray
    #: Samples of the record that are averaged into one.
    stride: int
    #: Whether `source` is `t` already.
    uniform: bool

    @classmethod
    def of(cls, record: SctRecord, sliding: float | None = None) -> Clock:
        """Return the clock of a record; its step is the usual one (of the sliding phase where it is stated).

        Raises InputError: gaps so long that the uniform base would be many times the record.
        """
        own = record.t
        phase = own if sliding is None else own[max(0, int(np.searchsorted(own, sliding)) - 1) :]
        step = usual_step(phase if len(phase) > 2 else own)
        stride = max(1, min(round(1.0 / (step * ENOUGH_HZ)), len(own) // 2000))
        times = block_means(own, stride)
        source = times - times[0]
        dt = step * stride
        count = round(float(source[-1]) / dt) + 1
        if count > max(_STRETCH * len(source), _SAMPLES):
            raise InputError(
                f"{record.where}: column 't' spans {float(np.ptp(own)):g} s in {len(own)} rows at {step:g} s; "
                f"allowed: gaps of less than {_STRETCH} times the record"
            )
        t: FloatArray = (np.arange(count) * dt).astype(np.float64)
        uniform = count == len(source) and bool(np.abs(source - t).max() < 1e-3 * dt)
        return cls(t, dt, float(times[0]), source, stride, uniform)

    def column(self, values: FloatArray) -> FloatArray:
        """Return a channel of the record on the uniform base."""
        means = block_means(values, self.stride)
        return means if self.uniform else np.interp(self.t, self.source, means)

    def row(self, time: float) -> int:
        """Return the sample at a time of the record's own clock [s]."""
        return int(np.clip(np.searchsorted(self.t, time - self.start - 1e-6 * self.dt), 0, len(self.t) - 1))


def block_means(values: FloatArray, stride: int) -> FloatArray:
    """Return the means of `stride` samples each; an unfinished block at the end is left out.

    >>> block_means(np.array([1.0, 3.0, 5.0, 7.0, 9.0]), 2).tolist()
    [2.0, 6.0]
    """
    if stride < 2:
        return values
    count = len(values) // stride
    return np.asarray(values[: count * stride].reshape(count, stride).mean(axis=1))
