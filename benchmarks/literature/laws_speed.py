"""Laws of the sliding speed: falling (mixed to boundary) and rising."""

from __future__ import annotations

import numpy as np

from .law import Array, Law, Parameters, Point, Ranges, State, add

FALLING_TWINS = ("rate_state", "flash")
RISING = ("speed_log", "speed_power")


def _rational_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"vs": r.between_log("v", rng.uniform(0.35, 0.75)), "n": rng.uniform(1.2, 2.2)}


def _rational(x: Point, p: Parameters, s: State) -> Array:
    return 1.0 / (1.0 + (x.v / p["vs"]) ** p["n"])


add(
    Law(
        key="stribeck_rational",
        equation="1 / (1 + (v / vs)^n)",
        source="Hess and Soom 1990 (n = 2); general n: friction library jchristopherson/friction, README (opened)",
        accept=("stribeck",),
        twins=(*FALLING_TWINS, "hersey"),
        factors=("v",),
        draw=_rational_draw,
        shape=_rational,
    )
)


def _brown_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"vt": r.between_log("v", rng.uniform(0.45, 0.7)), "v0": r.low["v"]}


def _brown(x: Point, p: Parameters, s: State) -> Array:
    u = (x.v + p["vt"]) / p["vt"]  # only the falling branch right of the maximum at u = 1
    return u / (0.25 * u**2 + 0.75) ** 2


add(
    Law(
        key="stribeck_brown",
        equation="u / (u^2 / 4 + 3 / 4)^2, u = 1 + v / vt",
        source="Brown and McPhee 2016, falling branch (formula opened in a public script)",
        accept=("stribeck",),
        twins=(*FALLING_TWINS, "hersey"),
        factors=("v",),
        draw=_brown_draw,
        shape=_brown,
    )
)


def _lambda_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "v": r.between_log("v", rng.uniform(0.4, 0.7)),
        "T0": 20.0,
        "B": rng.uniform(400.0, 800.0),
        "p": r.between("sigma", 0.5),
        "m": rng.uniform(1.5, 2.5),
    }


def _lambda(x: Point, p: Parameters, s: State) -> Array:
    thin = np.exp(p["B"] / (np.maximum(x.T, 0.0) + 140.0) - p["B"] / (p["T0"] + 140.0))
    film = (thin * x.v / p["v"] * p["p"] / x.sigma) ** 0.67
    return (1.0 + film) ** -p["m"]


add(
    Law(
        key="lambda_sharing",
        equation="(1 + L)^-m, L = (eta(T) v / sigma)^0.67, eta after Vogel",
        source="Olver and Spikes 1998, load sharing by film ratio (from memory)",
        accept=("stribeck", "hersey"),
        twins=(*FALLING_TWINS, "viscous"),
        factors=("v", "T", "sigma"),
        draw=_lambda_draw,
        shape=_lambda,
        scale_free=False,
    )
)


def _eyring_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"v0": r.between_log("v", rng.uniform(-0.1, 0.35))}


def _eyring(x: Point, p: Parameters, s: State) -> Array:
    return np.arcsinh(x.v / p["v0"])


add(
    Law(
        key="rise_eyring",
        equation="asinh(v / v0)",
        source="Eyring 1936, stress-activated shear of the film (from memory)",
        accept=RISING,
        twins=("viscous", "hersey"),
        factors=("v",),
        draw=_eyring_draw,
        shape=_eyring,
    )
)


def _langmuir_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"vh": r.between_log("v", rng.uniform(0.4, 0.75))}


def _langmuir(x: Point, p: Parameters, s: State) -> Array:
    return x.v / (x.v + p["vh"])


add(
    Law(
        key="rise_rational",
        equation="v / (v + vh)",
        source="rational variant of the rising law of Constantinou et al. 1990 for polymer on steel (from memory)",
        accept=RISING,
        twins=("viscous", "hersey"),
        factors=("v",),
        draw=_langmuir_draw,
        shape=_langmuir,
    )
)


def _root_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"vh": r.between_log("v", rng.uniform(0.45, 0.8))}


def _root(x: Point, p: Parameters, s: State) -> Array:
    return x.v / np.hypot(x.v, p["vh"])


add(
    Law(
        key="rise_limiting_shear",
        equation="v / sqrt(v^2 + vh^2)",
        source="film with a limiting shear stress, Bair and Winer 1979 in a root form (from memory)",
        accept=RISING,
        twins=("viscous", "hersey"),
        factors=("v",),
        draw=_root_draw,
        shape=_root,
    )
)


def _vogel_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "B": rng.uniform(500.0, 900.0),
        "vc": r.between_log("v", rng.uniform(0.85, 1.1)),
        "n": rng.uniform(0.5, 0.8),
        "v": r.high["v"],
        "p": r.between("sigma", 0.5),
    }


def _vogel(x: Point, p: Parameters, s: State) -> Array:
    thin = np.exp(p["B"] / (np.maximum(x.T, 0.0) + 95.0) - p["B"] / 115.0)
    carreau = (1.0 + (x.v / p["vc"]) ** 2) ** (0.5 * (p["n"] - 1.0))
    return thin * carreau * x.v / p["v"] * p["p"] / x.sigma


add(
    Law(
        key="viscous_carreau",
        equation="eta v / sigma, eta = exp(B / (T + 95)) (1 + (v / vc)^2)^((n - 1) / 2)",
        source="Carreau 1972 with the Vogel law of viscosity (from memory)",
        accept=("viscous", "hersey"),
        twins=RISING,
        factors=("v", "T"),
        draw=_vogel_draw,
        shape=_vogel,
        scale_free=False,
    )
)


def _hersey_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "a": rng.uniform(0.012, 0.025),
        "m": rng.uniform(0.3, 0.6),
        "h": rng.uniform(0.02, 0.3),
        "v": r.high["v"],
        "p": r.low["sigma"],
    }


def _hersey(x: Point, p: Parameters, s: State) -> Array:
    # Reynolds (not Arrhenius or Vogel) law of viscosity; the number itself enters as a saturating power.
    number = np.exp(-p["a"] * (np.minimum(x.T, 400.0) - 20.0)) * x.v / p["v"] * p["p"] / x.sigma
    return (number + 1e-4) ** p["m"] / ((number + 1e-4) ** p["m"] + p["h"])


add(
    Law(
        key="hersey_saturating",
        equation="H^m / (H^m + h), H = exp(-a T) v / sigma",
        source="Hersey number with Reynolds viscosity, limiting shear stress as saturation (from memory)",
        accept=("hersey", "viscous"),
        twins=RISING,
        factors=("v", "T", "sigma"),
        draw=_hersey_draw,
        shape=_hersey,
        scale_free=False,
    )
)
