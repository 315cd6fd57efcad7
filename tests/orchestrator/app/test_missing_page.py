"""What is missing: empirical terms where the catalogue has no answer."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("nicegui", reason="the extra [app] is not installed")

from orchestrator.app import commands
from orchestrator.app.project import Project
from orchestrator.report.parts.page import Page

from .seen import look, shown, waiting

OFFER = {
    "name": "empirical:bump(T)", "add": ["empirical:bump(T)"], "equation": "mu += 0.01 <b>exp</b>(-T)", "share": 0.62,
    "interval": [0.41, 0.8], "stability": 0.9,
}  # fmt: skip


def test_empirical_terms_are_offered_with_what_they_remove(example: Project) -> None:
    json_file, page_file, _ = commands.models.diagnosis_files("data/sct", "linear")
    page = Page("linear: something is missing that the catalogue does not know", "diagnosis")
    page.add("verdict", "Verdict", "<p>Unknown structure.</p>")
    (example.root / page_file).write_text(page.render())
    hostile: list[object] = [
        3,
        {"add": "x"},
        {"add": ["--force"]},
        {"add": ["x(T)"], "share": "a", "interval": [None]},
    ]
    answer = {"verdict": "unknown_structure", "effects": [], "ranking": [], "formulas": [OFFER, *hostile]}
    (example.root / json_file).write_text(json.dumps(answer))

    async def test(user: Any, worker: Any) -> None:
        await user.open("/")
        said = shown(user)
        assert "Curves that would help" in said and "&lt;b&gt;exp" in said
        assert "It removes 62 % [41 to 80 %] of the error that can be avoided." in said
        expected = commands.models.refine("data/sct", "linear", ["empirical:bump(T)"]).line
        # The shell would take the brackets for its own.
        assert "--add 'empirical:bump(T)'" in expected
        user.find("Add empirical:bump(T)").click()
        assert waiting(worker) == [expected]

    look(example, test)


@pytest.fixture(autouse=True)
def storage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is stored where the tests run."""
    monkeypatch.chdir(tmp_path)
