"""What a model is missing: the verdict beside a picture, what may be added, before and after, the story so far."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from typing import Any

from nicegui import ui

from friction_models.common import InputError
from friction_models.common.markup import escape
from friction_models.common.wording import listed

from ...report.reading import ReadFigure, ReadPage
from .. import commands
from ..commands import Command
from ..model_findings import Answer, Offer, rounds_of
from ..project.history import ACCEPTED, TAKEN_BACK, Round, Story, learnt_from
from .elements import action, button, choice, download, empty, fold, heading, panel, say, told, words
from .frame import page_head
from .report_sections import badge, parts, picture, section
from .view import View

_NEXT = "<h3>What to test next</h3>"
#: Most effects that are offered beside those named.
_OFFERED = 8


async def show(view: View) -> None:
    """Show the page."""
    if not view.project.data_sets():
        page_head("What is missing")
        empty(
            "There are no measurements yet",
            "Three steps from here: bring files that you measured, ask what a friction model is missing in them, and take the "
            "improved model away as an FMU.",
            ("Bring measurements", "/measurements"),
        )
        return
    story = view.story()
    if lost := view.lost():
        say(
            f"{lost}, which was in hand, is not in the project any more; this page begins anew with {story.data}. "
            "Give the folder its old name to go on where you were.",
            "problem",
        )
    answer, page, problem = await asyncio.to_thread(_answer, view, story)
    view.first(story, page.title if page else "")
    if page is None:
        page_head(
            f"What is the {commands.short(story.model)} model missing?",
            "Every physical effect of the catalogue is tried on what the model leaves of the measured friction. The answer "
            "says which effect is missing, that nothing is, or that these tests cannot tell.",
        )
        if problem:
            say(f"The last answer cannot be shown: {problem}", "problem")
        _choices(view, story)
        if story.model in commands.models.FAMILIES:
            say(
                "Without a model of your own, begin with linear: it is fitted to the measurements first, and is simple enough for "
                "what it lacks to be seen.",
                "soft",
            )
        action(view, commands.models.diagnose(story.data, story.model), "Ask what is missing", first=True)
        _waiting(view, story)
        await _rounds(view, story, answer)
        return
    page_head(page.title)
    words(f"<p>{page.lead}</p>", "lead")
    badge(page)
    # What waits for a decision stands first.
    _waiting(view, story)
    _verdict(view, story, answer, page)
    await _rounds(view, story, answer)
    section(page.section("budget"))
    section(page.section("evidence"), "What speaks for each effect")
    _next_tests(view, story, page)
    for name in ("residual", "response", "tests"):
        section(page.section(name))
    heading("Another question")
    _choices(view, story)
    action(view, commands.models.diagnose(story.data, story.model), "Ask again")


def _answer(view: View, story: Story) -> tuple[Answer, ReadPage | None, str]:
    """Return what `diagnose` wrote about the model in hand: its JSON and its page, or why they cannot be read."""
    file, page, _ = commands.models.diagnosis_files(story.data, story.model)
    try:
        return Answer.read(view.project.inside(file)), view.page(page), ""
    except InputError as error:
        return Answer(), None, view.bare(str(error))


def _choices(view: View, story: Story) -> None:
    project = view.project
    sets = view.data_sets()
    models = {name: f"{name} (fitted when asked)" for name in commands.models.FAMILIES}
    models |= {project.relative(p): p.name for p in project.models()}
    models.setdefault(story.model, story.model)
    sets.setdefault(story.data, story.data)
    with ui.element("div").classes("choices"):
        choice("Measurements", sets, story.data, view.take_in_hand)
        choice("Model", models, story.model, lambda value: view.choose(story.data, value))


def _verdict(view: View, story: Story, answer: Answer, page: ReadPage) -> None:
    verdict = page.section("verdict")
    with ui.element("div").classes("beside"):
        with ui.element("div"):
            for part in verdict.parts if verdict else []:
                if isinstance(part, str):
                    words(part.partition(_NEXT)[0])
            if not story.waiting:
                _offers(view, story, answer)
        with ui.element("div"):
            sections = [page.section(name) for name in ("response", "tests", "residual")]
            response = sections[0]
            if response is None:
                sections = sections[2:]
            elif (figure := response.figure()) is not None and not _has_curve(figure):
                # An effect that remembers has no curve over a load: it shows in the course of tests.
                sections = sections[1:]
            for found in sections:
                if found is not None and (figure := found.figure()) is not None:
                    picture(figure, narrow=found is response)
                    # Once is enough: what is left of the section are tables and maps.
                    found.parts.remove(figure)
                    break


def _has_curve(figure: ReadFigure) -> bool:
    return any(isinstance(t, dict) and "lines" in str(t.get("mode", "")) for t in figure.data)


def _offers(view: View, story: Story, answer: Answer) -> None:
    """Show what may be added: what is named, and on request anything else that was tried."""
    named, learnt = answer.effects, learnt_from(view.lines())
    adding = partial(commands.models.refine, story.data, story.model, learnt=learnt)
    if named:
        action(view, adding(named), f"Add {listed(named)}", first=True)
    _formulas(view, adding, answer.offers, first=not named)
    others = list(dict.fromkeys([*answer.rivals, *(e for e in answer.ranking if e not in named)]))[:_OFFERED]
    if answer.rivals:
        say(f"These data cannot tell it from: {', '.join(answer.rivals)}.")
    if not others:
        return
    with fold(view, "Add another effect"):
        for effect in others:
            say(answer.words.get(effect, ""), "soft")
            action(view, adding([effect]), f"Add {effect}")


def _formulas(view: View, adding: Callable[[list[str]], Command], offers: list[Offer], first: bool) -> None:
    """Offer empirical terms: curves without a law behind them, for what the catalogue does not explain."""
    if not offers:
        return
    heading("Curves that would help", 3)
    say(
        "No law stands behind these empirical terms; they fade out beyond the tested loads. What each removes was judged on tests "
        "that took no part in choosing it.",
        "soft",
    )
    for number, offer in enumerate(offers[:_OFFERED]):
        words(f"<pre>{escape(offer.equation)}</pre>", "formula")
        if offer.removes:
            say(offer.removes)
        action(view, adding(offer.effects), f"Add {listed(offer.effects)}", first=first and number == 0)


def _waiting(view: View, story: Story) -> None:
    """Show the additions that wait for a decision, the newest first."""
    if len(story.waiting) > 1:
        say(
            f"{len(story.waiting)} additions to {commands.short(story.model)} wait for a decision, each made without the others. "
            "Once one is accepted, the others stay in the folder models and can be chosen as a model.",
            "soft",
        )
    for addition in story.waiting[::-1]:
        _decide(view, addition)


def _take_back(view: View, model: str) -> None:
    view.note(TAKEN_BACK, model=model)
    ui.notify(f"Taken back. {model} is kept and can be chosen as a model.")


def _decide(view: View, addition: Round) -> None:
    """Show an addition before and after, to be accepted or taken back."""
    page = None
    with panel(f"Before and after: {listed(addition.added)} added"):
        with told(view):
            page = view.page(addition.report) if addition.report else None
        if page is not None:
            history = page.section("history")
            parts(history.parts if history else [])
        with ui.element("div").classes("buttons action"):
            button("Accept", lambda: view.note(ACCEPTED, model=addition.model), "first")
            button("Take back", partial(_take_back, view, addition.model))
        say("Accept to ask what the better model still misses. Taking back deletes nothing.", "soft")
        residual = page.section("residual") if page is not None else None
        if residual is not None:
            parts(residual.parts)


async def _rounds(view: View, story: Story, answer: Answer) -> None:
    """Show the additions that were accepted as a staircase, and the way on."""
    if len(story.rounds) < 2:
        return
    with panel("The rounds so far"):
        with told(view):
            figure = await asyncio.to_thread(_staircase, view, story.model, answer)
            if figure is not None:
                picture(figure, narrow=True)
        with ui.element("div").classes("buttons action"):
            ui.link("Take it away as an FMU", "/fmu").classes("button first")
            if not story.waiting:
                button("Take back the last one", partial(_take_back, view, story.model))


def _staircase(view: View, model: str, answer: Answer) -> Any:
    """Return the figure of the errors of all rounds of a model, which its card keeps."""
    from ...report.charts.rounds import rounds_chart
    from ..figures.report_charts import as_read

    history = rounds_of(view.project.inside(f"{model}/card.json"))
    if not history:
        return None
    chart = rounds_chart(history, answer.floor)
    by = ", ".join(dict.fromkeys(str(entry["judged_by"]) for entry in history))
    return as_read(
        chart,
        f"RMS error of mu on tests that the fit did not see ({by}), after each round; bars: 95 % intervals over tests.",
        "Error after each round, falling as a staircase.",
    )


def _next_tests(view: View, story: Story, page: ReadPage) -> None:
    verdict = page.section("verdict")
    told = [
        p.partition(_NEXT)[2] for p in (verdict.parts if verdict else []) if isinstance(p, str) and _NEXT in p
    ]
    if not told:
        return
    with ui.element("section"):
        heading("What to test next")
        for part in told:
            words(part)
        plan = commands.models.diagnosis_files(story.data, story.model)[2]
        if view.project.inside(plan).is_file():
            download(plan, "Download the plan (CSV)")
