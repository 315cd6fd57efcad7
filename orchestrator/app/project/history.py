"""The history of a project: one line of JSON for each thing that happened; nothing is ever taken out of it."""

from __future__ import annotations

import errno
import json
import os
import shlex
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path
from typing import Any

from friction_models.common import InputError

#: What a line of the history is about.
STARTED, ENDED, BROUGHT = "started", "ended", "brought"
CHOSEN, ACCEPTED, TAKEN_BACK = "chosen", "accepted", "taken back"
#: A file that a page wrote; a folder that got another place; an interrupted command that nobody wants any more.
SAVED, MOVED, LEFT = "saved", "moved", "left"
_LOCK = threading.Lock()
#: Largest history that is read [byte].
_LARGEST = 50_000_000


def add(file: Path, event: str, /, **content: Any) -> None:
    """Append a line.

    Raises InputError: the file cannot be written, or the disk is full.
    """
    line = {"time": datetime.now(UTC).isoformat(timespec="seconds"), "event": event, **content}
    # Half of a letter, which a browser can send, has no bytes; as JSON writes it, it is read as it was.
    data = (json.dumps(line, ensure_ascii=False) + "\n").encode(errors="backslashreplace")
    with _LOCK:
        try:
            _append(file, data)
        except OSError as error:
            raise InputError(
                f"{file.name}: cannot be written ({error.strerror}); allowed: a file that can be, on a disk with room"
            ) from None


def _append(file: Path, data: bytes) -> None:
    handle = os.open(file, os.O_RDWR | os.O_APPEND | os.O_CREAT, 0o644)
    try:
        size = os.fstat(handle).st_size
        # Behind a line that broke off a new one begins: else both would be lost.
        if size and os.pread(handle, 1, size - 1) != b"\n":
            data = b"\n" + data
        if os.write(handle, data) < len(data):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    finally:
        os.close(handle)


def read(file: Path) -> list[dict[str, object]]:
    """Return the lines that can be read; a line that broke off with the machine is left out."""
    try:
        if file.stat().st_size > _LARGEST:
            return []
        text = file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return []
    found: list[dict[str, object]] = []
    # Not splitlines: it knows more ends of lines, which may stand inside of a text.
    for line in text.split("\n"):
        try:
            entry = json.loads(line)
        except (ValueError, RecursionError):
            continue
        if isinstance(entry, dict) and isinstance(entry.get("event"), str):
            found.append(entry)
    return found


def about(line: Mapping[str, object]) -> str:
    """Return what a line of the history is about: its command, or what was decided on.

    Examples
    --------
    >>> about({"event": "chosen", "data": "data/oil", "model": "linear"}), about({"event": "saved", "file": "raw/oil/points.yaml"})
    ('linear on data/oil', 'raw/oil/points.yaml')
    """
    if line.get("model") and line.get("data"):
        return f"{line['model']} on {line['data']}"
    return str(line.get("command") or line.get("model") or line.get("data") or line.get("file") or "")


def outcome(line: Mapping[str, object]) -> str:
    """Return how the command of a line ended, and after how long; empty for a line of another kind.

    Examples
    --------
    >>> outcome({"event": "ended", "code": 130, "seconds": 2.5}), outcome({"event": "ended", "code": 1})
    ('cancelled in 2.5 s', 'failed')
    """
    if line["event"] != ENDED:
        return ""
    said = {"0": "done", "2": "refused", "130": "cancelled"}.get(str(line.get("code")), "failed")
    return f"{said} in {line['seconds']} s" if isinstance(line.get("seconds"), int | float) else said


def learnt_from(lines: Sequence[Mapping[str, object]]) -> dict[str, str]:
    """Return for each model which data set it was fitted to, as far as the history tells.

    Examples
    --------
    >>> learnt_from([{"event": "ended", "code": 0, "command": "tribofmu train linear --data data/oil -o models/linear"}])
    {'models/linear': 'data/oil'}
    """
    found = {}
    for line in lines:
        if line["event"] != ENDED or line.get("code") != 0:
            continue
        name, options = _options(line)
        if name in {"train", "refine"} and {"--data", "-o"} <= options.keys():
            found[options["-o"]] = options["--data"]
    return found


def set_aside(lines: Sequence[Mapping[str, object]]) -> dict[str, str]:
    """Return the additions that nobody accepted, and why they are none of the model in hand, in words.

    Examples
    --------
    >>> refined = {"event": "ended", "code": 0, "round": {"model": "models/b", "added": ["stribeck"]}}
    >>> set_aside([refined]), set_aside([refined, {"event": "accepted", "model": "models/b"}])
    ({'models/b': 'not accepted'}, {})
    >>> set_aside([refined, {"event": "accepted", "model": "models/b"}, {"event": "taken back", "model": "models/b"}])
    {'models/b': 'taken back'}
    """
    found: dict[str, str] = {}
    for line in lines:
        event, model, added = line["event"], str(line.get("model", "")), line.get("round")
        if event == ENDED and line.get("code") == 0 and isinstance(added, Mapping):
            found[_round(added).model] = "not accepted"
        elif event in {ACCEPTED, CHOSEN}:
            found.pop(model, None)
        elif event == TAKEN_BACK and model:
            found[model] = "taken back"
    return found


