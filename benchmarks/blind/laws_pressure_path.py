"""Laws of pressure, of surface expansion, and of what sliding does along the path."""

from __future__ import annotations

import numpy as np

from benchmarks.blind.campaign import Array, Campaign, Rng
from benchmarks.blind.law import law

FALLS_WITH_PRESSURE = "pressure_saturation pressure_power"


@law("Wanheim & Bay 1978, friction factor 0.35, Y = 600 MPa", FALLS_WITH_PRESSURE)
def wanheim_bay(c: Campaign, mu0: Array, rng: Rng) -> Array:
    f = 0.35
    root = np.sqrt(1 - f)
    limit = (1 + np.pi / 2 + np.arccos(f) + np.sqrt(1 - f * f)) / (np.sqrt(3) * (1 + root))
    tau_limit = 1 - root
    q = c.load("sigma_n") / 600
    late = f + (tau_limit - f) * np.exp((limit - q) * tau_limit / ((f - tau_limit) * limit))
    tau = np.where(q <= limit, tau_limit * q / limit, late)
    return np.asarray(tau / (q * np.sqrt(3)))


@law("Shaw, Ber, Mamin 1960: tau/k = tanh of the pressure", FALLS_WITH_PRESSURE)
def shaw_tanh(c: Campaign, mu0: Array, rng: Rng) -> Array:
    q = c.load("sigma_n") / 1100
    return np.asarray(0.055 * np.tanh(q) / q)


@law("Orowan 1943: Coulomb up to the shear strength of the layer", FALLS_WITH_PRESSURE)
def orowan_cap(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.06 * np.minimum(1, 1200 / c.load("sigma_n")))


@law("Hertzian asperities (Archard 1957): mu ~ p^(-1/3)", FALLS_WITH_PRESSURE)
def hertz_third(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.06 * (500 / c.load("sigma_n")) ** (1 / 3))


@law("Briscoe & Tabor 1978: shear strength tau0 + alpha p of thin films", FALLS_WITH_PRESSURE)
def briscoe(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(14 / c.load("sigma_n"))


@law("Fresh surface dA - dA0 without film: 1 - 1/psi", "surface_expansion")
def fresh_surface(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.035 * (1 - 1 / c.load("psi")))


@law("Film torn at a critical expansion, logistic in ln psi (Bay: threshold expansion)", "surface_expansion")
def torn_film(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.04 / (1 + (6 / c.load("psi")) ** 3))


@law("Film thickness h0/psi against roughness, Gaussian heights (Patir-Cheng)", "surface_expansion")
def film_over_roughness(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.04 * np.exp(-((4 / c.load("psi")) ** 2) / 2))


@law("Running-in with two lengths (Blau's composite curves)", "running_in")
def running_in_double(c: Campaign, mu0: Array, rng: Rng) -> Array:
    sd = c.load("sd")
    return np.asarray(0.012 * np.exp(-sd / 1.5) + 0.014 * np.exp(-sd / 9))


@law("Hyperbolic running-in", "running_in")
def running_in_hyperbolic(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.025 / (1 + c.load("sd") / 3))


@law(
    "Contamination layer rubbed off: friction rises to its level, sigmoid over 2 mm (Blau type b)",
    "running_in",
)
def running_in_rising(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(-0.03 / (1 + np.exp((c.load("sd") - 3) / 1.4)))


@law("A tribofilm grows: first-order growth over the distance", "running_in")
def tribofilm(c: Campaign, mu0: Array, rng: Rng) -> Array:
    sd = c.load("sd")
    return np.asarray(-0.022 * sd / (sd + 6))


@law("Breakaway: half a Gaussian over 0.35 mm", "static_peak")
def breakaway(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.05 * np.exp(-((c.load("sd") / 0.45) ** 2)))


@law("Bristles release on 0.6 mm: straight fall (Dahl)", "static_peak")
def bristles(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.045 * np.clip(1 - c.load("sd") / 0.6, 0, 1))


@law("Archard wear of a film of finite thickness: friction rises straight from 22 mm on", "wear_out")
def worn_through(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.03 * np.clip((c.load("sd") - 22) / 30, 0, None))


@law("Weibull life of film spots over the distance", "wear_out")
def weibull_film(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.05 * -np.expm1(-((c.load("sd") / 55) ** 2.6)))


def _work(c: Campaign, mu0: Array) -> Array:
    """Friction work per area [J/mm2] with the friction without the law."""
    out = np.empty(len(mu0))
    sd, p = c.load("sd"), c.load("sigma_n")
    for rows in c.slices():
        out[rows] = np.cumsum(mu0[rows] * p[rows] * np.diff(sd[rows], prepend=0.0)) / 1000
    return out


@law(
    "Energy of the film used up (Huq & Celis 2002): rise beyond a work, tends to bare metal",
    "work_exhaustion",
)
def energy_budget(c: Campaign, mu0: Array, rng: Rng) -> Array:
    over = np.clip(_work(c, mu0) - 2.0, 0, None)
    return np.asarray(0.06 * over / (over + 4.0))


@law("Kinetics of decay with friction work, Avrami exponent 2", "work_exhaustion")
def avrami_work(c: Campaign, mu0: Array, rng: Rng) -> Array:
    return np.asarray(0.06 * -np.expm1(-((_work(c, mu0) / 6.0) ** 2)))


def after_step(c: Campaign) -> tuple[Array, Array]:
    """Distance since the last change of speed, and the logarithm of that change."""
    since, jump = np.zeros(len(c.points)), np.zeros(len(c.points))
    sd, v = c.load("sd"), c.load("v_rel")
    for rows in c.slices():
        last, size = -1e9, 0.0
        for i in range(rows.start + 1, rows.stop):
            if abs(np.log(v[i] / v[i - 1])) > 0.1:
                last, size = sd[i], float(np.log(v[i] / v[i - 1]))
            since[i], jump[i] = sd[i] - last, size
    return since, jump


@law("Ruina 1983 slip law in its steady form between steps of speed", "rate_state")
def slip_steps(c: Campaign, mu0: Array, rng: Rng) -> Array:
    since, jump = after_step(c)
    return np.asarray(
        -0.004 * np.log(c.load("v_rel") / 50) + 0.012 * jump * np.exp(-np.clip(since, 0, 100) / 1.2)
    )


@law("Two state variables (Gu, Rice, Ruina, Tse 1984)", "rate_state")
def two_states(c: Campaign, mu0: Array, rng: Rng) -> Array:
    since, jump = after_step(c)
    s = np.clip(since, 0, 100)
    return np.asarray(
        -0.003 * np.log(c.load("v_rel") / 50) + jump * (0.008 * np.exp(-s / 0.7) + 0.006 * np.exp(-s / 3.5))
    )
