"""Pictures of a friction law: mu over each load, as one SVG without scripts for the page inside the FMU."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from html import escape

import numpy as np

from friction_models.loads import LOAD_NAMES, LOADS, QUANTITIES, FloatArray

from ..interface.friction_source import FrictionSource
from ..interface.quantities import USUAL, FrictionInterface
from ..source.reference_results import reference_run

_POINTS = 61
_WIDTH, _HEIGHT, _GAP = 186, 150, 16
_LEFT, _TOP, _BOTTOM = 56, 26, 36
#: The load that is varied from curve to curve, and in its own picture another one.
_FAMILY, _OTHER = "sigma_n", "T"
_SHARES = (0.1, 0.5, 0.9)
#: Steps of the way that a model with memory slides before it is drawn, and the slowest speed there, as a share of the fastest.
_STEPS, _SLOWEST = 40, 0.001


def response_curves(source: FrictionSource, interface: FrictionInterface) -> str:
    """Return an SVG with mu over each load, the others in the middle of the domain.

    A model that remembers got to each point by sliding its `sd` from fresh contact at its other loads.

    The margins lie outside of the trained domain, where the FMU moves the loads to its border. Numbers
    are rounded to a tenth of a pixel: equal models give equal pictures. Empty where mu is not a number.
    """
    box = {q.name: interface.domain.get(q.name, USUAL[q.name]) for q in LOADS}
    panels = []
    for quantity in LOADS:
        lower, upper = box[quantity.name]
        margin = 0.12 * (upper - lower) or max(abs(upper), 1.0) * 0.12
        x = np.linspace(max(lower - margin, quantity.lower), min(upper + margin, quantity.upper), _POINTS)
        panels.append((quantity, x, _curves(source, interface, box, quantity.name, x)))
    drawn = np.concatenate([y for _, _, curves in panels for y in curves])
    if not np.isfinite(drawn).all():
        return ""
    low, high = float(drawn.min()), float(drawn.max())
    low, high = 0.0 if low < 0.6 * high else low, high if high > low else low + max(0.01, 0.1 * low)
    ticks = _ticks(low, high)
    low, high = min(low, ticks[0]), max(high, ticks[-1])
    width = _LEFT + len(panels) * (_WIDTH + _GAP)
    parts = [
        f'<svg class="curves" viewBox="0 0 {width} {_TOP + _HEIGHT + _BOTTOM}" role="img" '
        f'aria-label="coefficient of friction over each load">'
    ]
    for k, (quantity, x, curves) in enumerate(panels):
        left = _LEFT + k * (_WIDTH + _GAP)
        inside = box[quantity.name] if interface.domain else (float(x[0]), float(x[-1]))
        parts.append(_panel(left, quantity.name, quantity.unit, x, curves, inside, (low, high)))
        if k == 0:
            parts += [_label(left, value, (low, high)) for value in ticks]
    parts.append("</svg>")
    return "".join(parts)


def legend(interface: FrictionInterface) -> str:
    """Return the sentence that says what the curves are."""
    box = {q.name: interface.domain.get(q.name, USUAL[q.name]) for q in LOADS}
    units = {q.name: q.unit for q in LOADS}

    def values(name: str) -> str:
        lower, upper = box[name]
        return ", ".join(short(lower + s * (upper - lower)) for s in _SHARES) + f" {units[name]}"

    return (
        f"Faint to strong: {_FAMILY} = {values(_FAMILY)}; in the picture over {_FAMILY}, {_OTHER} = {values(_OTHER)}. "
        f"The other loads are in the middle of the domain.{_memory(interface, box)}"
    )


def _memory(interface: FrictionInterface, box: dict[str, tuple[float, float]]) -> str:
    if not interface.states:
        return ""
    slid = f"{short(0.5 * sum(box['sd']))} {QUANTITIES['sd'].unit}"
    return (
        f" The model remembers: each point is drawn after it slid {slid} (sd) from fresh contact at the loads of the point; over sd, "
        "after that distance."
    )


def short(value: float) -> str:
    """Return a number with three digits or more, never with an exponent where four digits will do.

    Examples
    --------
    >>> short(0.123456), short(1234.4), short(20.0)
    ('0.123', '1234', '20')
    """
    return f"{value:.0f}" if 1000.0 <= abs(value) < 1e6 else f"{value:.3g}"


def _curves(
    source: FrictionSource,
    interface: FrictionInterface,
    box: dict[str, tuple[float, float]],
    name: str,
    x: FloatArray,
) -> list[FloatArray]:
    """Return mu over one load, one curve for each of `_SHARES`; all their points of one speed are worked out together."""
    loads = np.empty((len(_SHARES), len(x), len(LOADS)))
    for j, q in enumerate(LOADS):
        lower, upper = box[q.name]
        varied = q.name == (_OTHER if name == _FAMILY else _FAMILY)
        share = np.array(_SHARES)[:, None] if varied else 0.5
        loads[:, :, j] = x if q.name == name else lower + share * (upper - lower)
    if not interface.states:
        points = loads.reshape(1, -1, len(LOADS))
        mu = reference_run(source, replace(interface, nodes=points.shape[1]), points)["mu"]
        return [*mu.reshape(len(_SHARES), -1)]
    if name == "sd":
        along, mu = _sliding(source, interface, loads[:, -1], box)
        return [np.interp(x, along, values) for values in mu.T]
    if name == "v_rel":  # points of one speed get to their ends at the same time
        ends = [_sliding(source, interface, loads[:, k], box)[1][-1] for k in range(len(x))]
        return [*np.array(ends).T]
    _, mu = _sliding(source, interface, loads.reshape(-1, len(LOADS)), box)
    return [*mu[-1].reshape(len(_SHARES), -1)]


def _sliding(
    source: FrictionSource,
    interface: FrictionInterface,
    ends: FloatArray,
    box: dict[str, tuple[float, float]],
) -> tuple[FloatArray, FloatArray]:
    """Return distances and mu of shape (rows, points) on the way from fresh contact to loads of one speed and one `sd`."""
    v_rel, sd = LOAD_NAMES.index("v_rel"), LOAD_NAMES.index("sd")
    along = np.linspace(0.0, float(ends[0, sd]), _STEPS + 1)
    rows = np.repeat(ends[None], _STEPS + 1, axis=0)
    rows[:, :, sd] = along[:, None]
    # At rest no distance would ever be reached.
    rows[:-1, :, v_rel] = speed = max(float(ends[0, v_rel]), _SLOWEST * box["v_rel"][1])
    points = replace(interface, nodes=len(ends))
    return along, reference_run(source, points, rows, float(along[1]) / speed)["mu"]


def _ticks(low: float, high: float) -> list[float]:
    """Return three to six round numbers that cover the range."""
    rough = (high - low) / 4.0
    power = 10.0 ** np.floor(np.log10(rough))
    step = next(float(f * power) for f in (1.0, 2.0, 2.5, 5.0, 10.0) if f * power >= rough)
    first, last = int(np.floor(low / step + 1e-9)), int(np.ceil(high / step - 1e-9))
    return [step * k for k in range(first, last + 1)]


def _y(value: float, span: tuple[float, float]) -> float:
    return _TOP + _HEIGHT * (1.0 - (value - span[0]) / (span[1] - span[0]))


def _label(left: float, value: float, span: tuple[float, float]) -> str:
    return f'<text class="n" x="{left - 6}" y="{_y(value, span) + 4:.1f}">{value:.4g}</text>'


def _panel(
    left: float,
    name: str,
    unit: str,
    x: FloatArray,
    curves: Sequence[FloatArray],
    inside: tuple[float, float],
    span: tuple[float, float],
) -> str:
    def across(value: float) -> float:
        return left + _WIDTH * (value - float(x[0])) / float(x[-1] - x[0])

    bottom = _TOP + _HEIGHT
    start, end = across(inside[0]), across(inside[1])
    parts = [f'<rect class="in" x="{start:.1f}" y="{_TOP}" width="{end - start:.1f}" height="{_HEIGHT}"/>']
    outside = ((left, start), (end, left + _WIDTH))
    parts += [
        f'<rect class="out" x="{a:.1f}" y="{_TOP}" width="{b - a:.1f}" height="{_HEIGHT}"/>'
        for a, b in outside
        if b - a > 0.5
    ]
    for value in _ticks(*span):
        y = _y(value, span)
        if _TOP - 1 <= y <= bottom + 1:
            parts.append(f'<path class="grid" d="M{left} {y:.1f}h{_WIDTH}"/>')
    for k, curve in enumerate(curves):
        points = " ".join(f"{across(a):.1f},{_y(float(b), span):.1f}" for a, b in zip(x, curve, strict=True))
        parts.append(f'<polyline class="c{k}" points="{points}"/>')
    label = name if unit == "1" else f"{name} in {unit}"
    parts.append(f'<text class="t" x="{left}" y="{_TOP - 9}">{escape(label)}</text>')
    for value, anchor in ((inside[0], "b"), (inside[1], "e")):
        parts.append(
            f'<text class="{anchor}" x="{across(value):.1f}" y="{bottom + 16}">{short(value)}</text>'
        )
    return "".join(parts)
