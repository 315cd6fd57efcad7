"""Files of a project that somebody damaged, replaced or planted: a sentence on the page, and the way on stays open."""

from __future__ import annotations

import asyncio
import json
import os
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("nicegui", reason="the extra [app] is not installed")

from nicegui import ui
from nicegui.elements.upload_files import SmallFileUpload
from nicegui.testing import User

from orchestrator.app import commands
from orchestrator.app.pages.frame import PAGES
from orchestrator.app.project import HISTORY, Project, history
from orchestrator.app.project.history import ACCEPTED, BROUGHT, CHOSEN, ENDED
from orchestrator.app.raw.files import save_map
from orchestrator.app.work.worker import Worker

from .seen import built, look, shown, until
from .test_pages import storage

assert storage  # a fixture that holds here, too

ASK = "Ask what is missing"
MODEL = "models/linear-stribeck"


def every_page(project: Project, *more: str) -> dict[str, str]:
    """Return what each page says."""
    said: dict[str, str] = {}

    async def test(user: User, worker: Worker) -> None:
        for path in (*(p for p, _, _ in PAGES), *more):
            await user.open(path)
            await built(user)
            said[path] = shown(user)

    look(project, test)
    return said


def accepted(project: Project, card: object) -> None:
    """A project whose loop stands behind one accepted round, with that card."""
    (project.root / MODEL).mkdir()
    (project.root / MODEL / "card.json").write_text(json.dumps(card))
    file = project.root / HISTORY
    history.add(file, CHOSEN, data="data/sct", model="linear")
    history.add(file, ENDED, code=0, round={"model": MODEL, "added": ["stribeck"], "report": "../../x.html"})


def test_links_that_lead_nowhere_hide_no_page(example: Project) -> None:
    for folder, name in (("models", "loop"), ("data", "loop"), ("fmus", "loop.fmu"), ("reports", "loop.html"), ("raw", "loop")):  # fmt: skip
        (example.root / folder / name).symlink_to(name)
        (example.root / folder / f"to-{name}").symlink_to("nowhere")
    said = every_page(example)
    assert [path for path, text in said.items() if "cannot be shown" in text] == []
    assert [p.name for p in example.data_sets()] == ["sct"]


@pytest.mark.parametrize(
    "learned",
    [[1], {"error_history": [{"added": ["a"], "before": {"rmse": float("nan")}, "after": {"rmse": 1.0}, "judged_by": "x"}]},
     *(pytest.param({"error_history": h}, marks=pytest.mark.nightly) for h in ("abc", [1, 2], {"a": 1}, [{"added": ["a"]}]))],
)  # fmt: skip
def test_a_card_of_another_kind_leaves_the_question_and_the_decision(
    example: Project, learned: object
) -> None:
    accepted(example, {"model": {"learned": learned}})
    waiting = every_page(example)["/"]
    # The report of the addition leads out of the project: that is told, and it can still be taken back.
    assert "leads out of the project" in waiting and "Take back" in waiting
    history.add(example.root / HISTORY, ACCEPTED, model=MODEL)
    said = every_page(example)["/"]
    assert "cannot be shown" not in said and ASK in said and "Take it away as an FMU" in said


def test_an_answer_that_cannot_be_read_can_be_asked_for_again(example: Project) -> None:
    file, page, _ = commands.models.diagnosis_files("data/sct", "linear")
    (example.root / page).write_text("no page")
    said = every_page(example)["/"]
    assert (
        f"{page}: no page of tribofmu" in said and commands.models.diagnose("data/sct", "linear").line in said
    )
    (example.root / file).write_text("[]")
    said = every_page(example)["/"]
    assert f"{file}: holds a list" in said and str(example.root) not in said


def test_damaged_measurements_can_be_left_for_others(example: Project) -> None:
    (example.root / "data/bad").mkdir()
    (example.root / "data/bad/points.csv").write_text("")
    said = every_page(example, "/explore?data=data/bad")["/explore?data=data/bad"]
    assert "data/bad/points.csv: the file is empty" in said and str(example.root) not in said
    names: list[Any] = []

    async def test(user: User, worker: Worker) -> None:
        await user.open("/explore?data=data/bad")
        await built(user)
        names.extend(next(iter(user.find(ui.select).elements)).options)

    look(example, test)
    assert names == ["data/bad", "data/sct"]


def test_results_that_cannot_be_read_hide_no_form(example: Project) -> None:
    accepted(example, {})
    for name in ("comparison-sct.html", "forming-fre.html"):
        (example.root / "reports" / name).write_text("no page")
    said = every_page(example)
    assert "no page of tribofmu" in said["/compare"] and "tribofmu compare" in said["/compare"]
    assert "no page of tribofmu" in said["/forming"] and "Run them" in said["/forming"]


def test_wrong_kinds_in_the_history_hide_no_report(example: Project) -> None:
    with (example.root / HISTORY).open("a") as stream:
        for job in ([1], {"a": 1}, 10**300, None):
            stream.write(
                json.dumps({"event": ENDED, "job": job, "code": [0], "command": "tribofmu check a"}) + "\n"
            )
    assert "cannot be shown" not in every_page(example)["/reports"]


