"""What is around every page: names of the pages, the look, the commands at work."""

from __future__ import annotations

import asyncio
import importlib
import logging
from importlib.resources import files
from typing import Any

from fastapi import Request
from nicegui import app, background_tasks, ui

from friction_models.common import InputError
from friction_models.common.errors import shown
from friction_models.common.markup import escape

from ..commands import Command
from ..project import HISTORY, Project, history
from ..work.command_run import CANCELLED, FAILED, RUNNING, CommandRun
from ..work.worker import Worker
from .elements import BARE, button, empty, gone, heading, say
from .view import View

#: Address, name and module of each page, in the order in which a new project needs them.
PAGES = (
    ("/measurements", "Measurements", "measurements.overview"),
    ("/explore", "Explore", "explore"),
    ("/", "What is missing", "missing"),
    ("/compare", "Compare", "compare"),
    ("/forming", "Forming", "forming"),
    ("/fmu", "FMU", "fmu"),
    ("/reports", "Reports", "reports"),
)
LOOKS = {"auto": None, "light": False, "dark": True}
#: How often a page looks whether something changed [s].
TICK = 0.15
#: How long the answer of the server waits for what the page shows [s].
AT_ONCE = 0.3
#: While the server reads, the browser gets ready to draw.
_READY_TO_DRAW = '<script type="module">import("nicegui-plotly")</script>'
#: Pages without pictures; only those of raw files have some.
_NO_PICTURES = {"/measurements", "/fmu", "/reports"}


class Workbench:
    """The pages of a project."""

    def __init__(self, project: Project, worker: Worker) -> None:
        self.project, self.worker = project, worker
        # NiceGUI names to the browser only what was looked at once before the page was sent; pictures may come later.
        self.late = (ui.plotly, ui.aggrid)
        style, script = (files("orchestrator.app") / name for name in ("style.css", "workbench.js"))
        self.head = f"<style>{style.read_text('utf-8')}</style><script>{script.read_text('utf-8')}</script>"

    async def root(self, request: Request) -> None:
        """Build the page of an address."""
        path = request.url.path.rstrip("/") or "/"
        found = next((p for p in PAGES if p[0] == path), None)
        ui.add_head_html(self.head)
        ui.page_title(f"{found[1] if found else 'No such page'} - {self.project.title}")
        look = request.cookies.get("tribofmu-look", "auto")
        mode = ui.dark_mode(LOOKS.get(look))
        content = _head(self.project, path, mode, look)
        strip = Strip(self.worker)
        app.storage.client[BARE] = self.project.bare
        view = View(self.project, self.worker, dict(request.query_params), strip.show)

        async def fill() -> None:
            if gone(content):
                return
            content.clear()
            content.props("aria-busy=true")
            with content:
                await self._fill(path, found[2] if found else "", view, content)
            if not gone(content):
                content.props(remove="aria-busy")

        seen = await asyncio.to_thread(self._state)
        # What takes long to read comes when it is ready; the page itself does not wait for it.
        first = background_tasks.create(fill(), name=f"page {path}")
        await asyncio.wait({first}, timeout=AT_ONCE)
        if not first.done() and (path not in _NO_PICTURES or "raw" in request.query_params):
            ui.add_body_html(_READY_TO_DRAW)

        async def tick() -> None:
            nonlocal seen
            strip.show()
            now = await asyncio.to_thread(self._state)
            if now != seen and first.done() and not view.held:
                seen = now
                await fill()

        ui.timer(TICK, tick)

    async def _fill(self, path: str, module: str, view: View, content: ui.element) -> None:
        """Show the page of a module, or why there is none."""
        if not module:
            page_head("No such page")
            empty("There is nothing here", f"No page has the address {path}.", ("What is missing", "/"))
            return
        try:
            # What a page needs may take a second to import: meanwhile the frame around it is there, and other tabs are served.
            page = await asyncio.to_thread(importlib.import_module, f".{module}", __package__)
            await page.show(view)
        except InputError as error:
            _cannot_be_shown(view.bare(str(error)), content)
        except Exception as error:
            if gone(content):
                return
            # A file that nobody foresaw must not leave half a page: the rest of the workbench goes on.
            logging.getLogger("tribofmu.app").exception("page %s", path)
            _cannot_be_shown(view.bare(f"{type(error).__name__}: {shown(error)}"), content)

    def _state(self) -> tuple[int, int]:
        """Return what a page depends on: the commands that ended, and what was decided."""
        file = self.project.root / HISTORY
        size = file.stat().st_size if file.is_file() else 0
        if size != self._seen[0]:
            count = sum(line["event"] != history.STARTED for line in history.read(file))
            self._seen = (size, count)
        return self._seen[1], sum(j.ended for j in self.worker.jobs)

    _seen = (-1, 0)


def _cannot_be_shown(why: str, content: ui.element) -> None:
    """Say why there is no page, instead of half of one."""
    if gone(content):
        return
    content.clear()
    page_head("This cannot be shown")
    empty("Why", why, ("Reports and history", "/reports"))


