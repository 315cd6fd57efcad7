"""Laws that no entry of the catalogue describes."""

from __future__ import annotations

import numpy as np

from .law import Array, Law, Parameters, Point, Ranges, State, add


def _resonance_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"v": r.between_log("v", rng.uniform(0.6, 0.85)), "w": rng.uniform(0.2, 0.4)}


def _resonance(x: Point, p: Parameters, s: State) -> Array:
    return 1.0 / (1.0 + (np.log(np.maximum(x.v, 1e-6) / p["v"]) / p["w"]) ** 2)


add(
    Law(
        key="out_resonance",
        equation="Lorentz bump in ln v",
        source="friction near a resonance of the machine",
        accept=(),
        factors=("v",),
        draw=_resonance_draw,
        shape=_resonance,
    )
)


def _window_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    span = r.high["T"] - r.low["T"]
    return {"T": r.between("T", rng.uniform(0.3, 0.5)), "w": rng.uniform(0.06, 0.12) * span}


def _window(x: Point, p: Parameters, s: State) -> Array:
    return -np.exp(-0.5 * ((x.T - p["T"]) / p["w"]) ** 2)


add(
    Law(
        key="out_glaze_window",
        equation="Gauss dip in T",
        source="oxide glaze that only lubricates in a window",
        accept=(),
        factors=("T",),
        draw=_window_draw,
        shape=_window,
    )
)


def _waves_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"l": rng.uniform(0.18, 0.3) * r.high["sd"], "f": rng.uniform(0.0, 2.0 * np.pi)}


def _waves(x: Point, p: Parameters, s: State) -> Array:
    return np.sin(2.0 * np.pi * x.sd / p["l"] + p["f"])


add(
    Law(
        key="out_plate_waves",
        equation="sin(2 pi sd / l + f)",
        source="waviness of the plate, same on every plate",
        accept=(),
        within_only=True,
        draw=_waves_draw,
        shape=_waves,
    )
)


def _dip_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"s": rng.uniform(0.4, 0.6) * r.high["sd"], "w": rng.uniform(0.06, 0.12) * r.high["sd"]}


def _dip(x: Point, p: Parameters, s: State) -> Array:
    return -np.exp(-(np.abs((x.sd - p["s"]) / p["w"]) ** 3))


add(
    Law(
        key="out_reflow",
        equation="flat dip in sd",
        source="a stretch of the plate that still carries lubricant",
        accept=(),
        within_only=True,
        draw=_dip_draw,
        shape=_dip,
    )
)


def _bump_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"s": r.between("sigma", rng.uniform(0.45, 0.6)), "w": 0.25 * (r.high["sigma"] - r.low["sigma"])}


def _bump(x: Point, p: Parameters, s: State) -> Array:
    return np.maximum(1.0 - ((x.sigma - p["s"]) / p["w"]) ** 2, 0.0)


add(
    Law(
        key="out_pressure_bump",
        equation="parabola about a middle pressure",
        source="pockets that close, then leak",
        accept=(),
        factors=("sigma",),
        draw=_bump_draw,
        shape=_bump,
    )
)


def _saddle_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "psi": np.sqrt(r.low["psi"] * r.high["psi"]),
        "v": r.between_log("v", 0.6),
        "sign": float(rng.choice([-1.0, 1.0])),
    }


def _saddle(x: Point, p: Parameters, s: State) -> Array:
    return p["sign"] * np.log(x.psi / p["psi"]) * np.tanh(np.log(np.maximum(x.v, 1e-6) / p["v"]))


add(
    Law(
        key="out_saddle_psi_v",
        equation="ln(psi) tanh(ln v), centred",
        source="pure interaction, own",
        accept=(),
        factors=("psi", "v"),
        draw=_saddle_draw,
        shape=_saddle,
    )
)


def _pool_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"c": np.sqrt(r.between("sigma", 0.6) * r.between("psi", 0.6)), "w": rng.uniform(0.1, 0.2)}


def _pool(x: Point, p: Parameters, s: State) -> Array:
    # Even in the distance from a ridge sigma * psi = const: neither load alone shows it.
    ridge = np.log(np.sqrt(x.sigma * x.psi) / p["c"])
    return -np.exp(-np.abs(ridge) / p["w"])


add(
    Law(
        key="out_pool_ridge",
        equation="-exp(-|ln sqrt(sigma psi / c^2)| / w)",
        source="micro-pools that are squeezed out along a ridge, after Azushima (shape ours)",
        accept=(),
        factors=("sigma", "psi"),
        draw=_pool_draw,
        shape=_pool,
    )
)


def _twist_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "p": r.between("sigma", 0.5),
        "dp": 0.5 * (r.high["sigma"] - r.low["sigma"]),
        "psi": np.sqrt(r.low["psi"] * r.high["psi"]),
        "sign": float(rng.choice([-1.0, 1.0])),
    }


def _twist(x: Point, p: Parameters, s: State) -> Array:
    return p["sign"] * np.sin(np.pi * (x.sigma - p["p"]) / p["dp"] / 2.0) * np.sign(x.psi - p["psi"])


add(
    Law(
        key="out_twist_sigma_psi",
        equation="sin(sigma) sign(psi - psi0)",
        source="trend that turns over with psi, own",
        accept=(),
        factors=("sigma", "psi"),
        draw=_twist_draw,
        shape=_twist,
    )
)
