"""Findings of `check` in groups: as data, as text, and on their way from the second process."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

#: What a finding can be: a note is neither good nor bad.
OUTCOMES = ("passed", "failed", "skipped", "noted")


class Finding(NamedTuple):
    """One thing that was looked at."""

    outcome: str  #: One of `OUTCOMES`.
    group: str  #: Heading that it belongs under.
    text: str


@dataclass
class CheckReport:
    """Result of `check`.

    Attributes
    ----------
    title : str
        What the FMU says it is.

    Examples
    --------
    >>> report = CheckReport(Path("law.fmu"), "a friction law")
    >>> report.add(True, "Archive", "paths stay inside")
    >>> report.add(False, "Units", "mu has the unit 'MPa', allowed: '1'")
    >>> print(report)
    law.fmu: NOT ok (1 passed, 1 failed)
    a friction law
    Archive
      passed  paths stay inside
    Units
      failed  mu has the unit 'MPa', allowed: '1'
    >>> report.ok, report.messages[0]
    (False, 'passed: paths stay inside')
    """

    path: Path
    title: str = ""
    findings: list[Finding] = field(default_factory=list)

    @property
    def ok(self) -> bool:
        """Whether nothing failed."""
        return all(f.outcome != "failed" for f in self.findings)

    @property
    def messages(self) -> list[str]:
        """One line a finding."""
        return [f"{f.outcome}: {f.text}" for f in self.findings]

    def add(self, good: bool, group: str, text: str) -> None:
        """Note a finding."""
        self.findings.append(Finding("passed" if good else "failed", group, text))

    def __str__(self) -> str:
        counts = {o: sum(f.outcome == o for f in self.findings) for o in OUTCOMES}
        parts = [f"{n} {o}" for o, n in counts.items() if n and o != "noted"]
        lines = [f"{self.path}: {'ok' if self.ok else 'NOT ok'} ({', '.join(parts)})"]
        if self.title:
            lines.append(self.title)
        for group in dict.fromkeys(f.group for f in self.findings):
            lines.append(group)
            lines += [f"  {f.outcome:<7} {f.text}" for f in self.findings if f.group == group]
        return "\n".join(lines)


class Notes:
    """Findings of the second process, written to a file one by one: what was found before a crash is kept.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     notes = Notes(Path(place) / "findings")
    ...     notes.add(True, "paths stay inside")
    ...     print(notes.result.read_text())
    ["passed", "archive", "paths stay inside"]
    """

    def __init__(self, result: Path) -> None:
        self.result = result
        self.group = "archive"

    def add(self, good: bool, text: str) -> None:
        """Write what went well or not."""
        self.note("passed" if good else "failed", text)

    def note(self, outcome: str, text: str) -> None:
        """Write a finding with its outcome."""
        line = json.dumps([outcome, self.group, " ".join(text.split())[:600]])
        with self.result.open("a", encoding="utf-8") as stream:
            stream.write(line + "\n")
