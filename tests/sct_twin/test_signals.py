"""From raw channels to friction over distance, against records whose friction is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from friction_models.common import InputError
from sct_twin import SctRecord
from sct_twin.signals.filters import integral, running_mean, spike_rows
from sct_twin.signals.motion import Motion
from sct_twin.signals.sliding_phase import process
from sct_twin.signals.sliding_series import Bins, resample

Maker = Callable[..., SctRecord]


@pytest.mark.parametrize("v_set", [5.0, 50.0, 400.0])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_friction_at_equal_distances(record_maker: Maker, v_set: float, direction: float) -> None:
    truth = lambda sd: 0.05 + 0.02 / (1.0 + sd / 3.0)  # noqa: E731
    record = record_maker(truth, v_set=v_set, direction=direction, ramp=0.05)
    series = resample(process(record, 25.0))
    assert np.allclose(np.diff(series.sd), 0.1)
    assert series.sd[0] == pytest.approx(0.1)
    assert np.abs(series.mu - truth(series.sd))[5:].max() < 3e-4
    assert series.v_rel[-20:] == pytest.approx(v_set, rel=1e-3)
    assert series.F_n == pytest.approx(94e3, rel=1e-3)


def test_noise_stays_at_the_level_of_the_sensors(record_maker: Maker) -> None:
    series = resample(process(record_maker(0.08, v_set=50.0, noise=1.0), 25.0))
    # 35 N of 94 kN a sample, two samples a point.
    assert np.std(series.mu[5:] - 0.08) < 5e-4
    assert abs(np.mean(series.mu[5:]) - 0.08) < 2e-4
    assert np.std(series.v_rel[60:]) < 0.5


def test_inertia_is_taken_out_with_the_measured_acceleration(record_maker: Maker) -> None:
    record = record_maker(0.08, v_set=400.0, mass=25.0, ramp=0.05)
    ramp = slice(5, 60)
    corrected = resample(process(record, 25.0)).mu[ramp]
    ignored = resample(process(record, 0.0)).mu[ramp]
    assert np.abs(corrected - 0.08).max() < 3e-4
    assert (ignored - 0.08).max() > 2e-3


def test_zero_of_the_force_cells_comes_from_the_unloaded_part(record_maker: Maker) -> None:
    signals = process(record_maker(), 25.0)
    assert (signals.zeros.F_n.before, signals.zeros.F_r.before) == pytest.approx((25.0, -40.0), abs=1.0)


def test_what_comes_after_sliding_is_cut_off(record_maker: Maker) -> None:
    r = record_maker(0.07)
    back = np.linspace(r.s[-1], r.s[0], 800)
    after = {"F_n": np.full(800, 25.0), "F_r": np.full(800, -40.0), "s": back, "a": np.zeros(800)}
    columns = {name: np.concatenate([getattr(r, name), values]) for name, values in after.items()}
    t = np.arange(len(r) + 800) * 1e-3
    whole = SctRecord("whole", t, **columns, T_plate=np.full(len(t), 20.0))
    series = resample(process(whole, 25.0))
    assert series.sd[-1] == pytest.approx(np.ptp(r.s), abs=0.2)
    assert series.mu[5:-3] == pytest.approx(0.07, abs=4e-4)


def test_a_plate_that_stops(record_maker: Maker) -> None:
    r = record_maker(0.07, v_set=400.0, sliding=30.0)
    # Braked within 4 ms, seen by the accelerometer, then at rest under load.
    v = 400.0 * np.concatenate([np.linspace(1.0, 0.0, 5)[1:], np.zeros(396)])
    s = r.s[-1] + integral(np.concatenate([[400.0], v]), 1e-3)[1:]
    after = {"F_n": np.full(400, r.F_n[-1]), "F_r": np.where(v > 0, r.F_r[-1], -40.0), "s": s}
    columns = {name: np.concatenate([getattr(r, name), values]) for name, values in after.items()}
    columns["a"] = np.gradient(np.concatenate([np.gradient(r.s, 1e-3), v]), 1e-3)
    t = np.arange(len(r) + 400) * 1e-3
    record = with_noise(SctRecord("stop", t, **columns, T_plate=np.full(len(t), 20.0)), 2, 0.0)
    series = resample(process(record))
    assert series.sd[-1] == pytest.approx(float(s[-1] - r.s[0]), abs=0.3)
    before = series.sd < np.ptp(r.s) - 0.5
    assert series.v_rel[before][-30:] == pytest.approx(400.0, rel=5e-3)


def test_a_plate_that_never_moves(record_maker: Maker) -> None:
    record = record_maker(sliding=12.0)
    still = SctRecord(
        "still", record.t, record.F_n, record.F_r, 0.01 * np.sin(record.t), record.a, record.T_plate
    )
    with pytest.raises(InputError, match=r"test still: column 's' moves by .* at least 0.5 mm"):
        process(still)


def test_sliding_before_the_load(record_maker: Maker) -> None:
    r = record_maker()
    F_n = np.where(r.t < 0.95, 0.0, 94e3)
    early = SctRecord("early", r.t, F_n, r.F_r, r.s, r.a, r.T_plate)
    with pytest.raises(InputError, match=r"test early: sliding begins at 0.* before the load"):
        process(early)


def with_noise(record: SctRecord, seed: int, correlation: float) -> SctRecord:
    """The sensors' noise on a record without any; it remembers as an autoregressive process does."""
    rng = np.random.default_rng(seed)

    def noisy(values: np.ndarray, deviation: float, memory: float) -> np.ndarray:
        shocks = deviation * np.sqrt(1.0 - memory**2) * rng.standard_normal(len(values) + 200)
        return values + lfilter([1.0], [1.0, -memory], shocks)[200:]

    return replace(
        record,
        F_n=noisy(record.F_n, 90.0, correlation),
        F_r=noisy(record.F_r, 35.0, correlation),
        s=noisy(record.s, 0.0015, 0.0),
        a=noisy(record.a, 150.0, 0.0),
    )


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.8])
@pytest.mark.parametrize("v_set", [5.0, 50.0, 400.0])
def test_the_stated_uncertainty_covers_the_truth(
    record_maker: Maker, v_set: float, correlation: float
) -> None:
    truth = lambda sd: 0.05 + 0.02 / (1.0 + sd / 3.0)  # noqa: E731
    quiet = record_maker(truth, v_set=v_set, sliding=40.0 if v_set > 100.0 else 12.0, ramp=0.05)
    off = []
    for seed in range(10 if v_set < 10.0 else 25):
        series = resample(process(with_noise(quiet, seed, correlation), 25.0))
        off.append((np.abs(series.mu - truth(series.sd)) / series.mu_std)[5:])
    within = np.concatenate(off)
    # 68.3 and 95.4 % of normal errors.
    assert 0.60 < np.mean(within < 1.0) < 0.76
    assert 0.88 < np.mean(within < 2.0) < 0.98


