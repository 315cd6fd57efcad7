"""Every command that a page starts, pasted into a shell, gives the same files.

Asking, adding and packing are held against the command line where the whole loop runs, in `test_browser`. Checking writes nothing:
what it says is held against what a shell says.
"""

from __future__ import annotations

import contextlib
import inspect
import io
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

pytest.importorskip("nicegui", reason="the extra [app] is not installed")

from nicegui import ui
from nicegui.testing import User
from typer.main import get_command

from forming.press import PressCurves, PressLevel
from orchestrator.app import commands
from orchestrator.app.commands import Command
from orchestrator.app.project import HISTORY, Project, history
from orchestrator.app.work.command_run import DONE, CommandRun
from orchestrator.app.work.worker import Worker
from orchestrator.cli.app import app
from orchestrator.cli.main import run

from . import seen
from .seen import labelled, look, shown, until
from .test_measuring_pages import OIL, fields
from .test_pages import storage

assert storage  # a fixture that holds here, too

ELSEWHERE = {"diagnose", "refine", "pack"}
FMU = "fmus/constant.fmu"
#: What differs from time to time: when something was computed, and how long it took [s].
TIMES = re.compile(rb'"(seconds|friction|forming|master|setup|total)": [\d.e+-]+|\d{4}-\d\d-\d\dT[\d:+]+')
#: Runs lines in their order in a process of its own, as a shell would.
PASTED = """
import os, shlex, sys
os.sched_getaffinity = lambda _: {0}
from orchestrator.cli.app import app
from orchestrator.cli.main import run
for line in sys.stdin.read().splitlines():
    assert run(shlex.split(line)[1:]) == 0, line
"""


class AtOnce(seen.Idle):
    """A worker that does at once what is asked, and writes the history as the other does."""

    def start(self, command: Command) -> CommandRun:
        """Run a command in this process."""
        job = super().start(command)
        with contextlib.redirect_stdout(io.StringIO()) as said:
            assert run(command.arguments) == 0, command.line
        job.lines.extend(said.getvalue().splitlines())
        history.add(self.project.root / HISTORY, history.ENDED, command=command.line, code=0, job=job.number)
        job.state = DONE
        return job


def prepared(root: Path) -> Project:
    """The example with a table, records and press curves of a lab, and a form for a small forming run."""
    project = Project.open(root, example=True)
    for name, file, text in (("oil", "oil.csv", OIL), ("rig", "sct7.csv", _record())):
        (project.root / "raw" / name).mkdir()
        (project.root / "raw" / name / file).write_text(text)
    curve = pd.DataFrame({"stroke": [0.0, 0.3], "force": [0.0, 200.0], "repeat": [1, 1]})
    level = PressLevel("fre", 20.0, 5.0, "oil", "rod.csv", curve)
    small: dict[str, Any] = {"mesh_size": 1.0, "n_points": 12}
    PressCurves((level,), {"process": small}).save(project.root / "press/rods")
    coin = {**small, "height": 10.0}
    history.add(project.root / HISTORY, history.CHOSEN, data="data/sct", model="linear")
    assert run(("pack", "0.08", "-o", str(project.root / FMU))) == 0
    project.keep("forming", {"process": "upsetting", "constants": "0.1", "values": coin, "stroke": 0.3})
    return project


def _record() -> str:
    rows = ["t [s],F_n [kN],F_r [kN],s [mm]"]
    for k in range(300):
        t = k / 100
        loaded = 0.0 if t < 0.5 else min(1.0, (t - 0.5) / 0.3)
        way = 50.0 * max(0.0, min(t, 2.5) - 1.5)
        rows.append(f"{t:.2f},{90 * loaded:.3f},{7.2 * loaded if 0 < way < 50 else 0:.3f},{way:.3f}")
    return "\n".join(rows) + "\n"


def files_of(root: Path) -> dict[str, bytes]:
    """Return what commands left in a project, without times; files that hold times, or hashes of such, are passed over."""
    timed = {".workbench", HISTORY, "log.txt", "result.json"}
    left = (p for p in root.rglob("*") if p.is_file() and not timed & {*p.parts})
    return {str(p.relative_to(root)): TIMES.sub(b"", p.read_bytes()) for p in left}


