"""Data of the figures in the text and the page of a diagnosis: residual over two loads, response of an effect."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypedDict

import numpy as np
import pandas as pd

from ...effects.base import Effect, EffectContext
from ...estimation.campaign.settings import varies
from ...estimation.search.candidates import OPS
from ...estimation.search.structure import StructurePlace
from ...expressions.ops import LoadColumns
from ...loads import LOAD_NAMES, LOADS, FloatArray
from ...loads.contract import behind
from .findings import Findings

#: Loads over which a residual is mapped, where the data vary them.
MAPPED = ("sigma_n", "T")
CURVE = 81


def varied(averages: pd.DataFrame) -> list[str]:
    """Return the loads that the data hold and vary, in their usual order."""
    averaged = "test_id" in averages.columns and averages["test_id"].is_unique
    return [
        q.name
        for q in LOADS
        if q.name in averages.columns and varies(q.name, averages[q.name].to_numpy(), averaged)
    ]


def mapped_loads(averages: pd.DataFrame) -> tuple[str, str] | None:
    """Return the two loads of the map: pressure and temperature, else the first two that vary."""
    names = varied(averages)
    if all(n in names for n in MAPPED):
        return MAPPED
    return (names[0], names[1]) if len(names) > 1 else None


@dataclass(frozen=True)
class LoadMap:
    """Mean residual over two loads."""

    #: The loads.
    x: str
    y: str
    #: Shape (k + 1,), (m + 1,).
    x_edges: FloatArray
    y_edges: FloatArray
    #: Mean load of the points in each column and row of cells, its middle where there are none: the level, where a plan has some. Shapes (k,), (m,).
    x_measured: FloatArray
    y_measured: FloatArray
    tests: FloatArray  #: Tests in each cell, shape (m, k).
    #: By ``before`` and ``after``; NaN in cells without a test. Every test counts once in a cell. Shape (m, k).
    mean: dict[str, FloatArray]


def load_map(averages: pd.DataFrame, cells: int = 10, pair: tuple[str, str] | None = None) -> LoadMap | None:
    """Return the mean residual over two loads (`mapped_loads` by default); None where fewer than two vary."""
    pair = pair or mapped_loads(averages)
    if pair is None:
        return None
    places, edges, measured = [], [], []
    for name in pair:
        values = averages[name].to_numpy()
        edge = np.linspace(values.min(), values.max(), cells + 1)
        edges.append(edge)
        place = np.clip(np.searchsorted(edge, values, side="right") - 1, 0, cells - 1)
        places.append(place)
        points = np.bincount(place, minlength=cells)
        total = np.bincount(place, values, cells)
        measured.append(np.where(points > 0, total / np.maximum(points, 1), 0.5 * (edge[1:] + edge[:-1])))
    test = pd.factorize(averages["test_id"])[0]
    each = (
        pd.DataFrame({"x": places[0], "y": places[1], "test": test})
        .assign(before=averages["before"].to_numpy(), after=averages["after"].to_numpy())
        .groupby(["y", "x", "test"])
        .mean()
    )
    grouped = each.groupby(["y", "x"])
    rows, columns = (grouped.mean().index.get_level_values(k).to_numpy() for k in ("y", "x"))
    mean = {}
    for part in ("before", "after"):
        mean[part] = np.full((cells, cells), np.nan)
        mean[part][rows, columns] = grouped[part].mean().to_numpy()
    tests = np.zeros((cells, cells))
    tests[rows, columns] = grouped.size().to_numpy()
    (x_edges, y_edges), (x_measured, y_measured) = edges, measured
    return LoadMap(*pair, x_edges, y_edges, x_measured, y_measured, tests, mean)


def effect_curve(
    effect: Effect, values: Mapping[str, float], averages: pd.DataFrame, driver: str
) -> tuple[FloatArray, FloatArray] | None:
    """Return the contribution of an effect to mu along the load `driver`, the others at their median.

    `values` holds its amplitudes and shape parameters, `averages` are `Diagnosis.averages`. Returns load and contribution, each
    of shape (n,); None if the effect has memory or needs metadata.
    """
    if effect.states or effect.metadata or driver not in averages.columns or driver not in LOAD_NAMES:
        return None
    low, high = averages[driver].min(), averages[driver].max()
    along = (
        np.geomspace(low, high, CURVE) if low > 0.0 and high > 20.0 * low else np.linspace(low, high, CURVE)
    )
    columns = [
        along
        if q.name == driver
        else np.full(CURVE, float(averages[q.name].median()) if q.name in averages.columns else q.nominal)
        for q in LOADS
    ]
    memory = EffectContext(mu=np.full((CURVE, 1), float(averages["mu"].median())))
    shape = {s.name: float(values[s.name]) for s in effect.shapes}
    basis = effect.basis(
        OPS, LoadColumns(*(np.asarray(c, dtype=float)[:, None] for c in columns)), shape, memory
    )
    share = sum(
        float(values[a.name]) * np.broadcast_to(np.asarray(b), (CURVE, 1))[:, 0]
        for a, b in zip(effect.amplitudes, basis, strict=True)
    )
    return along, np.asarray(share, dtype=float)


class EffectDescription(TypedDict):
    """Title, source and meanings of an effect; ``parameters`` holds the meaning of each parameter."""

    title: str
    where: str
    citation: str
    driver: tuple[str, ...]
    parameters: dict[str, str]


def meanings(effect: Effect) -> EffectDescription:
    """Return title, source and meanings of an effect."""
    return {
        "title": effect.title,
        "where": effect.where_it_shows,
        "citation": effect.citation,
        "driver": effect.driver,
        "parameters": {a.name: a.meaning for a in effect.amplitudes}
        | {s.name: s.meaning for s in effect.shapes},
    }


def where_text(entry: StructurePlace) -> str:
    """Return a place where structure is left as text: ``v_rel 22 to 502 mm/s, psi 1.08 to 1.98: interaction (33 % of what is left)``."""
    units = {q.name: behind(q.unit) for q in LOADS}
    places = ", ".join(
        f"{name} {entry['region'][name][0]:.3g} to {entry['region'][name][1]:.3g}{units.get(name, '')}"
        if name in entry["region"]
        else name
        for name in dict.fromkeys([*entry["region"], *entry["variables"]])
    )
    return f"{places}: {entry['shape']} ({100 * entry['share']:.0f} % of what is left)"


def structure_pair(found: Findings) -> tuple[str, str] | None:
    """Return the two loads with most structure left, unless the map shows this pair already."""
    variables = found.where[0]["variables"] if found.where else []
    if len(variables) != 2 or any(v not in found.averages.columns for v in variables):
        return None
    pair = (str(variables[0]), str(variables[1]))
    return None if set(pair) == set(mapped_loads(found.averages) or ()) else pair


def setpoints_text(values: Mapping[str, Any]) -> str:
    """Return the set points of a proposed test: ``sigma_n 2760, 102 MPa; v_rel 50 mm/s``.

    Examples
    --------
    >>> setpoints_text({"sigma_n [MPa]": [2760.0, 102.0], "v_rel [mm/s]": 50.0})
    'sigma_n 2760, 102 MPa; v_rel 50 mm/s'
    """
    parts = []
    for key, value in values.items():
        name, _, unit = str(key).partition(" [")
        unit = f" {unit.rstrip(']')}" if unit else ""
        numbers = value if isinstance(value, list | tuple) else [value]
        shown = ", ".join(f"{x:g}" if isinstance(x, int | float) else str(x) for x in numbers)
        parts.append(f"{name} {shown}{unit}")
    return "; ".join(parts)
