"""Figures of reports with a slider: in a page the slider is one for the keyboard, too."""

from __future__ import annotations

import copy
from typing import Any

from nicegui import events, ui

from ...report.reading import ReadFigure
from .sizes import least_width

#: Room that the slider of a report takes below its figure [px].
_ROOM = 100


def has_slider(figure: ReadFigure) -> bool:
    """Whether a figure has a slider whose steps put other numbers into its curves."""
    return len(_steps(figure)) > 1


def _steps(figure: ReadFigure) -> list[tuple[str, dict[str, list[Any]]]]:
    """Return label and new numbers of each step; a figure comes from a file, which may hold anything."""
    sliders = figure.layout.get("sliders")
    first = sliders[0] if isinstance(sliders, list) and sliders else None
    steps = first.get("steps") if isinstance(first, dict) else None
    found = []
    for step in steps if isinstance(steps, list) else []:
        arguments = step.get("args") if isinstance(step, dict) else None
        given = arguments[0] if isinstance(arguments, list) and arguments else None
        if not isinstance(given, dict) or not all(
            isinstance(v, list) and len(v) == len(figure.data) for v in (given.get("x"), given.get("y"))
        ):
            return []
        found.append((str(step.get("label", "")), {"x": given["x"], "y": given["y"]}))
    return found


def stepped(figure: ReadFigure) -> ui.element:
    """Show a figure with a slider below it."""
    steps = _steps(figure)
    slider = figure.layout["sliders"][0]
    start = slider.get("active", 0)
    start = start if isinstance(start, int) and 0 <= start < len(steps) else 0
    said = slider.get("currentvalue")
    said = said if isinstance(said, dict) else {}
    before, behind = str(said.get("prefix", "")), str(said.get("suffix", ""))
    layout = {k: v for k, v in copy.deepcopy(figure.layout).items() if k != "sliders"}
    height = layout.get("height")
    height = int(height) - _ROOM if isinstance(height, int | float) else 330
    layout |= {"height": height, "autosize": True}
    margin = layout.get("margin")
    layout["margin"] = {**(margin if isinstance(margin, dict) else {}), "b": 50}
    data = copy.deepcopy(figure.data)
    frame = ui.element("div").classes("plot")
    frame.props.update({"role": "img", "aria-label": figure.description, "tabindex": "0"})
    with frame:
        plot = ui.plotly(
            {"data": data, "layout": layout, "config": {"displayModeBar": False, "responsive": True}}
        )
        plot.style(f"width: 100%; height: {height}px; min-width: {least_width(layout)}px")

    def moved(event: events.ValueChangeEventArguments[Any]) -> None:
        at = min(max(int(event.value or 0), 0), len(steps) - 1)
        label, numbers = steps[at]
        for trace, x, y in zip(data, numbers["x"], numbers["y"], strict=True):
            if isinstance(trace, dict):
                trace["x"], trace["y"] = x, y
        plot.update_figure({"data": data, "layout": layout, "config": plot.figure["config"]})
        shown.set_text(f"{before}{label}{behind}")

    with ui.element("div").classes("stepped"):
        shown = ui.label(f"{before}{steps[start][0]}{behind}")
        bar = ui.slider(min=0, max=len(steps) - 1, step=1, value=start, on_change=moved)
        bar.props["aria-label"] = before.strip() or "step"
    return frame
