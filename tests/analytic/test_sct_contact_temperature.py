"""The sliding thermal model against closed forms: Jaeger's moving band, two bodies in contact, constant flux."""

from __future__ import annotations

import pytest

from sct_twin import verification
from sct_twin.contact_temperature import SlidingContact, ThermalSettings


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


def test_heat_is_conserved_while_sliding() -> None:
    settings = ThermalSettings(cells=16, heat_transfer=35.0)
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