def test_numbers_that_are_none_leave_forms_empty(example: Project) -> None:
    raw = example.root / "raw/rig"
    raw.mkdir()
    (raw / "rig.csv").write_text("t [s],F_n [kN],F_r [kN]\n" + "".join(f"{k},90,7\n" for k in range(50)))
    (raw / "channels.yaml").write_text(
        "channels: {'F_n [kN]': {quantity: F_n, offset: .inf, std: .nan}}\nmoving_mass: .inf\nmetadata: {T_tool: .nan}\n"
        "phases: {sliding: [.inf, 5], upsetting: [a, 2]}\n"
    )
    (raw / "oil.csv").write_text("test,v_mm_s,mu\na,1,0.1\n")
    (raw / "points.yaml").write_text("columns: {mu: mu}\nonly: {mu: {min: .nan, max: .inf}}\n")
    where = ("/measurements?raw=rig&as=records", "/measurements?raw=rig&as=points")
    for kept in ('{"process": "fre", "values": {"n_points": 1e999}}', '{"process": "fre", "stroke": NaN}'):
        (example.root / ".workbench/forming.json").write_text(kept)
        said = every_page(example, *where)
        assert [path for path, text in said.items() if "cannot be shown" in text] == []


def test_a_campaign_whose_table_has_none_of_our_columns(example: Project) -> None:
    raw, campaign = example.root / "raw/rig", example.root / "campaigns/rig"
    raw.mkdir()
    campaign.mkdir()
    (raw / "rig.csv").write_text("t [s],F_n [kN],F_r [kN]\n" + "".join(f"{k},90,7\n" for k in range(50)))
    (campaign / "campaign.json").write_text("{}")
    (campaign / "quality.csv").write_text("a,b\n1,2\n")
    said = every_page(example, "/measurements?raw=rig&as=records")["/measurements?raw=rig&as=records"]
    assert "cannot be shown" not in said and "Run the digital twin" in said


def test_a_decision_that_cannot_be_written_is_told(example: Project) -> None:
    accepted(example, {})

    async def test(user: User, worker: Worker) -> None:
        await user.open("/")
        await built(user)
        (example.root / HISTORY).chmod(0o444)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(os, "open", _refused)
            user.find("Accept").click()
        await user.should_see("history.jsonl: cannot be written")

    look(example, test)


def _refused(*_: object, **__: object) -> int:
    raise PermissionError(13, "Permission denied")


def test_a_map_is_kept_inside_of_the_project(example: Project, tmp_path: Path) -> None:
    raw, away = example.root / "raw/oil", tmp_path / "away"
    raw.mkdir()
    away.mkdir()
    (raw / "earlier").symlink_to(away)
    save_map(example, "raw/oil", False, {"columns": {"a": "mu"}})
    with pytest.raises(ValueError, match="leads out of the project"):
        save_map(example, "raw/oil", False, {"columns": {"b": "mu"}})
    assert list(away.iterdir()) == [] and "a: mu" in (raw / "points.yaml").read_text()


class _Slow(SmallFileUpload):
    """An upload whose bytes take a while to come to the disk."""

    async def save(self, path: Any) -> None:
        await asyncio.sleep(0.1)
        await super().save(path)


def test_of_two_files_of_one_name_the_first_stays(example: Project) -> None:
    raw = example.root / "raw/oil"
    raw.mkdir()
    (raw / "a.csv").write_text("test,v_mm_s,mu\na,1,0.1\n")

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements?raw=oil")
        await built(user)
        (area,) = user.find(ui.upload).elements
        both = [_Slow("b.csv", "text/csv", f"test,v_mm_s,mu\n{k},1,0.1\n".encode()) for k in "xy"]
        await asyncio.gather(*(area.handle_uploads([one]) for one in both))
        await until(lambda: "is in the set already" in shown(user))
        assert "raw/oil/b.csv is in the project" in shown(user)

    look(example, test)
    assert (raw / "b.csv").read_text() in {f"test,v_mm_s,mu\n{k},1,0.1\n" for k in "xy"}
    assert sorted(p.name for p in raw.iterdir()) == ["a.csv", "b.csv"]


def test_the_page_of_a_set_comes_when_its_files_are_there(example: Project) -> None:
    """A large file is still being kept when the browser has sent it: its page said that there was none."""
    there: list[bool] = []

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements")
        await built(user)
        (area,) = user.find(ui.upload).elements
        await area.handle_uploads([_Slow("big.csv", "text/csv", b"test,v_mm_s,mu\n1,1,0.1\n")])
        await asyncio.sleep(0.02)
        for listener in list(area._event_listeners.values()):
            if listener.type == "finish":
                area._handle_event({"listener_id": listener.id, "args": {}})
        await until(lambda: BROUGHT in {line["event"] for line in history.read(example.root / HISTORY)})
        there.append((example.root / "raw/big/big.csv").is_file())

    look(example, test)
    assert there == [True]


def test_a_place_where_nothing_can_be_brought_is_told(example: Project) -> None:
    (example.root / "raw").rmdir()
    (example.root / "raw").write_text("a file")

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements")
        await built(user)
        (area,) = user.find(ui.upload).elements
        await area.handle_uploads([SmallFileUpload("b.csv", "text/csv", b"test,v_mm_s,mu\n1,1,0.1\n")])
        await until(lambda: "raw" in shown(user) and "cannot be" in shown(user))

    look(example, test)
    assert BROUGHT not in {line["event"] for line in history.read(example.root / HISTORY)}