def _options(line: Mapping[str, object]) -> tuple[str, dict[str, str]]:
    """Return the name of a line's command, and the word behind each of its options."""
    try:
        words = shlex.split(str(line.get("command", "")))
    except ValueError:
        return "", {}
    name = words[1] if len(words) > 1 else ""
    return name, {word: value for word, value in pairwise(words[2:]) if word.startswith("-")}


@dataclass
class Round:
    """A model of the story: `model` is a folder or the name of a family, `added` what it has more than the one before."""

    model: str
    added: list[str] = field(default_factory=list)
    report: str = ""


@dataclass
class Story:
    """Where the loop stands."""

    #: The data set in hand; empty before one is chosen.
    data: str = ""
    #: The model at the start and every addition that was accepted.
    rounds: list[Round] = field(default_factory=list)
    #: Additions to the model in hand that were computed and neither accepted nor taken back, the newest last.
    waiting: list[Round] = field(default_factory=list)

    @property
    def candidate(self) -> Round | None:
        """The newest addition that waits for a decision."""
        return self.waiting[-1] if self.waiting else None

    @property
    def model(self) -> str:
        """The model in hand; empty before one is chosen."""
        return self.rounds[-1].model if self.rounds else ""

    @classmethod
    def of(cls, lines: Sequence[Mapping[str, object]]) -> Story:
        """Return where the loop stands after these lines.

        Examples
        --------
        >>> refined = {"event": "ended", "code": 0, "round": {"model": "models/b", "added": ["stribeck"]}}
        >>> lines = [{"event": "chosen", "data": "data/sct", "model": "linear"}, refined]
        >>> Story.of(lines).model, Story.of(lines).candidate.model
        ('linear', 'models/b')
        >>> Story.of([*lines, {"event": "accepted"}]).model
        'models/b'
        >>> Story.of([*lines, {"event": "accepted"}, {"event": "taken back"}]).model
        'linear'
        """
        return cls.loops(lines)[-1]

    @classmethod
    def loops(cls, lines: Sequence[Mapping[str, object]]) -> list[Story]:
        """Return where each loop stands, or stood when the next data set or model was chosen; the last is the one in hand."""
        found = [cls()]
        for line in lines:
            if line["event"] == CHOSEN:
                data, model = str(line.get("data", "")), str(line.get("model", ""))
                before = [s for s in found if s.data == data]
                waiting = [s.waiting for s in before if s.model == model]
                found.append(cls(data, _way_to(model, before), [*waiting[-1]] if waiting else []))
            elif line["event"] == ENDED:
                _, options = _options(line)
                # Something else may have been chosen while the command ran.
                asked = [s for s in found if s._asked_by(options)]
                if asked:
                    asked[-1]._go_on(line)
            else:
                found[-1]._go_on(line)
        return found

    def _asked_by(self, options: Mapping[str, str]) -> bool:
        """Whether the options of a command name this data set and the model in hand, as far as they name any."""
        return (
            options.get("--data", self.data) == self.data and options.get("--model", self.model) == self.model
        )

    def _go_on(self, line: Mapping[str, object]) -> None:
        event, added = line["event"], line.get("round")
        # A decision is about the model that its page showed: pressed twice, or in two tabs, it counts once.
        newest = self.candidate
        about = line.get("model", self.model if newest is None else newest.model)
        meant = next((r for r in self.waiting if r.model == about), None)
        if event == ENDED and line.get("code") == 0 and isinstance(added, Mapping):
            new = _round(added)
            self.waiting = [*(r for r in self.waiting if r.model != new.model), new]
        elif meant is not None and event == ACCEPTED:
            # The others were added to the model before.
            self.rounds.append(meant)
            self.waiting = []
        elif meant is not None and event == TAKEN_BACK:
            self.waiting.remove(meant)
        elif event == TAKEN_BACK and about == self.model and len(self.rounds) > 1:
            self.rounds.pop()
            self.waiting = []


def _way_to(model: str, loops: list[Story]) -> list[Round]:
    """Return the rounds that led to a model in the last of the loops that came by it; the model alone where none did."""
    for loop in loops[::-1]:
        for number, each in enumerate(loop.rounds):
            if number and each.model == model:
                return loop.rounds[: number + 1]
    return [Round(model)]


def _round(entry: Mapping[str, object]) -> Round:
    added = entry.get("added")
    return Round(
        str(entry.get("model", "")),
        [str(a) for a in added] if isinstance(added, list) else [],
        str(entry.get("report", "")),
    )
