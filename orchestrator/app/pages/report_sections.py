"""Parts of reports on pages: sections, figures, and the slider of a figure, which is one for the keyboard, too."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable
from typing import Any

from nicegui import events, ui

from ...report.reading import Part, ReadFigure, ReadPage, ReadSection
from .elements import heading, words

#: Least width of a panel that stands beside others [px]: with less its ticks and titles touch.
PANEL = 210
#: Largest width that a figure may ask for [px].
WIDEST = 2000
#: Room that the slider of a report takes below its figure [px].
_ROOM = 100


def section(found: ReadSection | None, title: str = "") -> None:
    """Show a section of a report, if there is one."""
    if found is None or not found.parts:
        return
    with ui.element("section"):
        heading(title or found.heading)
        parts(found.parts)


def parts(found: Iterable[Part]) -> None:
    """Show parts of a section."""
    for part in found:
        if isinstance(part, ReadFigure):
            picture(part)
        else:
            words(part)


def badge(page: ReadPage) -> None:
    """Say that the numbers of a report are no measurements."""
    if page.synthetic:
        ui.label("synthetic data").classes("badge")


def picture(
    figure: ReadFigure,
    narrow: bool = False,
    pressed: Callable[[events.GenericEventArguments], None] | None = None,
) -> None:
    """Show a figure of a report; a `narrow` one fits a phone, others are moved sideways there.

    `pressed` is called with plotly's event of a click on a point.
    """
    steps = _steps(figure)
    if len(steps) > 1:
        _stepped(figure, steps)
    else:
        plot = _drawn(figure.data, figure.layout, figure.description, "plot narrow" if narrow else "plot")
        if pressed is not None:
            plot.on("plotly_click", pressed, ["points"])
    if figure.caption:
        words(figure.caption, "caption")


def plotted(data: list[Any], layout: dict[str, Any], changes: bool = False, **config: Any) -> ui.plotly:
    """Show a figure as wide as there is room; `changes`: whether it is brought up to date later."""
    config = {"displayModeBar": False, "responsive": True, **config}
    plot = ui.plotly({"data": data, "layout": {**layout, "autosize": True}, "config": config})
    if not changes:
        # What comes to a page later would be drawn twice: as it comes, and by a call that brings it up to date.
        plot._update_method = None
    return plot


def _drawn(
    data: list[Any], layout: dict[str, Any], description: str, kind: str, changes: bool = False
) -> ui.plotly:
    """Show a figure with the room that it needs; `description` is what a screen reader says."""
    frame = ui.element("div").classes(kind)
    frame.props.update({"role": "img", "aria-label": description, "tabindex": "0"})
    with frame:
        plot = plotted(data, layout, changes)
        height = int(layout.get("height") or 330)
        plot.style(f"width: 100%; height: {height}px; min-width: {least_width(layout)}px")
    return plot


def least_width(layout: dict[str, Any]) -> int:
    """Return the least width of a figure [px]: as its `meta` says, or by its panels.

    It is 0 for one or two panels beside each other, which fit a phone or follow the style.

    Examples
    --------
    >>> row = {f"xaxis{k}": {"domain": [0.3 * k, 0.3 * k + 0.2]} for k in (1, 2, 3)}
    >>> least_width(row), least_width({"xaxis": {"domain": [0, 1]}})
    (630, 0)
    >>> least_width({"meta": {"least_width": 720}})
    720
    """
    told = layout.get("meta")
    wanted = told.get("least_width") if isinstance(told, dict) else None
    if isinstance(wanted, int):
        return min(wanted, WIDEST)
    axes = [v for k, v in layout.items() if k.startswith("xaxis") and isinstance(v, dict)]
    beside = len({str(a.get("domain")) for a in axes})
    return PANEL * beside if beside > 2 else 0


def _steps(figure: ReadFigure) -> list[tuple[str, dict[str, list[Any]]]]:
    """Return label and new numbers of each step of a slider; a figure comes from a file, which may hold anything."""
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


def _stepped(figure: ReadFigure, steps: list[tuple[str, dict[str, list[Any]]]]) -> None:
    """Show a figure with a slider below it."""
    slider = figure.layout["sliders"][0]
    start = slider.get("active", 0)
    start = start if isinstance(start, int) and 0 <= start < len(steps) else 0
    said = slider.get("currentvalue")
    said = said if isinstance(said, dict) else {}
    before, behind = str(said.get("prefix", "")), str(said.get("suffix", ""))
    layout = {k: v for k, v in copy.deepcopy(figure.layout).items() if k != "sliders"}
    height, margin = layout.get("height"), layout.get("margin")
    layout["height"] = int(height) - _ROOM if isinstance(height, int | float) else 330
    layout["margin"] = {**(margin if isinstance(margin, dict) else {}), "b": 50}
    data = copy.deepcopy(figure.data)
    plot = _drawn(data, layout, figure.description, "plot", changes=True)

    def moved(event: events.ValueChangeEventArguments[Any]) -> None:
        at = min(max(int(event.value or 0), 0), len(steps) - 1)
        label, numbers = steps[at]
        for trace, x, y in zip(data, numbers["x"], numbers["y"], strict=True):
            if isinstance(trace, dict):
                trace["x"], trace["y"] = x, y
        plot.update_figure({**plot.figure, "data": data})
        shown.set_text(f"{before}{label}{behind}")

    with ui.element("div").classes("stepped"):
        shown = ui.label(f"{before}{steps[start][0]}{behind}")
        bar = ui.slider(min=0, max=len(steps) - 1, step=1, value=start, on_change=moved)
        bar.props["aria-label"] = before.strip() or "step"
