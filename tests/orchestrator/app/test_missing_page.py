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
from orchestrator.report.parts.chart import Chart
from orchestrator.report.parts.page import Page

from .seen import built, figures, look, shown, until, waiting
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
        assert "Curves that would help" in said and "<pre>mu += 0.01 &lt;b&gt;exp" in said
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


def test_an_earlier_addition_can_be_accepted_while_a_later_one_waits(example: Project) -> None:
    file = example.root / HISTORY
    history.add(file, history.CHOSEN, data="data/sct", model="linear")
    for effect in ("stribeck", "hersey"):
        added = commands.models.refine("data/sct", "linear", [effect])
        (example.root / f"models/linear-{effect}").mkdir()
        (example.root / f"models/linear-{effect}/card.json").write_text("{}")
        history.add(file, history.ENDED, code=0, **added.more)

    async def test(user: Any, worker: Any) -> None:
        await user.open("/")
        said = shown(user)
        assert "2 additions to linear wait for a decision" in said
        assert 0 < said.index("hersey added") < said.index("stribeck added")
        accept = user.find(kind=ui.button, content="Accept")
        accept.elements = {max(accept.elements, key=lambda e: e.id)}
        accept.click()
        await until(lambda: Story.of(history.read(file)).model == "models/linear-stribeck")
        await until(lambda: "wait for a decision" not in shown(user))

    look(example, test)
    assert Story.of(history.read(file)).waiting == []


def test_measurements_that_have_another_name_are_missed(example: Project) -> None:
    history.add(example.root / HISTORY, history.CHOSEN, data="data/oil", model="linear")

    async def test(user: Any, worker: Any) -> None:
        await user.open("/")
        assert "data/oil, which was in hand, is not in the project any more" in shown(user)
        (example.root / "data/sct").rename(example.root / "data/oil")
        await user.open("/")
        assert "not in the project any more" not in shown(user)

    look(example, test)


@pytest.mark.parametrize("mode", ["markers", "lines"])
def test_an_effect_without_a_curve_stands_beside_the_course_of_tests(example: Project, mode: str) -> None:
    page = Page("linear: Memory of the contact is missing", "diagnosis")
    page.add("verdict", "Verdict", "<p>Explained.</p>")
    for name, how in (("response", mode), ("tests", "lines")):
        chart = Chart()
        chart.scatter(0, [0.0, 1.0], [0.1, 0.2], name, mode=how)
        chart.dress(300)
        page.plot(name, name, chart, "", name)
    (example.root / commands.models.diagnosis_files("data/sct", "linear")[1]).write_text(page.render())

    async def test(user: Any, worker: Any) -> None:
        await user.open("/")
        await built(user)
        drawn = [figure["data"][0]["name"] for figure in figures(user)]
        # What stands beside the verdict is not drawn once more below.
        assert drawn == (["tests", "response"] if mode == "markers" else ["response", "tests"])

    look(example, test)


@pytest.fixture(autouse=True)
def storage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is stored where the tests run."""
    monkeypatch.chdir(tmp_path)
