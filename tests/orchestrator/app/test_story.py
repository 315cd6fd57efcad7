"""The story of a project: what it tells, that it tells it the same twice, and that files of others stay text."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from orchestrator.app.commands.fmus import check
from orchestrator.app.commands.forming import STORY, story
from orchestrator.app.commands.models import compare, refine
from orchestrator.app.project import HISTORY, Project, history
from orchestrator.app.project.history import ACCEPTED, CHOSEN, ENDED
from orchestrator.cli.main import run
from orchestrator.report.parts.page import Page
from orchestrator.report.reading import ReadFigure, read_page

HOSTILE = "<img src=x onerror=alert(1)>"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example with a comparison and an FMU."""
    root = Project.open(tmp_path_factory.mktemp("made") / "project", example=True).root
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(root)
        assert run(compare("data/sct", ["0.06", "0.08"]).arguments) == 0
        assert run(["pack", "0.08", "-o", "fmus/constant.fmu"]) == 0
    return root


@pytest.fixture
def told(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Project:
    """A copy of it with an accepted addition and the FMU checked."""
    shutil.copytree(made, tmp_path / "told")
    example = Project.open(tmp_path / "told")
    monkeypatch.chdir(example.root)
    page = Page("linear: Stribeck effect is missing", "diagnosis", "81 tests", synthetic=True)
    page.add("verdict", "Verdict", "<p>Explained.</p>")
    page.add("evidence", "Evidence", "<p>left out of the story</p>")
    Path("reports/diagnosis-sct-linear.html").write_text(page.render())
    errors = [{"rmse": 0.0068, "mae": 0.0055}, {"rmse": 0.0044, "mae": 0.0035}]
    entry = {"added": ["stribeck"], "judged_by": "30 held-out tests", "before": errors[0], "after": errors[1]}
    folder = example.root / "models/linear-stribeck"
    folder.mkdir()
    (folder / "card.json").write_text(json.dumps({"model": {"learned": {"error_history": [entry]}}}))
    file = example.root / HISTORY
    history.add(file, CHOSEN, data="data/sct", model="linear")
    history.add(file, ENDED, job=1, code=0, **refine("data/sct", "linear", ["stribeck"]).more)
    history.add(file, ACCEPTED, model="models/linear-stribeck")
    history.add(file, ENDED, job=2, code=0, seconds=3.5, command=check("fmus/constant.fmu").line)
    return example


def text_of(root: Path) -> str:
    return re.sub(r"<[^>]+>", " ", (root / STORY).read_text().rpartition('<header class="top">')[2])


def test_it_tells_what_was_measured_missed_added_compared_and_packed(told: Project) -> None:
    assert run(story().arguments) == 0
    page = read_page(told.root / STORY)
    assert page.title == "stribeck added: the RMS error of mu fell from 0.0068 to 0.0044" and page.synthetic
    assert [s.anchor for s in page.sections] == ["measurements", "missing", "rounds", "models", "fmus", "commands"]  # fmt: skip
    text = text_of(told.root)
    # 81 + 30 tests of the example; speeds up to 502 mm/s.
    assert "111" in text and "30 test, 81 train" in text and "v_rel [mm/s]" in text and "to 502" in text
    assert "Explained." in text and "left out of the story" not in text
    assert "-35 %" in text and "30 held-out tests" in text
    answer = json.loads((told.root / "reports/comparison-sct.json").read_text())["models"]["0.08"]
    low, high = answer["mae_interval"]
    assert f"{answer['mae']:.4f} [{low:.4f}, {high:.4f}]" in text
    assert "chosen linear on data/sct" in text
    assert re.search(r"constant\.fmu\s+\d+\s+passed", text) and "tribofmu check fmus/constant.fmu" in text
    staircase = next(p for s in page.sections if s.anchor == "rounds" for p in s.parts if isinstance(p, ReadFigure))  # fmt: skip
    assert list(staircase.data[0]["y"]) == [0.0068, 0.0044]
    # The same project tells the same story.
    first = (told.root / STORY).read_bytes()
    assert run(story().arguments) == 0
    assert (told.root / STORY).read_bytes() == first


def test_each_data_set_has_its_rounds(told: Project) -> None:
    """Another data set in hand does not silence what was added on the one before."""
    shutil.copytree(told.root / "data/sct", told.root / "data/second")
    entry = {"added": ["viscous"], "judged_by": "30 held-out tests",
             "before": {"rmse": 0.0071, "mae": 0.005}, "after": {"rmse": 0.0052, "mae": 0.004}}  # fmt: skip
    (told.root / "models/linear-viscous").mkdir()
    card = {"model": {"learned": {"error_history": [entry]}}}
    (told.root / "models/linear-viscous/card.json").write_text(json.dumps(card))
    file = told.root / HISTORY
    history.add(file, CHOSEN, data="data/second", model="linear")
    history.add(file, ENDED, job=3, code=0, **refine("data/second", "linear", ["viscous"]).more)
    history.add(file, ACCEPTED, model="models/linear-viscous")
    # Looked at once more, without an addition.
    history.add(file, CHOSEN, data="data/sct", model="linear")
    assert run(story().arguments) == 0
    page = read_page(told.root / STORY)
    assert page.title == "viscous added: the RMS error of mu on second fell from 0.0071 to 0.0052"
    assert "2 accepted additions" in page.lead
    rounds = page.section("rounds")
    assert rounds is not None
    stairs = [list(p.data[0]["y"]) for p in rounds.parts if isinstance(p, ReadFigure)]
    assert stairs == [[0.0068, 0.0044], [0.0071, 0.0052]]
    text = text_of(told.root)
    assert "Explained." in text and "stribeck" in text


def test_errors_stand_with_their_intervals(told: Project) -> None:
    card = told.root / "models/linear-stribeck/card.json"
    content = json.loads(card.read_text())
    (entry,) = content["model"]["learned"]["error_history"]
    known = {"before": [0.0061, 0.0075], "after": [0.0040, 0.0049], "fall": [0.0019, 0.0029]}
    entry |= {"clear": True, "intervals": {k: {"rmse": v, "mae": v} for k, v in known.items()}}
    card.write_text(json.dumps(content))
    assert run(story().arguments) == 0
    text = text_of(told.root)
    assert "0.0068 [0.0061, 0.0075]" in text and "0.0044 [0.0040, 0.0049]" in text
    assert "+0.0024 [+0.0019, +0.0029]" in text and "fell by 35 %: more than chance" in text
    assert "95 %: 0.0061 to 0.0075, then 0.0040 to 0.0049; the fall 0.0019 to 0.0029" in text
    # Intervals that are none are left out, and the round stays.
    entry["intervals"] = {"before": "x"}
    card.write_text(json.dumps(content))
    assert run(story().arguments) == 0
    assert "fell by 35 %" in text_of(told.root) and "95 %:" not in text_of(told.root)


def test_it_loads_nothing_and_what_comes_from_files_stays_text(told: Project) -> None:
    (told.root / "project.yaml").write_text(f"format: 1\ntitle: '{HOSTILE}'\n")
    history.add(told.root / HISTORY, ENDED, command=HOSTILE, code=HOSTILE, seconds=1)
    for name in ("diagnosis-sct-linear", "comparison-sct"):
        file = told.root / f"reports/{name}.html"
        text = file.read_text().replace("<h1>", f"<h1>{HOSTILE}").replace("<p>", f"<p onclick=alert(1)>{HOSTILE}<script>alert(1)</script>")  # fmt: skip
        file.write_text(text.replace("measured mu", "&lt;a href=javascript:alert(1)&gt;x&lt;/a&gt;"))
    (told.root / "reports/forming-broken.html").write_text("no page")
    (told.root / "data/bad.csv").write_text("a,b\n1,2\n")
    assert run(story().arguments) == 0
    page = (told.root / STORY).read_text()
    body = page.rpartition('<header class="top">')[2]
    assert "<img" not in body and "onclick" not in body and "<script>alert" not in body
    assert "<link" not in body and not re.search(r'(src|href)="(?!#)', body)
    problems = re.sub(r"<[^>]+>", " ", body)
    assert "reports/forming-broken.html: " in problems and "data/bad.csv: " in problems


def test_a_card_of_others_is_no_round(told: Project) -> None:
    entry = {"added": [], "judged_by": "", "before": {"rmse": 0.0, "mae": 1.0}, "after": {"rmse": "x"}}
    for learned in (3, {}, {"error_history": "x"}, {"error_history": [{"added": 3}, entry]}):
        (told.root / "models/linear-stribeck/card.json").write_text(
            json.dumps({"model": {"learned": learned}})
        )
        assert run(story().arguments) == 0
        assert "rounds" not in [s.anchor for s in read_page(told.root / STORY).sections]


def test_an_empty_project_says_that_nothing_was_made(tmp_path: Path) -> None:
    Project.open(tmp_path / "new")
    assert run(["story", str(tmp_path / "new")]) == 0
    assert "nothing was measured or made yet" in text_of(tmp_path / "new")


def test_what_is_no_project_is_a_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "thesis.tex").touch()
    for arguments, said in (
        ([str(tmp_path)], "holds other files"),
        ([str(tmp_path / "missing")], "no such folder"),
        ([str(tmp_path), "-o", str(tmp_path / "thesis.tex")], "allowed: .html, .htm"),
    ):
        assert run(["story", *arguments]) == 2
        assert said in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_click_tells_it(told: Project) -> None:
    pytest.importorskip("nicegui", reason="the extra [app] is not installed")
    from nicegui import ui

    from .seen import look, until, waiting

    async def test(user: Any, worker: Any) -> None:
        await user.open("/reports")
        user.find("Tell the story").click()
        assert waiting(worker) == [story().line]
        assert run(story().arguments) == 0
        await user.open("/reports")
        await until(lambda: "Tell it again" in [b.text for b in user.find(ui.button).elements])
        await user.should_see("Download the story")

    look(told, test)
