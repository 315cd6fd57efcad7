"""How far work of several stages is, as one share."""

from __future__ import annotations

from collections.abc import Callable

from .pool import Progress

#: What is still ahead of a stage, after each of its steps; how many steps there will be is not known.
REST = 0.85


class Stages:
    """Says how far work is, in percent of its usual time, to `progress`; never less than before.

    Examples
    --------
    >>> stages = Stages(lambda done, total, what: print(done, total, what))
    >>> stages(20, "reading")
    20 100 reading
    >>> step = stages.until(40)
    >>> step(), step()
    23 100 reading
    25 100 reading
    (None, None)
    >>> stages(10, "again")
    25 100 again
    """

    def __init__(self, progress: Progress | None = None) -> None:
        self._progress, self._percent, self._what = progress, 0.0, ""

    def __call__(self, percent: float, what: str) -> None:
        """Say that a stage begins, and at how much of the whole."""
        self._percent, self._what = max(percent, self._percent), what
        self._say()

    def until(self, percent: float) -> Callable[[], None]:
        """Return what is to be called after each step of the stage, which ends at `percent`."""

        def step() -> None:
            self._percent += (1.0 - REST) * max(0.0, percent - self._percent)
            self._say()

        return step

    def part(self, percent: float) -> Progress:
        """Return the progress of a piece of work that ends at `percent`."""
        begin = self._percent

        def progress(done: int, total: int, what: str) -> None:
            self(begin + (percent - begin) * done / max(total, 1), what)

        return progress

    def _say(self) -> None:
        if self._progress is not None:
            self._progress(int(self._percent), 100, self._what)
