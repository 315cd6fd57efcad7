"""What a page is given: the project, the commands at work, where the loop stands."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from nicegui import ui

from friction_models.common.errors import shown

from ...report.reading import ReadPage, read_page
from ..commands import Command, short
from ..commands.models import FAMILIES
from ..project import HISTORY, Project, history
from ..project.history import Round, Story
from ..work.command_run import CommandRun
from ..work.worker import Worker

#: The model with which the loop begins where none is chosen.
FIRST_MODEL = "linear"


@dataclass
class View:
    """A page in one browser tab."""

    project: Project
    worker: Worker
    #: What stands behind the question mark of the address.
    query: Mapping[str, str]
    #: Shows at once that a command was started.
    started: Callable[[], None]
    #: What was filled in and not saved yet: the page is built anew when a command ends.
    kept: dict[str, Any] = field(default_factory=dict)
    #: Until then the page stays as it is, on the monotonic clock: a page built anew breaks off what the browser is sending.
    _held: float = 0.0

    def hold(self, seconds: float) -> None:
        """Do not build the page anew for so long."""
        self._held = time.monotonic() + seconds

    def let_go(self) -> None:
        """Build the page anew again where something changed."""
        self._held = 0.0

    @property
    def held(self) -> bool:
        """Whether the page stays as it is."""
        return time.monotonic() < self._held

    def first(self, *what: object) -> None:
        """Lead to the head of the page where something else stands there now than when it was built before."""
        if self.kept.setdefault("first", what) != what:
            self.kept["first"] = what
            ui.run_javascript("scrollTo(0, 0)")

    def data_sets(self) -> dict[str, str]:
        """Return the data sets of the project, and what pages call them."""
        return {place: short(place) for place in map(self.project.relative, self.project.data_sets())}

    def lines(self) -> list[dict[str, object]]:
        """Return the history."""
        return history.read(self.project.root / HISTORY)

    def story(self) -> Story:
        """Return where the loop stands; the first data set and a plain model where nothing, or nothing of this project, was chosen."""
        story = Story.of(self.lines())
        sets = list(self.data_sets())
        models = {self.project.relative(p) for p in self.project.models()} | {*FAMILIES}
        if not story.data and story.rounds and sets:
            # The loop was begun before there was a data set.
            story.data = sets[0]
        # The history is a file like any other: what it names goes into command lines.
        if story.data not in sets or any(r.model not in models for r in story.rounds):
            return Story(sets[0] if sets else "", [Round(FIRST_MODEL)])
        story.waiting = [c for c in story.waiting if c.model in models]
        return story

    def lost(self) -> str:
        """Return the data set that was in hand and is not in the project any more; empty where there is none."""
        chosen = Story.of(self.lines()).data
        return "" if not chosen or chosen in self.data_sets() else shown(chosen, 100)

    def run(self, command: Command) -> CommandRun:
        """Start a command."""
        if not any(line["event"] == history.CHOSEN for line in self.lines()):
            story = self.story()
            if story.data:
                self.choose(story.data, story.rounds[0].model)
        job = self.worker.start(command)
        self.started()
        return job

    def choose(self, data: str, model: str) -> None:
        """Begin the loop with a data set and a model; what was made before stays in its folders."""
        self.note(history.CHOSEN, data=data, model=model)

    def take_in_hand(self, data: str) -> None:
        """Go on with a data set where it was left; one that was never in hand begins with the plain model of the loop in hand."""
        story = self.story()
        if story.data != data:
            before = [loop.model for loop in Story.loops(self.lines()) if loop.data == data]
            self.choose(data, before[-1] if before else story.rounds[0].model)

    def note(self, event: str, **content: Any) -> None:
        """Write a decision into the history."""
        history.add(self.project.root / HISTORY, event, **content)

    def bare(self, text: str) -> str:
        """Return a sentence with paths as the project names them."""
        return self.project.bare(text)

    def page(self, path: str) -> ReadPage | None:
        """Return the report at a path of the project, taken apart; None where there is none."""
        file = self.project.inside(path)
        return read_page(file) if file.is_file() else None
