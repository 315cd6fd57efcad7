"""Commands at work: processes beside the server; they know nothing of the pages that watch them.

Long commands run one after the other. A quick one runs beside a long one, unless both name the same files.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import re
import signal
import subprocess
import sys
import threading
import time
from typing import IO

from friction_models.common import InputError
from friction_models.common.errors import shown
from friction_models.common.processes.child_processes import python_command
from friction_models.common.replaced_outputs import KEEP

from ..commands import Command, command_of
from ..project import HISTORY, WORK, Project, history
from .attached import GRACE
from .command_run import CANCELLED, DONE, FAILED, RUNNING, WAITING, CommandRun

#: Environment variable of the command line: how often it says how far it is [s].
PROGRESS_EVERY = "TRIBOFMU_PROGRESS_EVERY"

#: Longest line of a job that a page shows.
LONGEST = 400
#: Largest log [byte].
LARGEST_LOG = 4_000_000
#: ``twin: 12/81 twin of test sct012``, as commands write where no terminal is.
_PROGRESS = re.compile(r"([^:]{1,60}): (\d{1,9})/(\d{1,9})(?: (.*))?$")


class Worker:
    """Runs the commands of a project, first come first served."""

    def __init__(self, project: Project) -> None:
        self.project = project
        self.jobs: list[CommandRun] = []
        self._numbers = itertools.count(1 + _last_number(project))
        #: What was at work when the workbench ended the last time, and was not begun again.
        self.interrupted = interrupted_commands(project)
        self._wake = threading.Condition()
        self._closing = False
        self._threads = [
            threading.Thread(target=self._work, args=(quick,), daemon=True, name="commands")
            for quick in (False, True)
        ]
        for thread in self._threads:
            thread.start()

    def start(self, command: Command) -> CommandRun:
        """Put a command in the queue; the same one that waits or runs is not started twice."""
        with self._wake:
            for job in self.jobs:
                if job.command.arguments == command.arguments and not job.ended:
                    return job
            self.interrupted = [c for c in self.interrupted if c.arguments != command.arguments]
            job = CommandRun(next(self._numbers), command)
            waiting, ended = ([j for j in self.jobs if j.ended == is_ended] for is_ended in (False, True))
            self.jobs = [*waiting[-20:], *ended[-20:], job]
            self._wake.notify_all()
        return job

    def leave(self, command: Command) -> None:
        """Do not offer an interrupted command any more."""
        with self._wake:
            self.interrupted = [c for c in self.interrupted if c.arguments != command.arguments]
        history.add(self.project.root / HISTORY, history.LEFT, command=command.line)

    def current(self) -> list[CommandRun]:
        """Return what runs or waits, in this order."""
        return sorted((j for j in self.jobs if not j.ended), key=lambda j: j.number)

    def last(self, arguments: tuple[str, ...]) -> CommandRun | None:
        """Return the last job of a command line."""
        same = [j for j in self.jobs if j.command.arguments == arguments]
        return max(same, key=lambda j: j.number, default=None)

    def cancel(self, job: CommandRun) -> None:
        """End a job; what it had not finished leaves no file."""
        with self._wake:
            running, process = job.state == RUNNING, job.process
            if not job.ended:
                job.state = CANCELLED
                job.seconds = time.monotonic() - job.began if running else 0.0
                # What waited for this one may begin.
                self._wake.notify_all()
        if running and process is not None:
            threading.Thread(target=_end, args=(process,), daemon=True).start()

    def close(self) -> None:
        """End everything."""
        with self._wake:
            self._closing = True
            self._wake.notify_all()
        for job in self.current():
            self.cancel(job)
        for thread in self._threads:
            thread.join(GRACE + 2.0)

    def _next(self, quick: bool) -> CommandRun | None:
        """Return the first job that may begin: none before it that has not ended names files of it."""
        before: list[Command] = []
        for job in self.current():
            if (
                job.state == WAITING
                and job.command.quick == quick
                and not any(job.command.places & c.places for c in before)
            ):
                return job
            before.append(job.command)
        return None

    def _work(self, quick: bool) -> None:
        while True:
            with self._wake:
                while (job := self._next(quick)) is None and not self._closing:
                    self._wake.wait()
                if self._closing or job is None:
                    return
                job.state, job.began = RUNNING, time.monotonic()
            try:
                self._run(job)
            except Exception as error:
                # Whatever it was: a thread that ends leaves every later command waiting for ever.
                if job.process is not None:
                    _end(job.process)
                self._finish(job, 1, f"tribofmu: error: {error}")

    def _run(self, job: CommandRun) -> None:
        file = self.project.root / HISTORY
        job.before = last_seconds(history.read(file), job.command.line)
        history.add(
            file, history.STARTED, job=job.number, command=job.command.line, title=job.command.title,
            **({"more": job.command.more} if job.command.more else {}),
        )  # fmt: skip
        log = self.project.root / WORK / f"{job.number:05d}.log"
        log.parent.mkdir(mode=0o700, exist_ok=True)
        # Unbuffered: what a full disk refuses is not tried again when the file is closed.
        with log.open("wb", buffering=0) as kept:
            # The lock keeps a cancel from coming between the start and the place where it finds the process.
            with self._wake:
                if job.state != RUNNING:
                    history.add(file, history.ENDED, job=job.number, command=job.command.line, code=130)
                    return
                process = job.process = self._begun(job.command)
            assert process.stdout is not None
            self._listen(job, process.stdout, kept)
        code = process.wait()
        assert process.stdin is not None
        process.stdin.close()
        process.stdout.close()
        if code < 0:
            name = signal.Signals(-code).name if -code in {*signal.Signals} else str(-code)
            said = f"the process of this command was ended from outside ({name}), or the memory was full"
            self._finish(job, code, f"tribofmu: error: {said}")
            return
        self._finish(job, code)

    def _begun(self, command: Command) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            python_command("orchestrator.app.work.attached", "orchestrator.cli", *command.arguments),
            cwd=self.project.root,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env={
                **os.environ,
                "PYTHONUNBUFFERED": "1",
                "COLUMNS": "120",
                "NO_COLOR": "1",
                PROGRESS_EVERY: "1",
                # The workbench names its outputs itself, and shows every folder of its project.
                KEEP: "no",
            },
            start_new_session=True,
        )

    def _listen(self, job: CommandRun, said: IO[bytes], kept: IO[bytes]) -> None:
        written = _keep(kept, f"$ {job.command.line}\n".encode())
        # A line without end is cut: what a command says of foreign files may be of any length.
        while raw := said.readline(100_000):
            if written < LARGEST_LOG:
                written += _keep(kept, raw)
            line = shown_line(raw)
            job.lines.append(line)
            found = _PROGRESS.match(line)
            if found:
                done, total = int(found[2]), int(found[3])
                if total:
                    job.heard(found[1], min(1.0, done / total))
                job.saying = found[4] or job.saying
            elif line.strip():
                job.saying = line.strip()

    def _finish(self, job: CommandRun, code: int, said: str = "") -> None:
        if said:
            job.lines.append(shown(said))
        seconds = time.monotonic() - job.began
        with self._wake:
            cancelled = job.state == CANCELLED
            code = 130 if cancelled else code
            more = job.command.more if code == 0 else {"interrupted": True} if self._closing else {}
            try:
                history.add(
                    self.project.root / HISTORY, history.ENDED, job=job.number, command=job.command.line,
                    code=code, seconds=round(seconds, 2), **more,
                )  # fmt: skip
            except InputError as error:
                job.lines.append(f"tribofmu: error: {error}")
                code = code or 1
            job.seconds, job.process = seconds, None
            job.state = CANCELLED if cancelled else DONE if code == 0 else FAILED
            self._wake.notify_all()


def _keep(log: IO[bytes], raw: bytes) -> int:
    """Write to a log; a full disk costs the rest of the log, and not the command."""
    try:
        return log.write(raw)
    except OSError:
        return LARGEST_LOG


def _last_number(project: Project) -> int:
    """Return the largest number of a job that the history or a log knows."""
    told = [line.get("job") for line in history.read(project.root / HISTORY)]
    logs = [p.stem for p in (project.root / WORK).glob("*.log")]
    numbers = [n for n in told if isinstance(n, int)] + [int(n) for n in logs if re.fullmatch(r"\d{1,9}", n)]
    return max((n for n in numbers if 0 <= n < 10**9), default=0)


def shown_line(raw: bytes) -> str:
    """Return a line of output as a page may show it: bounded, without control characters."""
    text = raw.decode("utf-8", errors="replace").rstrip()
    return "".join(c if c.isprintable() else " " for c in text)[:LONGEST]


def interrupted_commands(project: Project) -> list[Command]:
    """Return the commands that a workbench before had at work when it ended, and that were not begun again.

    The history is a file like any other: a line whose paths lead out of the project is passed over.
    """
    found: dict[str, Command | None] = {}
    for line in history.read(project.root / HISTORY):
        text = str(line.get("command", ""))
        if line["event"] == history.STARTED:
            found[text] = command_of(text, project, line.get("title"), line.get("more"))
        elif line["event"] == history.LEFT or (
            line["event"] == history.ENDED and not line.get("interrupted")
        ):
            found.pop(text, None)
    return [command for command in found.values() if command is not None]


def last_seconds(lines: list[dict[str, object]], command: str) -> float | None:
    """Return how long a command line took the last time [s].

    Examples
    --------
    >>> entry = {"event": "ended", "code": 0, "command": "tribofmu check a.fmu"}
    >>> lines = [{**entry, "seconds": 3.0}, {**entry, "seconds": 2.0}, {**entry, "seconds": True}]
    >>> last_seconds(lines, "tribofmu check a.fmu"), last_seconds(lines, "tribofmu check b.fmu")
    (2.0, None)
    """
    for line in reversed(lines):
        seconds = line.get("seconds")
        same = line["event"] == history.ENDED and line.get("code") == 0 and line.get("command") == command
        if (
            same
            and isinstance(seconds, int | float)
            and not isinstance(seconds, bool)
            and 0.0 <= seconds < 1e7
        ):
            return float(seconds)
    return None


def _end(process: subprocess.Popen[bytes]) -> None:
    """Interrupt a process as Ctrl-C does; kill it and all it started when it does not end."""
    if sys.platform == "win32":
        process.terminate()
        return
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGINT)
    try:
        process.wait(GRACE)
    except subprocess.TimeoutExpired:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
