"""Pictures of measurements that are brushed together: the same points in all of them, in the same order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from friction_models.common.markup import escape
from friction_models.loads import LOAD_NAMES, DataSet
from friction_models.loads.contract import with_unit

from ...report.parts.chart import Chart
from ...report.parts.theme import AFTER, COLORS, CONSTANT, INK, LINE
from ...report.reading import ReadFigure
from .report_charts import as_read, with_fixed_margins

#: Most points that are drawn, and most levels that have a colour of their own.
MOST, LEVELS = 3000, 8
#: Of more tests the points are not joined: lines would be an area.
LINES = 150
#: From dark to light at even steps of lightness, so that it also holds in grey.
_SCALE = [[0.0, "#34589a"], [0.35, "#1f7f86"], [0.7, "#8db35c"], [1.0, "#f2d95c"]]
#: Points that are not picked. An opacity of each point would be a layer of its own for the browser, which thousands of them bring to
#: a stand; that of a colour costs nothing.
_FAINT = "rgba(127, 140, 153, 0.1)"
#: What the plan of a test sets each load to, in the test table.
SETTINGS = {"v_rel": "v_set", "T": "T_tool", "sigma_n": "sigma_set", "sd": "sd_set", "psi": "psi_set"}


@dataclass(frozen=True)
class Sample:
    """Points that are drawn, of a `whole` number of points."""

    #: Points with the metadata of their tests; the points of a test stand together, in their order.
    frame: pd.DataFrame
    whole: int
    #: Names of the tests, by their number in the column ``test_number``.
    tests: list[str]


def sample(dataset: DataSet, chosen: str = "") -> Sample:
    """Return points of a data set, the same share of every test; `chosen`: part of the names of the tests.

    Examples
    --------
    >>> points = pd.DataFrame({"test_id": ["a"] * 9000 + ["b"] * 1000, "sd": np.arange(10_000.0), "mu": 0.1})
    >>> found = sample(DataSet(points))
    >>> drawn = found.frame["test_id"].value_counts()
    >>> len(found.frame) <= MOST, found.whole, round(drawn["a"] / drawn["b"])
    (True, 10000, 9)
    """
    points = dataset.points
    if chosen:
        names = points["test_id"].unique()
        kept = [name for name in names if chosen.casefold() in str(name).casefold()]
        points = points[points["test_id"].isin(kept)]
    whole = len(points)
    numbers, tests = pd.factorize(points["test_id"])
    codes: np.ndarray = np.asarray(numbers, dtype=np.int32)
    if whole > MOST:
        begins = np.flatnonzero(np.r_[True, codes[1:] != codes[:-1]])
        ends = np.r_[begins[1:], whole]
        draw = np.random.default_rng(0)
        rows = [
            b + _spread(e - b, max(2, round((e - b) * MOST / whole)), draw)
            for b, e in zip(begins, ends, strict=True)
        ]
        points = points.iloc[np.concatenate(rows)]
        codes = codes[np.concatenate(rows)]
    frame = points.assign(test_number=codes)
    if dataset.tests is not None:
        more = [c for c in dataset.tests.columns if c == "test_id" or c not in frame.columns]
        frame = frame.merge(dataset.tests[more], on="test_id", how="left")
    return Sample(frame.reset_index(drop=True), whole, [str(name) for name in tests])


def _spread(count: int, wanted: int, draw: np.random.Generator) -> np.ndarray:
    """Return rows of a test: first, last, and one out of each of the equal pieces between them.

    One at random: rows at even steps would lie at the same places in all tests, and hide what is between them.
    """
    pieces = max(1, wanted - 2)
    inner = 1 + ((np.arange(pieces) + draw.random(pieces)) * (count - 2) / pieces).astype(int)
    return np.unique(np.r_[0, inner, count - 1].clip(0, count - 1))


def levels(values: pd.Series) -> list[str]:
    """Return the names that have a colour of their own: the commonest, at most `LEVELS`; empty for numbers."""
    if pd.api.types.is_numeric_dtype(values):
        return []
    return sorted(values.dropna().astype(str).value_counts().index[:LEVELS])


def cloud(found: Sample, x: str, y: str, color: str, lines: bool = False, plan: bool = False) -> ReadFigure:
    """Return a cloud of points; pictures of the same sample and `color` have the same curves, point by point.

    `x` and `y` are columns of numbers. `color` is a column, of which numbers have a scale and names a colour each; '' for one
    colour. With `lines` the points of a test are joined; with `plan` it also shows what the tests were set to.
    """
    frame = found.frame
    named = bool(color) and not pd.api.types.is_numeric_dtype(frame[color])
    chart = Chart(legend=named)
    size = 8 if len(frame) < 300 else 4.5
    if lines and len(found.tests) <= LINES:
        # One curve for all tests, broken between them, and under the points.
        breaks = np.flatnonzero(np.diff(frame["test_number"].to_numpy())) + 1
        chart.figure.add_scatter(
            x=np.insert(_floats(frame[x]), breaks, np.nan), y=np.insert(_floats(frame[y]), breaks, np.nan), mode="lines",
            line={"width": 0.6, "color": LINE}, hoverinfo="skip", showlegend=False,
        )  # fmt: skip
    for rows, name, look in _parts(frame, color):
        part = frame.iloc[rows]
        chart.figure.add_scatter(
            x=_floats(part[x]), y=_floats(part[y]), mode="markers", name=escape(name), showlegend=named,
            customdata=part["test_number"].to_numpy(np.int32), text=[escape(t) for t in part["test_id"]],
            marker={"size": size, "opacity": 1.0, **look}, selected={"marker": {"opacity": 1.0, "size": size + 2}}, unselected={"marker": {"opacity": 1.0, "color": _FAINT}},
            hovertemplate=f"%{{text}}<br>{escape(x)} %{{x:.4g}}<br>{escape(y)} %{{y:.4g}}<extra></extra>",
        )  # fmt: skip
    set_x, set_y = SETTINGS.get(x, ""), SETTINGS.get(y, "")
    if plan and set_x in frame.columns and set_y in frame.columns:
        wanted = frame[[set_x, set_y]].drop_duplicates().apply(pd.to_numeric, errors="coerce").dropna()
        if len(wanted):
            chart.figure.add_scatter(
                x=_floats(wanted[set_x]), y=_floats(wanted[set_y]), mode="markers", name="plan", showlegend=True,
                marker={"symbol": "cross-thin", "size": 9, "line": {"width": 1.5, "color": INK}},
                hovertemplate=f"plan: {set_x} %{{x:.4g}}, {set_y} %{{y:.4g}}<extra></extra>",
            )  # fmt: skip
            chart.legend = True
    across, up = escape(label(x)), escape(label(y))
    made = chart.dress(380, across, up, dragmode="select", selectdirection="any")
    if not chart.legend:
        made = with_fixed_margins(made, right=96 if color else 14)
    return as_read(made, "", f"{y} over {x}, coloured by {color or 'nothing'}.")


def _parts(frame: pd.DataFrame, color: str) -> list[tuple[np.ndarray, str, dict[str, Any]]]:
    """Return rows, name and look of each curve of points."""
    if not color:
        return [(np.arange(len(frame)), "points", {"color": AFTER})]
    names = levels(frame[color])
    if not names and pd.api.types.is_numeric_dtype(frame[color]):
        title = {"text": escape(label(color)), "side": "right", "font": {"size": 13}}
        bar = {"title": title, "thickness": 12, "outlinewidth": 0}
        look = {"color": _floats(frame[color]), "colorscale": _SCALE, "colorbar": bar, "showscale": True}
        return [(np.arange(len(frame)), "points", look)]
    values = frame[color].astype(str)
    found = [(np.flatnonzero((values == n).to_numpy()), n, {"color": COLORS[k]}) for k, n in enumerate(names)]
    rest = np.flatnonzero((~values.isin(names)).to_numpy())
    return [*found, *([(rest, "others", {"color": CONSTANT})] if len(rest) else [])]


def summary(found: Sample, picked: Sequence[int], y: str) -> list[tuple[str, str]]:
    """Return what is to be said of the tests that were picked: how many, and ranges of loads and `y`."""
    frame = found.frame[found.frame["test_number"].isin(list(picked))]
    rows = [("tests", str(frame["test_number"].nunique()))]
    for name in dict.fromkeys([*(n for n in LOAD_NAMES if n in frame.columns), y]):
        values = _floats(frame[name])
        if np.isfinite(values).any():
            rows.append((label(name), f"{np.nanmin(values):.4g} to {np.nanmax(values):.4g}"))
    return rows


def _floats(values: pd.Series) -> np.ndarray:
    # Four bytes are more than a screen shows, and half of what goes over the line.
    return values.to_numpy(dtype=np.float32)


def label(name: str) -> str:
    """Return what a column is called beside an axis, with its unit."""
    return "t [s]" if name == "t" else with_unit(name)
