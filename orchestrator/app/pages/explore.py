"""Explore: friction over distance, time or any load, loads against loads; what is picked in one picture is picked in all."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from functools import partial
from typing import Any

from nicegui import events, ui

from friction_models.common.markup import table
from friction_models.loads import LOAD_NAMES, DataSet

from ...report.reading import ReadFigure
from ..figures.explore import Sample, cloud, label, sample, summary
from ..project.loaded import loaded
from .elements import asked_data, button, choice, empty, gone, say, text_field, told, words
from .frame import page_head
from .report_sections import plotted
from .view import View

#: What drawing with the mouse does, as plotly calls it.
_DRAGS = {"select": "Frame", "lasso": "Lasso", "zoom": "Zoom", "pan": "Move"}
#: Columns that name things or stand for the table itself.
_NO_AXES = {"test_id", "test_number"}
#: Names of tests that are written out.
_NAMED = 12


async def show(view: View) -> None:
    """Show the page."""
    project = view.project
    page_head(
        "Explore the measurements",
        "Draw a frame around points: the same tests light up in every picture. Click twice to let them go.",
    )
    if not view.data_sets():
        empty(
            "There are no measurements yet", "They are drawn here.", ("Bring measurements", "/measurements")
        )
        return
    data = asked_data(view, "/explore")
    with told(view):
        dataset = await asyncio.to_thread(loaded, project.inside(data))
        await _Explorer(view, dataset, data).build()


@dataclass
class _Choices:
    """The axes and the colour of the cloud, the two loads of the plan, and how tests are picked."""

    x: str
    y: str
    color: str
    a: str
    b: str
    tests: str = ""
    whole: bool = True
    drag: str = "select"


class _Explorer:
    """Choices, pictures and what is picked."""

    def __init__(self, view: View, dataset: DataSet, data: str) -> None:
        self.view, self.dataset, self.data = view, dataset, data
        self.found: Sample = sample(dataset)
        columns = [c for c in self.found.frame.columns if c not in _NO_AXES]
        self.colors = columns
        self.numbers = [c for c in columns if self.found.frame[c].dtype.kind in "fiu"]
        loads = [n for n in LOAD_NAMES if n in self.numbers and n != "sd"]
        first = next((c for c in ("sd", "t", *loads) if c in self.numbers), self.numbers[0])
        axes = loads or self.numbers
        self.chosen: _Choices = view.kept.setdefault(
            f"explore {data}",
            _Choices(
                x=first,
                y="mu" if "mu" in self.numbers else self.numbers[-1],
                color="v_rel" if "v_rel" in columns else "",
                a=axes[0],
                b=axes[1 % len(axes)],
            ),
        )
        self.asked = 0
        self.ids: list[int] = []

    async def build(self) -> None:
        """Build the choices and the pictures."""
        chosen, numbers = self.chosen, {n: label(n) for n in self.numbers}
        with ui.element("div").classes("choices"):
            choice("Up", numbers, chosen.y, partial(self._set, "y"))
            choice("Across", numbers, chosen.x, partial(self._set, "x"))
            choice("Colour", {"": "one colour", **{c: c for c in self.colors}, **numbers}, chosen.color, partial(self._set, "color"))  # fmt: skip
        with ui.element("div").classes("choices"):
            choice("Load across", numbers, chosen.a, partial(self._set, "a"))
            choice("Load up", numbers, chosen.b, partial(self._set, "b"))
            text_field("Part of a test name", chosen.tests, partial(self._set, "tests")).props("clearable")
            ui.switch("Pick whole tests", value=chosen.whole, on_change=lambda e: self._set("whole", e.value))
        with ui.element("div").classes("choices"):
            choice("Drawing with the mouse", _DRAGS, chosen.drag, self._drag)
            button(
                "Whole picture", lambda: self._change("{'xaxis.autorange': true, 'yaxis.autorange': true}")
            )
        self.said = ui.element("div").props('role="status"')
        self.place = ui.element("div")
        self.picked = ui.element("section")
        await self._draw()

    def _drag(self, value: str) -> None:
        """Draw frames, or something else, in all pictures."""
        self.chosen.drag = value if value in _DRAGS else "select"
        self._change(f"{{dragmode: '{self.chosen.drag}'}}")

    def _change(self, change: str) -> None:
        ui.run_javascript(f"tribofmu.relayout({self.ids}, {change})")

    async def _set(self, name: str, value: Any) -> None:
        setattr(self.chosen, name, value if isinstance(value, bool) else str(value or ""))
        self.asked += 1
        mine = self.asked
        if name == "tests":
            await asyncio.sleep(0.4)
        if mine == self.asked:
            await self._draw()

    async def _draw(self) -> None:
        found, figures = await asyncio.to_thread(self._figures)
        if gone(self.place):
            return
        self.found = found
        self.place.clear()
        self.picked.clear()
        self.said.clear()
        with self.said:
            drawn = len(found.frame)
            thinned = f", {drawn} of them drawn, evenly over each test" if drawn < found.whole else ""
            made = "Synthetic data: " if self.dataset.synthetic else ""
            say(f"{made}{found.whole} points of {len(found.tests)} tests{thinned}.", "soft")
        if not figures:
            with self.place:
                empty("No test has such a name", "Empty the field with the name of the tests to see all.")
            return
        with self.place, ui.element("div").classes("pictures"):
            plots = [_picture(figure, self.chosen.drag) for figure in figures]
        self.ids = [p.id for p in plots]
        whole = "true" if self.chosen.whole else "false"
        for plot in plots:
            script = f"(event) => tribofmu.brush(event, {plot.id}, {self.ids}, {whole}, emit)"
            for event in ("plotly_selected", "plotly_deselect"):
                plot.on(event, self._picked, js_handler=script)

    def _figures(self) -> tuple[Sample, list[ReadFigure]]:
        c = self.chosen
        found = sample(self.dataset, c.tests)
        if not len(found.frame):
            return found, []
        over_time = c.x in {"sd", "t"}
        first = cloud(found, c.x, c.y, c.color, lines=over_time)
        return found, [first, cloud(found, c.a, c.b, c.color, plan=True)]

    def _picked(self, event: events.GenericEventArguments) -> None:
        """Say which tests were picked."""
        numbers = [n for n in event.args or [] if isinstance(n, int) and 0 <= n < len(self.found.tests)]
        self.picked.clear()
        if not numbers:
            return
        names = [self.found.tests[n] for n in sorted(numbers)]
        more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        with self.picked, ui.element("div").classes("panel"):
            say(f"Picked: {', '.join(names[:_NAMED])}{more}")
            words(table(["quantity", "range"], summary(self.found, numbers, self.chosen.y), narrow=True))
            if (self.view.project.root / self.data).is_dir():
                with ui.element("div").classes("buttons"):
                    ui.link("Edit the test table", f"/measurements?tests={self.data}").classes("button")
                    button("Let them go", self._draw)


def _picture(figure: ReadFigure, drag: str) -> ui.plotly:
    frame = ui.element("div").classes("plot narrow")
    frame.props.update({"role": "figure", "aria-label": figure.description})
    with frame:
        # plotly's own bar of buttons brings Chromium to a stand for minutes, and keys do not reach it.
        plot = plotted(figure.data, {**figure.layout, "dragmode": drag}, scrollZoom=True)
        plot.style(f"width: 100%; height: {int(figure.layout.get('height') or 380)}px")
    return plot
