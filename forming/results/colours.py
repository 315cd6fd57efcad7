"""Colour maps of field pictures, and round numbers for their scales."""

from __future__ import annotations

import math

import numpy as np

from ..fe.mesh.shape import FloatArray

#: Stops of equal distance: perceptually even maps from dark to light, and one that is white at 0.
MAPS: dict[str, tuple[str, ...]] = {
    "heat": (
        "#140b34",
        "#420a68",
        "#781c6d",
        "#a92e5e",
        "#d8454f",
        "#f1731d",
        "#fca50a",
        "#f6d746",
        "#fcffa4",
    ),
    "even": (
        "#440154",
        "#472d7b",
        "#3b528b",
        "#2c728e",
        "#21918c",
        "#28ae80",
        "#5ec962",
        "#addc30",
        "#fde725",
    ),
    "signed": (
        "#16366f",
        "#2f62a8",
        "#6b9bcb",
        "#b4cfe4",
        "#f4f3f0",
        "#f0c3ab",
        "#dc8367",
        "#b43a3c",
        "#76102a",
    ),
}


def map_of(name: str, signed: bool) -> tuple[str, ...]:
    """Return the stops for a field."""
    return MAPS["signed" if signed else "heat" if name == "T" else "even"]


def colours(stops: tuple[str, ...], count: int) -> list[str]:
    """Return `count` colours from the first to the last stop."""
    rgb = np.array([[int(s[k : k + 2], 16) for k in (1, 3, 5)] for s in stops], dtype=np.float64)
    at = np.linspace(0.0, len(stops) - 1, count)
    mixed = np.column_stack([np.interp(at, np.arange(len(stops)), channel) for channel in rgb.T])
    return ["#" + "".join(f"{round(c):02x}" for c in row) for row in mixed]


def ticks(low: float, high: float, about: int = 6) -> FloatArray:
    """Return round numbers in [low, high]."""
    raw = (high - low) / about
    unit = 10.0 ** math.floor(math.log10(raw))
    step = next(unit * f for f in (1.0, 2.0, 2.5, 5.0, 10.0) if unit * f >= raw * 0.999)
    first = math.ceil(low / step - 1e-9)
    return step * np.arange(first, math.floor(high / step + 1e-9) + 1, dtype=np.float64)


def number(value: float) -> str:
    """Return a tick's value as one writes it."""
    text = f"{value:.6g}" if 1e-3 <= abs(value) < 1e6 or value == 0.0 else f"{value:.2e}"
    return text.replace("-", "\N{MINUS SIGN}")
