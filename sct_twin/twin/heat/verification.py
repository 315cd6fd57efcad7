"""Verification of the sliding heat model: Jaeger's moving source, two bodies in contact, constant flux."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.integrate import quad
from scipy.special import erfc, k0e

from forming.fe.heat.properties import value_at
from forming.verification.case import Case, Row, case

from .contact_temperature import SlidingContact
from .thermal_settings import ThermalBody, ThermalSettings

GROUP = "Heat"
#: Half the length of the moving source [mm], friction and pressure [MPa] that heat it, speeds [mm/s].
HALF_LENGTH, MU, PRESSURE = 9.0, 0.08, 1000.0
SPEEDS = (5.0, 50.0, 200.0, 500.0)
#: Temperatures of the two bodies [degC] and instants [s].
HOT, COLD = 120.0, 20.0
INSTANTS = (0.01, 0.1, 1.0)
#: Heat flux into the plate, and one that heats it through a wide range of its heat data [N/(mm s), kW/m2].
FLUX, STRONG_FLUX = 1000.0, 4000.0
#: The cases of the twin.
CASES: list[Case] = []


def jaeger_mean(speed: float, half_length: float, flux: float, body: ThermalBody) -> float:
    """Return the mean temperature rise under a band source that moves over a half space [K] (Jaeger 1942)."""
    w = speed / (2.0 * body.diffusivity())
    conductivity = float(value_at(body.conductivity, 20.0))

    def kernel(distance: float) -> float:
        # `distance` downstream of the element of the source.
        return float(np.exp(w * distance - w * abs(distance)) * k0e(w * abs(distance)))

    def rise(x: float) -> float:
        upstream = quad(kernel, 0.0, x + half_length, limit=200)[0]
        downstream = quad(lambda d: kernel(-d), 0.0, half_length - x, limit=200)[0]
        return flux / (np.pi * conductivity) * float(upstream + downstream)

    nodes, weights = np.polynomial.legendre.leggauss(24)
    return float(np.sum(0.5 * weights * [rise(half_length * node) for node in nodes]))


@case(CASES, "heat-moving-source", GROUP)
def moving_sources() -> list[Row]:
    """Twin: band source of 18 mm that slides over a plate (k 40, 3.6 MJ/(m3 K)), half of mu p v, mu p 80 MPa."""
    return [moving_source(speed) for speed in SPEEDS]


def moving_source(speed: float) -> Row:
    """Return the row of the plate's mean temperature under the source at one speed [mm/s]."""
    body = ThermalBody(40.0, 3.6)
    flux = 0.5 * MU * PRESSURE * speed
    slow = speed < 50.0
    contact = SlidingContact(
        HALF_LENGTH,
        speed=speed,
        plate_temperature=0.0,
        specimen_temperature=0.0,
        punch_temperature=0.0,
        settings=ThermalSettings(depth=60.0 if slow else 12.0, heat_transfer=1e-9, plate=body, specimen=body),
        band=True,
        margin=9.0 if slow else None,
    )
    step = 0.5 * contact.cell
    for _ in range(round((400.0 if slow else 120.0) / step)):
        contact.advance(step / speed, step, 2.0 * flux * contact.area)
    exact = jaeger_mean(speed, HALF_LENGTH, flux, body)
    quantity = f"mean rise of the plate at {speed:g} mm/s"
    return Row(quantity, "K", exact, "Jaeger 1942, integrated", contact.contact.plate, 2.0)


@case(CASES, "heat-two-bodies", GROUP)
def touching_bodies() -> list[Row]:
    """Twin: specimen at 120 degC on a plate at 20 degC, 35 000 W/(m2 K)."""
    return [row for seconds in INSTANTS for row in two_bodies(seconds)]


