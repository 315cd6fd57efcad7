"""What pages are built of: sections, figures of reports, command lines with their button, empty states."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from nicegui import app, events, ui

from friction_models.common import InputError
from friction_models.common.errors import nearest, shown
from friction_models.common.markup import escape

from ...report.reading import Part, ReadFigure, ReadPage, ReadSection
from ..commands import Command
from ..serving import address
from .sizes import least_width
from .stepped import has_slider, stepped
from .view import View

#: Where a tab keeps how its project names paths.
BARE = "bare"


def gone(element: ui.element) -> bool:
    """Whether the tab of an element was closed, or went to another page, while something was computed for it."""
    try:
        return element.is_deleted or element.client.is_deleted
    except RuntimeError:  # nothing is left of the tab
        return True


def words(text: str, kind: str = "") -> ui.html:
    """Show HTML that was written by `markup` or by `reading`; the browser sanitizes it once more."""
    # What is moved sideways on a phone must be reached by keys.
    moved = '<div class="scroll" tabindex="0" role="group" aria-label="Table">'
    text = text.replace('<div class="scroll">', moved)
    return ui.html(text, sanitize=True).classes(kind)


def say(text: str, kind: str = "") -> ui.html:
    """Show plain text as a paragraph."""
    return words(f"<p>{escape(text)}</p>", kind)


@contextmanager
def told(view: View) -> Iterator[None]:
    """Say what cannot be read, and go on with the page: who sees it can ask again, or choose something else."""
    try:
        yield
    except InputError as error:
        say(view.bare(str(error)), "problem")


def asked_data(view: View, sets: Mapping[str, str], otherwise: str) -> str:
    """Return the data set that the address names; where the project has none of that name, say so and return `otherwise`."""
    asked = view.query.get("data", "")
    if not asked or asked in sets:
        return asked or otherwise
    near = nearest(asked, sets) or nearest(f"data/{asked}", sets)
    guess = f"; the nearest name is {near}" if near else ""
    say(f"The project has no data set {shown(asked, 80)}{guess}. This page shows {otherwise}.", "problem")
    return otherwise


def heading(text: str, level: int = 2) -> None:
    """Show a heading."""
    with ui.element(f"h{level}"):
        ui.html(escape(text), sanitize=False, tag="span")


def picture(
    figure: ReadFigure,
    narrow: bool = False,
    pressed: Callable[[events.GenericEventArguments], None] | None = None,
) -> None:
    """Show a figure of a report; a `narrow` one fits a phone, others are moved sideways there.

    `pressed` is called with plotly's event of a click on a point.
    """
    if has_slider(figure):
        stepped(figure)
    else:
        frame = drawing(figure.data, figure.layout, figure.description).classes("narrow" if narrow else "")
        if pressed is not None:
            frame.default_slot.children[0].on("plotly_click", pressed, ["points"])
    if figure.caption:
        words(figure.caption, "caption")


def drawing(data: list[Any], layout: dict[str, Any], description: str) -> ui.element:
    """Show a figure as plotly takes it; `description` is what a screen reader says."""
    frame = ui.element("div").classes("plot")
    frame.props.update({"role": "img", "aria-label": description, "tabindex": "0"})
    with frame:
        height = layout.get("height") or 330
        config = {"displayModeBar": False, "responsive": True}
        plot = plotted(data, layout, config)
        plot.style(f"width: 100%; height: {int(height)}px; min-width: {least_width(layout)}px")
    return frame


def plotted(data: list[Any], layout: dict[str, Any], config: dict[str, Any]) -> ui.plotly:
    """Show a figure that stays as it is, as wide as there is room."""
    plot = ui.plotly({"data": data, "layout": {**layout, "autosize": True}, "config": config})
    # What comes to a page later would be drawn twice: as it comes, and by a call that brings it up to date.
    plot._update_method = None
    return plot


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


def button(label: str, pressed: Callable[[], Any], kind: str = "") -> ui.button:
    """Show a button in our own colours; `kind`: ``first`` for the step that comes next, ``plain`` for a quiet one."""
    made = ui.button(label, on_click=_heard(pressed), color=None).props("no-caps unelevated")
    return made.classes(f"press {kind}".strip())


def _heard(done: Callable[..., Any]) -> Callable[..., Any]:
    """Return a handler that says what was refused, as by a full disk; without it nothing would seem to happen."""

    def heard(*given: Any) -> Any:
        try:
            found = done(*given)
        except (InputError, OSError) as error:
            refused(error)
            return None
        return _waited(found) if inspect.iscoroutine(found) else found

    return heard


async def _waited(going_on: Any) -> None:
    try:
        await going_on
    except (InputError, OSError) as error:
        refused(error)


def refused(error: Exception, said: str = "") -> None:
    """Say what was refused, with paths as the project names them."""
    bare = app.storage.client.get(BARE, str)
    ui.notify(f"{said}{bare(str(error))}", type="negative")


def fold(view: View, title: str, key: str = "", kind: str = "other", unfolded: bool = False) -> ui.expansion:
    """Show a part that is folded away; one that was opened stays open when the page is built anew."""
    name = f"open {key or title}"
    made = ui.expansion(title, value=view.kept.get(name, unfolded)).classes(kind)
    made.on_value_change(lambda e: view.kept.update({name: bool(e.value)}))
    return made


def action(view: View, command: Command, label: str, first: bool = False) -> ui.button:
    """Show a button with the command line behind it."""
    with ui.element("div").classes("action"):
        made = button(label, lambda: view.run(command), "first" if first else "")
        line(command)
    return made


def line(command: Command) -> None:
    """Show a command line, to be copied."""
    with ui.element("div").classes("line"):
        ui.html(escape(command.line), sanitize=False, tag="code").props('tabindex="0"')
        copy = ui.button(icon="content_copy", color=None, on_click=lambda: ui.clipboard.write(command.line))
        copy.props('flat dense round size=sm aria-label="Copy the command line"')


def empty(title: str, text: str, link: tuple[str, str] | None = None) -> None:
    """Say what is missing and what to do next."""
    with ui.element("div").classes("empty"):
        heading(title)
        say(text)
        if link is not None:
            ui.link(link[0], link[1]).classes("button")


def download(path: str, label: str) -> None:
    """Show a link that keeps a file of the project."""
    ui.link(label, address(path)).classes("button").props("download")


def reading(target: str, label: str) -> ui.link:
    """Show a link to a page of its own, which opens in a new tab."""
    made = ui.link(label, target, new_tab=True).classes("button").props('rel="noopener"')
    made.on("click", js_handler="(event) => tribofmu.opening(event)")
    return made


def choice(
    label: str, options: dict[str, str] | list[str], value: Any, changed: Callable[[Any], Any], **more: Any
) -> ui.select:
    """Show a field to choose from."""
    heard = _heard(changed)
    field = ui.select(options, value=value, label=label, on_change=lambda e: heard(e.value), **more)
    field.props("outlined dense options-dense").classes("choice")
    return field
