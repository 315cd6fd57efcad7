"""Report of `check`: findings in groups, as data and as text."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

#: What a finding can be: a note is neither good nor bad.
OUTCOMES = ("passed", "failed", "skipped", "noted")


class Finding(NamedTuple):
    """One thing that was looked at.

    Attributes
    ----------
    outcome : {"passed", "failed", "skipped", "noted"}
    group : str
        Heading that it belongs under.

    Examples
    --------
    >>> Finding("passed", "Archive", "paths stay inside").outcome
    'passed'
    """

    outcome: str
    group: str
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