def test_what_adds_to_the_uncertainty(record_maker: Maker) -> None:
    record = with_noise(record_maker(0.08), 1, 0.0)
    plain = resample(process(record, 25.0))
    stated = resample(process(replace(record, metadata={"F_r_std": 47.0, "F_n_std": 0.0}), 25.0))
    added = np.sqrt(stated.mu_std**2 - plain.mu_std**2)
    assert added == pytest.approx(47.0 / 94e3, rel=0.01)
    # Of the zero: 89 samples of 35 N, their median.
    assert plain.common_std == pytest.approx(1.2533 * 35.0 / np.sqrt(89.0) / 94e3, rel=0.35)


def test_means_over_bins_and_their_variance() -> None:
    rng = np.random.default_rng(3)
    x = np.cumsum(rng.uniform(0.01, 0.3, 400))
    bins = Bins(x, 0.1, 300)
    assert bins.mean(2.0 * x + 1.0) == pytest.approx(2.0 * 0.1 * np.arange(1, 301) + 1.0)
    draws = np.array([bins.mean(rng.standard_normal(400)) for _ in range(3000)])
    assert bins.variance(np.ones(400)) == pytest.approx(draws.var(axis=0), rel=0.15)


def test_a_zero_that_drifts_between_both_ends(record_maker: Maker) -> None:
    r = with_noise(record_maker(0.08), 2, 0.0)
    n = 600
    rng = np.random.default_rng(4)
    after = {
        "F_n": 25.0 + 90.0 * rng.standard_normal(n),
        "F_r": -40.0 + 35.0 * rng.standard_normal(n),
        "s": np.full(n, r.s[-1]) + 0.0015 * rng.standard_normal(n),
        "a": 150.0 * rng.standard_normal(n),
    }
    t = np.arange(len(r) + n) * 1e-3
    columns = {name: np.concatenate([getattr(r, name), values]) for name, values in after.items()}
    columns["F_r"] = columns["F_r"] + 500.0 * t
    whole = SctRecord("whole", t, **columns, T_plate=np.full(len(t), 20.0))
    signals = process(whole, 25.0)
    assert signals.zeros.F_r.drift == pytest.approx(500.0, rel=0.05)
    corrected, seen = resample(signals), resample(process(cut(whole, len(r)), 25.0))
    assert abs(np.mean(corrected.mu) - 0.08) < 3e-4
    # One end alone cannot tell: 500 N/s over about 0.9 s of 94 kN.
    assert np.mean(seen.mu) - 0.08 > 3e-3


