"""Laws of the contact temperature: softening and breakdown of the lubricant."""

from __future__ import annotations

import numpy as np

from .law import Array, Law, Parameters, Point, Ranges, State, add


def _cook_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"Tm": r.between("T", rng.uniform(0.55, 0.95)), "T0": r.low["T"], "m": rng.uniform(0.4, 0.65)}


def _cook(x: Point, p: Parameters, s: State) -> Array:
    share = np.clip((x.T - p["T0"]) / (p["Tm"] - p["T0"]), 0.0, 1.0)
    return 1.0 - share ** p["m"]


add(
    Law(
        key="softening_johnson_cook",
        equation="1 - ((T - T0) / (Tm - T0))^m, cut at 0 and 1",
        source="Johnson and Cook 1983, thermal term used for the film strength (from memory)",
        accept=("softening",),
        factors=("T",),
        draw=_cook_draw,
        shape=_cook,
    )
)


def _wlf_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "Tg": r.low["T"],
        "c2": rng.uniform(0.35, 0.8) * (r.high["T"] - r.low["T"]) * 0.4,
        "k": rng.uniform(1.5, 3.0),
    }


def _wlf(x: Point, p: Parameters, s: State) -> Array:
    above = np.maximum(x.T - p["Tg"], 0.0)
    return np.exp(-p["k"] * above / (p["c2"] + above))


add(
    Law(
        key="softening_wlf",
        equation="exp(-k (T - Tg) / (c2 + T - Tg))",
        source="Williams, Landel and Ferry 1955, polymer film above its glass point (from memory)",
        accept=("softening",),
        factors=("T",),
        draw=_wlf_draw,
        shape=_wlf,
    )
)


def _weibull_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "T0": r.low["T"],
        "Tb": r.between("T", rng.uniform(0.4, 0.6)) - r.low["T"],
        "n": rng.uniform(5.0, 9.0),
    }


def _weibull(x: Point, p: Parameters, s: State) -> Array:
    return 1.0 - np.exp(-((np.maximum(x.T - p["T0"], 0.0) / p["Tb"]) ** p["n"]))


add(
    Law(
        key="breakdown_weibull",
        equation="1 - exp(-((T - T0) / Tb)^n)",
        source="Weibull 1951, share of failed film sites (from memory)",
        accept=("breakdown",),
        twins=("breakdown_pt",),
        factors=("T",),
        draw=_weibull_draw,
        shape=_weibull,
    )
)


def _desorption_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    middle = r.between("T", rng.uniform(0.35, 0.6)) + 273.0
    return {"E": rng.uniform(9000.0, 15000.0) * middle / 600.0, "Tm": middle, "v": r.between_log("v", 0.6)}


def _desorption(x: Point, p: Parameters, s: State) -> Array:
    kelvin = np.maximum(x.T + 273.0, 250.0)
    # A site stays filled if the time to cross it is short against the residence time of a molecule.
    stay = np.exp(np.clip(p["E"] * (1.0 / kelvin - 1.0 / p["Tm"]), -40.0, 40.0))
    return 1.0 - np.exp(-((p["v"] / np.maximum(x.v, 1e-3)) ** 0.15) / stay)


add(
    Law(
        key="breakdown_desorption",
        equation="1 - exp(-(v0 / v)^0.15 exp(-E (1/T - 1/Tm)))",
        source="Kingsbury 1958, film defect by desorption, weak speed exponent (from memory)",
        accept=("breakdown",),
        twins=("breakdown_pt",),
        factors=("T", "v"),
        draw=_desorption_draw,
        shape=_desorption,
    )
)


def _product_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "T": r.between("T", rng.uniform(0.3, 0.5)),
        "p": r.between("sigma", rng.uniform(0.4, 0.65)),
        "k": rng.uniform(0.7, 1.2),
        "n": rng.uniform(3.0, 5.0),
    }


def _product(x: Point, p: Parameters, s: State) -> Array:
    index = (np.maximum(x.T, 1.0) / p["T"]) * (x.sigma / p["p"]) ** p["k"]
    return index ** p["n"] / (1.0 + index ** p["n"])


add(
    Law(
        key="breakdown_index",
        equation="I^n / (1 + I^n), I = (T / T0) (sigma / p0)^k",
        source="Hill function of a severity index, in the manner of pressure-temperature limits for forming lubricants",
        accept=("breakdown_pt",),
        twins=("breakdown",),
        factors=("T", "sigma"),
        draw=_product_draw,
        shape=_product,
    )
)


def _lowered_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    span = r.high["T"] - r.low["T"]
    return {
        "T": r.between("T", rng.uniform(0.55, 0.7)),
        "drop": rng.uniform(0.3, 0.5) * span,
        "p0": r.low["sigma"],
        "dp": r.high["sigma"] - r.low["sigma"],
        "w": rng.uniform(0.08, 0.15) * span,
    }


def _lowered(x: Point, p: Parameters, s: State) -> Array:
    limit = p["T"] - p["drop"] * np.clip((x.sigma - p["p0"]) / p["dp"], 0.0, 1.2)
    return np.clip((x.T - limit) / (2.0 * p["w"]) + 0.5, 0.0, 1.0)


add(
    Law(
        key="breakdown_lowered",
        equation="ramp of width 2 w about Tb(sigma), Tb falls linearly with sigma",
        source="film limit temperature lowered by pressure (ASTM style load-temperature maps; own ramp)",
        accept=("breakdown_pt",),
        twins=("breakdown",),
        factors=("T", "sigma"),
        draw=_lowered_draw,
        shape=_lowered,
    )
)
