"""Laws from physics that no entry of the catalogue describes; written without a look at the grammar of the terms."""

from __future__ import annotations

import numpy as np

from ..literature.law import Array, Draw, Law, Parameters, Point, Ranges, Shape, State

KELVIN = 273.15
#: All laws by key, in the order in which they were written.
LAWS: dict[str, Law] = {}


def _add(key: str, equation: str, source: str, factors: tuple[str, ...], draw: Draw, shape: Shape) -> None:
    LAWS[key] = Law(key, equation, source, (), draw, shape, factors=factors, within_only=not factors)


def _log_speed(x: Point, v: float) -> Array:
    return np.log(np.maximum(x.v, 1e-6) / v)


def _hump_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "v": r.between_log("v", rng.uniform(0.2, 0.35)),
        "u": r.between_log("v", rng.uniform(0.7, 0.85)),
        "h": rng.uniform(0.5, 1.0),
    }


def _hump(x: Point, p: Parameters, s: State) -> Array:
    falling = 1.0 / (1.0 + (x.v / p["v"]) ** 1.5)
    return falling + p["h"] * np.exp(-((_log_speed(x, p["u"]) / 0.35) ** 2))


_add(
    "second_hump",
    "1/(1 + (v/vs)^1.5) + h exp(-(ln(v/u)/0.35)^2)",
    "Stribeck curve with a second hump where a texture resonates or an additive desorbs",
    ("v",),
    _hump_draw,
    _hump,
)


def _solid_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "p": r.between("sigma", rng.uniform(0.35, 0.5)),
        "T": r.between("T", 0.5),
        "b": rng.uniform(0.4, 1.0) * (r.high["sigma"] - r.low["sigma"]) / (r.high["T"] - r.low["T"]),
        "w": rng.uniform(0.05, 0.12) * r.high["sigma"],
    }


def _solid(x: Point, p: Parameters, s: State) -> Array:
    return 1.0 / (1.0 + np.exp(-(x.sigma - p["p"] - p["b"] * (x.T - p["T"])) / p["w"]))


_add(
    "solidification",
    "1/(1 + exp(-(p - p0 - b (T - T0))/w))",
    "glass transition of a lubricant: the pressure of solidification rises with temperature (Alsaad, Bair, Winer 1978)",
    ("sigma", "T"),
    _solid_draw,
    _solid,
)


def _coverage_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "E": rng.uniform(2500.0, 5000.0),
        "T": r.between("T", rng.uniform(0.35, 0.6)),
        "v": r.between_log("v", 0.6),
        "m": rng.uniform(0.5, 1.0),
    }


def _coverage(x: Point, p: Parameters, s: State) -> Array:
    grows = np.exp(-p["E"] * (1.0 / (x.T + KELVIN) - 1.0 / (p["T"] + KELVIN)))
    goes = (np.maximum(x.v, 1e-6) / p["v"]) ** p["m"]
    return -grows / (grows + goes)


_add(
    "arrhenius_crossing",
    "-k/(k + (v/v0)^m), k = exp(-E (1/T - 1/T0))",
    "reaction film that grows by Arrhenius and is worn off by sliding",
    ("T", "v"),
    _coverage_draw,
    _coverage,
)


def _squeeze_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "t": rng.uniform(0.02, 0.2) * r.high["sd"] / r.between_log("v", 0.6),
        "s": r.between("sigma", 0.5),
    }


def _squeeze(x: Point, p: Parameters, s: State) -> Array:
    return 1.0 - 1.0 / np.sqrt(1.0 + x.t * x.sigma / (p["t"] * p["s"]))


_add(
    "squeeze_film",
    "1 - 1/sqrt(1 + t p/(t0 p0))",
    "squeeze film between plates, Stefan 1874: h falls with the root of time times pressure",
    ("sigma", "v"),
    _squeeze_draw,
    _squeeze,
)


def _oxide_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"E": rng.uniform(2000.0, 4000.0), "T": r.between("T", 0.6), "c": rng.uniform(0.3, 1.0)}


def _oxide(x: Point, p: Parameters, s: State) -> Array:
    rate = np.exp(-p["E"] * (1.0 / (x.T + KELVIN) - 1.0 / (p["T"] + KELVIN)))
    s["x"] = s.get("x", np.zeros_like(x.T)) + x.dt * rate
    return -np.tanh(np.sqrt(s["x"]) / p["c"])


_add(
    "oxidation",
    "-tanh(sqrt(integral exp(-E (1/T - 1/T0)) dt)/c)",
    "parabolic growth of an oxide, Wagner 1933, that lubricates",
    ("T", "v"),
    _oxide_draw,
    _oxide,
)


def _regimes_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "s": r.between("sigma", 0.5),
        "ds": r.high["sigma"] - r.low["sigma"],
        "T": r.between("T", 0.5),
        "dT": r.high["T"] - r.low["T"],
        "w": rng.uniform(0.05, 0.15),
    }


