"""One command at work: how far it is, and what it said."""

from __future__ import annotations

import math
import subprocess
import time
from collections import deque
from dataclasses import dataclass, field

from ..commands import Command

#: Lines of a job that a page can show.
LINES = 400
#: The time left is guessed after so many steps and this share of the work, where the first and the second half of the steps agree
#: within this factor, and where it is long enough to matter [s]: what ends a command, such as its report, is no step.
STEPS, SHARE, AGREE, MATTERS = 6, 0.1, 1.5, 5.0
WAITING, RUNNING, DONE, FAILED, CANCELLED = "waiting", "running", "done", "failed", "cancelled"


@dataclass
class CommandRun:
    """A command that waits, runs or has ended."""

    number: int
    command: Command
    state: str = WAITING
    #: 0 to 1, where the command says so.
    progress: float | None = None
    #: The last thing that it said.
    saying: str = ""
    began: float = 0.0
    seconds: float = 0.0
    #: How long the same command line took the last time [s].
    before: float | None = None
    #: When it said how far it was [s, share]; and what it called that.
    marks: list[tuple[float, float]] = field(default_factory=list, repr=False)
    part: str | None = ""
    lines: deque[str] = field(default_factory=lambda: deque(maxlen=LINES))
    process: subprocess.Popen[bytes] | None = field(default=None, repr=False)

    @property
    def ended(self) -> bool:
        """Whether it will not change any more."""
        return self.state in {DONE, FAILED, CANCELLED}

    def elapsed(self) -> float:
        """Return how long it has run [s]."""
        return time.monotonic() - self.began if self.state == RUNNING else self.seconds

    def left(self) -> float | None:
        """Return about how long it still takes [s]; None where a guess would often be off by more than a factor of two."""
        share = self.progress or 0.0
        if self.state != RUNNING or self.part is None or len(self.marks) < STEPS or not SHARE <= share < 1.0:
            return None
        last, _ = self.marks[-1]
        # The time before the first step, in which a command loads and reads, says nothing of the steps.
        guesses = [
            (last - at) * (1.0 - share) / (share - done)
            for at, done in (self.marks[0], self.marks[len(self.marks) // 2])
            if share > done
        ]
        if len(guesses) < 2 or max(guesses) > AGREE * min(guesses):
            return None
        left = math.sqrt(guesses[0] * guesses[1]) - (self.elapsed() - last)
        return left if left >= MATTERS else None

    def heard(self, part: str, share: float) -> None:
        """Note how far a part of the work is."""
        # Nobody knows how many parts there are: from the second on nothing is guessed.
        if self.part and part != self.part:
            self.part = None
        elif self.part is not None:
            self.part = part
        if self.progress is None or share > self.progress:
            self.marks.append((self.elapsed(), share))
        self.progress = share

    def problem(self) -> str:
        """Return why it failed, in the sentence of the command."""
        said = [line for line in self.lines if line.startswith("tribofmu: ")]
        return said[-1].removeprefix("tribofmu: ").removeprefix("error: ") if said else self.saying
