"""FMU: pack a model, check the file, take it away."""

from __future__ import annotations

import asyncio

from nicegui import ui

from friction_models.common.markup import escape

from .. import commands
from ..worker import DONE, FAILED, Job
from .frame import page_head
from .parts import action, choice, download, empty, heading, line, say
from .parts import button as press
from .view import View


async def show(view: View) -> None:
    """Show the page."""
    page_head(
        "Take the model away",
        "A friction FMU runs in any simulator that loads FMI 2.0 or 3.0. It needs no Python and no other file.",
    )
    models = [view.project.relative(p) for p in view.project.models()]
    if not models:
        empty(
            "There is no model to pack yet",
            "Ask what the plain model is missing and add the effect, or train a model under Compare.",
            ("What is missing", "/"),
        )
    else:
        story = view.story()
        _pack(view, models, story.model if story.model in models else models[-1])
    files = await asyncio.to_thread(_sizes, view)
    if files:
        heading("In this project")
    for path, size in files:
        _file(view, path, size)


def _sizes(view: View) -> list[tuple[str, int]]:
    found = sorted(view.project.fmus(), key=lambda p: -p.stat().st_mtime)
    return [(view.project.relative(p), p.stat().st_size) for p in found]


def _pack(view: View, models: list[str], model: str) -> None:
    """Show the options and the button, whose command line follows them."""
    chosen = {"model": model, "fmi": "2.0", "nodes": "1"}

    @ui.refreshable
    def button() -> None:
        command = commands.pack(chosen["model"], chosen["fmi"], int(chosen["nodes"]))
        with ui.element("div").classes("action"):
            press("Pack as FMU", lambda: view.run(command), "first")
            line(command)

    def changed(name: str, value: str) -> None:
        chosen[name] = value
        button.refresh()

    with ui.element("div").classes("choices"):
        choice("Model", {m: commands.short(m) for m in models}, model, lambda v: changed("model", v))
        choice("FMI version", ["2.0", "3.0"], "2.0", lambda v: changed("fmi", v))
        nodes = ui.number("Contact points", value=1, min=1, max=100_000, precision=0)
        nodes.props("outlined dense").classes("choice")
        nodes.on_value_change(lambda e: changed("nodes", str(int(e.value or 1))))
    button()


def _file(view: View, path: str, size: int) -> None:
    check = commands.check(path)
    with ui.element("section").classes("panel"):
        heading(path.removeprefix("fmus/"))
        say(f"{size / 1000:.0f} kB", "soft")
        with ui.element("div").classes("buttons"):
            download(path, "Download")
        action(view, check, "Check it")
        job = view.worker.last(check.arguments)
        if job is not None and job.state in {DONE, FAILED}:
            _checked(job)


def _checked(job: Job) -> None:
    """Show what the check said."""
    failed = [x for x in job.lines if x.strip().startswith("failed")]
    if job.state == DONE:
        passed = sum(x.strip().startswith("passed") for x in job.lines)
        say(f"It passed all {passed} checks.")
    else:
        say(f"The check failed: {'; '.join(failed) or job.problem()}", "problem")
    with ui.expansion("What was checked").classes("other"):
        ui.html(escape("\n".join(job.lines)), sanitize=False, tag="pre")
