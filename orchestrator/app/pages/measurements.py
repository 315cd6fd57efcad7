"""Measurements: the data sets of the project, what was recognised in them, and bringing new ones."""

from __future__ import annotations

import asyncio
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import events, ui

from friction_models.common import InputError, atomic_path
from friction_models.common.markup import bullets, table

from .. import commands, history
from ..project import name_of
from .frame import page_head
from .parts import button, empty, heading, say, words
from .view import View

#: Largest file that is taken [byte].
LARGEST = 100_000_000
_SUFFIXES = (".csv", ".parquet")


async def show(view: View) -> None:
    """Show the page."""
    page_head(
        "Measurements",
        "Data sets in the folder data of the project: points of tests with the loads and the measured friction.",
    )
    sets = [view.project.relative(p) for p in view.project.data_sets()]
    found = await asyncio.to_thread(lambda: [_look(view.project.inside(s)) for s in sets])
    if not sets:
        empty(
            "There are none yet",
            "Bring a table of points: a column test_id, the loads that were measured (v_rel, T, sigma_n, sd, psi) and mu.",
        )
    story = view.story()
    for name, looked in zip(sets, found, strict=True):
        with ui.element("section").classes("panel"):
            heading(commands.short(name))
            if isinstance(looked, str):
                say(looked, "problem")
                continue
            if looked["synthetic"]:
                ui.label("synthetic data").classes("badge")
            words(table(["quantity", "found"], looked["rows"], narrow=True))
            words(bullets(looked["notes"]))
            if name == story.data:
                say("This is the data set in hand.", "soft")
            else:
                button("Use it", partial(view.choose, name, story.rounds[0].model))
            ui.link("Explore", f"/explore?data={name}").classes("button")
    _bring(view)


def _look(path: Path) -> dict[str, Any] | str:
    """Return what is in a data set, or in one sentence why it cannot be read."""
    from friction_models.loads import LOAD_NAMES, DataSet, not_measured
    from friction_models.loads.contract import with_unit

    try:
        found = DataSet.load(path)
    except InputError as error:
        return str(error)
    points = found.points
    rows = [
        ("tests", points["test_id"].nunique()),
        ("points", len(points)),
        *(
            (with_unit(n) if n in LOAD_NAMES else n, f"{points[n].min():.4g} to {points[n].max():.4g}")
            for n in (*LOAD_NAMES, "mu")
            if n in points.columns
        ),
    ]
    if found.tests is not None and "role" in found.tests.columns:
        roles = found.tests["role"].astype(str).value_counts()
        rows.insert(1, ("roles", ", ".join(f"{count} {role}" for role, count in roles.items())))
    lacking = not_measured(points.columns)
    notes = [*([f"not measured: {', '.join(lacking)}"] if lacking else []), *found.notes]
    return {"rows": rows, "notes": notes, "synthetic": found.synthetic}


def _bring(view: View) -> None:
    with ui.element("section"):
        heading("Bring a table of points")
        say(
            f"CSV or Parquet, at most {LARGEST / 1e6:.0f} MB. Raw files of a data logger first pass through tribofmu ingest and "
            "tribofmu twin, which write such a data set.",
            "soft",
        )
        said = ui.element("div").props('role="status"')

        async def taken(event: events.UploadEventArguments) -> None:
            said.clear()
            with said:
                try:
                    name = await _keep(view, event)
                except InputError as error:
                    say(str(error), "problem")
                else:
                    ui.notify(f"{name} is in the project.", type="positive")
                    view.note(history.BROUGHT, data=name)

        upload = ui.upload(
            on_upload=taken,
            auto_upload=True,
            max_file_size=LARGEST,
            on_rejected=lambda: ui.notify("This file is too large or of another kind.", type="negative"),
            label="Drop a file here",
        )
        upload.props(f'accept="{",".join(_SUFFIXES)}" flat bordered').classes("upload")
        # The button of the uploader has no name for a screen reader.
        choose = button("Choose a file", lambda: None)
        choose.on("click", js_handler=f"() => getElement({upload.id}).$refs.qRef.pickFiles()")


async def _keep(view: View, event: events.UploadEventArguments) -> str:
    """Put a file into the folder data; what is there already is not replaced, and what cannot be read is not kept."""
    file = event.file
    name = name_of(file.name)
    if Path(name).suffix not in _SUFFIXES:
        raise InputError(f"{name}: suffix {Path(name).suffix!r}; allowed: {', '.join(_SUFFIXES)}")
    if file.size() > LARGEST:
        raise InputError(f"{name}: {file.size()} byte; allowed: at most {LARGEST}")
    path = view.project.inside(f"data/{name}")
    if path.exists():
        raise InputError(f"{name}: is in the project already; allowed: another name")
    with atomic_path(path) as temporary:
        await file.save(temporary)
        looked = await asyncio.to_thread(_look, temporary)
        if isinstance(looked, str):
            raise InputError(looked.replace(str(temporary), name))
    return f"data/{name}"