class Strip:
    """The commands at work, at the foot of every page."""

    def __init__(self, worker: Worker) -> None:
        self.worker = worker
        self.seen: tuple[Any, ...] = ()
        self.dismissed = max((j.number for j in worker.jobs if j.ended), default=0)
        self.bar = ui.element("div").classes("strip").props('role="status" aria-live="polite"')
        self.time: ui.label | None = None
        self.show()

    def show(self) -> None:
        """Bring it up to date."""
        current = self.worker.current()
        last = max(
            (j for j in self.worker.jobs if j.state in {FAILED, CANCELLED} and j.number > self.dismissed),
            key=lambda j: j.number,
            default=None,
        )
        interrupted = self.worker.interrupted
        if not current and last is None and not interrupted:
            if self.seen:
                self.bar.clear()
            self.seen = ()
            self.bar.set_visibility(False)
            return
        self.bar.set_visibility(True)
        seen = (
            *((j.number, j.state, j.saying, j.progress) for j in (*current, *([last] if last else []))),
            *(c.line for c in interrupted),
        )
        if seen != self.seen:
            self.seen = seen
            self.bar.clear()
            with self.bar:
                if current:
                    self._current(current)
                elif last is not None:
                    self._failed(last)
                else:
                    self._interrupted(interrupted[0])
        elif self.time is not None and current:
            self.time.set_text(_time(current[0]))

    def _current(self, current: list[CommandRun]) -> None:
        job = current[0]
        with ui.element("div").classes("job"):
            ui.html(f"<strong>{escape(job.command.title)}</strong>", sanitize=False, tag="span")
            self.time = ui.label(_time(job)).classes("soft")
            if len(current) > 1:
                ui.label(f"{len(current) - 1} more waiting").classes("soft")
            button("Cancel", lambda: self.worker.cancel(job), "plain")
        share = job.progress
        bar = ui.linear_progress(value=share or 0.0, show_value=False, color=None).props(
            'aria-label="Progress"'
        )
        if share is None:
            bar.props("indeterminate")
        ui.label(job.saying or job.command.line).classes("soft saying")

    def _failed(self, job: CommandRun) -> None:
        with ui.element("div").classes("job"):
            said = "was cancelled; nothing half-written is left" if job.state == CANCELLED else job.problem()
            ui.html(
                f"<strong>{escape(job.command.title)}</strong>: {escape(said)}", sanitize=False, tag="span"
            ).classes("soft" if job.state == CANCELLED else "problem")
            button("Close", lambda: self._dismiss(job), "plain")

    def _interrupted(self, command: Command) -> None:
        """Offer what a workbench before did not finish."""
        with ui.element("div").classes("job"):
            said = f"<strong>{escape(command.title)}</strong> was interrupted when the workbench ended."
            ui.html(said, sanitize=False, tag="span")
            button("Go on", lambda: self._go_on(command), "plain")
            button("Leave it", lambda: self.worker.leave(command), "plain")
        ui.label(command.line).classes("soft saying")

    def _go_on(self, command: Command) -> None:
        self.worker.start(command)
        self.show()

    def _dismiss(self, job: CommandRun) -> None:
        self.dismissed = job.number
        self.show()


def _time(job: CommandRun) -> str:
    if job.state != RUNNING:
        return "waiting"
    left, before = job.left(), job.before
    said = [f"{job.elapsed():.0f} s"]
    if job.progress is not None:
        said.append(f"{100.0 * job.progress:.0f} %")
    if left is not None:
        said.append(f"about {left:.0f} s left")
    elif before is not None:
        said.append(f"the last time it took {before:.0f} s")
    return ", ".join(said)


def _head(project: Project, path: str, mode: ui.dark_mode, look: str) -> ui.element:
    """Build name, pages and look; return the element for the content."""
    ui.html('<a class="skip" href="#content">Skip to the content</a>', sanitize=False)
    with ui.element("header").classes("top"), ui.element("div").classes("bar"):
        ui.link(project.title, "/").classes("title")
        with ui.element("nav").props('aria-label="Pages"'):
            for target, name, _ in PAGES:
                link = ui.link(name, target)
                if target == path:
                    link.classes("here").props('aria-current="page"')
        _look(mode, look if look in LOOKS else "auto")
    return ui.element("div").classes("content").props('id="content" tabindex="-1"')


def _look(mode: ui.dark_mode, look: str) -> None:
    """Build the button that goes from the look of the system to light and to dark; the browser keeps it."""
    names = list(LOOKS)

    def pressed() -> None:
        nonlocal look
        look = names[(names.index(look) + 1) % len(names)]
        mode.set_value(LOOKS[look])
        made.set_text(f"Look: {look}")
        kept = "path=/; max-age=31536000; samesite=strict"
        ui.run_javascript(f"document.cookie = 'tribofmu-look={look}; {kept}'")

    made = button(f"Look: {look}", pressed, "plain")


def page_head(title: str, lead: str = "") -> None:
    """Show the headline of a page and what it is for."""
    heading(title, 1)
    if lead:
        say(lead, "lead")