def two_bodies(seconds: float) -> list[Row]:
    """Return the rows of both surfaces a time after two bodies have touched."""
    settings = _column_settings()
    contact = _column(settings, COLD, HOT)
    for dt in np.diff(np.linspace(0.0, 1.0, 401) ** 2 * seconds):
        contact.advance(float(dt), 0.0, 0.0)
    plate, specimen = half_spaces(settings, seconds)
    source = "Carslaw and Jaeger: two half spaces over a film"
    risen, fallen = contact.contact.plate - COLD, HOT - contact.contact.specimen
    return [
        Row(f"plate above {COLD:g} degC, {seconds:g} s", "K", plate, source, risen, 1.0),
        Row(f"specimen below {HOT:g} degC, {seconds:g} s", "K", specimen, source, fallen, 1.0),
    ]


def half_spaces(settings: ThermalSettings, seconds: float) -> tuple[float, float]:
    """Return how far the cold surface has risen and the hot one has fallen [K]."""
    h = settings.heat_transfer
    e_p, e_s = settings.plate.effusivity(), settings.specimen.effusivity()
    x = h * (1.0 / e_p + 1.0 / e_s) * np.sqrt(seconds)
    gap = float((HOT - COLD) * np.exp(x**2) * erfc(x))
    middle = (COLD * e_p + HOT * e_s) / (e_p + e_s)
    return middle - gap * e_s / (e_p + e_s) - COLD, HOT - middle - gap * e_p / (e_p + e_s)


@case(CASES, "heat-flux", GROUP)
def constant_flux() -> list[Row]:
    """Twin: 1 MW/m2 into the plate of 1.2379."""
    settings = _column_settings()
    exact = _half_space(FLUX, settings.plate)
    source = "half space: 2 q sqrt(t / pi) / effusivity"
    return [Row("plate after 1 s", "K", exact, source, _heated(FLUX, settings), 1.0)]


@case(CASES, "heat-flux-varying", GROUP)
def varying_flux() -> list[Row]:
    """Twin: 4 MW/m2 into a plate whose conductivity and heat capacity change alike with temperature."""
    # With k and c both proportional to 1 + b T the Kirchhoff transform T + b T^2 / 2 obeys the linear equation with the
    # diffusivity at 0 degC (Carslaw and Jaeger, section 1.6), so that its surface value is that of a half space with
    # constant data.
    plain = _column_settings().plate
    rows = []
    for slope in (-5e-4, 1e-3):
        pairs = [(T, 1.0 + slope * T) for T in (0.0, 1500.0)]
        body = ThermalBody(
            tuple((T, float(value_at(plain.conductivity, 0.0)) * v) for T, v in pairs),
            tuple((T, float(value_at(plain.capacity, 0.0)) * v) for T, v in pairs),
        )
        exact = (float(np.sqrt(1.0 + 2.0 * slope * _half_space(STRONG_FLUX, plain))) - 1.0) / slope
        quantity = f"plate after 1 s, k and c change by {100.0 * slope:+g} %/K"
        ours = _heated(STRONG_FLUX, replace(_column_settings(), plate=body, specimen=plain))
        rows.append(Row(quantity, "K", exact, "Kirchhoff transform, half space", ours, 1.0))
    return rows


def _half_space(flux: float, body: ThermalBody) -> float:
    """Return the rise of the surface of a half space after 1 s of a flux [K]."""
    return 2.0 * flux / body.effusivity() / float(np.sqrt(np.pi))


def _heated(flux: float, settings: ThermalSettings) -> float:
    """Return the surface temperature of the plate after 1 s of a flux, from 0 degC on."""
    contact = _column(replace(settings, heat_transfer=1e-9), 0.0, 0.0)
    for dt in np.diff(np.linspace(0.0, 1.0, 201) ** 2):
        contact.advance(float(dt), 0.0, 2.0 * flux * contact.area)
    return contact.contact.plate


def _column_settings() -> ThermalSettings:
    settings = ThermalSettings(cells=4, surface_layer=0.01, growth=1.15, depth=25.0)
    return settings.constant()


def _column(settings: ThermalSettings, plate: float, specimen: float) -> SlidingContact:
    """Return two bodies that touch everywhere: conduction in one dimension."""
    return SlidingContact(
        9.0,
        25.0,
        plate_temperature=plate,
        specimen_temperature=specimen,
        punch_temperature=specimen,
        settings=settings,
        band=True,
        margin=0.0,
    )
