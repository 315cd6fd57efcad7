"""The page Forming: a form from declared parameters, the command behind it, and what it wrote."""

from __future__ import annotations

import json
import shlex
import shutil
from pathlib import Path

import pytest

pytest.importorskip("nicegui", reason="the extra [app] is not installed")

from nicegui import ui
from nicegui.testing import User

from forming.press import PressCurves, PressLevel
from forming.processes.names import PROCESSES
from forming.processes.parameters import declared
from orchestrator.app.commands.forming import coverage, form
from orchestrator.app.project import HISTORY, Project, history
from orchestrator.app.work.worker import Worker
from orchestrator.cli.main import run

from .seen import figures, labelled, look, shown, until, waiting

QUICK = form("upsetting", ["0.05", "0.1"], {"height": "10", "mesh_size": "1", "n_points": "12"}, [5.0], [20.0], 0.4)  # fmt: skip


@pytest.fixture(scope="module")
def formed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example after forming, by the line of the button."""
    project = Project.open(tmp_path_factory.mktemp("formed") / "project", example=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(project.root)
        assert run([*QUICK.arguments, "-j", "1"]) == 0
    return project.root


@pytest.fixture
def project(formed: Path, tmp_path: Path) -> Project:
    """A copy of it."""
    shutil.copytree(formed, tmp_path / "copy")
    return Project.open(tmp_path / "copy")


def test_every_process_has_a_form_of_its_declared_parameters(example: Project) -> None:
    async def test(user: User, worker: Worker) -> None:
        await user.open("/forming")
        for process in PROCESSES:
            labelled(user, ui.select, "Process").set_value(process)
            await until(lambda process=process: f"--process {process} " in shown(user))
            fields = {str(n.props["label"]): n for n in user.find(ui.number).elements}
            for p in declared(process).values():
                if p.kind == "number" and p.name not in {"speed", "T_tool"}:
                    (field,) = [f for label, f in fields.items() if label.partition(" [")[0].replace(" ", "_") == p.name]  # fmt: skip
                    assert field.value == p.default and (field.min, field.max) == (p.low, p.high)
                    assert p.unit in field.props["label"] and p.meaning[:20] in shown(user).replace(
                        "&#x27;", "'"
                    )

    look(example, test)


def test_the_form_becomes_a_command_line(example: Project) -> None:
    async def test(user: User, worker: Worker) -> None:
        await user.open("/forming")
        await until(
            lambda: "Constant mu" in str([i.props.get("label") for i in user.find(ui.input).elements])
        )
        labelled(user, ui.number, "half angle").set_value(30)
        labelled(user, ui.input, "Punch speeds").set_value("5, 50")
        labelled(user, ui.input, "Constant mu").set_value("0.05,0.1")
        labelled(user, ui.number, "stroke").set_value(6)
        labelled(user, ui.input, "Name").set_value("../my rods")
        expected = form(
            "fre", ["0.05", "0.1"], {"half_angle": "30"}, [5.0, 50.0], [20.0], 6.0, name="my rods"
        )
        assert "--runs runs/my-rods --json reports/forming-my-rods.json" in expected.line
        await until(lambda: expected.line in shown(user).replace("&#x27;", "'"))
        user.find("Run them").click()
        assert waiting(worker) == [expected.line]
        labelled(user, ui.number, "half angle").set_value(85)
        await until(lambda: "10 to 80 degrees" in shown(user))
        labelled(user, ui.number, "half angle").set_value(45)
        labelled(user, ui.input, "Constant mu").set_value("")
        await until(lambda: "Choose at least one friction model" in shown(user))

    look(example, test)


def test_what_was_filled_in_stays_when_a_command_ends(example: Project) -> None:
    async def test(user: User, worker: Worker) -> None:
        await user.open("/forming")
        await until(lambda: "--process fre " in shown(user))
        labelled(user, ui.number, "half angle").set_value(31)
        await until(lambda: "half_angle=31" in shown(user))
        user.find("Run them").click()
        user.find("Cancel").click()  # ends the command: the page is built again
        await until(lambda: "was cancelled" in shown(user))
        await until(lambda: "half_angle=31" in shown(user) and labelled(user, ui.number, "half").value == 31)
        # Also when one goes to another page and comes back.
        await user.open("/fmu")
        await user.open("/forming")
        await until(lambda: "half_angle=31" in shown(user) and labelled(user, ui.number, "half").value == 31)

    look(example, test)


@pytest.mark.parametrize("left", ['{"process": "fre", "values": {"half_angle": []}}', '{"process": "x"}', "[1", '{"process": "fre", "style": 1}', '{"process": "fre", "values": {"material": "../x"}}', '{"process": "fre", "press": "../x.csv"}'])  # fmt: skip
def test_a_form_of_others_is_not_filled_in(example: Project, left: str) -> None:
    (example.root / ".workbench/forming.json").write_text(left)

    async def test(user: User, worker: Worker) -> None:
        await user.open("/forming")
        await until(lambda: "--process fre " in shown(user))
        assert "--set" not in shown(user) and "--press" not in shown(user)

    look(example, test)


def test_forces_and_loads_of_the_runs_with_a_slider(project: Project) -> None:
    answer = json.loads((project.root / "reports/forming-upsetting.json").read_text())
    models = answer["levels"][0]["models"]

    async def test(user: User, worker: Worker) -> None:
        await user.open("/forming")
        await until(lambda: "Results: upsetting" in shown(user) and len(figures(user)) >= 3)
        text = shown(user)
        assert all(f"{m['max_force_kN']:.2f}" in text for m in models)
        await until(lambda: "stroke 0.20 mm" in shown(user))
        (slider,) = user.find(ui.slider).elements
        contact = next(f for f in figures(user) if len(f["data"]) == 12)
        before = json.dumps(contact["data"])
        slider.set_value(4)
        await until(lambda: "stroke 0.40 mm" in shown(user))
        contact = next(f for f in figures(user) if len(f["data"]) == 12)
        assert json.dumps(contact["data"]) != before and "sliders" not in contact["layout"]

    look(project, test)


def test_coverage_is_asked_of_a_run_and_shown(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(user: User, worker: Worker) -> None:
        await user.open("/forming")
        await until(lambda: "Were these loads tested?" in shown(user))
        user.find("Ask for upsetting-speed-5-T_tool-20").click()
        (line,) = waiting(worker)
        assert run(shlex.split(line)[1:]) == 0
        await user.open("/forming")
        await until(lambda: "Pairs of loads" in shown(user))

    monkeypatch.chdir(project.root)
    look(project, test)
    folders = json.loads((project.root / "runs/upsetting/upsetting-speed-5-T_tool-20/runs.json").read_text())
    assert coverage("data/sct", f"runs/upsetting/upsetting-speed-5-T_tool-20/{folders['0.05']}", "x").line.count("jobs") == 1  # fmt: skip


def test_measurements_that_lack_loads_are_not_held_against_a_run(project: Project) -> None:
    (project.root / "data/oil.csv").write_text("test_id,v_rel,mu\na,1,0.1\nb,2,0.1\n")
    history.add(project.root / HISTORY, history.CHOSEN, data="data/oil.csv", model="linear")

    async def test(user: User, worker: Worker) -> None:
        await user.open("/forming")
        await until(lambda: "oil, lack T, sigma_n, sd, psi" in shown(user))
        assert "Ask for upsetting" not in shown(user)

    look(project, test)


def test_a_press_curve_fills_the_form(example: Project) -> None:
    import pandas as pd

    curves = pd.DataFrame({"stroke": [0.0, 4.0, 0.0, 4.0], "force": [0.0, 200, 0.0, 210], "repeat": [1, 1, 2, 2]})  # fmt: skip
    level = PressLevel("bce", 100.0, 50.0, "<b>soap</b>", "cup.csv", curves)
    PressCurves((level,), {"process": {"punch_diameter": 15.0}}).save(example.root / "press/cups")

    async def test(user: User, worker: Worker) -> None:
        await user.open("/forming")
        await until(lambda: "--process fre " in shown(user))
        labelled(user, ui.select, "Over a press").set_value("press/cups/cup.csv")
        expected = form("bce", ["0.08"], {"punch_diameter": "15"}, [50.0], [100.0], 4.0, "press/cups/cup.csv", name="cups-cup")  # fmt: skip
        await until(lambda: expected.line in shown(user))
        assert "tribofmu compare --press press/cups --models 0.08 --runs runs/press-cups" in shown(user)
        labelled(user, ui.input, "Punch speeds").set_value("5,50")
        await until(lambda: "that of one level" in shown(user))

    look(example, test)


def test_run_folders_of_others_lead_nowhere(project: Project) -> None:
    file = project.root / "runs/upsetting/upsetting-speed-5-T_tool-20/runs.json"
    places = ["../../../../etc", "jobs/../../x", "--force", 3, None]
    file.write_text(json.dumps({f"<img src=x>{k}": place for k, place in enumerate(places)}))

    async def test(user: User, worker: Worker) -> None:
        await user.open("/forming")
        await until(lambda: len(figures(user)) >= 3)
        assert "Were these loads tested?" not in shown(user) and "cannot be shown" not in shown(user)

    look(project, test)


@pytest.fixture(autouse=True)
def storage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is stored where the tests run."""
    monkeypatch.chdir(tmp_path)
