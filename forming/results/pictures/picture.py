"""A field as a drawing: the full cross-section with the tools and a colour bar, as SVG."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError, unknown_name, write_text
from friction_models.common.markup import document

from ...fe.mesh.shape import FloatArray
from ..fields import FieldHistory
from ..snapshot import FIELDS, Snapshot
from .animation import animation
from .drawing import (
    BANDS,
    FONT,
    INK,
    SOFT,
    STEEL,
    STEEL_EDGE,
    Window,
    colours,
    map_of,
    number,
    ticks,
    tool_polygon,
)

#: Parts of an element along each side, so that colours follow the field within it.
PARTS = 3


def write_picture(
    history: FieldHistory, path: str | os.PathLike[str], field: str = "T", stroke: float | None = None
) -> Path:
    """Write one snapshot as ``.svg``, or all of them as a page (``.html``) that opens with it; return the path.

    Raises InputError: no snapshots, an unknown field, another kind of file.
    """
    if field not in FIELDS:
        raise unknown_name("field", field, FIELDS, "forming")
    shown = history.at(stroke)
    kind = Path(path).suffix.lower()
    if kind == ".svg":
        return write_text(path, svg(history, field, shown.stroke))
    if kind == ".html":
        page = animation(history, field, shown.stroke)
        return write_text(path, document("Fields of a forming run", "", page))
    raise InputError(
        f"{path}: a picture is written as {kind or 'a file without suffix'}; allowed: .svg, .html"
    )


def svg(history: FieldHistory, field: str = "T", stroke: float | None = None) -> str:
    """Return the drawing of the snapshot nearest to `stroke`; colours span its own range."""
    s = history.at(stroke)
    f = FIELDS[field]
    low, high = FieldHistory((s,)).extremes(field, 0.002)
    window = Window.around((s,))
    scale = min(620.0 / (window.z_max - window.z_min), 760.0 / (2.0 * window.r_max))
    width, height = 2.0 * window.r_max * scale, (window.z_max - window.z_min) * scale
    left, top, bar = 16.0, 58.0, 118.0
    total_w, total_h = max(left + width + bar, 460.0), top + height + 40.0
    half = _half(s, field, low, high, window, scale)
    heading = f"{f.meaning[:1].upper()}{f.meaning[1:]}"
    unit = "" if f.unit == "1" else " [" + f.unit.replace("degC", "°C") + "]"
    values = s.nodal(field)
    middle = left + 0.5 * width
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {total_w:.0f} {total_h:.0f}" '
        f'width="{total_w:.0f}" height="{total_h:.0f}" font-family={_quoted(FONT)} role="img" '
        f"aria-label={_quoted(f'{heading} at a stroke of {s.stroke:.2f} mm')}>",
        f'<rect width="{total_w:.0f}" height="{total_h:.0f}" fill="#ffffff"/>',
        f'<text x="{left}" y="24" font-size="17" font-weight="600" fill="{INK}">{escape(heading + unit)}</text>',
        f'<text x="{left}" y="44" font-size="13" fill="{SOFT}">stroke {s.stroke:.2f} mm, time {s.time:.3g} s, '
        f"{number(float(f'{values.min():.4g}'))} to {number(float(f'{values.max():.4g}'))}</text>",
        f'<defs><clipPath id="window"><rect x="0" y="{-window.z_max:.3f}" width="{window.r_max:.3f}" '
        f'height="{window.z_max - window.z_min:.3f}"/></clipPath><g id="half" clip-path="url(#window)">{half}</g></defs>',
        f'<g transform="translate({middle:.2f} {top + window.z_max * scale:.2f}) scale({scale:.4f})">',
        '<use href="#half"/><use href="#half" transform="scale(-1 1)"/>',
        f'<path d="M0 {-window.z_max:.2f}V{-window.z_min:.2f}" stroke="{INK}" stroke-opacity="0.45" fill="none" '
        f'stroke-width="{0.8 / scale:.4f}" stroke-dasharray="{9 / scale:.3f} {3 / scale:.3f} {2 / scale:.3f} {3 / scale:.3f}"/></g>',
        _bar(field, low, high, left + width + 22.0, top, min(height, 320.0)),
        _ruler(left, top + height + 22.0, scale),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def _quoted(text: str) -> str:
    return '"' + escape(text, {'"': "&quot;"}) + '"'


def _half(s: Snapshot, field: str, low: float, high: float, window: Window, scale: float) -> str:
    """Return the right half: tools, elements by colour, outline; x = r, y = -z in mm, lines in pixels / `scale`."""
    palette = colours(map_of(field, FIELDS[field].signed), BANDS)
    corners, values = subdivided(s, field)
    band = np.clip(((values - low) / (high - low) * BANDS).astype(int), 0, BANDS - 1)
    parts = [_tool(chain, scale) for chain in s.tools.values()]
    for k in np.unique(band):
        path = "".join(
            "M" + "L".join(f"{r:.3f} {-z:.3f}" for r, z in quad) + "Z" for quad in corners[band == k]
        )
        parts.append(
            f'<path d="{path}" fill="{palette[k]}" stroke="{palette[k]}" stroke-width="{0.6 / scale:.4f}" stroke-linejoin="round"/>'
        )
    outline = "L".join(f"{r:.3f} {-z:.3f}" for r, z in s.x[s.chain])
    parts.append(f'<path d="M{outline}" fill="none" stroke="{INK}" stroke-width="{1.4 / scale:.4f}"/>')
    return "\n".join(parts)


def subdivided(s: Snapshot, field: str) -> tuple[FloatArray, FloatArray]:
    """Return the elements cut into `PARTS` x `PARTS`: corners (m, 4, 2) and the field in the middle (m,)."""
    a = np.linspace(0.0, 1.0, PARTS + 1)

    def weights(u: FloatArray, v: FloatArray) -> FloatArray:
        return np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=-1)

    x, y = np.meshgrid(a, a, indexing="ij")
    grid = np.einsum("ijk,ekc->eijc", weights(x, y), s.x[s.quads].astype(np.float64))
    corners = np.stack([grid[:, :-1, :-1], grid[:, 1:, :-1], grid[:, 1:, 1:], grid[:, :-1, 1:]], axis=3)
    middle = 0.5 * (a[1:] + a[:-1])
    u, v = np.meshgrid(middle, middle, indexing="ij")
    values = np.einsum("ijk,ek->eij", weights(u, v), s.nodal(field)[s.quads])
    return corners.reshape(-1, 4, 2), values.ravel()


def _tool(chain: npt.NDArray[np.floating[Any]], scale: float) -> str:
    outline = "L".join(f"{r:.3f} {-z:.3f}" for r, z in tool_polygon(chain))
    surface = "L".join(f"{r:.3f} {-z:.3f}" for r, z in chain)
    return (
        f'<path d="M{outline}Z" fill="{STEEL}"/>'
        f'<path d="M{surface}" fill="none" stroke="{STEEL_EDGE}" stroke-width="{1.6 / scale:.4f}"/>'
    )


def _bar(field: str, low: float, high: float, x: float, y: float, height: float) -> str:
    f = FIELDS[field]
    palette = colours(map_of(field, f.signed), BANDS)
    step = height / BANDS
    parts = [
        f'<rect x="{x:.1f}" y="{y + height - (k + 1) * step:.2f}" width="16" height="{step + 0.3:.2f}" fill="{c}"/>'
        for k, c in enumerate(palette)
    ]
    for value in ticks(low, high):
        at = y + height * (1.0 - (value - low) / (high - low))
        parts.append(
            f'<path d="M{x + 16:.1f} {at:.1f}h5" stroke="{SOFT}"/>'
            f'<text x="{x + 25:.1f}" y="{at + 4.5:.1f}" font-size="13" fill="{INK}">{number(float(f"{value:.6g}"))}</text>'
        )
    return "".join(parts)


def _ruler(x: float, y: float, scale: float) -> str:
    length = 10.0 if 10.0 * scale > 40.0 else 20.0
    return (
        f'<path d="M{x:.1f} {y - 4:.1f}v8M{x:.1f} {y:.1f}h{length * scale:.1f}m0 -4v8" stroke="{SOFT}" fill="none"/>'
        f'<text x="{x + length * scale + 8:.1f}" y="{y + 4.5:.1f}" font-size="13" fill="{SOFT}">{length:.0f} mm</text>'
    )
