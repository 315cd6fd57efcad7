"""Common parts of field drawings: colour maps, round numbers of scales, the window, outlines of tools."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ...fe.mesh.shape import FloatArray
from ..snapshot import Snapshot

#: Room around the workpiece in which tools are drawn [mm].
MARGIN = 4.0
#: Steps of the colour scale.
BANDS = 32
FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif'
INK, SOFT, STEEL, STEEL_EDGE = "#1b2530", "#566474", "#d3d8de", "#7d8894"
#: Stops of equal distance: perceptually even maps from dark to light, and one that is white at 0.
MAPS = {
    "heat": "#140b34 #420a68 #781c6d #a92e5e #d8454f #f1731d #fca50a #f6d746 #fcffa4",
    "even": "#440154 #472d7b #3b528b #2c728e #21918c #28ae80 #5ec962 #addc30 #fde725",
    "signed": "#16366f #2f62a8 #6b9bcb #b4cfe4 #f4f3f0 #f0c3ab #dc8367 #b43a3c #76102a",
}


def map_of(name: str, signed: bool) -> str:
    """Return the stops for a field."""
    return MAPS["signed" if signed else "heat" if name == "T" else "even"]


def colours(stops: str, count: int) -> list[str]:
    """Return `count` colours from the first to the last stop."""
    rgb = np.array([[int(s[k : k + 2], 16) for k in (1, 3, 5)] for s in stops.split()], dtype=np.float64)
    at = np.linspace(0.0, len(rgb) - 1, count)
    mixed = np.column_stack([np.interp(at, np.arange(len(rgb)), channel) for channel in rgb.T])
    return ["#" + "".join(f"{round(c):02x}" for c in row) for row in mixed]


def ticks(low: float, high: float, about: int = 6) -> FloatArray:
    """Return round numbers in [low, high]."""
    raw = (high - low) / about
    unit = 10.0 ** math.floor(math.log10(raw))
    step = next(unit * f for f in (1.0, 2.0, 2.5, 5.0, 10.0) if unit * f >= raw * 0.999)
    first = math.ceil(low / step - 1e-9)
    return step * np.arange(first, math.floor(high / step + 1e-9) + 1, dtype=np.float64)


def number(value: float) -> str:
    """Return the label of a tick."""
    text = f"{value:.6g}" if 1e-3 <= abs(value) < 1e6 or value == 0.0 else f"{value:.2e}"
    return text.replace("-", "\N{MINUS SIGN}")


@dataclass(frozen=True)
class Window:
    """Part of the plane that is drawn: 0 <= r <= r_max, z_min <= z <= z_max [mm]."""

    r_max: float
    z_min: float
    z_max: float

    @classmethod
    def around(cls, snapshots: tuple[Snapshot, ...]) -> Window:
        """Return the window that holds the workpiece of all snapshots."""
        return cls(
            max(float(s.x[:, 0].max()) for s in snapshots) + MARGIN,
            min(float(s.x[:, 1].min()) for s in snapshots) - MARGIN,
            max(float(s.x[:, 1].max()) for s in snapshots) + MARGIN,
        )


def tool_polygon(chain: npt.NDArray[np.floating[Any]], depth: float = 25.0) -> npt.NDArray[np.floating[Any]]:
    """Return the closed outline of a tool whose surface is `chain`, with the tool on its right-hand side."""
    start, end = chain[0], chain[-1]
    closings = [[np.array([start[0], end[1]])], [np.array([end[0], start[1]])]]
    along = end - start
    side = np.array([along[1], -along[0]]) * depth / max(float(np.hypot(*along)), 1e-9)
    closings.append([end + side, start + side])
    outlines = [np.concatenate([chain, np.array(c)]) for c in closings]
    # The tool is on the right, so its outline runs clockwise; a straight face has no corner to close over.
    areas = [-_area(o) for o in outlines]
    corner = int(np.argmax(areas[:2]))
    return outlines[corner] if areas[corner] > 1.0 else outlines[2]


def _area(points: npt.NDArray[np.floating[Any]]) -> float:
    r, z = points.T
    return 0.5 * float(r @ np.roll(z, -1) - z @ np.roll(r, -1))
