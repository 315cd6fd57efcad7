"""Sensors of the virtual rig: noise, drift and lag of forces, motion and temperature, and faults."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt
import pandas as pd
from numba import njit

from friction_models.common import InputError, unknown_name
from friction_models.loads import FloatArray

from .drive import RATE

#: Channels that the rig records, in the order of its files.
RECORDED = ("t", "F_n", "F_r", "s", "a", "T_plate")


@dataclass(frozen=True)
class Instruments:
    """Sensors, drive and lubricant scatter; standard deviations unless said otherwise.

    The defaults are a plain rig: rigid drive, cells without drift. `realistic` adds what a real one has.

    Attributes
    ----------
    moving_mass : float
        Mass between force cell and contact [kg].
    offset : float
        Of mu from test to test: specimen and lubricant.
    drift, drift_length : float
        Slow change of mu within a test, and the distance over which it forgets [mm].
    roughness : float
        Fast fluctuation of mu from sample to sample.
    F_n_noise, F_r_noise, zero : float
        Force cells: noise and unloaded reading [N].
    position_noise : float
        Of the plate position [mm].
    acceleration_noise : float
        Of the plate acceleration [mm/s2].
    temperature_noise : float
        Of the plate thermocouple [K].
    control : float
        Relative wobble of the force control.
    acceleration : float
        With which the plate is set in motion [mm/s2]; not a standard deviation.
    gain : float
        Of the calibration of both force cells; the same for all tests of a campaign.
    zero_drift : float
        Of the change of the force cells' zeros with time [N/s], another one in every test.
    stiffness : float
        Of the drive that pulls the plate [N/mm]; 0: rigid. Not a standard deviation.
    damping : float
        Damping ratio of plate and drive; not a standard deviation.
    static, static_length : float
        Static friction above the sliding one, as mu, and the slip over which half of it is lost [mm]; acts
        with an elastic drive; not standard deviations.
    thermocouple_lag : float
        Time constant of the plate thermocouple [s]; not a standard deviation.
    plate_capacity : float
        Heat capacity of the plate around the thermocouple [J/K], which friction warms; 0: infinite. Not a
        standard deviation.
    batch_scatter : float
        Of mu from lubricant batch to lubricant batch.
    caliper : float
        Of the specimen dimensions in the test table [mm].
    contact_reading : float
        Of the diameter of the contact, measured after the test [mm]; 0: it is not measured.
    unloaded_after : float
        How long the rig goes on recording after the load is off [s]; not a standard deviation.

    Examples
    --------
    >>> from sct_twin.virtual_lab import Instruments
    >>> Instruments().stiffness, Instruments.realistic().stiffness
    (0.0, 100000.0)
    >>> Instruments(offset=-0.01)
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: instruments: offset = -0.01; allowed: a finite number from 0 on
    """

    moving_mass: float = 25.0
    offset: float = 0.0042
    drift: float = 0.0016
    drift_length: float = 15.0
    roughness: float = 0.0012
    F_n_noise: float = 90.0
    F_r_noise: float = 35.0
    zero: float = 40.0
    position_noise: float = 0.0015
    acceleration_noise: float = 150.0
    temperature_noise: float = 0.15
    control: float = 0.002
    acceleration: float = 12000.0
    gain: float = 0.0
    zero_drift: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.3
    static: float = 0.0
    static_length: float = 0.01
    thermocouple_lag: float = 0.0
    plate_capacity: float = 0.0
    batch_scatter: float = 0.0
    caliper: float = 0.0
    contact_reading: float = 0.0
    unloaded_after: float = 0.0

    def __post_init__(self) -> None:
        for f in fields(self):
            value = getattr(self, f.name)
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value < math.inf:
                raise InputError(f"instruments: {f.name} = {value!r}; allowed: a finite number from 0 on")
        for name in ("acceleration", "moving_mass", "drift_length", "static_length"):
            if getattr(self, name) == 0.0:
                raise InputError(f"instruments: {name} = 0; allowed: above 0")

    @classmethod
    def realistic(cls) -> Instruments:
        """Return a rig whose plate sticks before it slides, with drifting cells and a lagging thermocouple."""
        return cls(
            gain=0.001,
            zero_drift=1.5,
            stiffness=1.0e5,
            static=0.012,
            thermocouple_lag=0.6,
            plate_capacity=400.0,
            caliper=0.01,
            contact_reading=0.04,
            unloaded_after=0.3,
        )


@dataclass(frozen=True)
class Faults:
    """Faults of a test and their size; none by default.

    Attributes
    ----------
    spikes, spike_size : int, float
        Single samples of F_n and F_r that stand out, and by how much [N].
    clip : float
        Share of the largest friction force that the amplifier of F_r cuts off.
    gaps, gap_length : int, float
        Losses of the logger and their length [s].
    dead : str
        Channel that holds its first value.
    force_zero : float
        Added to F_r from the load on, so that the unloaded samples do not show it [N].
    late_start : bool
        The recording begins under load: no unloaded samples, the zeros of the cells stay in.
    drift : float
        Change of F_r with time [N/s].
    tests : tuple of str
        The tests it happens to; empty: all.
    """

    spikes: int = 0
    spike_size: float = 8000.0
    clip: float = 0.0
    gaps: int = 0
    gap_length: float = 0.02
    dead: str = ""
    force_zero: float = 0.0
    late_start: bool = False
    drift: float = 0.0
    tests: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.dead and self.dead not in RECORDED[1:]:
            raise unknown_name("channel", self.dead, RECORDED[1:], "faults: dead")
        for name, low, high in (
            ("spikes", 0, 1000),
            ("spike_size", 0.0, 1e7),
            ("clip", 0.0, 0.9),
            ("gaps", 0, 100),
            ("gap_length", 0.0, 10.0),
            ("force_zero", -1e6, 1e6),
            ("drift", -1e5, 1e5),
        ):
            value = getattr(self, name)
            if not (isinstance(value, int | float) and low <= value <= high):
                raise InputError(f"faults: {name} = {value!r}; allowed: {low:g} to {high:g}")

    def happen_to(self, test_id: str) -> bool:
        """Return whether a test is hit."""
        return not self.tests or test_id in self.tests

    def apply(self, frame: pd.DataFrame, load_start: int, rng: np.random.Generator) -> pd.DataFrame:
        """Return the record with the faults; `load_start` is the first sample under load."""
        columns: dict[str, FloatArray] = {str(n): frame[n].to_numpy(np.float64).copy() for n in frame}
        n = len(frame)
        columns["F_r"] += self.drift * columns["t"]
        columns["F_r"][load_start:] += self.force_zero
        if self.clip:
            limit = (1.0 - self.clip) * float(np.abs(columns["F_r"]).max())
            columns["F_r"] = np.clip(columns["F_r"], -limit, limit)
        for name in ("F_n", "F_r"):
            at = rng.choice(np.arange(5, n - 5), self.spikes, replace=False)
            columns[name][at] += self.spike_size * rng.choice((-1.0, 1.0), self.spikes)
        if self.dead:
            columns[self.dead][:] = columns[self.dead][0]
        keep = np.ones(n, dtype=bool)
        length = max(1, round(self.gap_length * RATE))
        for begin in rng.integers(load_start, max(n - length - 5, load_start + 1), self.gaps):
            keep[begin : begin + length] = False
        if self.late_start:
            keep[: load_start + 5] = False
        return pd.DataFrame({name: values[keep] for name, values in columns.items()})


def measured(
    true: dict[str, FloatArray],
    sliding: npt.NDArray[np.bool_],
    instruments: Instruments,
    gains: FloatArray,
    rng: np.random.Generator,
    more: np.random.Generator,
) -> pd.DataFrame:
    """Return what the sensors record, in canonical channels and units.

    - `true`, shape (n,): `F_n`, `friction` [N], `a` [mm/s2], `sd` [mm], `T_plate` [degC].
    - `sliding`, shape (n,): whether the plate moves.
    - `gains`: calibration of the two force cells.
    - `rng`, `more`: of the plain rig's noise, and of everything beyond it: a realistic rig has the same noise
      as a plain one.
    """
    n = len(true["F_n"])
    i, t = instruments, np.arange(n) / RATE
    zeros = i.zero * rng.standard_normal(2)
    drifts = i.zero_drift * more.standard_normal(2)
    F_n = true["F_n"]
    friction = true["friction"] + i.roughness * rng.standard_normal(n) * sliding * F_n
    wander_T = wander(n, 3.0 * RATE, 0.4, rng)
    plate = lagged(true["T_plate"] + wander_T, i.thermocouple_lag)
    plate = plate + i.temperature_noise * rng.standard_normal(n)
    a = true["a"]
    return pd.DataFrame(
        {
            "t": t,
            "F_n": gains[0] * F_n + zeros[0] + drifts[0] * t + i.F_n_noise * rng.standard_normal(n),
            "F_r": gains[1] * (friction + i.moving_mass * 1e-3 * a)
            + zeros[1]
            + drifts[1] * t
            + i.F_r_noise * rng.standard_normal(n),
            "s": true["sd"] + 12.0 + i.position_noise * rng.standard_normal(n),
            "a": a + 30.0 * float(rng.standard_normal()) + i.acceleration_noise * rng.standard_normal(n),
            "T_plate": plate,
        }
    )


def lagged(values: FloatArray, lag: float) -> FloatArray:
    """Return what a sensor with a first-order lag [s] shows, settled at the first value."""
    if lag <= 0.0:
        return values
    keep = math.exp(-1.0 / (lag * RATE))
    return following((1.0 - keep) * (values - values[0]), keep) + values[0]


def wander(count: int, memory: float, deviation: float, rng: np.random.Generator) -> FloatArray:
    """Return a stationary process that forgets over `memory` samples (Ornstein-Uhlenbeck)."""
    keep = float(np.exp(-1.0 / memory))
    shocks = deviation * float(np.sqrt(1.0 - keep**2)) * rng.standard_normal(count)
    shocks[0] = deviation * float(rng.standard_normal())
    return following(shocks, keep)


@njit(cache=True)
def following(pushes: FloatArray, keep: float) -> FloatArray:
    """Return what keeps a share of itself from sample to sample, and is pushed at each.

    `scipy.signal.lfilter` does this, too, but loading it costs every process of a campaign half a second.
    """
    found = np.empty(pushes.shape[0])
    value = 0.0
    for k in range(pushes.shape[0]):
        value = keep * value + pushes[k]
        found[k] = value
    return found
