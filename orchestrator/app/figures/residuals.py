"""Where models miss: residuals over one load and over two, cell by cell, and the curves of single tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from friction_models.common import InputError, check_readable
from friction_models.common.markup import escape
from friction_models.common.wording import counted
from friction_models.discovery.answer.figures_data import varied
from friction_models.discovery.answer.summaries import clustered_mean, load_bins
from friction_models.loads import LOAD_NAMES, MU
from friction_models.loads.contract import with_unit

from ...comparison.on_tests import OF
from ...report.charts.residuals import binned_residual
from ...report.parts.chart import Chart
from ...report.parts.theme import INK, PRESS, SIGNED, looks
from ...report.reading import ReadFigure
from ..project.loaded import kept_while_unchanged
from .report_charts import as_read

#: Most bins of each load in a map, most points of a curve, largest file that is read [byte].
BINS, POINTS, LARGEST = 6, 400, 500_000_000
#: Residuals from too high a model over none to too low a one.


@dataclass(frozen=True)
class Cell:
    """Points between bounds of two loads (of one where both are the same).

    `mean` is that of measured - model, `half` half of its 95 % interval over tests (NaN for one test).
    """

    bounds: tuple[tuple[float, float], tuple[float, float]]
    place: tuple[int, int]
    mean: float
    half: float
    tests: list[str]

    @property
    def apart(self) -> float:
        """By how much the mean is surely away from zero; a single test is never sure."""
        return abs(self.mean) - self.half if np.isfinite(self.half) else -np.inf


@kept_while_unchanged(2)
def points_of(file: Path) -> pd.DataFrame:
    """Return the points that `compare --points` wrote; raises InputError for another table."""
    check_readable(file, LARGEST)
    try:
        frame = pd.read_parquet(file)
        numbers = [c for c in frame.columns if c in (*LOAD_NAMES, MU.name) or str(c).startswith(OF)]
        frame = frame.astype(dict.fromkeys(numbers, float) | {"test_id": str})
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"{file.name}: cannot be read ({' '.join(str(error).split())[:200]}); allowed: a table that "
            "compare --points wrote"
        ) from None
    if MU.name not in frame.columns or not models_of(frame):
        raise InputError(f"{file.name}: no mu of a model; allowed: a table that compare --points wrote")
    return frame


def models_of(frame: pd.DataFrame) -> list[str]:
    """Return the names of the models in a table of points."""
    return [str(c).removeprefix(OF) for c in frame.columns if str(c).startswith(OF)]


def cells(frame: pd.DataFrame, model: str, first: str, second: str) -> list[Cell]:
    """Return the residual of a model in each cell of two loads, whose bins are quantiles.

    Examples
    --------
    Six tests at two temperatures; the model is right at 20 degC and 0.01 too low at 80 degC:

    >>> points = pd.DataFrame({"test_id": list("abcdef"), "T": [20.0] * 3 + [80.0] * 3, "mu of law": 0.1})
    >>> found = cells(points.assign(mu=[0.1] * 3 + [0.11] * 3), "law", "T", "T")
    >>> [(cell.bounds[0], round(cell.mean, 6), cell.tests) for cell in found]
    [((20.0, 20.0), 0.0, ['a', 'b', 'c']), ((80.0, 80.0), 0.01, ['d', 'e', 'f'])]
    """
    residual = (frame[MU.name] - frame[f"{OF}{model}"]).to_numpy()
    names, test = np.unique(frame["test_id"].to_numpy().astype(str), return_inverse=True)
    values = [frame[n].to_numpy() for n in (first, second)]
    which = [load_bins(v, BINS) for v in values]
    found = []
    for i in range(int(which[0].max()) + 1):
        for j in range(int(which[1].max()) + 1):
            inside = (which[0] == i) & (which[1] == j)
            if not inside.any():
                continue
            mean, half, _ = clustered_mean(residual, np.ones(len(residual)), test.astype(np.intp), inside)
            low, high = ((float(v[w == k].min()), float(v[w == k].max())) for v, w, k in zip(values, which, (i, j), strict=True))  # fmt: skip
            found.append(Cell((low, high), (i, j), mean, half, [str(n) for n in names[np.unique(test[inside])]]))  # fmt: skip
    return found


def between(bounds: tuple[float, float]) -> str:
    """Return bounds in words.

    Examples
    --------
    >>> between((5.0, 5.0)), between((20.0, 301.2345))
    ('5', '20 to 301.2')
    """
    low, high = (f"{v:.4g}" for v in bounds)
    return low if low == high else f"{low} to {high}"


def over_loads(frame: pd.DataFrame, models: Sequence[str]) -> ReadFigure:
    """Return the mean residual of models over each load that varies, with intervals over tests."""
    names = varied(frame) or [LOAD_NAMES[0]]
    chart = Chart.of_panels(len(names), shared_yaxes=True, horizontal_spacing=0.03, gap=0.35)
    styles = looks(models)
    ids = frame["test_id"].to_numpy().astype(str)
    for panel, name in enumerate(names):
        for model in models:
            residual = (frame[MU.name] - frame[f"{OF}{model}"]).to_numpy()
            found = binned_residual(frame[name].to_numpy(), residual, ids)
            chart.scatter(
                panel, found.centre, found.mean, escape(model), f"{name} %{{x:.4g}}<br>%{{y:+.4f}}<extra>%{{fullData.name}}</extra>",
                mode="lines+markers", line=styles[model], marker={"size": 5},
                error_y={"type": "data", "array": np.nan_to_num(found.half), "width": 2, "thickness": 1},
            )  # fmt: skip
        chart.axes(panel, x=with_unit(name))
    chart.dress(260 * chart.rows + 60, y="measured &#8722; model (mu)")
    caption = "Mean of measured minus predicted mu in bins of each load; bars are 95 % intervals, which count whole tests."
    return as_read(chart, caption, "Residual of each model over each load.")


def cell_map(found: Sequence[Cell], first: str, second: str) -> ReadFigure:
    """Return the map of residuals over two loads, one square a cell."""
    ends: tuple[dict[int, str], dict[int, str]] = ({}, {})
    for cell in found:
        for side in (0, 1):
            ends[side][cell.place[side]] = between(cell.bounds[side])
    shape = (max(ends[1]) + 1, max(ends[0]) + 1)
    mean, said = np.full(shape, np.nan), np.full(shape, "", dtype=object)
    for cell in found:
        at = cell.place[::-1]
        mean[at] = cell.mean
        interval = f" &#177; {cell.half:.4f}" if np.isfinite(cell.half) else ""
        said[at] = f"{cell.mean:+.4f}{interval}<br>{counted(len(cell.tests), 'test')}"
    most = float(np.nanmax(np.abs(mean))) or 1e-6
    chart = Chart(legend=False)
    chart.figure.add_heatmap(
        z=mean, text=said, texttemplate="%{text}", textfont={"size": 11, "color": INK}, hoverinfo="text",
        colorscale=SIGNED, zmin=-1.6 * most, zmax=1.6 * most, xgap=2, ygap=2, showscale=False,
    )  # fmt: skip
    # Labels of a cell need this much room: on a phone the map is moved sideways.
    chart.dress(
        90 + 62 * shape[0],
        meta={"least_width": 170 + 110 * shape[1]},
        x=with_unit(first),
        y=with_unit(second),
    )
    for update, labels in ((chart.figure.update_xaxes, ends[0]), (chart.figure.update_yaxes, ends[1])):
        update(tickvals=list(labels), ticktext=[labels[k] for k in labels], showgrid=False, zeroline=False)
    caption = (
        "Mean of measured minus predicted mu with its 95 % interval over tests: orange, the model is too low; blue, it is too "
        "high. Press a cell to open its tests."
    )
    return as_read(chart, caption, f"Residual over {first} and {second}; the table below holds the same numbers.")  # fmt: skip


def curves(frame: pd.DataFrame, test: str, models: Sequence[str]) -> ReadFigure:
    """Return mu over the sliding distance of one test, measured and of each model."""
    part = frame[frame["test_id"] == test]
    part = part.iloc[:: max(1, len(part) // POINTS)]
    slid = "sd" in part.columns and float(np.ptp(part["sd"])) > 0.0
    along = part["sd"].to_numpy() if slid else np.arange(1, len(part) + 1)
    chart = Chart()
    said = "%{x:.4g}: %{y:.4f}<extra>%{fullData.name}</extra>"
    chart.scatter(0, along, part[MU.name], "measured", said, mode="markers", marker={"size": 5, "color": PRESS})  # fmt: skip
    styles = looks(models)
    for model in models:
        chart.scatter(0, along, part[f"{OF}{model}"], escape(model), said, mode="lines" if len(part) > 1 else "markers", line=styles[model])  # fmt: skip
    chart.dress(330, x=with_unit("sd") if slid else "number of the point", y="mu")
    loads = ", ".join(f"{with_unit(n)} {between((float(part[n].min()), float(part[n].max())))}" for n in LOAD_NAMES if n in part.columns)  # fmt: skip
    return as_read(chart, f"Test {escape(test)}: {escape(loads)}.", f"mu of test {test}.")
