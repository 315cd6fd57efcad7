"""The sliding thermal model against closed forms: Jaeger's moving band, two bodies in contact, constant flux."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import erfc, k0e

from sct_twin.contact_temperature import PLATE_1_2379, SlidingContact, ThermalBody, ThermalSettings


def jaeger_mean(speed: float, half_length: float, flux: float, body: ThermalBody) -> float:
    """Mean temperature rise under a band source that moves over a half space (Jaeger 1942) [K]."""
    w = speed / (2.0 * body.diffusivity)

    def kernel(distance: float) -> float:  # distance downstream of the element of the source
        return float(np.exp(w * distance - w * abs(distance)) * k0e(w * abs(distance)))

    def rise(x: float) -> float:
        upstream = quad(lambda d: kernel(d), 0.0, x + half_length, limit=200)[0]
        downstream = quad(lambda d: kernel(-d), 0.0, half_length - x, limit=200)[0]
        return flux / (np.pi * body.conductivity) * float(upstream + downstream)

    nodes, weights = np.polynomial.legendre.leggauss(24)
    return float(np.sum(0.5 * weights * [rise(half_length * node) for node in nodes]))


@pytest.mark.parametrize(("speed", "published"), [(5, 24.85), (50, 75.6), (200, 150.3), (500, 237.4)])
def test_moving_band_source(speed: float, published: float) -> None:
    body = ThermalBody(40.0, 3.6)
    flux = 0.5 * 0.08 * 1000.0 * speed
    exact = jaeger_mean(speed, 9.0, flux, body)
    assert exact == pytest.approx(published, rel=0.005)
    settings = ThermalSettings(
        depth=60.0 if speed < 50 else 12.0, heat_transfer=1e-9, plate=body, specimen=body
    )
    start = {"plate_temperature": 0.0, "specimen_temperature": 0.0, "punch_temperature": 0.0}
    contact = SlidingContact(
        9.0, speed=speed, settings=settings, band=True, margin=9.0 if speed < 50 else None, **start
    )
    step = 0.5 * contact.cell
    for _ in range(round((400 if speed < 50 else 120) / step)):
        contact.advance(step / speed, step, 2.0 * flux * contact.area)
    assert contact.contact.plate == pytest.approx(exact, rel=0.02)


def column(depth_settings: ThermalSettings, plate: float, specimen: float) -> SlidingContact:
    """Two bodies that touch everywhere: one-dimensional conduction."""
    return SlidingContact(
        9.0,
        25.0,
        plate_temperature=plate,
        specimen_temperature=specimen,
        punch_temperature=specimen,
        settings=depth_settings,
        band=True,
        margin=0.0,
    )


@pytest.mark.parametrize("seconds", [0.01, 0.1, 1.0])
def test_two_bodies_in_contact(seconds: float) -> None:
    settings = ThermalSettings(cells=4, surface_layer=0.01, growth=1.15, depth=25.0)
    contact = column(settings, 20.0, 120.0)
    for dt in np.diff(np.linspace(0.0, 1.0, 401) ** 2 * seconds):
        contact.advance(float(dt), 0.0, 0.0)
    # Carslaw & Jaeger, two half spaces over a contact resistance 1/h.
    h = settings.heat_transfer
    e_p = np.sqrt(settings.plate.conductivity * settings.plate.capacity)
    e_s = np.sqrt(settings.specimen.conductivity * settings.specimen.capacity)
    x = h * (1.0 / e_p + 1.0 / e_s) * np.sqrt(seconds)
    gap = 100.0 * np.exp(x**2) * erfc(x)
    middle = (20.0 * e_p + 120.0 * e_s) / (e_p + e_s)
    plate, specimen = middle - gap * e_s / (e_p + e_s), middle + gap * e_p / (e_p + e_s)
    assert contact.contact.plate - 20.0 == pytest.approx(plate - 20.0, rel=0.01)
    assert 120.0 - contact.contact.specimen == pytest.approx(120.0 - specimen, rel=0.01)


def test_constant_flux_into_the_plate() -> None:
    settings = ThermalSettings(cells=4, surface_layer=0.01, growth=1.15, depth=25.0, heat_transfer=1e-9)
    contact = column(settings, 0.0, 0.0)
    for dt in np.diff(np.linspace(0.0, 1.0, 201) ** 2):
        contact.advance(float(dt), 0.0, 2.0 * 1000.0 * contact.area)  # 1 MW/m2 to each side
    assert contact.contact.plate == pytest.approx(134.07, rel=0.01)
    effusivity = np.sqrt(PLATE_1_2379.conductivity * PLATE_1_2379.capacity)
    assert 2.0 * 1000.0 / effusivity / np.sqrt(np.pi) == pytest.approx(134.07, rel=2e-3)


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
