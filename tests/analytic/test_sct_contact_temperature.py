"""The sliding thermal model against closed forms: Jaeger's moving band, two bodies in contact, constant flux."""

from __future__ import annotations

import numpy as np
import pytest

from sct_twin.twin.heat import verification
from sct_twin.twin.heat.contact_temperature import SlidingContact, ThermalBody, ThermalSettings
from sct_twin.twin.heat.sliding import rests, slide


@pytest.mark.parametrize(("speed", "published"), [(5, 24.85), (50, 75.6), (200, 150.3), (500, 237.4)])
def test_moving_band_source(speed: float, published: float) -> None:
    row = verification.moving_source(speed)
    assert row.reference == pytest.approx(published, rel=0.005)
    assert row.verdict == "pass", row


@pytest.mark.parametrize("seconds", [0.01, 0.1, 1.0])
def test_two_bodies_in_contact(seconds: float) -> None:
    rows = verification.two_bodies(seconds)
    # Surfaces of the plate and the specimen [degC].
    known = {0.01: (48.21, 100.92), 0.1: (65.63, 89.15), 1.0: (74.88, 82.89)}[seconds]
    assert [rows[0].reference + 20.0, 120.0 - rows[1].reference] == pytest.approx(known, abs=0.02)
    assert [row.verdict for row in rows] == ["pass", "pass"]


def test_constant_flux_into_the_plate() -> None:
    (row,) = verification.constant_flux()
    assert row.reference == pytest.approx(134.07, rel=2e-3)
    assert row.verdict == "pass", row


def test_constant_flux_where_k_and_c_change_alike() -> None:
    rows = verification.varying_flux()
    # With constant data both would be 536 K.
    assert [row.reference for row in rows] == pytest.approx([638.03, 439.63], abs=0.02)
    assert [row.verdict for row in rows] == ["pass", "pass"]


VARYING = ThermalBody(((20.0, 20.0), (400.0, 24.0)), ((20.0, 3.5), (300.0, 4.2), (600.0, 5.0)))


@pytest.mark.parametrize("body", [ThermalBody(20.0, 3.5), VARYING])
def test_heat_is_conserved_while_sliding(body: ThermalBody) -> None:
    settings = ThermalSettings(cells=16, heat_transfer=35.0, plate=body, specimen=body)
    contact = SlidingContact(7.0, 6.0, speed=50.0, settings=settings, margin=14.0)
    step = 0.25 * contact.cell
    power = 5.0e5
    for _ in range(60):
        contact.advance(step / 50.0, step, power)
    stored = contact.heat_content(20.0)
    # Nothing has left the modelled plate yet; the punch takes a little.
    assert stored == pytest.approx(power * 60 * step / 50.0, rel=0.01)


def test_division_of_steps_does_not_matter() -> None:
    whole = SlidingContact(7.0, 6.0, speed=200.0)
    parts = whole.copy()
    for _ in range(20):
        whole.advance(0.01, 2.0, 4.0e6)
        for _ in range(5):
            parts.advance(0.002, 0.4, 4.0e6)
    assert parts.contact.mean - 20.0 == pytest.approx(whole.contact.mean - 20.0, rel=0.01)
    assert whole.contact.mean > 100.0


def test_a_rest_in_the_middle_cools_the_contact_and_adds_no_work() -> None:
    sd = 0.1 * np.arange(0.0, 121.0)
    t = sd / 50.0
    friction, v = np.full(sd.shape, 20e3), np.full(sd.shape, 50.0)
    waiting = t + np.where(sd > 6.05, 60.0, 0.0)
    where, pauses = rests(waiting, sd, v)
    assert where == pytest.approx([6.05]) and pauses == pytest.approx([60.0])
    settings = ThermalSettings()
    through = slide(SlidingContact(7.0, 6.0, speed=50.0, settings=settings), t, sd, friction, v)
    rested = slide(SlidingContact(7.0, 6.0, speed=50.0, settings=settings), waiting, sd, friction, v)
    before, after = np.flatnonzero(np.abs(rested.sd - 6.05) < 1e-9)
    assert rested.mean[before] == pytest.approx(float(np.interp(6.05, through.sd, through.mean)), rel=1e-3)
    assert rested.mean[before] > 60.0
    # The punch at 20 degC takes the heat away.
    assert rested.mean[after] < 30.0
    assert np.allclose(
        rested.mean[: before + 1], np.interp(rested.sd[: before + 1], through.sd, through.mean), rtol=2e-3
    )
