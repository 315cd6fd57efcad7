"""Laws with local heat or with memory of the contact."""

from __future__ import annotations

import numpy as np

from .law import Array, Law, Parameters, Point, Ranges, State, add


def _flash_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    typical = r.between("mu", 0.5) * r.between("sigma", 0.6) * np.sqrt(r.between("v", 0.4))
    return {"q": rng.uniform(0.15, 0.5) * typical, "n": rng.uniform(0.9, 1.4)}


def _flash(x: Point, p: Parameters, s: State) -> Array:
    local = np.maximum(x.mu, 0.0) * x.sigma * np.sqrt(x.v)
    return 1.0 / (1.0 + (local / p["q"]) ** p["n"])


add(
    Law(
        key="flash_molinari",
        equation="1 / (1 + (mu sigma sqrt(v) / q)^n)",
        source="Molinari, Estrin and Mercier 1999, softening of hot junctions (from memory)",
        accept=("flash",),
        twins=("stribeck", "rate_state"),
        factors=("v", "sigma"),
        draw=_flash_draw,
        shape=_flash,
    )
)


def _weak_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    typical = (r.between("mu", 0.5) * r.between("sigma", 0.5)) ** 2 * r.between("v", 0.3)
    return {"q": rng.uniform(0.04, 0.2) * typical}


def _weak(x: Point, p: Parameters, s: State) -> Array:
    tau = np.maximum(x.mu, 1e-3) * x.sigma
    return 1.0 / np.maximum(x.v * tau**2 / p["q"], 1.0)


add(
    Law(
        key="flash_rice",
        equation="min(1, vw / v), vw = q / (mu sigma)^2",
        source="Rice 2006, flash weakening, with the weakening speed from the mean shear stress (from memory)",
        accept=("flash",),
        twins=("stribeck", "rate_state"),
        factors=("v", "sigma"),
        draw=_weak_draw,
        shape=_weak,
    )
)


def _prz_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "L": rng.uniform(0.02, 0.08) * r.high["sd"],
        "v0": r.between_log("v", 0.5),
        "a": rng.uniform(0.2, 0.6),
    }


def _prz(x: Point, p: Parameters, s: State) -> Array:
    # d theta / dt = 1 - (v theta / 2 L)^2 has the exact step tanh / coth about its steady value 2 L / v.
    steady = 2.0 * p["L"] / np.maximum(x.v, 1e-6)
    theta = s.get("theta", np.asarray(x.meta["t_wait"], float).copy())
    u = theta / steady
    pace = np.tanh(np.minimum(x.dt / steady, 20.0))
    s["theta"] = steady * (u + pace) / (1.0 + u * pace)
    age = np.log(s["theta"] * p["v0"] / (2.0 * p["L"]))
    return age + p["a"] * np.log(np.maximum(x.v, 1e-6) / p["v0"])


add(
    Law(
        key="rate_state_prz",
        equation="a ln(v / v0) + ln(v0 theta / 2 L), d theta / dt = 1 - (v theta / 2 L)^2",
        source="Perrin, Rice and Zheng 1995 (from memory); starts from the rest time",
        accept=("rate_state",),
        twins=("stribeck", "flash", "static_peak", "running_in"),
        factors=("v",),
        draw=_prz_draw,
        shape=_prz,
    )
)


def _lag_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "D": rng.uniform(0.05, 0.12) * r.high["sd"],
        "vs": r.between_log("v", rng.uniform(0.4, 0.65)),
        "q": rng.uniform(1.0, 1.6),
    }


def _lag(x: Point, p: Parameters, s: State) -> Array:
    target = 1.0 / (1.0 + (x.v / p["vs"]) ** p["q"])
    held = s.get("held", np.ones_like(x.v))
    s["held"] = target + (held - target) * np.exp(-x.dsd / p["D"])
    return s["held"]


add(
    Law(
        key="memory_distance",
        equation="dm/dsd = (g(v) - m) / D, g = 1 / (1 + (v / vs)^q)",
        source="contact renewal over a distance, Rabinowicz 1958 (from memory), first order in sd",
        accept=("rate_state", "stribeck"),
        twins=("flash", "running_in", "static_peak"),
        factors=("v",),
        draw=_lag_draw,
        shape=_lag,
    )
)
