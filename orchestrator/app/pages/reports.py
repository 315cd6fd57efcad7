"""Reports: the pages that commands wrote, and the story of the project line by line."""

from __future__ import annotations

import asyncio

from nicegui import ui

from friction_models.common.markup import table

from ..commands.forming import STORY, story
from ..project import history
from ..serving import address
from .elements import action, download, empty, heading, panel, reading, say, words
from .frame import page_head
from .view import View

#: Most lines of the history that are shown.
_LINES = 100


async def show(view: View) -> None:
    """Show the page."""
    page_head(
        "Reports and history",
        "Each report is one file that works offline. The history holds every command, the newest first; pasted into a shell "
        "in the project folder from the last line up, they give the same files.",
    )
    reports = await asyncio.to_thread(view.project.reports)
    lines = await asyncio.to_thread(view.lines)
    if not reports:
        empty(
            "There is no report yet",
            "Diagnosing, adding and comparing write one each.",
            ("What is missing", "/"),
        )
    _story(view, [view.project.relative(p) for p in reports])
    if reports:
        heading("Reports of the commands")
    for path in reports:
        name = view.project.relative(path)
        if name == STORY:
            continue
        with ui.element("div").classes("buttons"):
            reading(address(name, read=True), path.stem.replace("-", " "))
            download(name, "Download")
    if not lines:
        return
    heading("History")
    rows = [
        (
            str(line.get("time", ""))[:19].replace("T", " "),
            line["event"],
            history.about(line),
            history.outcome(line) or ("running, or broken off" if line["event"] == history.STARTED else ""),
        )
        for line in _told(lines)[::-1][:_LINES]
    ]
    words(f'<div class="scroll">{table(["time (UTC)", "what", "command", "outcome"], rows)}</div>', "history")
    if len(lines) > _LINES:
        say(f"The last {_LINES} of {len(lines)} lines; all are in history.jsonl.", "soft")


def _story(view: View, reports: list[str]) -> None:
    """Offer the page that tells all in one, and show where it is."""
    if not reports and not view.project.data_sets():
        return
    with panel("The story of this project"):
        say(
            "One page with what was measured, what the models missed, what was added, packed and formed. It works offline and "
            "can be given away.",
            "soft",
        )
        if STORY in reports:
            with ui.element("div").classes("buttons"):
                reading(address(STORY, read=True), "Read the story")
                download(STORY, "Download the story")
        action(view, story(), "Tell it again" if STORY in reports else "Tell the story", STORY not in reports)


def _told(lines: list[dict[str, object]]) -> list[dict[str, object]]:
    """Return the lines without the starts of commands whose end is there, too."""
    ended = {str(line.get("job")) for line in lines if line["event"] == history.ENDED}
    return [line for line in lines if line["event"] != history.STARTED or str(line.get("job")) not in ended]