def _regimes(x: Point, p: Parameters, s: State) -> Array:
    one, two = (x.sigma - p["s"]) / p["ds"], -(x.T - p["T"]) / p["dT"]
    return p["w"] * np.logaddexp(one / p["w"], two / p["w"])


_add(
    "two_regimes",
    "w ln(exp(a/w) + exp(b/w)), a linear in p, b linear in T",
    "the larger of two mechanisms, joined smoothly",
    ("sigma", "T"),
    _regimes_draw,
    _regimes,
)


def _chatter_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"l": rng.uniform(0.1, 0.25) * r.high["sd"], "d": rng.uniform(0.3, 1.0) * r.high["sd"]}


def _chatter(x: Point, p: Parameters, s: State) -> Array:
    return np.cos(2.0 * np.pi * x.sd / p["l"]) * np.exp(-x.sd / p["d"])


_add(
    "fading_waves",
    "cos(2 pi sd/l) exp(-sd/d)",
    "turning marks of the plate, which the specimen wears level",
    (),
    _chatter_draw,
    _chatter,
)


def _relax_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"d": rng.uniform(0.05, 0.3) * r.high["sd"], "v": r.between_log("v", 0.5)}


def _relax(x: Point, p: Parameters, s: State) -> Array:
    target = np.tanh(_log_speed(x, p["v"]))
    s["x"] = target + (s.get("x", np.zeros_like(x.v)) - target) * np.exp(-x.dsd / p["d"])
    return s["x"]


_add(
    "relaxation",
    "x' = (tanh(ln(v/v0)) - x)/d over distance",
    "third body that adapts to the speed over a distance",
    ("v",),
    _relax_draw,
    _relax,
)


def _instable_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "v": r.between_log("v", rng.uniform(0.4, 0.6)),
        "s": r.between("sigma", rng.uniform(0.4, 0.6)),
        "w": 0.08 * r.high["sigma"],
    }


def _instable(x: Point, p: Parameters, s: State) -> Array:
    slow = 1.0 / (1.0 + (x.v / p["v"]) ** 2)
    return slow / (1.0 + np.exp(-(x.sigma - p["s"]) / p["w"]))


_add(
    "stick_slip_corner",
    "1/(1 + (v/v0)^2)/(1 + exp(-(p - p0)/w))",
    "stick-slip where sliding is slow and pressure is high",
    ("v", "sigma"),
    _instable_draw,
    _instable,
)


def _shift_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    span = r.high["T"] - r.low["T"]
    return {
        "T": r.between("T", rng.uniform(0.4, 0.55)),
        "w": rng.uniform(0.1, 0.18) * span,
        "k": rng.uniform(0.03, 0.08) * span,
        "v": r.between_log("v", 0.6),
    }


def _shift(x: Point, p: Parameters, s: State) -> Array:
    return np.exp(-(((x.T - p["T"] - p["k"] * _log_speed(x, p["v"])) / p["w"]) ** 2))


_add(
    "moving_peak",
    "exp(-((T - T0 - k ln(v/v0))/w)^2)",
    "loss peak of a polymer: speed and temperature are equivalent (Williams, Landel, Ferry 1955; Grosch 1963)",
    ("T", "v"),
    _shift_draw,
    _shift,
)


def _starved_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"c": rng.uniform(0.3, 0.8) * r.high["sd"] * np.log(r.between("psi", 0.5))}


def _starved(x: Point, p: Parameters, s: State) -> Array:
    return 1.0 - np.exp(-((x.sd * np.log(np.maximum(x.psi, 1.0)) / p["c"]) ** 2))


_add(
    "starvation",
    "1 - exp(-(sd ln(psi)/c)^2)",
    "lubricant spread over new surface runs out",
    ("psi",),
    _starved_draw,
    _starved,
)


def _third_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"w": rng.uniform(0.15, 0.4) * r.high["sd"] * r.between("sigma", 0.6)}


def _third(x: Point, p: Parameters, s: State) -> Array:
    s["w"] = s.get("w", np.zeros_like(x.sd)) + x.sigma * x.dsd
    share = s["w"] / p["w"]
    return share * np.exp(1.0 - share)


_add(
    "third_body",
    "W/W0 exp(1 - W/W0), W = integral p dsd",
    "wear particles collect, then are carried out (Godet 1984)",
    ("sigma",),
    _third_draw,
    _third,
)


def _ageing_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"t": rng.uniform(0.05, 0.5), "T": r.between("T", 0.5), "b": rng.uniform(0.3, 1.0)}


def _ageing(x: Point, p: Parameters, s: State) -> Array:
    return np.log1p(x.t / p["t"]) * (1.0 + p["b"] * np.tanh((x.T - p["T"]) / 60.0))


