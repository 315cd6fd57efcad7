"""From raw channels to friction over distance, against records whose friction is known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from friction_models.loads import InputError
from sct_twin import SctRecord
from sct_twin.signals import process, resample

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
    assert signals.force_zero == pytest.approx((25.0, -40.0), abs=1.0)


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