def cut(record: SctRecord, rows: int) -> SctRecord:
    return replace(record, **{name: getattr(record, name)[:rows] for name in record.channels})


@pytest.mark.parametrize(("v_set", "loss"), [(5.0, 3e-4), (50.0, 3e-4), (400.0, 6e-4)])
@pytest.mark.parametrize("channels", [("s",), ("v",), ("s", "v"), ("v", "a")])
def test_position_or_speed_alone(
    record_maker: Maker, channels: tuple[str, ...], v_set: float, loss: float
) -> None:
    whole = with_noise(record_maker(0.08, v_set=v_set, sliding=30.0, ramp=0.05), 3, 0.0)
    rng = np.random.default_rng(9)
    v = np.gradient(record_maker(0.08, v_set=v_set, sliding=30.0, ramp=0.05).s, whole.t)
    speed = v + 0.003 * v_set * rng.standard_normal(len(v))
    known = {"s": whole.s, "a": whole.a, "v": speed}
    given = {name: known[name] if name in channels else None for name in known}
    record = replace(whole, T_plate=None, metadata={"T_tool": 35.0}, **given)
    signals = process(record, 25.0)
    series, full = resample(signals), resample(process(whole, 25.0))
    assert signals.T_plate == 35.0
    assert series.sd[-1] == pytest.approx(full.sd[-1], abs=0.35)
    assert np.median(series.v_rel) == pytest.approx(v_set, rel=0.01)
    assert abs(np.mean(series.mu[20:]) - 0.08) < loss
    with pytest.raises(InputError, match="no plate temperature 'T_plate' and no 'T_tool'"):
        process(replace(record, metadata={}))


@pytest.mark.parametrize("v_set", [50.0, 400.0])
def test_a_coarse_position(record_maker: Maker, v_set: float) -> None:
    record = record_maker(0.08, v_set=v_set, sliding=30.0, ramp=0.05)
    s = np.asarray(record.s) + 0.05 * np.random.default_rng(2).standard_normal(len(record))
    for a in (record.a, None):
        series = resample(process(replace(record, s=s, a=a), 25.0))
        assert np.abs(series.mu - 0.08).max() < 1e-3
        assert np.std(series.v_rel[150:]) < 0.01 * v_set


def test_neither_position_nor_speed(record_maker: Maker) -> None:
    with pytest.raises(InputError, match="neither a position 's' nor a speed 'v'"):
        replace(record_maker(), s=None)


def test_spikes_are_replaced_when_asked(record_maker: Maker) -> None:
    record = with_noise(record_maker(0.08), 5, 0.0)
    F_n, F_r = record.F_n.copy(), record.F_r.copy()
    F_n[[50, 850]] += 9e3
    F_r[[900, 901]] += 4e3
    # A break-away peak at the start of sliding is friction.
    F_r[[811, 812]] += 6e3
    spiky = replace(record, F_n=F_n, F_r=F_r)
    kept, repaired = process(spiky, 25.0), process(replace(spiky, metadata={"despike": True}), 25.0)
    assert kept.spikes == 0 and repaired.spikes == 4
    assert kept.slide_start == repaired.slide_start
    assert np.abs(resample(kept).mu - 0.08)[10:].max() > 5e-3
    assert np.abs(resample(repaired).mu - 0.08)[10:].max() < 2e-3
    assert resample(repaired).mu[:6].max() > 0.1


def test_steps_and_ramps_are_no_spikes() -> None:
    rng = np.random.default_rng(6)
    step = np.where(np.arange(500) < 250, 0.0, 1e4) + rng.standard_normal(500)
    ramp = np.interp(np.arange(500), [200, 203], [0.0, 1e4]) + rng.standard_normal(500)
    assert not len(spike_rows(step)) and not len(spike_rows(ramp))
    assert not len(spike_rows(np.zeros(500)))
    step[100] += 50.0
    assert list(spike_rows(step)) == [100]
    coarse = np.round(np.linspace(0.0, 5.0, 500))
    coarse[100] += 30.0
    assert list(spike_rows(coarse)) == [100]


