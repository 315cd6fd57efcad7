"""Renaming a set of files, putting it aside and bringing it back."""

from __future__ import annotations

from functools import partial

from nicegui import ui

from friction_models.common import InputError

from ...project import is_name
from ...raw.files import RAW, free_name
from ...raw.moving import ASIDE, aside, move, own_set
from ..elements import button, fold, heading, say, text_field
from ..view import View


def rename_or_put_aside(view: View, name: str) -> None:
    """Offer another name for a set, and to put it aside."""
    place = f"{RAW}/{name}"

    def rename() -> None:
        new = str(field.value or "").strip()
        _move(view, place, f"{RAW}/{new or '-'}")
        ui.navigate.to(f"/measurements?raw={new}")

    def away() -> None:
        _move(view, place, aside(view.project, name))
        ui.navigate.to("/measurements")

    with fold(view, "Another name for this set, or away with it"):
        with ui.element("div").classes("choices"):
            field = text_field("New name", name)
            button("Rename", rename)
            button("Put this set aside", away)
        say(
            f"What was put aside is kept in the folder {ASIDE}, and the page Measurements brings it back; nothing is deleted. "
            "Data sets that were made of the files stay as they are.",
            "soft",
        )


def bring_back(view: View) -> None:
    """Offer the sets that were put aside."""
    top = view.project.root / ASIDE
    names = sorted(p.name for p in top.iterdir() if p.is_dir() and is_name(p.name)) if top.is_dir() else []
    if not names:
        return

    def back(name: str) -> None:
        _move(view, f"{ASIDE}/{name}", f"{RAW}/{free_name(view.project, RAW, name)}")

    heading("Put aside", 3)
    with ui.element("div").classes("buttons"):
        for name in names:
            button(f"Bring {name} back", partial(back, name))


def into_own_set(view: View, file: str) -> None:
    """Put a file of a set into a set of its own, and go there."""
    _check_idle(view, "/".join(file.split("/")[:2]))
    name = own_set(view.project, file)
    ui.navigate.to(f"/measurements?raw={name}")


def _check_idle(view: View, place: str) -> None:
    if any(place in job.command.places for job in view.worker.current()):
        raise InputError(
            f"{place}: a command that runs or waits names it; allowed: when that has ended, or was cancelled"
        )


def _move(view: View, source: str, target: str) -> None:
    _check_idle(view, source)
    move(view.project, source, target)
