"""What is missing: empirical terms where the catalogue has no answer."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("nicegui", reason="the extra [app] is not installed")

from nicegui import ui

from orchestrator.app import commands
from orchestrator.app.project import HISTORY, Project, history
from orchestrator.app.project.history import Story
from orchestrator.report.parts.page import Page

from .seen import look, shown, waiting
from .test_measuring_pages import fields

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


def test_a_model_of_other_measurements_is_not_replaced(example: Project) -> None:
    json_file, page_file, _ = commands.models.diagnosis_files("data/sct", "linear")
    (example.root / page_file).write_text(Page("linear lacks something", "diagnosis").render())
    answer = {"effects": ["stribeck"], "ranking": [{"effect": "hersey"}, {"effect": "no such effect"}]}
    (example.root / json_file).write_text(json.dumps(answer))
    before = "tribofmu refine --data data/oil --model linear --add stribeck -o models/linear-stribeck"
    history.add(example.root / HISTORY, history.ENDED, code=0, command=before)

    async def test(user: Any, worker: Any) -> None:
        await user.open("/")
        assert "Stribeck curve over viscosity" in shown(user)
        user.find("Add stribeck").click()
        assert "-o models/linear-stribeck-sct " in waiting(worker)[0]

    look(example, test)


def test_measurements_that_were_left_come_with_their_own_model(example: Project) -> None:
    shutil.copytree(example.root / "data/sct", example.root / "data/oil")
    (example.root / "models/linear-stribeck").mkdir()
    (example.root / "models/linear-stribeck/card.json").write_text("{}")
    lines = [("data/oil", "models/linear-stribeck"), ("data/sct", "linear")]
    for data, model in lines:
        history.add(example.root / HISTORY, history.CHOSEN, data=data, model=model)

    async def test(user: Any, worker: Any) -> None:
        await user.open("/")
        fields(user, ui.select, "Measurements")[0].set_value("data/oil")

    look(example, test)
    story = Story.of(history.read(example.root / HISTORY))
    assert (story.data, story.model) == ("data/oil", "models/linear-stribeck")


@pytest.fixture(autouse=True)
def storage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is stored where the tests run."""
    monkeypatch.chdir(tmp_path)
