"""FMU: pack a model, check the file, take it away."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from nicegui import ui

from fmus.native.platforms import PLATFORMS
from friction_models.common.markup import escape, table

from .. import commands
from ..commands.fmus import MOST_NODES, SWITCHES, TARGETS, PackOptions, last_check, pack
from ..fmu_facts import Facts, facts_of
from ..project import history
from ..project.history import Story
from ..project.project import changed
from ..serving import has_page, page_address
from ..work.command_run import DONE, FAILED, CommandRun
from .elements import (
    action,
    choice,
    download,
    empty,
    fold,
    heading,
    number_field,
    panel,
    reading,
    say,
    text_field,
    words,
)
from .frame import page_head
from .view import View


@dataclass
class _Choices:
    """What is to be packed, and how; without a choice the model follows the history of the project."""

    model: str = ""
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
        _pack(view, models)
    files = await asyncio.to_thread(_files, view)
    lines = await asyncio.to_thread(view.lines)
    if files:
        heading("In this project")
    for path, facts in files:
        _file(view, path, facts, last_check(lines, path))


def _files(view: View) -> list[tuple[str, Facts]]:
    """Return the FMUs and systems of the project, the newest first, with what is known of them."""
    found = sorted([*view.project.fmus(), *view.project.systems()], key=changed, reverse=True)
    return [(view.project.relative(p), facts_of(p)) for p in found if p.is_file()]


def _in_hand(models: list[str], story: Story, aside: Mapping[str, str]) -> str:
    """Return the model that is offered: that in hand, else one that was accepted or trained, else the last one."""
    accepted = [m for m in models if m not in aside]
    own = [m for m in (story.model, f"models/{story.model}") if m in accepted]
    return (own or accepted[-1:] or models[-1:])[0]


def _pack(view: View, models: list[str]) -> None:
    """Show the options and the button, whose command line follows them."""
    kept: _Choices = view.kept.setdefault("fmu", _Choices())
    story, lines = view.story(), view.lines()
    aside = {m: why for m, why in history.set_aside(lines).items() if m != story.model}
    # What was chosen here holds until something else is decided about that model.
    if kept.model not in models or (kept.model in aside and view.kept.get("fmu aside") != aside):
        kept.model = ""
    view.kept["fmu aside"] = aside
    offered = _in_hand(models, story, aside)

    @ui.refreshable
    def button() -> None:
        if problem := kept.options.problem():
            say(problem, "problem")
            return
        model = kept.model or offered
        command = pack(model, kept.options)
        if model in aside:
            say(f"{commands.short(model)} is {aside[model]}: it is not the model in hand.", "problem")
        action(view, command, "Pack as FMU", first=model not in aside)

    def changed(name: str, value: Any) -> None:
        if name == "model":
            kept.model = value
        else:
            kept.options = replace(kept.options, **{name: value})
        button.refresh()

    options = kept.options
    with ui.element("div").classes("choices").style("align-items: flex-start"):
        names = {m: commands.short(m) + (f" ({aside[m]})" if m in aside else "") for m in models}
        choice("Model", names, kept.model or offered, partial(changed, "model"))
        choice("FMI version", ["2.0", "3.0"], options.fmi, partial(changed, "fmi"))
        number_field(
            "Contact points", options.nodes, lambda v: changed("nodes", int(v or 1)), "1, or the nodes of a contact as arrays",
            min=1, max=MOST_NODES, precision=0,
        )  # fmt: skip
    with fold(view, "More options"):
        # Only some of them have a hint below.
        with ui.element("div").classes("choices").style("align-items: flex-start"):
            choice("Runs as", TARGETS, options.target, partial(changed, "target"))
            platforms = choice(
                "Platforms", list(PLATFORMS), list(options.platforms),
                lambda v: changed("platforms", tuple(v)), multiple=True,
            )  # fmt: skip
            platforms.props("use-chips").style("min-width: 270px").props["hint"] = (
                "without one: that of this machine"
            )
            text_field(
                "Name inside the FMU", options.name, lambda v: changed("name", v.strip()), "without one: from the model"
            )  # fmt: skip
        for name, said in SWITCHES.items():
            ui.checkbox(
                said, value=getattr(options, name), on_change=lambda e, n=name: changed(n, bool(e.value))
            )
    button()


def _file(view: View, path: str, facts: Facts, checked: tuple[str, str]) -> None:
    check = commands.fmus.check(path)
    system = path.endswith(".ssp")
    with panel(path.removeprefix("fmus/")):
        if facts.problem:
            say(view.bare(facts.problem), "problem")
        rows = [*facts.rows, *([] if system else [("checked", _last(checked, facts.written))])]
        words(table(["quantity", "found"], rows, narrow=True), "facts")
        with ui.element("div").classes("buttons"):
            download(path, "Download")
            if has_page(view.project.inside(path)):
                reading(page_address(path), "Read its page")
        if system:
            say("A system around the FMU; the FMU alone can be checked here.", "soft")
            return
        action(view, check, "Check it")
        job = view.worker.last(check.arguments)
        if job is not None and job.state in {DONE, FAILED}:
            _checked(view, path, job)


def _last(checked: tuple[str, str], written: str) -> str:
    """Return how the last check of an FMU ended.

    Examples
    --------
    >>> _last(("passed", "2026-11-20 10:00"), "2026-11-20 09:58"), _last(("failed", "2026-11-20 10:00"), "2026-11-21 08:00")
    ('passed, 2026-11-20 10:00 UTC', 'failed, 2026-11-20 10:00 UTC; the file is newer than that')
    >>> _last(("", ""), "2026-11-20 09:58")
    'not yet'
    """
    said, when = checked
    if not said:
        return "not yet"
    return f"{said}, {when} UTC" + ("; the file is newer than that" if written > when else "")


def _checked(view: View, path: str, job: CommandRun) -> None:
    """Show what the check said."""
    failed = [x for x in job.lines if x.strip().startswith("failed")]
    if job.state == DONE:
        passed = sum(x.strip().startswith("passed") for x in job.lines)
        say(f"It passed all {passed} checks.")
    else:
        say(f"The check failed: {'; '.join(failed) or job.problem()}", "problem")
    with fold(view, "What was checked", f"check of {path}"):
        ui.html(escape("\n".join(job.lines)), sanitize=False, tag="pre")
