"""What new users stumbled over on the way from their files to the question."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("nicegui", reason="the extra [app] is not installed")

from nicegui import ui
from nicegui.testing import User

from friction_models.loads import DataSet
from orchestrator.app import commands
from orchestrator.app.project import HISTORY, Project, history
from orchestrator.app.work.worker import Worker
from orchestrator.cli.main import run

from .seen import built, labelled, look, shown, until, waiting
from .test_measuring_pages import OIL, fields, file, upload
from .test_pages import storage

assert storage  # a fixture that holds here, too

TESTS = "test_id,role\n" + "".join(f"t{k},{'test' if k < 2 else ''}\n" for k in range(6))


@pytest.fixture
def project(tmp_path: Path) -> Project:
    """A project with a data set of six tests, two of them held out, and none to learn from."""
    made = Project.open(tmp_path / "new")
    (made.root / "data/oil").mkdir()
    points = "test_id,v_rel,mu\n" + "".join(f"t{k},{k},0.1\n" for k in range(6))
    (made.root / "data/oil/points.csv").write_text(points)
    (made.root / "data/oil/tests.csv").write_text(TESTS)
    return made


@pytest.mark.parametrize(("first", "name"), [("tests.csv", "oil"), ("oil.csv", "oil")])
def test_a_set_is_called_after_its_measurements(tmp_path: Path, first: str, name: str) -> None:
    project = Project.open(tmp_path / "new")
    texts = {"oil.csv": OIL, "tests.csv": "test_id,batch\nt0,a\n"}

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements")
        for each in sorted(texts, key=lambda n: n != first):
            await upload(user).handle_uploads([file(each, texts[each])])
        (finish,) = (x for x in upload(user)._event_listeners.values() if x.type == "finish")
        upload(user)._handle_event({"listener_id": finish.id, "args": {}})
        await until(lambda: bool(history.read(project.root / HISTORY)))

    look(project, test)
    assert [p.name for p in (project.root / "raw").iterdir()] == [name]
    assert sorted(p.name for p in (project.root / "raw" / name).iterdir()) == ["oil.csv", "tests.csv"]
    assert history.read(project.root / HISTORY)[-1]["data"] == f"raw/{name}"


def test_a_set_of_nothing_but_a_test_table_keeps_its_name(tmp_path: Path) -> None:
    project = Project.open(tmp_path / "new")

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements")
        await upload(user).handle_uploads([file("tests.csv", "test_id,batch\nt0,a\n")])
        (finish,) = (x for x in upload(user)._event_listeners.values() if x.type == "finish")
        upload(user)._handle_event({"listener_id": finish.id, "args": {}})
        await until(lambda: bool(history.read(project.root / HISTORY)))

    look(project, test)
    assert [p.name for p in (project.root / "raw").iterdir()] == ["tests"]


def test_the_unit_that_holds_without_one_is_shown(tmp_path: Path) -> None:
    project = Project.open(tmp_path / "new")
    (project.root / "raw/oil").mkdir()
    (project.root / "raw/oil/oil.csv").write_text(OIL.replace("v_mm_s", "speed"))

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements?raw=oil")
        await built(user)
        labelled(user, ui.select, "speed is").set_value("v_rel")
        await until(lambda: fields(user, ui.input, "unit")[1].props.get("placeholder") == "mm/s")
        labelled(user, ui.select, "speed is").set_value("T")
        await until(lambda: fields(user, ui.input, "unit")[1].props.get("placeholder") == "degC")

    look(project, test)


def test_all_that_is_not_held_out_is_learnt_from(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    lines: list[str] = []

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements?tests=data/oil")
        labelled(user, ui.input, "Value; empty clears").set_value("test")
        labelled(user, ui.input, "Tests: * is any text").set_value("*5")
        user.find("Set").click()
        await until(lambda: "Not saved yet" in shown(user))
        assert "All tests are held out" not in shown(user)
        user.find("Save the table").click()
        await until(lambda: bool(waiting(worker)))
        lines.extend(waiting(worker))

    look(project, test)
    monkeypatch.chdir(project.root)
    assert run(shlex.split(lines[0])[1:]) == 0
    data = DataSet.load("data/oil")
    held_out = set(data.select("test").points["test_id"])
    assert (
        len(held_out) == 3
        and set(data.select("train").points["test_id"]) == set(data.points["test_id"]) - held_out
    )


def test_from_the_test_table_the_way_leads_on(project: Project) -> None:
    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements?tests=data/oil")
        user.find("Ask what is missing").click()
        await until(lambda: bool(waiting(worker)))
        assert waiting(worker)[0].startswith("tribofmu diagnose --data data/oil ")

    look(project, test)


def test_what_is_refused_is_said_without_paths_of_the_machine(
    project: Project, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied", str(project.root / "raw/oil"))

    monkeypatch.setattr(Path, "rename", full)
    (project.root / "raw/oil").mkdir()
    (project.root / "raw/oil/oil.csv").write_text(OIL)

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements?raw=oil")
        await built(user)
        labelled(user, ui.input, "New name").set_value("motor-oil")
        user.find("Rename").click()
        await until(lambda: bool(user.notify.messages))
        assert user.notify.messages == ["[Errno 13] Permission denied: 'raw/oil'"]

    look(project, test)


def test_axes_are_chosen_with_their_units(project: Project) -> None:
    async def test(user: User, worker: Worker) -> None:
        await user.open("/explore")
        await built(user)
        assert "v_rel [mm/s]" in labelled(user, ui.select, "Across").options.values()

    look(project, test)


def test_what_waits_behind_a_long_command_is_counted(project: Project) -> None:
    async def test(user: User, worker: Worker) -> None:
        await user.open("/fmu")
        worker.start(commands.models.diagnose("data/oil", "linear"))
        worker.start(commands.models.train("data/oil", "linear", "linear"))
        # In a line of its own: behind a long command line it would be cut off.
        await until(lambda: "1 more waiting" in shown(user).split("\n"))

    look(project, test)


def test_the_first_page_does_not_wait_for_what_it_does_not_need() -> None:
    """What reads and fits data takes longer to import than the server to start."""
    script = (
        "import sys, orchestrator.app.server.listening, orchestrator.app.work.worker;"
        "import orchestrator.app.pages.frame, orchestrator.app.pages.missing, orchestrator.app.serving;"
        "print(sorted({'numpy', 'pandas', 'scipy', 'sklearn', 'numba', 'plotly', 'torch'} & sys.modules.keys()))"
    )
    found = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"
