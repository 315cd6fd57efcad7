"""Laws of pressure and of surface expansion."""

from __future__ import annotations

import numpy as np

from .law import Array, Law, Parameters, Point, Ranges, State, add

PRESSURE_TWINS = ("p_power", "p_saturation", "force_zero")


def _limit_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"s": r.between("sigma", rng.uniform(0.12, 0.35)), "n": rng.uniform(1.5, 3.0)}


def _tanh(x: Point, p: Parameters, s: State) -> Array:
    return np.tanh(x.sigma / p["s"]) * p["s"] / x.sigma


add(
    Law(
        key="pressure_tanh",
        equation="tanh(sigma / s) s / sigma",
        source="smooth shear limit as used in bulk forming codes (from memory)",
        accept=("p_saturation",),
        twins=PRESSURE_TWINS,
        factors=("sigma",),
        draw=_limit_draw,
        shape=_tanh,
    )
)


def _root(x: Point, p: Parameters, s: State) -> Array:
    return (1.0 + (x.sigma / p["s"]) ** p["n"]) ** (-1.0 / p["n"])


add(
    Law(
        key="pressure_root",
        equation="(1 + (sigma / s)^n)^(-1 / n)",
        source="Shaw, Ber and Mamin 1960: Coulomb and shear limit joined by a root (from memory)",
        accept=("p_saturation",),
        twins=PRESSURE_TWINS,
        factors=("sigma",),
        draw=_limit_draw,
        shape=_root,
    )
)


def _pockets_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"s": r.between("sigma", rng.uniform(0.3, 0.55)), "n": rng.uniform(1.4, 2.2)}


def _pockets(x: Point, p: Parameters, s: State) -> Array:
    return np.exp(-((x.sigma / p["s"]) ** p["n"]))


add(
    Law(
        key="pressure_pockets",
        equation="exp(-(sigma / s)^n)",
        source="share of the surface that is not yet flattened, stretched exponential (own variant)",
        accept=("p_saturation",),
        twins=PRESSURE_TWINS,
        factors=("sigma",),
        draw=_pockets_draw,
        shape=_pockets,
    )
)


def _bare_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"c": 1.0 + rng.uniform(0.0, 0.08) * (r.high["psi"] - 1.0)}


def _bare(x: Point, p: Parameters, s: State) -> Array:
    return np.maximum(1.0 - p["c"] / x.psi, 0.0)


add(
    Law(
        key="expansion_bare",
        equation="(psi - c) / psi above the threshold c",
        source="Bay 1983: share of bare metal after the cover layer cracks (from memory)",
        accept=("expansion",),
        factors=("psi",),
        draw=_bare_draw,
        shape=_bare,
    )
)


def _hill_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"h": r.between("psi", rng.uniform(0.12, 0.4)), "n": rng.uniform(1.5, 3.0)}


def _hill(x: Point, p: Parameters, s: State) -> Array:
    grown = np.maximum(x.psi - 1.0, 0.0) / (p["h"] - 0.9)
    return grown ** p["n"] / (1.0 + grown ** p["n"])


add(
    Law(
        key="expansion_hill",
        equation="g^n / (1 + g^n), g = (psi - 1) / (h - 1)",
        source="Hill form of the loss of cover with surface growth (own variant of film thinning)",
        accept=("expansion",),
        factors=("psi",),
        draw=_hill_draw,
        shape=_hill,
    )
)


def _root_psi(x: Point, p: Parameters, s: State) -> Array:
    return np.sqrt(np.maximum(1.0 - 1.0 / x.psi, 0.0)) + 0.0 * p["c"]


add(
    Law(
        key="expansion_root",
        equation="sqrt(1 - 1 / psi)",
        source="exposure with real area as the root of the grown share (own variant)",
        accept=("expansion",),
        factors=("psi",),
        draw=_bare_draw,
        shape=_root_psi,
    )
)
