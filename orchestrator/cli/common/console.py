"""What commands show: progress on stderr, results on stdout, JSON without NaN."""

from __future__ import annotations

import errno
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from friction_models.common import inert, write_json
from friction_models.common.json_values import plain

from . import interrupts

#: Called with (done, total, what).
Tick = Callable[[int, int, str], None]

#: Longest time without a line of progress where stderr is no terminal and work is being done [s].
QUIET = 30.0
#: Environment variable with another such time [s], for programs that show the progress.
EVERY = "TRIBOFMU_PROGRESS_EVERY"


class Interrupted(Exception):
    """Ctrl-C in a command that keeps finished work; the message says what was kept."""


@contextmanager
def keeping(what: Callable[[], str] | None = None) -> Iterator[None]:
    """Turn Ctrl-C into a sentence that says what was kept; without `what` into the sentence that came with it, if any."""
    try:
        yield
    except KeyboardInterrupt as interrupt:
        said = str(interrupt) if what is None else f"interrupted; {what()}"
        if not said:
            raise
        raise Interrupted(said) from None


@contextmanager
def progress(title: str, says_time: bool = False) -> Iterator[Tick]:
    """Show a progress bar on stderr (plain lines where stderr is no terminal); `says_time`: its texts hold the time left."""
    if not sys.stderr.isatty():
        with _plain(title) as tick:
            yield _interruptible(tick)
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    bar = Progress(
        # What the texts say comes from files: it is not read as markup.
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.completed:.0f}/{task.total:.0f}"),
        TimeElapsedColumn(),
        *([] if says_time else [TimeRemainingColumn()]),
        TextColumn("{task.fields[what]}", style="dim", markup=False),
        console=Console(stderr=True),
    )
    with bar:
        task = bar.add_task(inert(title), total=1, what="")
        yield _interruptible(
            lambda done, total, what: bar.update(task, completed=done, total=total, what=inert(what))
        )


def _interruptible(tick: Tick) -> Tick:
    def checked(done: int, total: int, what: str) -> None:
        interrupts.check()
        tick(done, total, what)

    return checked


@contextmanager
def _plain(title: str, clock: Callable[[], float] = time.monotonic) -> Iterator[Tick]:
    """Print a line at every quarter, and whenever something was done half a minute after the last line."""
    shown, since = -1, clock()
    every = os.environ.get(EVERY, "")
    quiet = float(every) if every.isdigit() else QUIET

    def tick(done: int, total: int, what: str) -> None:
        nonlocal shown, since
        quarter, now = 4 * done // max(total, 1), clock()
        if quarter > shown or now - since >= quiet:
            shown, since = quarter, now
            print(inert(f"{title}: {done}/{total} {what}".rstrip()), file=sys.stderr, flush=True)

    yield tick


def share(tick: Tick, steps: int, what: str = "") -> Callable[[float], None]:
    """Make a callback for a share from 0 to 1 out of a tick."""
    return lambda done: tick(round(done * steps), steps, what)


def say(text: str) -> None:
    """Print a line of the result to stdout; names and texts of files may hold anything, a terminal obeys none of it.

    Who reads the first lines only (`| head`) gets the files all the same that were asked for.
    """
    try:
        print(inert(text), flush=True)
    except BrokenPipeError:
        read_no_more()
    except OSError as error:
        if error.errno == errno.ENOSPC:
            raise OSError(error.errno, os.strerror(error.errno), "standard output") from None
        raise


def read_no_more() -> None:
    """Let what is still said to stdout go nowhere, when nobody reads it any more."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def write_page(outs: Sequence[Path] | None, name: str, *content: Any) -> None:
    """Write the page of a kind that `report.registry` names to each file that the user asked for, and say so."""
    built_page(outs, name, *content)()


def built_page(outs: Sequence[Path] | None, name: str, *content: Any) -> Callable[[], None]:
    """Build such a page, and return what writes it: files that belong together are written together, when all is computed."""
    if not outs:
        return lambda: None
    from ...report.registry import page_of

    html = page_of(name, *content)

    def write() -> None:
        from ...report.writing import write_page_file

        for out in outs:
            say(f"report written: {write_page_file(out, html)}")

    return write


def note(text: str) -> None:
    """Print a remark to stderr."""
    print(f"note: {inert(text)}", file=sys.stderr, flush=True)


def write_result(path: Path | None, content: object) -> None:
    """Write a JSON result file (stable keys, no NaN) where the user asked for one, and say so."""
    if path is not None:
        write_json(path, plain(content))
        say(f"written: {path}")
