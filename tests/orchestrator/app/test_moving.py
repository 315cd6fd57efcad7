"""Sets of measurement files that are renamed, put aside and brought back: nothing is deleted, nothing replaced."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

pytest.importorskip("nicegui", reason="the extra [app] is not installed")

from nicegui import ui
from nicegui.testing import User

from friction_models.common import InputError
from orchestrator.app.commands import Command
from orchestrator.app.project import HISTORY, Project, history
from orchestrator.app.raw.moving import ASIDE, aside, move, own_set
from orchestrator.app.work.worker import Worker

from .seen import built, labelled, look, shown, until
from .test_pages import storage

assert storage  # a fixture that holds here, too

OIL = "test,v_mm_s,sigma_n_MPa,mu\n" + "".join(f"t{k},{1 + k % 3},{1 + k},0.1\n" for k in range(6))


@pytest.fixture
def raw(example: Project) -> Path:
    """A set of files with its map."""
    made = example.root / "raw/oil"
    made.mkdir()
    (made / "oil.csv").write_text(OIL)
    (made / "points.yaml").write_text("columns: {mu: mu}\n")
    return made


def files_of(root: Path) -> dict[str, bytes]:
    left = (p for p in root.rglob("*") if p.is_file() and p.name != HISTORY and ".workbench" not in p.parts)
    return {str(p.relative_to(root)): p.read_bytes() for p in left}


def test_a_set_is_renamed_put_aside_and_brought_back(example: Project, raw: Path) -> None:
    before = set(files_of(example.root).values())

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements?raw=oil")
        await built(user)
        labelled(user, ui.input, "New name").set_value("motor oil")
        user.find("Rename").click()
        await user.should_see("letters, digits, dot, dash and underscore")
        assert raw.is_dir()
        labelled(user, ui.input, "New name").set_value("motor-oil")
        user.find("Rename").click()
        await until(lambda: (example.root / "raw/motor-oil/points.yaml").is_file())
        await user.open("/measurements?raw=motor-oil")
        await built(user)
        user.find("Put this set aside").click()
        await until(lambda: (example.root / ASIDE / "motor-oil/oil.csv").is_file())
        await user.open("/measurements")
        await built(user)
        assert "motor-oil: 1 file" not in shown(user)
        user.find("Bring motor-oil back").click()
        await until(lambda: "motor-oil: 1 file" in shown(user))

    look(example, test)
    assert set(files_of(example.root).values()) == before
    told = [history.about(line) for line in history.read(example.root / HISTORY)]
    assert told == [
        "mv raw/oil raw/motor-oil",
        "mv raw/motor-oil aside/motor-oil",
        "mv aside/motor-oil raw/motor-oil",
    ]


def test_a_summary_beside_its_records_gets_a_set_of_its_own(example: Project, raw: Path) -> None:
    (raw / "points.yaml").unlink()
    (raw / "summary.csv").write_text(OIL)
    before = set(files_of(example.root).values())

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements?raw=oil")
        await built(user)
        assert "tables of the same kind" in shown(user)
        await user.should_see("Put oil.csv into a set of its own")
        user.find("Put summary.csv into a set of its own").click()
        await until(lambda: (example.root / "raw/summary/summary.csv").is_file())
        await user.open("/measurements?raw=oil")
        await until(lambda: "6 tests, 6 points" in shown(user))
        await user.should_not_see("into a set of its own")

    look(example, test)
    assert set(files_of(example.root).values()) == before


def test_the_old_address_says_where_a_set_is_now(example: Project, raw: Path) -> None:
    for source, target in (("raw/oil", "raw/tin"), ("raw/tin", "raw/zinc")):
        move(example, source, target)

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements?raw=oil")
        await user.should_see("It is called zinc now.")
        move(example, "raw/zinc", "aside/zinc")
        await user.open("/measurements?raw=tin")
        await user.should_see("This set was put aside")
        # The history is a file like any other.
        history.add(example.root / HISTORY, history.MOVED, command="mv raw/hostile /etc")
        history.add(example.root / HISTORY, history.MOVED, command="mv raw/'")
        for name in ("hostile", "never"):
            await user.open(f"/measurements?raw={name}")
            await user.should_see("no such folder of measurement files")

    look(example, test)


def test_the_lines_of_the_history_move_the_same_files(example: Project, raw: Path, tmp_path: Path) -> None:
    again = Project.open(tmp_path / "again", example=True)
    (again.root / "raw/oil").mkdir()
    for file in raw.iterdir():
        (again.root / "raw/oil" / file.name).write_bytes(file.read_bytes())
    assert own_set(example, "raw/oil/oil.csv") == "oil-2"
    move(example, "raw/oil-2", "raw/a")
    move(example, "raw/a", f"{ASIDE}/a")
    for line in history.read(example.root / HISTORY):
        (again.root / ASIDE).mkdir(exist_ok=True)
        subprocess.run(str(line["command"]), shell=True, cwd=again.root, check=True)
    assert files_of(again.root) == files_of(example.root)


def test_nothing_is_replaced_and_nothing_leaves_the_project(
    example: Project, raw: Path, tmp_path: Path
) -> None:
    (example.root / "raw/taken").mkdir()
    (example.root / "raw/file").write_text("x")
    (tmp_path / "away").mkdir()
    (example.root / ASIDE).symlink_to(tmp_path / "away")
    for target in ("raw/taken", "raw/file", "raw/oil", "raw/../x", "raw/--force", "raw/", f"{ASIDE}/oil"):
        with pytest.raises(InputError):
            move(example, "raw/oil", target)
    for file in ("raw/oil/none.csv", "raw/oil", "raw/file", "data/sct/points.csv"):
        with pytest.raises(InputError, match="no such file of measurements"):
            own_set(example, file)
    with pytest.raises(InputError, match="no such folder"):
        move(example, "raw/none", "raw/new")
    assert raw.is_dir() and list((tmp_path / "away").iterdir()) == []
    assert history.read(example.root / HISTORY) == []


def test_a_set_that_a_command_reads_stays(example: Project, raw: Path) -> None:
    line = Command("Make", ("points", "raw/oil/oil.csv", "--map", "raw/oil/points.yaml", "-o", "data/oil"))

    async def test(user: User, worker: Worker) -> None:
        worker.start(line)
        await user.open("/measurements?raw=oil")
        await built(user)
        user.find("Put this set aside").click()
        await user.should_see("a command that runs or waits names it")

    look(example, test)
    assert raw.is_dir()


def test_a_set_that_cannot_be_read_can_be_put_aside(example: Project, raw: Path) -> None:
    (raw / "oil.csv").write_bytes(b"\0\1")

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements?raw=oil")
        await built(user)
        user.find("Put this set aside").click()
        await until(lambda: not raw.exists())

    look(example, test)


def test_a_name_that_is_taken_aside_gets_another(example: Project, raw: Path) -> None:
    (example.root / ASIDE / "oil").mkdir(parents=True)
    assert aside(example, "oil") == "aside/oil-2"
