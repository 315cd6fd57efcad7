"""The fields of a run as an animation in HTML, which needs no network."""

from __future__ import annotations

import base64
import json
from importlib.resources import files

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError

from ...fe.mesh.shape import FloatArray
from ..fields import FieldHistory
from ..snapshot import FIELDS, Snapshot
from .drawing import BANDS, Window, colours, map_of, ticks, tool_polygon

#: Largest text of one animation [bytes]; of larger histories every so many snapshots are left out.
LARGEST = 2_500_000


def animation(
    history: FieldHistory,
    field: str = "T",
    stroke: float | None = None,
    force: tuple[FloatArray, FloatArray] | None = None,
    largest: int = LARGEST,
) -> str:
    """Return the HTML of an animation with a slider and a choice of fields; its data take at most `largest` bytes.

    It opens with `field` at `stroke` [mm], by default at the end. `force`: stroke [mm] and force [kN], drawn beside it.

    Raises InputError: no snapshots, or an unknown field.
    """
    history.at(stroke)
    low_high = {name: history.extremes(name, 0.002) for name in FIELDS}
    history.extremes(field)
    chosen = history
    while True:
        text = json.dumps(
            _data(chosen, low_high, field, stroke, force), separators=(",", ":"), allow_nan=False
        )
        if len(text) <= largest:
            break
        if len(chosen) == 1:
            raise InputError(
                f"forming: a snapshot of {len(chosen.at().x)} nodes is too large for an animation"
            )
        fewer = max(1, int(0.95 * len(chosen) * largest / len(text)))
        index = np.unique(np.linspace(0, len(chosen) - 1, fewer).round().astype(int))[: len(chosen) - 1]
        chosen = FieldHistory(tuple(chosen.snapshots[k] for k in index))
    template = files(__package__).joinpath("animation.html").read_text(encoding="utf-8")
    # Names in the data come from files: no tag can end the script element.
    return template.replace("@DATA@", text.replace("<", "\\u003c"))


def _data(
    history: FieldHistory,
    low_high: dict[str, tuple[float, float]],
    field: str,
    stroke: float | None,
    force: tuple[FloatArray, FloatArray] | None,
) -> dict[str, object]:
    window = Window.around(history.snapshots)
    whole = {name: _range(history, name) for name in FIELDS}
    found: dict[str, object] = {
        "window": [window.r_max, window.z_min, window.z_max],
        "field": list(FIELDS).index(field),
        "frame": len(history) - 1 if stroke is None else int(np.abs(history.strokes - stroke).argmin()),
        "fields": [
            {
                "meaning": f.meaning,
                "unit": "" if f.unit == "1" else f.unit.replace("degC", "°C"),
                "min": whole[f.name][0],
                "max": whole[f.name][1],
                "low": low_high[f.name][0],
                "high": low_high[f.name][1],
                "ticks": [float(f"{t:.6g}") for t in ticks(*low_high[f.name])],
                "colours": colours(map_of(f.name, f.signed), BANDS),
            }
            for f in FIELDS.values()
        ],
        "frames": [_frame(s, window, whole) for s in history.snapshots],
    }
    if force is not None and len(force[0]) > 1:
        top = 1.08 * float(max(force[1].max(), 1e-6))
        found["force"] = {
            "stroke": [round(float(v), 4) for v in force[0]],
            "force": [round(float(v), 3) for v in force[1]],
            "top": top,
            "force_ticks": ticks(0.0, top, 5).tolist(),
            "stroke_ticks": ticks(0.0, float(force[0][-1]), 5).tolist(),
        }
    return found


def _range(history: FieldHistory, name: str) -> tuple[float, float]:
    values = [s.nodal(name) for s in history.snapshots]
    low, high = min(float(v.min()) for v in values), max(float(v.max()) for v in values)
    return low, high if high > low else low + 1.0


def _frame(s: Snapshot, window: Window, whole: dict[str, tuple[float, float]]) -> dict[str, object]:
    if len(s.x) > 65535:
        raise InputError(f"forming: a snapshot of {len(s.x)} nodes; an animation takes at most 65535")
    low = np.array([0.0, window.z_min])
    span = np.array([window.r_max, window.z_max - window.z_min])
    values = [(s.nodal(name) - a) / (b - a) for name, (a, b) in whole.items()]
    return {
        "stroke": s.stroke,
        "time": s.time,
        "x": _words((s.x - low) / span * 65535.0),
        "quads": _words(s.quads),
        "chain": _words(s.chain),
        "values": _words(np.concatenate(values) * 65535.0),
        "tools": [
            {"outline": _flat(tool_polygon(chain)), "surface": _flat(chain)} for chain in s.tools.values()
        ],
    }


def _words(values: npt.ArrayLike) -> str:
    packed = np.clip(np.rint(values), 0, 65535).astype("<u2").tobytes()
    return base64.b64encode(packed).decode("ascii")


def _flat(points: npt.ArrayLike) -> list[float]:
    return [round(float(v), 3) for v in np.asarray(points).ravel()]
