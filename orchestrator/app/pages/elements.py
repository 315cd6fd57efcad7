"""What pages are built of: words, fields, buttons, command lines with their button, empty states."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

from nicegui import app, ui

from friction_models.common import InputError
from friction_models.common.errors import nearest, shown
from friction_models.common.markup import escape

from ..commands import Command
from ..serving import address
from .view import View

Field = TypeVar("Field", bound=ui.element)
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


def asked_data(view: View, page: str, fewest: int = 1) -> str:
    """Return the data set that the address of a page names, or the one in hand; `fewest`: of so many one can be chosen there."""
    sets, asked, data = view.data_sets(), view.query.get("data", ""), view.story().data
    if asked in sets:
        data = asked
    elif asked:
        near = nearest(asked, sets) or nearest(f"data/{asked}", sets)
        guess = f"; the nearest name is {near}" if near else ""
        say(f"The project has no data set {shown(asked, 80)}{guess}. This page shows {data}.", "problem")
    if len(sets) >= fewest:
        with ui.element("div").classes("choices"):
            choice("Measurements", sets, data, lambda value: ui.navigate.to(f"{page}?data={value}"))
    return data


def heading(text: str, level: int = 2) -> None:
    """Show a heading."""
    with ui.element(f"h{level}"):
        ui.html(escape(text), sanitize=False, tag="span")


def panel(title: str, level: int = 2) -> ui.element:
    """Show a framed part of a page below its heading; what belongs into it is built within it."""
    made = ui.element("section").classes("panel")
    with made:
        heading(title, level)
    return made


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


def text_field(
    label: str, value: str, changed: Callable[[str], Any] = lambda text: None, hint: str = "", **more: Any
) -> ui.input:
    """Show a field to type in; the hint stands below it."""
    field = ui.input(label, value=value, on_change=lambda e: changed(str(e.value or "")), **more)
    return _dressed(field, hint)


def number_field(
    label: str, value: float | None, changed: Callable[[float | None], Any], hint: str = "", **more: Any
) -> ui.number:
    """Show a field for a number; the hint stands below it."""
    return _dressed(ui.number(label, value=value, on_change=lambda e: changed(e.value), **more), hint)


def _dressed(field: Field, hint: str) -> Field:
    field.props("outlined dense").classes("choice")
    if hint:
        field.props["hint"] = hint
    return field
