"""Load ranges of a kind of test: cold forging, and foreign tribometers."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Domain:
    """Levels of the set points and typical sizes of a kind of test.

    Attributes
    ----------
    name : str
        Name of the domain.
    v, T, sigma, psi : tuple of float
        Three levels each: speed [mm/s], tool temperature [degC], pressure [MPa], surface expansion [-].
    sd_max : float
        Sliding distance of a test [mm].
    mu : tuple of float
        Range of the mean friction coefficient.
    size : float
        Factor on all friction effects and scatters against cold forging.
    acceleration : tuple of float
        Range of the acceleration of the drive [mm/s2].
    heat : float
        Share of the friction heat that reaches the surfaces.
    """

    name: str
    v: tuple[float, float, float]
    T: tuple[float, float, float]
    sigma: tuple[float, float, float]
    psi: tuple[float, float, float]
    sd_max: float
    mu: tuple[float, float]
    size: float
    acceleration: tuple[float, float]
    heat: float


FORGING = Domain(
    "sliding_compression",
    (5.0, 200.0, 500.0),
    (20.0, 100.0, 300.0),
    (500.0, 1750.0, 2750.0),
    (1.069, 5.0, 20.0),
    55.0,
    (0.06, 0.11),
    1.0,
    (4000.0, 15000.0),
    0.22,
)
STRIP = Domain(
    "strip_drawing",
    (1.0, 20.0, 100.0),
    (20.0, 50.0, 80.0),
    (2.0, 8.0, 20.0),
    (1.0, 1.05, 1.15),
    200.0,
    (0.08, 0.16),
    1.5,
    (200.0, 1000.0),
    0.5,
)
PIN_ON_DISC = Domain(
    "pin_on_disc",
    (20.0, 150.0, 600.0),
    (25.0, 60.0, 120.0),
    (0.5, 1.5, 4.0),
    (1.0, 1.0, 1.0),
    50000.0,
    (0.35, 0.6),
    6.0,
    (200.0, 500.0),
    0.5,
)
ROCK = Domain(
    "rock_shear",
    (0.0002, 0.002, 0.02),
    (22.0, 23.0, 24.0),
    (10.0, 30.0, 60.0),
    (1.0, 1.0, 1.0),
    10.0,
    (0.5, 0.7),
    4.0,
    (0.0005, 0.002),
    0.5,
)
HOT_STRIP = Domain(
    "hot_strip",
    (10.0, 60.0, 150.0),
    (500.0, 600.0, 700.0),
    (5.0, 10.0, 20.0),
    (1.0, 1.1, 1.25),
    120.0,
    (0.3, 0.5),
    4.0,
    (500.0, 2000.0),
    0.5,
)

DOMAINS: dict[str, Domain] = {d.name: d for d in (FORGING, STRIP, PIN_ON_DISC, ROCK, HOT_STRIP)}
