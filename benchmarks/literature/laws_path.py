"""Laws of the sliding path: first millimetres, wear of the film, spent friction work."""

from __future__ import annotations

import numpy as np

from .law import Array, Law, Parameters, Point, Ranges, State, add


def _decay_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"s": rng.uniform(0.03, 0.09) * r.high["sd"], "n": rng.uniform(1.5, 3.0)}


def _running(x: Point, p: Parameters, s: State) -> Array:
    return (1.0 + x.sd / p["s"]) ** -p["n"]


add(
    Law(
        key="running_in_power",
        equation="(1 + sd / s)^-n",
        source="algebraic wear-down of asperities, Queener et al. 1965 in another form (from memory)",
        accept=("running_in",),
        twins=("static_peak",),
        within_only=True,
        draw=_decay_draw,
        shape=_running,
    )
)


def _lubricant_supply(x: Point, p: Parameters, s: State) -> Array:
    return -1.0 / (1.0 + (x.sd / (1.2 * p["s"])) ** p["n"])


add(
    Law(
        key="running_in_rise",
        equation="-1 / (1 + (sd / s)^n)",
        source="rise at the start while a supply of lubricant is used up, after Blau 1989 (shape ours)",
        accept=("running_in",),
        within_only=True,
        draw=_decay_draw,
        shape=_lubricant_supply,
    )
)


def _peak_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {
        "s": rng.uniform(0.006, 0.014) * r.high["sd"],
        "c": rng.uniform(0.1, 0.4),
        "n": rng.uniform(0.3, 0.6),
    }


def _peak(x: Point, p: Parameters, s: State) -> Array:
    rest = 1.0 - np.exp(-p["c"] * np.asarray(x.meta["t_wait"], float) ** p["n"])
    return rest / (1.0 + (x.sd / p["s"]) ** 2)


add(
    Law(
        key="static_peak_kato",
        equation="(1 - exp(-c t_wait^n)) / (1 + (sd / s)^2)",
        source="Kato, Sato and Matsubayashi 1972, growth with rest time (from memory)",
        accept=("static_peak",),
        twins=("running_in",),
        within_only=True,
        draw=_peak_draw,
        shape=_peak,
    )
)


def _onset_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"s": rng.uniform(0.45, 0.7) * r.high["sd"], "w": rng.uniform(0.04, 0.1) * r.high["sd"]}


def _onset(x: Point, p: Parameters, s: State) -> Array:
    return np.logaddexp(0.0, (x.sd - p["s"]) / p["w"])


add(
    Law(
        key="wear_onset",
        equation="ln(1 + exp((sd - s) / w))",
        source="galling distance followed by a steady rise, strip reduction tests (shape ours)",
        accept=("wear_out",),
        twins=("work",),
        within_only=True,
        draw=_onset_draw,
        shape=_onset,
    )
)


def _step(x: Point, p: Parameters, s: State) -> Array:
    return 0.5 + np.arctan((x.sd - p["s"]) / p["w"]) / np.pi


add(
    Law(
        key="wear_step",
        equation="1/2 + atan((sd - s) / w) / pi",
        source="worn share of a film of uneven thickness, Cauchy distributed (own variant)",
        accept=("wear_out",),
        twins=("work",),
        within_only=True,
        draw=_onset_draw,
        shape=_step,
    )
)


def _work_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    typical = r.between("mu", 0.5) * r.between("sigma", 0.5) * r.high["sd"]
    return {"W": rng.uniform(0.4, 0.8) * typical, "n": rng.uniform(2.0, 4.0)}


def _work(x: Point, p: Parameters, s: State) -> Array:
    s["W"] = s.get("W", np.zeros_like(x.sd)) + np.maximum(x.mu, 0.0) * x.sigma * x.dsd
    load = (s["W"] / p["W"]) ** p["n"]
    return load / (1.0 + load)


add(
    Law(
        key="work_hill",
        equation="W^n / (W^n + Wc^n), W = integral of mu sigma dsd",
        source="energy limit of a coating, Fouvry et al. 2003 in the manner of a Hill curve (from memory)",
        accept=("work",),
        twins=("wear_out",),
        factors=("sigma",),
        draw=_work_draw,
        shape=_work,
    )
)


def _spread_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    typical = r.between("mu", 0.5) * r.between("sigma", 0.5) * r.high["sd"]
    return {"W": rng.uniform(0.08, 0.15) * typical, "c0": rng.uniform(0.01, 0.05)}


def _spread(x: Point, p: Parameters, s: State) -> Array:
    bare = s.get("bare", np.full_like(x.sd, p["c0"]))
    work = np.maximum(x.mu, 0.0) * x.sigma * x.dsd / p["W"]
    # Exact step of dc/dW = c (1 - c): bare patches grow at their edges.
    grown = bare * np.exp(np.minimum(work, 30.0))
    s["bare"] = grown / (1.0 - bare + grown)
    return s["bare"]


add(
    Law(
        key="work_spreading",
        equation="dc/dW = c (1 - c) / Wc",
        source="autocatalytic growth of bare patches with friction work (own variant of film exhaustion)",
        accept=("work",),
        twins=("wear_out",),
        factors=("sigma",),
        draw=_spread_draw,
        shape=_spread,
    )
)
