"""The pages in NiceGUI's simulated browser: empty projects, the loop with prepared answers, hostile files."""

from __future__ import annotations

import asyncio
import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("nicegui", reason="the extra [app] is not installed")

from nicegui import ui
from nicegui.testing import User

from orchestrator.app import commands
from orchestrator.app.pages.frame import PAGES
from orchestrator.app.pages.view import View
from orchestrator.app.project import HISTORY, Project, history
from orchestrator.app.project.history import ACCEPTED, CHOSEN, ENDED
from orchestrator.app.work.worker import Worker
from orchestrator.cli.main import run

from .conftest import shorter_example
from .seen import Idle, built, figures, look, shown, until, waiting


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example after asking and adding, by the command lines that the buttons show."""
    project = shorter_example(tmp_path_factory.mktemp("finished") / "project")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(project.root)
        assert run(commands.models.diagnose("data/sct", "linear").arguments) == 0
        assert run(commands.models.refine("data/sct", "linear", ["stribeck"]).arguments) == 0
        assert run(commands.models.compare("data/sct", ["models/linear-stribeck", "0.08"]).arguments) == 0
    return project.root


@pytest.fixture
def loop(finished: Path, tmp_path: Path) -> Project:
    """A copy of it."""
    shutil.copytree(finished, tmp_path / "loop")
    return Project.open(tmp_path / "loop")


def test_every_page_of_an_empty_project_says_what_to_do_next(tmp_path: Path) -> None:
    project = Project.open(tmp_path / "new")

    async def test(user: User, worker: Worker) -> None:
        for path, _, _ in PAGES:
            await user.open(path)
            await until(lambda: "yet" in shown(user))  # the solver of the forming page is loaded first
            said = shown(user)
            assert "cannot be shown" not in said
            assert "yet" in said and "<h1" not in said
        await user.open("/nowhere")
        await user.should_see("No such page")

    look(project, test)


def test_asking_starts_the_command_that_is_shown(example: Project) -> None:
    async def test(user: User, worker: Worker) -> None:
        await user.open("/")
        line = commands.models.diagnose("data/sct", "linear").line
        await user.should_see(line)
        user.find("Ask what is missing").click()
        await user.should_see("Cancel")
        assert waiting(worker) == [line]
        user.find("Ask what is missing").click()
        assert waiting(worker) == [line]
        user.find("Cancel").click()
        await user.should_see("was cancelled")

    look(example, test)
    assert history.read(example.root / HISTORY)[0]["event"] == CHOSEN


def test_the_answer_beside_its_picture_and_the_effect_to_add(loop: Project) -> None:
    async def test(user: User, worker: Worker) -> None:
        await user.open("/")
        said = shown(user)
        assert "linear: Stribeck effect is missing" in said
        assert "What to test next" in said and said.count("What to test next") == 1
        # Confidence and p stand in one sentence; the next line says what each of them means, here as in the report.
        report = (loop.root / "reports/diagnosis-sct-linear.html").read_text()
        for text in (said, report):
            assert (
                "p = 0.004" in text
                and "chance alone would make some effect look this good in 0.4 % of data sets" in text
            )
            assert "judged by made-up data whose cause is known" in text
        assert "synthetic data" in said
        # The effect beside the words; budget, ranking, residuals, their map, worst tests.
        assert len(figures(user)) == 6
        user.find("Add stribeck").click()
        assert waiting(worker) == [commands.models.refine("data/sct", "linear", ["stribeck"]).line]

    look(loop, test)


def test_before_and_after_then_accepted_then_taken_back(loop: Project) -> None:
    file = loop.root / HISTORY
    history.add(file, CHOSEN, data="data/sct", model="linear")
    history.add(file, ENDED, job=1, code=0, **commands.models.refine("data/sct", "linear", ["stribeck"]).more)

    async def test(user: User, worker: Worker) -> None:
        await user.open("/")
        await user.should_see("Before and after: stribeck added")
        card = json.loads((loop.root / "models/linear-stribeck/card.json").read_text())
        (only,) = card["model"]["learned"]["error_history"]
        for errors in (only["before"], only["after"]):
            assert f"{errors['rmse']:.4f}" in shown(user)
        low, high = (f"{edge:.4f}" for edge in only["intervals"]["after"]["rmse"])
        said = shown(user)
        # Beside the number, and in the table of the rounds; the fall is more than chance.
        assert f"then {low} to {high}" in said and f"[{low}, {high}]" in said
        assert only["clear"] and ": more than chance" in said
        user.find("Accept").click()
        await user.should_see("The rounds so far", retries=30)
        steps: list[Any] = []
        for _ in range(800):  # the picture comes behind its heading
            steps = [f for f in figures(user) if f["layout"]["yaxis"]["title"]["text"] == "RMS error of mu"]
            if steps:
                break
            await asyncio.sleep(0.01)
        assert steps[0]["data"][0]["y"] == pytest.approx([only["before"]["rmse"], only["after"]["rmse"]])
        assert only["after"]["rmse"] < only["before"]["rmse"]
        tops = np.add(steps[0]["data"][0]["y"], steps[0]["data"][0]["error_y"]["array"])
        assert list(tops) == pytest.approx([only["intervals"][k]["rmse"][1] for k in ("before", "after")])
        await user.should_see("What is the linear-stribeck model missing?")
        user.find("Take back the last one").click()
        await user.should_see("linear: Stribeck effect is missing", retries=30)
        assert (loop.root / "models/linear-stribeck").is_dir()

    look(loop, test)


def test_a_loop_that_began_before_there_were_data_goes_on_with_them(loop: Project, tmp_path: Path) -> None:
    file = loop.root / HISTORY
    history.add(file, CHOSEN, data="", model="linear")
    history.add(file, ENDED, job=1, code=0, **commands.models.refine("data/sct", "linear", ["stribeck"]).more)
    story = View(loop, Idle(loop), {}, lambda: None).story()
    assert (story.data, story.model) == ("data/sct", "linear")
    assert story.candidate is not None and story.candidate.model == "models/linear-stribeck"
    # Taking in records chooses no data set: there is none yet.
    new = Project.open(tmp_path / "new")
    View(new, Idle(new), {}, lambda: None).run(commands.measuring.twin("campaigns/rig", "rig"))
    assert history.read(new.root / HISTORY) == []


def test_the_model_is_packed_with_the_chosen_options(loop: Project) -> None:
    file = loop.root / HISTORY
    history.add(file, CHOSEN, data="data/sct", model="linear")
    history.add(file, ENDED, job=1, code=0, **commands.models.refine("data/sct", "linear", ["stribeck"]).more)
    history.add(file, ACCEPTED)

    async def test(user: User, worker: Worker) -> None:
        await user.open("/fmu")
        next(iter(user.find(ui.number).elements)).set_value(80)
        expected = "tribofmu pack models/linear-stribeck --nodes 80 -o fmus/linear-stribeck-80.fmu"
        await user.should_see(expected)
        user.find("Pack as FMU").click()
        assert waiting(worker) == [expected]

    look(loop, test)


def test_tiles_of_what_is_expected_and_of_what_came_have_other_names(loop: Project) -> None:
    command = commands.models.refine("data/sct", "linear", ["stribeck"])
    history.add(loop.root / HISTORY, CHOSEN, data="data/sct", model="linear")
    history.add(loop.root / HISTORY, ENDED, code=0, command=command.line, **command.more)

    async def test(user: User, worker: Worker) -> None:
        await user.open("/")
        await until(lambda: "Before and after" in shown(user) and "What to test next" in shown(user))
        tiles = re.findall(r'<p class="name">([^<]*)</p>', shown(user))
        assert len(tiles) == 4 and len(set(tiles)) == 4

    look(loop, test)


def test_a_constant_is_explained(loop: Project) -> None:
    async def test(user: User, worker: Worker) -> None:
        await user.open("/compare")
        await user.should_see(
            "the one coefficient of friction that a simulation without a friction model uses"
        )
        report = shown(user)
        assert "0.08: the same coefficient of friction at every load; nothing was fitted" in report

    look(loop, test)


def test_a_comparison_and_the_measurements(loop: Project) -> None:
    async def test(user: User, worker: Worker) -> None:
        await user.open("/compare")
        said = shown(user)
        assert "Errors on tests" in said and "Measured against predicted" in said
        # Errors over each load and over two, parity, response, tests.
        assert len(figures(user)) == 5
        user.find("Compare 2 models").click()
        assert waiting(worker) == [
            commands.models.compare("data/sct", ["models/linear-stribeck", "0.08"]).line
        ]
        await user.open("/measurements")
        assert "40 train, 15 test" in shown(user) and "sigma_n [MPa]" in shown(user)
        history.add(loop.root / HISTORY, history.SAVED, file="raw/oil/points.yaml")
        await user.open("/reports")
        await user.should_see("refined sct linear stribeck")
        said = shown(user)
        # What came last stands first, and the words say so.
        assert "the newest first" in said and "from the last line up" in said
        assert 0 < said.index("raw/oil/points.yaml") < said.index("linear on data/sct")

    look(loop, test)


def test_a_data_set_is_taken_in_hand_again_where_it_was_left(loop: Project) -> None:
    (loop.root / "data/zinc").mkdir()
    (loop.root / "data/zinc/points.csv").write_text("test_id,v_rel,mu\na,1,0.1\nb,2,0.1\n")
    file = loop.root / HISTORY
    added = commands.models.refine("data/sct", "linear", ["stribeck"])
    history.add(file, history.CHOSEN, data="data/sct", model="linear")
    history.add(file, history.ENDED, code=0, **added.more)
    history.add(file, history.ACCEPTED, model="models/linear-stribeck")
    history.add(file, history.CHOSEN, data="data/zinc", model="linear")

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements")
        user.find("Take it in hand").click()
        await until(lambda: history.Story.of(history.read(file)).data == "data/sct")

    look(loop, test)
    rounds = history.Story.of(history.read(file)).rounds
    assert [r.model for r in rounds] == ["linear", "models/linear-stribeck"]


HOSTILE = "<img src=x onerror=alert(1)>"


def test_what_comes_from_files_stays_text(loop: Project) -> None:
    (loop.root / "project.yaml").write_text(f"format: 1\ntitle: '{HOSTILE}'\n")
    page = loop.root / "reports/diagnosis-sct-linear.html"
    text = page.read_text()
    text = text.replace("<h1>", f"<h1>{HOSTILE}").replace(
        '<section id="budget"', f'{HOSTILE}<section id="budget"'
    )
    page.write_text(text.replace("<table>", "<table onclick=alert(1)><script>alert(1)</script>"))
    answer = loop.root / "reports/diagnosis-sct-linear.json"
    content = json.loads(answer.read_text())
    content |= {
        "effects": ["--force", HOSTILE],
        "confusion_set": ["../../x"],
        "ranking": [3, {"effect": None}],
    }
    answer.write_text(json.dumps(content))
    history.add(loop.root / HISTORY, ENDED, command=HOSTILE, code=0)

    async def test(user: User, worker: Worker) -> None:
        for path, _, _ in PAGES:
            await user.open(path)
            assert user.client is not None
            for element in user.client.elements.values():
                if isinstance(element, ui.html):
                    assert "<img" not in element.content and "<script" not in element.content
                    assert "onclick" not in element.content
        await user.open("/")
        await user.should_not_see("--add --force")
        user.find("Add ../../x").click()
        assert "-o models/linear-x " in waiting(worker)[0]

    look(Project.open(loop.root), test)


@pytest.mark.parametrize(
    "line", [{"data": "../..", "model": "linear"}, {"data": "data/sct", "model": "-o"}, {"data": 1}]
)
def test_a_history_of_others_names_nothing_outside(example: Project, line: dict[str, object]) -> None:
    history.add(example.root / HISTORY, CHOSEN, **line)

    async def test(user: User, worker: Worker) -> None:
        await user.open("/")
        await user.should_see(commands.models.diagnose("data/sct", "linear").line)

    look(example, test)


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("reports/diagnosis-sct-linear.html", "no page"),
        ("reports/diagnosis-sct-linear.json", "{"),
        ("data/sct/points.csv", "test_id,mu\na,x\n"),
        ("data/sct/dataset.json", "[" * 5000),
    ],
)
def test_a_damaged_file_is_a_sentence_on_its_page(loop: Project, file: str, text: str) -> None:
    (loop.root / file).write_text(text)

    async def test(user: User, worker: Worker) -> None:
        for path, _, _ in PAGES:
            await user.open(path)
        await user.open("/measurements" if file.startswith("data") else "/")
        assert Path(file).name in shown(user) or "cannot be shown" in shown(user)

    look(loop, test)


@pytest.fixture(autouse=True)
def storage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Nothing is stored where the tests run."""
    monkeypatch.chdir(tmp_path)
    yield
    assert not (tmp_path / ".nicegui").exists()


def test_an_address_with_an_unknown_data_set_says_what_is_shown_instead(loop: Project) -> None:
    shutil.copytree(loop.root / "data/sct", loop.root / "data/zinc")

    async def test(user: User, worker: Worker) -> None:
        for page in ("/explore", "/compare"):
            await user.open(f"{page}?data=data/zink")
            await user.should_see(
                "no data set data/zink; the nearest name is data/zinc. This page shows data/sct."
            )
            await user.open(f"{page}?data=sct")
            await user.should_see("no data set sct; the nearest name is data/sct.")
            await user.open(f"{page}?data=data/zinc")
            await built(user)
            await user.should_not_see("The project has no data set")

    look(loop, test)
