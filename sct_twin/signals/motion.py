"""Motion of the plate: speed, distance and acceleration from those of them that were recorded."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter

from friction_models.common import InputError
from friction_models.loads import FloatArray

from .filters import CORNER_HZ, integral, noise_of, running_mean, smooth

#: Noise of a speed from positions alone that is aimed at, over the speed itself.
SPEED_NOISE = 0.005
#: A plate stands while it moves less than this in 0.05 s [mm].
STANDING = 0.05
#: So many samples at the beginning show the plate at rest, or a fiftieth of a shorter record: of a long one, with a minute of
#: hold, a fiftieth may reach into the sliding.
AT_REST = 100


def _at_rest(record: FloatArray) -> slice:
    return slice(0, max(5, min(len(record) // 50, AT_REST)))


class Motion:
    """Motion of the plate on a uniform time base.

    With position and acceleration the speed is the derivative of the position below 10 Hz and the integral
    of the acceleration above. With the position alone it is the derivative of the low-passed position; the
    corner is as high as the noise of the position allows. A recorded speed is taken as it is.

    - `s`, `v`, `a`, shape (n,): position [mm], speed [mm/s], acceleration [mm/s2], `dt` [s] apart; position or speed at
      least.
    """

    def __init__(
        self, s: FloatArray | None, v: FloatArray | None, a: FloatArray | None, dt: float, where: str
    ) -> None:
        self.v, self.a, self.dt, self.where = v, a, dt, where
        self.measured = s is not None
        if s is None:
            assert v is not None
            s = integral(v - float(np.median(v[_at_rest(v)])), dt)
        self.s = s

    def first(self) -> int:
        """Return a sample at which the plate has begun to move.

        Raises InputError: it never moves, or moves from the first sample on.
        """
        travel = float(np.ptp(self.s))
        what = "column 's'" if self.measured else "the integral of column 'v'"
        if travel < 0.5:
            raise InputError(
                f"{self.where}: {what} moves by {travel:g} mm; allowed: at least 0.5 mm of sliding"
            )
        if not self.measured and self.v is not None:
            rest = self.v[_at_rest(self.v)]
            noise = 1.4826 * float(np.median(np.abs(rest - np.median(rest))))
            mean = np.abs(running_mean(self.v - float(np.median(rest)), 5))
            away = mean > max(0.02 * float(mean.max()), 5.0 * noise)
        else:
            steady = median_filter(self.s, 5, mode="nearest")
            origin = float(np.median(steady[_at_rest(steady)]))
            away = np.abs(steady - origin) > max(0.02, 0.001 * travel, 6.0 * noise_of(self.s))
        if not away.any() or away[0]:
            raise InputError(
                f"{self.where}: the plate moves from the first sample on; allowed: upsetting at rest first"
            )
        return int(np.argmax(away))

    def standing(self) -> np.ndarray:
        """Return for every sample whether the plate stands."""
        half = max(1, round(0.025 / self.dt))
        if len(self.s) <= 2 * half:
            return np.zeros(len(self.s), dtype=bool)
        padded = np.pad(self.s, half, mode="edge")
        moved = np.abs(padded[2 * half :] - padded[: -2 * half])
        return np.asarray(moved < max(STANDING, 6.0 * noise_of(self.s)))

    def acceleration_ratio(self, slide: int, end: int) -> float:
        """Return the largest speed by the acceleration alone over that by the position (or speed) alone.

        0 without acceleration; the position's is the largest over 50 ms.
        """
        if self.a is None:
            return 0.0
        rest = slice(0, max(slide - 1, 5))
        a = self.a - float(np.median(self.a[rest]))
        fast = integral(np.where(_accelerates(a, rest, self.dt), a, 0.0), self.dt)[slide:end]
        span = min(max(1, round(0.05 / self.dt)), end - slide - 1)
        s = self.s[slide:end]
        largest = float(np.abs(s[span:] - s[:-span]).max()) / (span * self.dt)
        return float(np.abs(fast - fast[0]).max()) / max(largest, 1e-9)

    def slide(self, slide: int, end: int, stated: bool) -> tuple[FloatArray, FloatArray, FloatArray, int]:
        """Return speed [mm/s], acceleration [mm/s2], distance [mm] up to `end`, and where sliding begins.

        Speed and distance are 0 before sliding and count its direction as positive; the acceleration keeps
        the sign of the plate's.
        """
        rest = slice(0, max(slide - 1, 5))
        # A plate that stops is looked at beyond its stop; one that turns at full speed up to there only.
        part = self
        if not self._stops(slide, end):
            v, a = (None if values is None else values[:end] for values in (self.v, self.a))
            part = Motion(self.s[:end], v, a, self.dt, self.where)
        v, a = (values[:end] for values in part._speed(rest, slide, end))
        s = self.s[:end]
        direction = 1.0 if v[slide:].mean() >= 0.0 else -1.0
        v = direction * v
        noise = 1.4826 * float(np.median(np.abs(v[rest] - np.median(v[rest]))))
        threshold = max(5.0 * noise, 0.003 * float(v.max()))
        while not stated and slide > 1 and v[slide - 1] > threshold:
            slide -= 1
        # A plate that holds, or has stopped: the noise of its speed must not add up to a distance.
        mean = np.abs(running_mean(v, max(1, round(0.05 / self.dt))))
        still = mean < 5.0 * 1.4826 * float(np.median(mean[rest]))
        v = np.where(still, 0.0, np.maximum(v, 0.0))
        v[:slide] = 0.0
        sd = integral(v, self.dt)
        if self.measured and sd[-1] > 0.0:
            origin = s[max(0, slide - 5) : slide + 1] if stated else s[rest]
            measured = direction * (s - float(np.median(origin)))
            lag = float(np.median((measured - sd)[-max(5, (end - slide) // 10) :]))
            sd = sd * max(0.0, 1.0 + lag / sd[-1])
        return v, a, sd, slide

    def _stops(self, slide: int, end: int) -> bool:
        """Whether the plate stands at the end of sliding, judged by its last 5 ms."""
        tail = min(max(3, round(0.005 / self.dt)), end - 1 - slide)
        last = abs(float(self.s[end - 1] - self.s[end - 1 - tail])) / max(tail, 1)
        return last < 0.3 * abs(float(self.s[end - 1] - self.s[slide])) / max(end - 1 - slide, 1)

    def _speed(self, rest: slice, slide: int, end: int) -> tuple[FloatArray, FloatArray]:
        a = None if self.a is None else self.a - float(np.median(self.a[rest]))
        if self.v is not None:
            v = self.v - float(np.median(self.v[rest]))
        elif a is not None:
            return _blend(self.s, a, rest, self.dt), a
        else:
            v = _derivative(self.s, self.dt, self._corner(slide, end))
        if a is None:
            corner = 2.0 * CORNER_HZ if self.v is not None else self._corner(slide, end)
            a = np.gradient(smooth(v, self.dt, corner), self.dt)
            # At constant speed the derivative is noise and nothing else.
            a = np.where(_accelerates(a, rest, self.dt), a, 0.0)
        return v, a

    def _corner(self, slide: int, end: int) -> float:
        """Return the corner [Hz] at which the derivative of the position has the noise that is aimed at."""
        noise = noise_of(self.s[:end])
        speed = abs(float(self.s[end - 1] - self.s[slide])) / max((end - slide) * self.dt, self.dt)
        highest = 0.2 / self.dt
        if noise <= 0.0:
            return highest
        share = SPEED_NOISE * speed / (2.0 * np.pi * noise * np.sqrt(2.0 * self.dt / 3.0))
        return float(np.clip(share ** (2.0 / 3.0), min(0.5 * CORNER_HZ, highest), highest))


def _accelerates(a: FloatArray, rest: slice, dt: float) -> np.ndarray:
    """Return for every sample whether the plate speeds up or slows down within 20 ms of it."""
    width = max(1, round(0.01 / dt))
    mean = running_mean(a, width)
    noise = 1.4826 * float(np.median(np.abs(mean[rest])))
    moved = (np.abs(mean) > 4.0 * noise).astype(np.uint8)
    return np.asarray(maximum_filter1d(moved, 2 * width + 1, mode="constant") > 0)


def _blend(s: FloatArray, a: FloatArray, rest: slice, dt: float) -> FloatArray:
    """Low frequencies from the position, high ones from the acceleration where the plate does accelerate."""
    # At constant speed the integrated noise of the acceleration would be all there is above the corner.
    fast = integral(np.where(_accelerates(a, rest, dt), a, 0.0), dt)
    return np.asarray(fast + _derivative(s - integral(fast, dt), dt, CORNER_HZ))


def _derivative(s: FloatArray, dt: float, corner: float) -> FloatArray:
    """Return the derivative of the low-passed position."""
    # The record ends while the plate moves: go on along a line through its last 60 ms, not from one sample.
    tail = min(len(s), max(8, round(0.06 / dt)))
    count = round(0.4 / dt)
    slope, level = np.polyfit(np.arange(tail) - (tail - 1.0), s[-tail:], 1)
    before = np.full(count, float(np.median(s[:tail])))
    extended = np.concatenate([before, s, level + slope * np.arange(1, count + 1)])
    return np.asarray(np.gradient(smooth(extended, dt, corner), dt)[count : count + len(s)])
