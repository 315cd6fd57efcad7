"""What a benchmark gives back, and how it becomes markdown."""

from __future__ import annotations

import os
import platform
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NotRequired, TypedDict


class Section(TypedDict):
    """A part of the page: its text, then the lines of its tables; plain data, so that finished benchmarks can be kept."""

    title: str
    text: str
    lines: list[str]
    machine: NotRequired[str]


@dataclass
class Table:
    """A table of a section."""

    headings: Sequence[str]
    rows: list[Sequence[object]] = field(default_factory=list)

    def lines(self) -> list[str]:
        """Return markdown lines; all columns but the first align right."""
        rule = ["---", *("---:" for _ in self.headings[1:])]
        body = [self.headings, rule, *self.rows]
        return ["| " + " | ".join(str(c) for c in row) + " |" for row in body]


def section(title: str, text: str, *tables: Table) -> Section:
    """Return a section as plain data."""
    lines: list[str] = []
    for table in tables:
        lines += ["", *table.lines()]
    return {"title": title, "text": text, "lines": lines}


def seconds(work: Callable[[], object], repeats: int = 5, calls: int = 1) -> float:
    """Return the median time of one call of `work` [s]."""
    taken = []
    for _ in range(repeats):
        began = time.perf_counter()
        for _ in range(calls):
            work()
        taken.append((time.perf_counter() - began) / calls)
    return statistics.median(taken)


def machine() -> str:
    """Say on what was measured, without naming it."""
    return f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"
