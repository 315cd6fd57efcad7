"""Pictures of measurement files: every column over time, with the phases, thinned so that every peak of a record stays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from friction_models.common import InputError
from friction_models.common.markup import escape
from friction_models.common.units import conversion
from friction_models.loads import FloatArray
from friction_models.loads.contract import LOAD_NAMES, POINT_UNITS, with_unit
from sct_twin.ingest.channel_map import ChannelMap, MappedColumn
from sct_twin.ingest.quality import quality_row
from sct_twin.readers import RawTable
from sct_twin.records.channels import CHANNELS

from ...report.parts.chart import Chart
from ...report.parts.theme import AFTER, CONSTANT
from ...report.reading import ReadFigure
from ..raw.map_form import ColumnForm, MapForm
from .explore import label
from .report_charts import as_read, with_fixed_margins

#: Points of a curve, and panels, that are drawn.
POINTS, PANELS = 1200, 24
#: Points of a cloud: each is something of its own to a browser, and there are as many clouds as columns.
CLOUD = 600
#: So many points are drawn large.
FEW = 100
#: Columns of the quality table that say what the phases are.
_PHASES = (
    ("upsetting_s", "sliding_s", "rgba(200, 100, 31, 0.12)"),
    ("sliding_s", "end_s", "rgba(10, 127, 121, 0.12)"),
)


def envelope(y: FloatArray) -> np.ndarray:
    """Return rows of a curve, at most `POINTS`: the smallest and largest of each piece, so that no peak is lost.

    Examples
    --------
    >>> y = np.zeros(100_000)
    >>> y[77_777] = 5.0
    >>> rows = envelope(y)
    >>> len(rows) <= POINTS, float(y[rows].max())
    (True, 5.0)
    """
    if len(y) <= POINTS:
        return np.arange(len(y))
    size = -(-len(y) // (POINTS // 2))
    whole = len(y) // size
    with np.errstate(invalid="ignore"):
        pieces = np.where(np.isfinite(y[: whole * size]), y[: whole * size], 0.0).reshape(whole, size)
    first = np.arange(whole) * size
    rows = np.concatenate([first + pieces.argmin(1), first + pieces.argmax(1), [len(y) - 1]])
    return np.unique(rows)[:POINTS]


def cloud(y: FloatArray) -> np.ndarray:
    """Return rows of points that are not joined, at most `CLOUD`: drawn without order, with the smallest and the largest value.

    The extremes of pieces, as of a curve, would show the ends of many short tests and nothing between them.

    Examples
    --------
    >>> distance = np.tile(np.arange(20.0), 500)
    >>> rows = cloud(distance)
    >>> len(rows) <= CLOUD, set(distance[rows]) == set(range(20))
    (True, True)
    """
    if len(y) <= CLOUD:
        return np.arange(len(y))
    known = np.where(np.isfinite(y), y, 0.0)
    rows = np.random.default_rng(0).permutation(len(y))[: CLOUD - 2]
    return np.unique([*rows, known.argmin(), known.argmax()])


def preview_row(form: MapForm, table: RawTable) -> dict[str, object]:
    """Return what `ingest` would say of the first file: a row of the quality table.

    Raises InputError: what the map lacks, or what is wrong with the record.
    """
    mapping = ChannelMap.load(form.content())
    record = mapping.record(table, "first", mapping.metadata)
    return quality_row(record, record.number("moving_mass", mapping.moving_mass or 0.0))


def columns_figure(
    form: MapForm, table: RawTable, row: Mapping[str, object] | None = None
) -> ReadFigure | None:
    """Return a picture of every column, in the units that it is mapped to; `row` has the times of the phases."""
    shown = [c for c in form.columns if c.number and c.is_ != "t"]
    shown = sorted(shown, key=lambda c: not c.is_)[:PANELS]
    if not shown:
        return None
    time, along = _time(form, table)
    titles = [escape(_title(c, form.records)) for c in shown]
    chart = Chart.of_panels(len(shown), gap=0.36, titles=titles, legend=False, horizontal_spacing=0.07)
    # A table may hold many tests: their points are not joined.
    mode, size = ("lines", None) if form.records else ("markers", _size(len(table.frame), 3))
    for at, column in enumerate(shown):
        values = _values(column, table, form.records)
        rows = envelope(values) if form.records else cloud(values)
        color = AFTER if column.is_ else CONSTANT
        chart.scatter(at, time[rows], values[rows], hover="%{x:.4g}, %{y:.5g}<extra></extra>", mode=mode, line={"color": color, "width": 1.2}, marker_color=color, marker_size=size)  # fmt: skip
        for begin, end, shade in _PHASES:
            low, high = (_number((row or {}).get(key)) for key in (begin, end))
            if low is not None and high is not None:
                chart.figure.add_vrect(
                    x0=low, x1=high, fillcolor=shade, line_width=0, layer="below", **chart.place(at)
                )
    chart.dress(175 * chart.rows + 40, x=along).figure.update_annotations(font_size=12)
    thinned = "" if form.records else _thinned(len(table.frame))
    caption = f"First file, {len(table.frame)} rows{thinned}."
    if row is not None:
        caption += " Orange: upsetting; green: sliding."
    if len(form.columns) > len(shown) + 1:
        caption += " Columns of text are not drawn."
    drawn = with_fixed_margins(chart, left=50)
    return as_read(drawn, escape(caption), "Every column of the first file over time.")


def _size(points: int, least: int) -> int:
    """Return the size of markers: a few small ones are hardly seen.

    Examples
    --------
    >>> _size(12, 3), _size(5000, 3)
    (6, 3)
    """
    return least if points > FEW else 2 * least


def _title(column: ColumnForm, records: bool) -> str:
    name = column.name if len(column.name) <= 24 else column.name[:22] + "..."
    if not column.is_:
        return f"{name} [{column.file_unit}]" if column.file_unit else name
    if records and column.is_ in CHANNELS:
        return f"{name} → {column.is_} [{CHANNELS[column.is_].unit}]"
    if column.is_ == column.name:
        return with_unit(column.name)
    if column.is_ in LOAD_NAMES or column.is_ == "mu":
        return f"{name} → {with_unit(column.is_)}"
    return f"{name} → test table"


def _time(form: MapForm, table: RawTable) -> tuple[FloatArray, str]:
    for column in form.columns:
        if column.is_ == "t" and column.number:
            return _values(column, table, form.records), "t [s]"
    return np.arange(float(len(table.frame))), "row"


def _values(column: ColumnForm, table: RawTable, records: bool) -> FloatArray:
    """Return a column as it is mapped, or as it stands in the file where its unit does not fit."""
    values, _ = table.numbers(column.name)
    unit = column.unit or column.file_unit
    try:
        if records and column.is_:
            mapped = MappedColumn(
                column.is_,
                column.unit or None,
                scale=column.scale or None,
                sensitivity=column.sensitivity or None,
            )
            factor, shift = mapped.factor(unit, column.name)
            return column.sign * ((values - (column.offset or 0.0)) * factor + shift)
        if column.is_ in POINT_UNITS and unit:
            factor, shift = conversion(POINT_UNITS[column.is_], unit, column.name)
            return column.sign * (values * factor + shift)
    except InputError:
        pass
    return column.sign * values if column.is_ else values


def loads_figure(points: Any) -> ReadFigure | None:
    """Return mu over each load of points that were read."""
    loads = [n for n in (*LOAD_NAMES, "t") if n in points.columns]
    if not loads:
        return None
    chart = Chart.of_panels(len(loads), gap=0.36, legend=False, horizontal_spacing=0.05, shared_yaxes=True)
    rows = np.random.default_rng(0).permutation(len(points))[:CLOUD]
    mu = points["mu"].to_numpy()[rows]
    dots = {"size": _size(len(points), 4), "opacity": 0.6, "color": AFTER}
    for at, name in enumerate(loads):
        x, said = points[name].to_numpy()[rows], "%{x:.4g}, %{y:.4g}<extra></extra>"
        chart.scatter(at, x, mu, hover=said, mode="markers", marker=dots)
        chart.axes(at, x=label(name))
    chart.dress(215 * chart.rows + 40, y="mu")
    caption = f"{len(points)} points of {points['test_id'].nunique()} tests{_thinned(len(points))}."
    return as_read(with_fixed_margins(chart), caption, "Friction over each load.")


def _thinned(points: int) -> str:
    return f", thinned to {CLOUD}" if points > CLOUD else ""


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) and np.isfinite(value) else None
