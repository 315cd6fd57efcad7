"""Measurements: the data sets of the project, what was recognised in them, and bringing new ones."""

from __future__ import annotations

import asyncio
from functools import partial
from pathlib import Path
from typing import NamedTuple

from nicegui import ui

from friction_models.common import InputError
from friction_models.common.markup import bullets, table
from friction_models.common.wording import counted

from ... import commands
from ...project import Project
from ...project.loaded import kept_while_unchanged, loaded
from ..elements import button, empty, heading, panel, say, words
from ..frame import page_head
from ..view import View
from . import raw_set, taken_in, tests_editor
from .bring import bring
from .moving import bring_back


class _Found(NamedTuple):
    """What is in a data set: rows of a table, remarks, and whether it is synthetic."""

    rows: list[tuple[str, object]]
    notes: list[str]
    synthetic: bool


async def show(view: View) -> None:
    """Show the page: the list, one set of files (``?raw=``) or one test table (``?tests=``)."""
    if "raw" in view.query:
        await raw_set.show(view, view.query["raw"])
        return
    if "tests" in view.query:
        await tests_editor.show(view, view.query["tests"])
        return
    page_head(
        "Measurements",
        "From raw files to data sets: points of tests with the loads and the measured friction.",
    )
    project = view.project
    sets = list(view.data_sets())
    places = [project.inside(s) for s in sets]
    found = await asyncio.to_thread(lambda: list(map(_looked, places)))
    if not sets:
        empty(
            "There are no data sets yet",
            "Drop records of a tribometer or tables of points below; the next page asks what each column is.",
        )
    else:
        ui.link("Bring measurements", "#bring").classes("button")
    story = view.story()
    for name, looked in zip(sets, found, strict=True):
        _data_set(view, name, looked, story.data)
    _raw_sets(project)
    bring_back(view)
    bring(view, "Bring measurements")


def _data_set(view: View, name: str, looked: _Found | str, in_hand: str) -> None:
    with panel(commands.short(name)):
        if isinstance(looked, str):
            say(looked, "problem")
            return
        if looked.synthetic:
            ui.label("synthetic data").classes("badge")
        words(table(["quantity", "found"], looked.rows, narrow=True))
        words(bullets(looked.notes))
        with ui.element("div").classes("buttons"):
            if name == in_hand:
                ui.link("Ask what is missing", "/").classes("button first")
            else:
                button("Take it in hand", partial(taken_in.use, view, name), "first")
            ui.link("Explore", f"/explore?data={name}").classes("button")
            if (view.project.root / name).is_dir():
                ui.link("Edit the test table", f"/measurements?tests={name}").classes("button")
        if name == in_hand:
            say("This is the data set in hand.", "soft")


def _raw_sets(project: Project) -> None:
    sets = project.raw_sets()
    if not sets:
        return
    with ui.element("section"):
        heading("Measurement files")
        with ui.element("div").classes("buttons"):
            for folder in sets:
                files = sum(1 for p in folder.iterdir() if p.is_file() and p.suffix not in {".yaml", ".yml"})
                said = f"{folder.name}: {counted(files, 'file')}"
                ui.link(said, f"/measurements?raw={folder.name}").classes("button")


@kept_while_unchanged(50)
def _looked(path: Path) -> _Found | str:
    """Return what is in a data set, or in one sentence why it cannot be read."""
    from friction_models.loads import LOAD_NAMES, not_measured
    from friction_models.loads.contract import QUANTITIES, with_unit
    from friction_models.loads.dataset import roles_of

    try:
        found = loaded(path)
    except InputError as error:
        return str(error)
    points = found.points
    idle: list[str] = []
    rows: list[tuple[str, object]] = [
        ("tests", points["test_id"].nunique()),
        ("points", len(points)),
        *(
            (with_unit(n), f"{points[n].min():.4g} to {points[n].max():.4g}")
            for n in (*LOAD_NAMES, "mu")
            if n in points.columns and points[n].notna().any()
        ),
    ]
    if found.tests is not None and "role" in found.tests.columns:
        roles = roles_of(found.tests["role"]).value_counts()
        rows.insert(1, ("roles", ", ".join(f"{count} {role}" for role, count in roles.items())))
        if "train" not in roles:
            idle = ["no test has the role train: models have nothing to learn from (edit the test table)"]
    lacking = [f"{n} ({QUANTITIES[n].meaning.partition(',')[0]})" for n in not_measured(points.columns)]
    notes = [*idle, *([f"not measured: {', '.join(lacking)}"] if lacking else []), *found.notes]
    return _Found(rows, notes, found.synthetic)
