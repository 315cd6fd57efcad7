"""Laws of metadata (system variables) and faults of the measurement."""

from __future__ import annotations

import numpy as np

from .law import Array, Law, Parameters, Point, Ranges, State, add


def _none(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {}


def _lots(rng: np.random.Generator, r: Ranges) -> Parameters:
    steps = rng.permutation(np.array([-1.0, -0.1, 1.1])) + rng.normal(0.0, 0.1, 3)
    return {"A": steps[0], "B": steps[1], "C": steps[2]}


def _column(name: str, labels: tuple[str, ...]) -> object:
    def shape(x: Point, p: Parameters, s: State) -> Array:
        values = np.asarray(x.meta[name]).astype(str)
        keys = sorted(p)
        return np.select([values == label for label in labels], [p[keys[i]] for i in range(len(labels))], 0.0)

    return shape


add(
    Law(
        key="batch_lots",
        equation="one constant a batch of lubricant",
        source="system variable, three lots",
        accept=("batch", "factor:batch"),
        draw=_lots,
        shape=_column("batch", ("B1", "B2", "B3")),  # type: ignore[arg-type]
    )
)
add(
    Law(
        key="operator_habit",
        equation="one constant an operator",
        source="system variable, three operators",
        accept=("factor:operator",),
        draw=_lots,
        shape=_column("operator", ("O1", "O2", "O3")),  # type: ignore[arg-type]
    )
)


def _ra(x: Point, p: Parameters, s: State) -> Array:
    ra = np.asarray(x.meta["Ra"], float)
    return np.sqrt(ra / 0.05)


add(
    Law(
        key="roughness_root",
        equation="sqrt(Ra)",
        source="friction with the slope of the asperities (own variant)",
        accept=("roughness", "factor:Ra"),
        twins=("factor:tool_id",),
        draw=_none,
        shape=_ra,
    )
)


def _film(x: Point, p: Parameters, s: State) -> Array:
    return 1.0 / (1.0 + (np.asarray(x.meta["film_weight"], float) / 6.0) ** 2)


add(
    Law(
        key="film_weight_rational",
        equation="1 / (1 + (w / 6 g/m2)^2)",
        source="coating weight (own variant)",
        accept=("factor:film_weight",),
        draw=_none,
        shape=_film,
    )
)


def _damp(x: Point, p: Parameters, s: State) -> Array:
    return -np.tanh((np.asarray(x.meta["humidity"], float) - 45.0) / 15.0)


add(
    Law(
        key="humidity_tanh",
        equation="-tanh((h - 45 %) / 15 %)",
        source="solid lubricants and humidity (shape ours)",
        accept=("factor:humidity",),
        draw=_none,
        shape=_damp,
    )
)


def _warm_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"n": rng.uniform(0.15, 0.35) * max(r.high["order"], 1.0), "sign": float(rng.choice([-1.0, 1.0]))}


def _warm(x: Point, p: Parameters, s: State) -> Array:
    return p["sign"] * (1.0 - np.exp(-np.asarray(x.meta["order"], float) / p["n"]))


add(
    Law(
        key="drift_warm_up",
        equation="1 - exp(-order / n)",
        source="warm-up of an amplifier, first order",
        accept=("drift",),
        twins=("factor:order",),
        fault=True,
        draw=_warm_draw,
        shape=_warm,
    )
)


def _zero_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"d": rng.uniform(0.1, 0.3) * r.low["sigma"], "s": r.low["sigma"]}


def _zero(x: Point, p: Parameters, s: State) -> Array:
    return p["s"] / (x.sigma + p["d"])


add(
    Law(
        key="zero_of_normal_force",
        equation="1 / (sigma + d)",
        source="zero error in the divisor F_r / (F_n + d), at constant true friction",
        accept=("force_zero",),
        twins=("p_power", "p_saturation"),
        factors=("sigma",),
        fault=True,
        draw=_zero_draw,
        shape=_zero,
    )
)


def _twin_draw(rng: np.random.Generator, r: Ranges) -> Parameters:
    return {"r": rng.uniform(0.2, 0.6) * max(r.high["rise"], 1.0), "sign": float(rng.choice([-1.0, 1.0]))}


def _twin(x: Point, p: Parameters, s: State) -> Array:
    return p["sign"] * x.rise / (x.rise + p["r"])


add(
    Law(
        key="twin_rise_wrong",
        equation="R / (R + r), R = T - T at the start",
        source="heating estimated wrongly, error saturating with the rise (own variant)",
        accept=("twin",),
        twins=("softening", "flash", "breakdown"),
        factors=("T", "v", "sigma"),
        fault=True,
        draw=_twin_draw,
        shape=_twin,
    )
)
