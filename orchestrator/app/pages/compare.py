"""Compare: the models and FMUs of the project on one data set."""

from __future__ import annotations

import asyncio

from nicegui import ui

from friction_models.common.wording import listed

from .. import commands
from ..project import Project, history
from .elements import action, asked_data, choice, empty, fold, say, told, words
from .frame import page_head
from .report_sections import badge, section
from .residuals import show_residuals
from .view import View

#: Constant coefficients of friction that stand beside models: the usual ones of the literature.
CONSTANTS = ("0.04", "0.08")


def own_models(project: Project) -> list[str]:
    """Return the friction models of a project, as commands name them: folders, ONNX files, FMUs."""
    return [project.relative(p) for p in (*project.models(), *project.onnx_models(), *project.fmus())]


async def show(view: View) -> None:
    """Show the page."""
    project = view.project
    own = own_models(project)
    page_head(
        "Compare models",
        "Errors with intervals, measured against predicted, test by test - on the tests that were held out, where there are some.",
    )
    if not project.data_sets():
        empty(
            "There are no measurements yet",
            "Models are compared on measured friction.",
            ("Bring measurements", "/measurements"),
        )
        return
    data = asked_data(view, "/compare", fewest=2)
    learnt = history.learnt_from(view.lines())
    if not own:
        empty(
            "There is no model to compare yet",
            "Train one here, or add an effect to one under What is missing. Put FMUs of others into the folder fmus.",
            ("What is missing", "/"),
        )
    _train(view, data, learnt, unfolded=not own)
    if own:
        _ask(view, own, data, learnt)
    with told(view):
        await _compared(view, data)


async def _compared(view: View, data: str) -> None:
    """Show the comparison on a data set, if there is one."""
    page = await asyncio.to_thread(view.page, f"reports/comparison-{commands.short(data)}.html")
    if page is None:
        return
    with ui.element("section"):
        words(f"<h2>{page.title}</h2><p>{page.lead}</p>")
        badge(page)
    for found in page.sections:
        section(found)
        if found.anchor == "errors":
            await show_residuals(view, commands.models.comparison_points(data))


def _ask(view: View, own: list[str], data: str, learnt: dict[str, str]) -> None:
    """Show the choice of models and the button, whose command line follows the choice."""
    names = {name: name.removeprefix("models/") for name in own} | {c: f"constant {c}" for c in CONSTANTS}
    foreign = {m for m in own if learnt.get(m, data) != data}
    models = [m for m in own if m.startswith("models/")] or own
    chosen = [*([m for m in models if m not in foreign] or models)[-3:], CONSTANTS[1]]

    @ui.refreshable
    def button() -> None:
        if not chosen:
            ui.label("Choose at least one model.").classes("soft")
            return
        for model in (m for m in chosen if m in foreign):
            say(
                f"{names[model]} was fitted to {commands.short(learnt[model])}, not to these measurements.",
                "soft",
            )
        command = commands.models.compare(data, chosen)
        action(view, command, command.title, first=True)

    def changed(value: list[str]) -> None:
        chosen[:] = value
        button.refresh()

    with ui.element("div").classes("choices"):
        choice("Models", names, list(chosen), changed, multiple=True).props("use-chips").style(
            "min-width: 320px"
        )
    button()
    say(
        "A constant is the one coefficient of friction that a simulation without a friction model uses at every load; "
        f"{listed(CONSTANTS)} are usual in cold forming. A model that is worth its effort is better than these.",
        "soft",
    )


def _train(view: View, data: str, learnt: dict[str, str], unfolded: bool) -> None:
    """Offer the families of which there is no model of these measurements."""
    models = view.project.root / "models"
    names = {f: commands.models.model_name(f, data, learnt) for f in ("linear", "polynomial", "power_law")}
    offers = [commands.models.train(data, f, n) for f, n in names.items() if not (models / n).exists()]
    if not offers:
        return
    with fold(view, "Train a model", unfolded=unfolded):
        for command in offers:
            action(view, command, command.title)
