"""Laws of sliding speed, of film numbers and of temperature."""

from __future__ import annotations

import numpy as np
from scipy.special import erf

from benchmarks.blind.campaign import Array, Campaign, Rng
from benchmarks.blind.law import law


@law("Hess & Soom 1990: Lorentzian Stribeck curve", "stribeck")
def stribeck_lorentz(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.025 / (1 + (c.load("v_rel") / 30) ** 2))


@law("Makkar, Dixon, Sawyer, Hu 2007: difference of hyperbolic tangents", "stribeck")
def stribeck_tanh(c: Campaign, mu0: Array, rng: Rng) -> Array:
    v = c.load("v_rel")
    return np.asarray(0.03 * (np.tanh(v / 0.5) - np.tanh(v / 60)))


@law("Armstrong-Helouvry 1994: straight fall of partial lubrication between two speeds", "stribeck")
def stribeck_ramp(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.025 * np.clip((120 - c.load("v_rel")) / 115, 0, 1))


@law("Prandtl-Tomlinson, Eyring: thermally activated slip, asinh", "rising_speed")
def eyring_asinh(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.006 * np.arcsinh(c.load("v_rel") / 8))


@law("Sang, Dube, Grant 2001: (ln v)^(2/3)", "rising_speed")
def slip_two_thirds(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.012 * np.log1p(c.load("v_rel") / 3) ** (2 / 3))


@law("Persson: contact ageing lost, saturating rise v/(v + v0)", "rising_speed")
def saturating_speed(c: Campaign, mu0: Array, rng: Rng) -> Array:
    v = c.load("v_rel")
    return np.asarray(0.03 * v / (v + 60))


@law("Schipper, ter Haar, Emmens: tanh of the logarithm of the lubrication number v/p", "hersey")
def lubrication_number(c: Campaign, mu0: Array, rng: Rng) -> Array:
    h = c.load("v_rel") / c.load("sigma_n") / 0.05
    return np.asarray(-0.02 * np.tanh(np.log(h) / 1.8))


@law("Johnson, Greenwood, Poon 1972 with Hamrock-Dowson film: load share of asperities", "hersey")
def load_share(c: Campaign, mu0: Array, rng: Rng) -> Array:
    film = (c.load("v_rel") / 60) ** 0.68 * (1000 / c.load("sigma_n")) ** 0.6
    return np.asarray(0.04 / (1 + 0.8 * film**1.5))


@law("Couette film, Vogel viscosity", "viscous")
def couette_vogel(c: Campaign, mu0: Array, rng: Rng) -> Array:
    eta = np.exp(700 / (c.load("T") + 110) - 700 / 130)
    return np.asarray(0.05 * c.load("v_rel") / 500 * eta)


@law("Couette film, Walther (ASTM D341) viscosity, shear thinning v^0.7", "viscous")
def couette_walther(c: Campaign, mu0: Array, rng: Rng) -> Array:
    log_log = 0.48 - 3.4 * np.log10((c.load("T") + 273.15) / 293.15)
    nu = 10 ** (10**log_log) - 0.7
    return np.asarray(0.05 * (c.load("v_rel") / 500) ** 0.7 * nu / (10 ** (10**0.48) - 0.7))


@law("Johnson & Cook 1983 softening of the shear strength of the film", "thermal_softening")
def johnson_cook(c: Campaign, mu0: Array, rng: Rng) -> Array:
    x = np.clip((c.load("T") - 20) / 430, 0, 1)
    return np.asarray(-0.05 * x**0.6)


@law("Wang: solid lubricant, power of the temperature, -0.403", "thermal_softening")
def log_log_temperature(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.045 * (np.maximum(c.load("T"), 10) / 20) ** -0.403)


@law("Shear strength of the film by Arrhenius: (exp(Q/RT))", "thermal_softening")
def arrhenius_film(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.035 * np.exp(1700 * (1 / (c.load("T") + 273.15) - 1 / 293.15)))


@law("Desorption over a band of chain lengths: error function of temperature", "thermal_breakdown")
def desorption_erf(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.022 * (1 + erf((c.load("T") - 195) / 40)))


@law("Soap melts from 150 degC on: straight rise to 250 degC", "thermal_breakdown")
def melting_ramp(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.04 * np.clip((c.load("T") - 150) / 100, 0, 1))


@law(
    "Kingsbury 1958, Beerbower: fractional film defect, desorption in the time of contact",
    "thermal_breakdown",
)
def film_defect(c: Campaign, mu0: Array, rng: Rng) -> Array:
    kelvin = c.load("T") + 273.15
    rate = 2e9 * np.sqrt(kelvin) / np.maximum(c.load("v_rel"), 1) ** 0.3 * np.exp(-11000 / kelvin)
    return np.asarray(0.06 * -np.expm1(-rate))


@law("Blok's critical temperature, lower at high pressure", "hot_pressure_breakdown", "thermal_breakdown")
def blok_pressure(c: Campaign, mu0: Array, rng: Rng) -> Array:
    critical = 260 - 95 * np.log(c.load("sigma_n") / 600)
    return np.asarray(
        0.05 * 0.5 * (1 + (c.load("T") - critical) / np.sqrt((c.load("T") - critical) ** 2 + 35**2))
    )


@law(
    "Bearing strength of the film falls straight to its melting point",
    "hot_pressure_breakdown",
    "thermal_breakdown",
)
def bearing_strength(c: Campaign, mu0: Array, rng: Rng) -> Array:
    strength = np.maximum(3600 * (1 - c.load("T") / 420), 150)
    return np.asarray(0.06 * np.clip(c.load("sigma_n") / strength - 0.55, 0, 0.9))


@law("Ashby, Abulawi, Kong 1991 flash temperature; straight loss of strength", "flash_temperature")
def flash_ashby(c: Campaign, mu0: Array, rng: Rng) -> Array:
    q = 0.06 * c.load("sigma_n") * c.load("v_rel")
    peclet = c.load("v_rel") * 1.0 / (2 * 11.4)
    rise = q * 1.0 / (42 * np.sqrt(1.273 + peclet)) * 0.5
    return np.asarray(-0.04 * rise / (rise + 400))


@law("Molinari, Estrin, Mercier 1999: exponential softening at the flash temperature", "flash_temperature")
def flash_molinari(c: Campaign, mu0: Array, rng: Rng) -> Array:
    work = c.load("sigma_n") / 1500 * np.sqrt(c.load("v_rel") / 100)
    return np.asarray(0.035 * np.exp(-0.7 * work))
