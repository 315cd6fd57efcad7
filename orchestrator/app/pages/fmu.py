"""FMU: pack a model, check the file, take it away."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from nicegui import ui

from friction_models.common.markup import escape

from .. import commands
from ..commands.fmus import MOST_NODES, SWITCHES, TARGETS, PackOptions, pack, platform_names
from ..project.project import changed
from ..serving import has_page, page_address
from ..work.job import DONE, FAILED, Job
from .frame import page_head
from .parts import action, choice, download, empty, fold, heading, line, say
from .parts import button as press
from .view import View


@dataclass
class _Choices:
    """What is to be packed, and how."""

    model: str
    options: PackOptions = field(default_factory=PackOptions)


async def show(view: View) -> None:
    """Show the page."""
    page_head(
        "Take the model away",
        "A friction FMU runs in any simulator that loads FMI 2.0 or 3.0. It needs no Python and no other file.",
    )
    project = view.project
    models = [project.relative(p) for p in (*project.models(), *project.onnx_models())]
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
    found = sorted([*view.project.fmus(), *view.project.systems()], key=changed, reverse=True)
    return [(view.project.relative(p), p.stat().st_size) for p in found if p.is_file()]


def _pack(view: View, models: list[str], model: str) -> None:
    """Show the options and the button, whose command line follows them."""
    kept: _Choices = view.kept.setdefault("fmu", _Choices(model))
    if kept.model not in models:
        kept.model = model

    @ui.refreshable
    def button() -> None:
        if problem := kept.options.problem():
            say(problem, "problem")
            return
        command = pack(kept.model, kept.options)
        with ui.element("div").classes("action"):
            press("Pack as FMU", lambda: view.run(command), "first")
            line(command)

    def changed(name: str, value: Any) -> None:
        if name == "model":
            kept.model = value
        else:
            kept.options = replace(kept.options, **{name: value})
        button.refresh()

    options = kept.options
    with ui.element("div").classes("choices").style("align-items: flex-start"):
        choice("Model", {m: commands.short(m) for m in models}, kept.model, partial(changed, "model"))
        choice("FMI version", ["2.0", "3.0"], options.fmi, partial(changed, "fmi"))
        nodes = ui.number("Contact points", value=options.nodes, min=1, max=MOST_NODES, precision=0)
        nodes.props("outlined dense").classes("choice").props["hint"] = (
            "1, or the nodes of a contact as arrays"
        )
        nodes.on_value_change(lambda e: changed("nodes", int(e.value or 1)))
    with fold(view, "More options"):
        # Only some of them have a hint below.
        with ui.element("div").classes("choices").style("align-items: flex-start"):
            choice("Runs as", TARGETS, options.target, partial(changed, "target"))
            names = choice(
                "Platforms", {n: n for n in platform_names()}, list(options.platforms),
                lambda v: changed("platforms", tuple(v)), multiple=True,
            )  # fmt: skip
            names.props("use-chips").style("min-width: 270px").props["hint"] = (
                "without one: that of this machine"
            )
            named = ui.input("Name inside the FMU", value=options.name)
            named.props("outlined dense").classes("choice").props["hint"] = "without one: from the model"
            named.on_value_change(lambda e: changed("name", str(e.value or "").strip()))
        for name, words in SWITCHES.items():
            ui.checkbox(
                words, value=getattr(options, name), on_change=lambda e, n=name: changed(n, bool(e.value))
            )
    button()


def _file(view: View, path: str, size: int) -> None:
    check = commands.fmus.check(path)
    with ui.element("section").classes("panel"):
        heading(path.removeprefix("fmus/"))
        say(f"{size / 1000:.0f} kB", "soft")
        with ui.element("div").classes("buttons"):
            download(path, "Download")
            if has_page(view.project.inside(path)):
                page = ui.link("Read its page", page_address(path), new_tab=True)
                page.classes("button").props('rel="noopener"')
        if path.endswith(".ssp"):
            say("A system around the FMU; the FMU alone can be checked here.", "soft")
            return
        action(view, check, "Check it")
        job = view.worker.last(check.arguments)
        if job is not None and job.state in {DONE, FAILED}:
            _checked(view, path, job)


def _checked(view: View, path: str, job: Job) -> None:
    """Show what the check said."""
    failed = [x for x in job.lines if x.strip().startswith("failed")]
    if job.state == DONE:
        passed = sum(x.strip().startswith("passed") for x in job.lines)
        say(f"It passed all {passed} checks.")
    else:
        say(f"The check failed: {'; '.join(failed) or job.problem()}", "problem")
    with fold(view, "What was checked", f"check of {path}"):
        ui.html(escape("\n".join(job.lines)), sanitize=False, tag="pre")
