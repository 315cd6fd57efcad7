"""Forming: a process with several friction models, their forces over each other, the loads along the contact."""

from __future__ import annotations

import asyncio
from functools import partial

from nicegui import ui

from friction_models.common import InputError
from friction_models.common.files import read_json
from friction_models.common.markup import escape
from friction_models.loads import not_measured

from .. import commands
from ..project import is_name
from ..project.loaded import loaded
from ..serving import address
from .compare import CONSTANTS
from .elements import action, button, choice, download, empty, fold, heading, panel, reading, say, told, words
from .forming_form import ask, first_form, processes
from .forming_state import FormState, constants_of
from .frame import page_head
from .report_sections import badge, parts, section
from .view import View


async def show(view: View) -> None:
    """Show the page."""
    page_head(
        "Forming",
        "One process with several friction models: forces laid over each other and over the press, loads along the contact.",
    )
    waiting = say("One moment: the solver is being loaded.", "soft")
    known = await asyncio.to_thread(processes)
    form = view.kept.setdefault(
        "forming", FormState.of(view.project.kept("forming"), known) or first_form(view)
    )
    waiting.delete()
    await ask(view, form)
    await _every_press_level(view, form)
    with told(view):
        await _results(view)


async def _every_press_level(view: View, form: FormState) -> None:
    """Offer to form all levels of each folder of press curves."""
    folders = await asyncio.to_thread(view.project.press_folders)
    if not folders:
        return
    try:
        models = [*form.models, *constants_of(form.constants)]
    except InputError:
        models = list(form.models)
    with fold(view, "Form every level of the press"):
        say(
            "Errors of the largest force and of the work over all levels, with what the scatter of the press leaves open."
        )
        for folder in folders:
            command = commands.forming.form_press(view.project.relative(folder), models or [CONSTANTS[1]])
            action(view, command, command.title)


async def _results(view: View) -> None:
    """Show the results of one name, and the names of the others."""
    reports = await asyncio.to_thread(view.project.reports)
    names = [
        p.stem.removeprefix("forming-") for p in reports if p.stem.startswith("forming-") and is_name(p.stem)
    ]
    if not names:
        empty(
            "There are no forming runs yet",
            "Choose a process and friction models above and run them; constants alone are enough to begin with. Measured "
            "force curves go into the folder press, then the runs are laid over them.",
        )
        return
    asked = (view.kept.get("forming shown"), view.query.get("name"))
    name = next((n for n in asked if n in names), names[0])
    heading(f"Results: {name}")
    if len(names) > 1:

        def chosen(value: str) -> None:
            view.kept["forming shown"] = value
            ui.navigate.to(f"/forming?name={value}")

        choice("Results", names, name, chosen)
    _, json, path = commands.forming.results(name)
    page = await asyncio.to_thread(view.page, path)
    if page is None:
        return
    with ui.element("section"):
        words(f"<p><strong>{escape(page.title)}</strong>. {page.lead}</p>")
        badge(page)
        with ui.element("div").classes("buttons"):
            reading(address(path, read=True), "Read the report")
            if view.project.inside(json).is_file():
                download(json, "Numbers (JSON)")
    for found in page.sections:
        section(found)
    await _coverage(view, name)


async def _coverage(view: View, name: str) -> None:
    """Show which of the loads were tested; ask where nothing was."""
    runs = await asyncio.to_thread(_runs, view, name)
    data = view.story().data
    if not runs:
        return
    with panel("Were these loads tested?"):
        if not data:
            say(
                "There are no measurements yet: bring some, and the loads of the process are held against them."
            )
            ui.link("Bring measurements", "/measurements").classes("button")
            return
        lacking = not_measured((await asyncio.to_thread(loaded, view.project.inside(data))).points.columns)
        if lacking:
            say(
                f"The measurements in hand, {commands.short(data)}, lack {', '.join(lacking)}: what was tested can be told only where "
                "all five loads were recorded. Choose others under Measurements."
            )
            return
        for label, run in runs.items():
            command = commands.forming.coverage(data, run, f"{name}-{label}")
            _, path, plan = commands.forming.coverage_files(data, f"{name}-{label}")
            page = await asyncio.to_thread(view.page, path)
            if page is None:
                action(view, command, f"Ask for {label}")
                continue
            words(f"<h3>{escape(label)}</h3><p>{page.lead}</p>")
            for found in page.sections:
                if found.anchor in {"loads", "pairs", "tests"}:
                    words(f"<h4>{escape(found.heading)}</h4>")
                    parts(found.parts)
            with ui.element("div").classes("buttons"):
                if view.project.inside(plan).is_file():
                    download(plan, "Download the tests (CSV)")
                button("Ask again", partial(view.run, command))


def _runs(view: View, name: str) -> dict[str, str]:
    """Return one run of each level, by the name of the level: that of the first model."""
    found: dict[str, str] = {}
    top = next((p for p in view.project.run_folders() if p.name == name), None)
    for folder in sorted(top.iterdir()) if top is not None else []:
        listed = folder / "runs.json"
        if not (is_name(folder.name) and listed.is_file()):
            continue
        content = read_json(listed)
        for place in content.values() if isinstance(content, dict) else []:
            path = f"{view.project.relative(folder)}/{place}"
            try:
                kept = view.project.inside(path)
            except InputError:
                continue
            if all(is_name(part) for part in path.split("/")) and (kept / "results.nc").is_file():
                found[folder.name] = path
                break
    return found