def test_low_pass_of_the_forces(record_maker: Maker) -> None:
    record = record_maker(0.08, v_set=20.0)
    hum = replace(record, F_r=record.F_r + 400.0 * np.sin(2.0 * np.pi * 150.0 * record.t))
    plain = process(hum, 25.0)
    for corner in (40.0, "auto"):
        filtered = process(replace(hum, metadata={"low_pass": corner}), 25.0)
        assert filtered.low_pass == pytest.approx(100.0 if corner == "auto" else 40.0)
        rows = slice(plain.slide_start + 100, -50)
        left = np.std(filtered.friction[rows]) / np.std(plain.friction[rows])
        # Second order, forwards and backwards: 1 / (1 + (f/f_c)^4) but for the warping near Nyquist.
        assert left < 1.1 / (1.0 + (150.0 / filtered.low_pass) ** 4)
        # No phase shift: friction rises where it rose.
        half = [int(np.argmax(s.friction > 0.04 * 94e3)) for s in (process(record, 25.0), filtered)]
        assert abs(half[0] - half[1]) <= 1
    assert process(replace(hum, metadata={"low_pass": 450.0}), 25.0).low_pass == 0.0


def test_a_hold_in_the_middle(record_maker: Maker) -> None:
    first = record_maker(0.08, v_set=20.0, sliding=6.0)
    stop, rest, go = 900, 10_000, first.v if first.v is not None else None
    assert go is None
    held = {
        name: np.concatenate([values[:stop], np.full(rest, values[stop]), values[stop:]])
        for name, values in ((n, getattr(first, n)) for n in ("F_n", "F_r", "s", "T_plate"))
    }
    t = np.arange(len(first) + rest) * 1e-3
    record = with_noise(SctRecord("held", t, **held, a=np.zeros(len(t))), 7, 0.0)
    signals = process(replace(record, a=None))
    sliding = signals.sd[-1]
    assert sliding == pytest.approx(np.ptp(first.s), abs=0.05)
    middle = slice(stop + 200, stop + rest - 200)
    assert not signals.v[middle].any() and np.ptp(signals.sd[middle]) < 1e-6
    series = resample(signals)
    assert np.diff(series.t).max() == pytest.approx(10.0, abs=0.2)


def test_slow_and_irregular_sampling(record_maker: Maker) -> None:
    record = record_maker(0.08, v_set=5.0, sliding=20.0)
    coarse = replace(record, **{name: getattr(record, name)[::80] for name in record.channels})
    series = resample(process(coarse, 25.0))
    assert series.sd[-1] == pytest.approx(20.0, abs=0.3)
    # 0.4 mm a sample: points between two samples; one sample before the load is no zero (40 N of 94 kN).
    assert series.mu[10:] == pytest.approx(0.08 - 40.0 / 94e3, abs=3e-4)
    rng = np.random.default_rng(8)
    rows = np.sort(rng.choice(len(record), len(record) // 3, replace=False))
    uneven = replace(record, **{name: getattr(record, name)[rows] for name in record.channels})
    assert resample(process(uneven, 25.0)).mu[10:] == pytest.approx(0.08, abs=3e-4)


def test_the_running_mean_is_that_of_a_convolution() -> None:
    values = np.random.default_rng(1).standard_normal(300)
    for width in (1, 5, 10, 51):
        expected = np.convolve(values, np.full(width, 1.0 / width), mode="same")
        assert running_mean(values, width) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("channel", ["s", "v"])
def test_a_long_hold_after_a_short_upsetting_does_not_hide_the_start(channel: str) -> None:
    # 0.4 s at rest, 0.2 s of sliding at 50 mm/s, 60 s of hold, 0.2 s of sliding: a fiftieth of the record ends in the hold.
    dt = 0.002
    v = 50.0 * np.r_[np.zeros(200), np.ones(100), np.zeros(30_000), np.ones(100), np.zeros(50)]
    rng = np.random.default_rng(0)
    if channel == "s":
        motion = Motion(np.cumsum(v) * dt + 1e-3 * rng.standard_normal(len(v)), None, None, dt, "record")
    else:
        motion = Motion(None, v + 0.1 * rng.standard_normal(len(v)), None, dt, "record")
    assert motion.first() == pytest.approx(200, abs=4)
