"""Explore: friction over distance, time or any load, coloured by whatever was recorded."""

from __future__ import annotations

import asyncio
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from nicegui import ui

from ...report.reading import ReadFigure
from .. import commands
from ..figures import as_read
from .frame import page_head
from .parts import choice, empty, picture
from .view import View

if TYPE_CHECKING:
    import pandas as pd

#: Columns that name things or stand for the table itself.
_NO_AXES = {"test_id"}


async def show(view: View) -> None:
    """Show the page."""
    project = view.project
    page_head("Explore the measurements", "Every point is one of a test; hover over it to see which.")
    sets = [project.relative(p) for p in project.data_sets()]
    if not sets:
        empty(
            "There are no measurements yet", "They are drawn here.", ("Bring measurements", "/measurements")
        )
        return
    story = view.story()
    data = view.query.get("data", story.data)
    data = data if data in sets else sets[0]
    frame = await asyncio.to_thread(_frame, project.inside(data))
    numbers = [c for c in frame.columns if frame[c].dtype.kind in "fiu" and c not in _NO_AXES]
    colors = [c for c in frame.columns if c not in _NO_AXES]
    chosen = {
        "x": "sd" if "sd" in numbers else numbers[0],
        "y": "mu" if "mu" in numbers else numbers[-1],
        "color": "v_rel" if "v_rel" in colors else "",
    }

    async def draw() -> None:
        figure = await asyncio.to_thread(
            _figure, project.inside(data), chosen["x"], chosen["y"], chosen["color"]
        )
        place.clear()
        with place:
            picture(figure, narrow=True)

    async def changed(name: str, value: object) -> None:
        chosen[name] = str(value or "")
        await draw()

    with ui.element("div").classes("choices"):
        choice(
            "Measurements", {s: commands.short(s) for s in sets}, data,
            lambda v: ui.navigate.to(f"/explore?data={v}"),
        )  # fmt: skip
        choice("Across", numbers, chosen["x"], lambda v: changed("x", v))
        choice("Up", numbers, chosen["y"], lambda v: changed("y", v))
        choice(
            "Colour",
            {"": "one colour", **{c: c for c in colors}},
            chosen["color"],
            lambda v: changed("color", v),
        )
    place = ui.element("div")
    await draw()


def _frame(path: Path) -> pd.DataFrame:
    """Return the points with the metadata of their tests, read once for as long as the files stay as they are."""
    return _read(path, _stamp(path))


def _stamp(path: Path) -> tuple[float, ...]:
    files = [path / "points.csv", path / "tests.csv"] if path.is_dir() else [path]
    return tuple(f.stat().st_mtime for f in files if f.is_file())


@lru_cache(maxsize=2)
def _read(path: Path, stamp: tuple[float, ...]) -> pd.DataFrame:
    from friction_models.loads import DataSet

    dataset = DataSet.load(path, need_mu=False)
    if dataset.tests is None:
        return dataset.points
    more = dataset.tests.reset_index() if "test_id" not in dataset.tests.columns else dataset.tests
    columns = ["test_id", *(c for c in more.columns if c not in dataset.points.columns)]
    return dataset.points.merge(more[columns], on="test_id", how="left")


def _figure(path: Path, x: str, y: str, color: str) -> ReadFigure:
    from ...report.charts.points import MOST, points_chart

    frame = _frame(path)
    columns = ["test_id", *dict.fromkeys(c for c in (x, y, color) if c)]
    clean = frame[columns].dropna()
    thinned = f", thinned to {MOST}" if len(clean) > MOST else ""
    chart = points_chart(clean, x, y, color)
    return as_read(
        "explore", chart, f"{len(clean)} points{thinned}.", f"{y} over {x}, coloured by {color or 'nothing'}."
    )
