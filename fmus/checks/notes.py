"""Findings of the second process of `check`, written to a file one by one."""

from __future__ import annotations

import json
from pathlib import Path


class Notes:
    """Findings are written one by one: what was found before a crash is kept.

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