_add(
    "creep_in_time",
    "ln(1 + t/t0) (1 + b tanh((T - T0)/60))",
    "contacts grow by creep, faster where hot (Dieterich and Kilgore 1994)",
    ("v", "T"),
    _ageing_draw,
    _ageing,
)


def _rough_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "e": rng.uniform(0.25, 0.5) * np.log(r.high["psi"]),
        "s": r.between("sigma", rng.uniform(0.3, 0.6)),
    }


def _rough(x: Point, p: Parameters, s: State) -> Array:
    strain = np.log(np.maximum(x.psi, 1.0))
    return np.maximum(strain - p["e"], 0.0) / (1.0 + (x.sigma / p["s"]) ** 2)


_add(
    "free_roughening",
    "max(ln psi - e, 0)/(1 + (p/p0)^2)",
    "grains roughen the new surface where pressure does not iron it",
    ("psi", "sigma"),
    _rough_draw,
    _rough,
)


def _melt_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    typical = r.between("sigma", 0.6) * np.sqrt(r.between("v", 0.5))
    span = r.high["T"] - r.low["T"]
    return {
        "k": rng.uniform(0.5, 1.0) * span / typical,
        "T": r.between("T", 0.5) + rng.uniform(0.3, 0.6) * span,
        "w": rng.uniform(0.05, 0.1) * span,
    }


def _melt(x: Point, p: Parameters, s: State) -> Array:
    return -0.5 * (1.0 + np.tanh((x.T + p["k"] * x.sigma * np.sqrt(x.v) - p["T"]) / p["w"]))


_add(
    "melting_contacts",
    "-(1 + tanh((T + k p sqrt(v) - Tm)/w))/2",
    "contact temperature reaches the melting point of the soap (Archard 1959)",
    ("T", "sigma", "v"),
    _melt_draw,
    _melt,
)


def _power_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"q": rng.uniform(0.25, 0.6) * r.between("sigma", 0.6) * r.between("v", 0.6)}


def _power(x: Point, p: Parameters, s: State) -> Array:
    load = x.sigma * x.v / p["q"]
    return load**3 / (1.0 + load**3)


_add(
    "power_limit",
    "x^3/(1 + x^3), x = p v/q",
    "limit of the p v product of dry bearings",
    ("sigma", "v"),
    _power_draw,
    _power,
)


def _viscoelastic_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "v": r.between_log("v", rng.uniform(0.45, 0.65)),
        "E": rng.uniform(1500.0, 3000.0),
        "T": r.between("T", 0.4),
        "s": r.between("sigma", 0.5),
    }


def _viscoelastic(x: Point, p: Parameters, s: State) -> Array:
    rate = x.v / p["v"] * np.exp(-p["E"] * (1.0 / (p["T"] + KELVIN) - 1.0 / (x.T + KELVIN)))
    return 2.0 * rate / (1.0 + rate**2) * np.sqrt(x.sigma / p["s"])


_add(
    "hysteresis_loss",
    "2 w/(1 + w^2) sqrt(p/p0), w = v/v0 exp(...1/T)",
    "hysteresis of a Maxwell body under moving asperities, Greenwood and Tabor 1958",
    ("v", "T", "sigma"),
    _viscoelastic_draw,
    _viscoelastic,
)


def _roughness_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"s": r.between("sigma", rng.uniform(0.35, 0.6))}


def _roughness(x: Point, p: Parameters, s: State) -> Array:
    tool = np.asarray(x.meta["Ra"], float) / 0.06
    return tool / (1.0 + (x.sigma / p["s"]) ** 3)


_add(
    "tool_by_pressure",
    "Ra/(1 + (p/p0)^3)",
    "a rough tool ploughs until pressure fills its valleys",
    ("sigma",),
    _roughness_draw,
    _roughness,
)


def _film_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"c": rng.uniform(0.1, 0.3) * r.high["sd"]}


def _film(x: Point, p: Parameters, s: State) -> Array:
    life = p["c"] * np.asarray(x.meta["film_weight"], float) / 4.0
    return 1.0 / (1.0 + np.exp(-(x.sd - life) / (0.15 * life)))


_add(
    "film_life",
    "1/(1 + exp(-(sd - L)/(0.15 L))), L = c m",
    "the life of a coating is in proportion to its weight",
    (),
    _film_draw,
    _film,
)


def _phases_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"l": rng.uniform(0.4, 0.7) * (r.high["T"] - r.low["T"]), "f": rng.uniform(0.0, 6.28)}


def _phases(x: Point, p: Parameters, s: State) -> Array:
    return np.sin(2.0 * np.pi * x.T / p["l"] + p["f"]) * np.exp(-x.T / 400.0)


_add(
    "several_peaks",
    "sin(2 pi T/l + f) exp(-T/400)",
    "loss peaks of a blend one after the other",
    ("T",),
    _phases_draw,
    _phases,
)