async def press_all(user: User) -> None:
    """Do everything that the pages offer."""

    async def press(path: str, text: str, label: str) -> None:
        await user.open(path)
        await until(lambda: text in shown(user) and label in shown(user))
        user.find(label).click()

    raw = "/measurements?raw=oil"
    await press(raw, "30 tests, 30 points", "Look through all files")
    await press(raw, "30 tests, 30 points", "Make the data set")
    await user.open("/measurements?raw=rig&as=records")
    await until(lambda: bool(fields(user, ui.number, "T_tool of all tests [degC]")))
    fields(user, ui.number, "T_tool of all tests [degC]")[0].set_value(20)
    await until(lambda: "sliding begins [s]" in shown(user))
    user.find("Look through all files").click()
    user.find("Take in the records").click()
    await press("/measurements?raw=rig&as=records", "What was taken in", "Run the digital twin")
    await user.open("/measurements?tests=data/oil")
    await until(lambda: bool(fields(user, ui.input, "Tests: * is any text")))
    labelled(user, ui.element, "Column, or a new one").set_value("batch")
    fields(user, ui.input, "Value; empty clears")[0].set_value("it's new")
    fields(user, ui.input, "Tests: * is any text")[0].set_value("t2*")
    user.find("Set").click()
    await user.should_see("Not saved yet")
    user.find("Save the table").click()
    await press("/compare", "Train a model", "Train a linear model")
    await press("/compare", "tribofmu compare", "Compare 2 models")
    await press("/forming", "--process upsetting", "Run them")
    await press("/forming", "--press press/rods", "Form every level of rods")
    await press("/forming?name=upsetting", "Were these loads tested?", "Ask for upsetting")
    await press("/fmu", f"tribofmu check {FMU}", "Check it")
    await user.open("/fmu")
    await user.should_see("It passed all")
    await press("/reports", "Tell the story", "Tell the story")


@pytest.mark.nightly
def test_every_line_of_the_pages_gives_the_same_files_in_a_shell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    project = prepared(tmp_path / "clicked")
    monkeypatch.setattr(seen, "Idle", AtOnce)
    monkeypatch.chdir(project.root)
    # One process does for runs as small as these.
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0}, raising=False)

    checked: list[str] = []

    async def test(user: User, worker: Worker) -> None:
        await press_all(user)
        checked.extend(next(j for j in worker.jobs if j.command.arguments[0] == "check").lines)

    look(project, test)
    lines = [e["command"] for e in history.read(project.root / HISTORY) if e["event"] == history.ENDED]
    sources = map(inspect.getsource, (commands.fmus, commands.forming, commands.measuring, commands.models))
    first = {word for source in sources for word in re.findall(r'[(\[]\s*"([a-z-]+)"', source)}
    offered = first & {*get_command(app).commands}  # type: ignore[attr-defined]
    assert {line.split()[1] for line in lines} | ELSEWHERE == offered
    # The same from the raw files, the maps that the pages saved, and the lines.
    again = prepared(tmp_path / "pasted").root
    for place in project.root.glob("raw/*/*.yaml"):
        shutil.copyfile(place, again / place.relative_to(project.root))
    told = (project.root / HISTORY).read_text().splitlines(keepends=True)
    (again / HISTORY).write_text("".join(told[:-1]))  # as it was when the last line, which tells it, began
    # -P: a project has a folder fmus, which is not the package.
    told_there = subprocess.run(
        [sys.executable, "-P", "-c", PASTED],
        input="\n".join(lines), text=True, cwd=again, check=True, stdout=subprocess.PIPE,
    ).stdout.splitlines()  # fmt: skip
    outcome = [line for line in checked if line.strip().startswith(("passed", "failed"))]
    assert len(outcome) > 5 and [line for line in told_there if line in outcome] == outcome
    clicked, pasted = files_of(project.root), files_of(again)
    assert clicked.keys() == pasted.keys()
    assert sum(name.endswith("results.nc") for name in clicked) == 3 and "data/rig/points.csv" in clicked
    assert [name for name in clicked if clicked[name] != pasted[name]] == []
