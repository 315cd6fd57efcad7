"""Measurements and Explore in NiceGUI's simulated browser: files brought, columns mapped, test tables changed, points picked."""

from __future__ import annotations

import base64
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("nicegui", reason="the extra [app] is not installed")

from nicegui import ui
from nicegui.elements.upload_files import SmallFileUpload
from nicegui.testing import User

from friction_models.loads import DataSet
from orchestrator.app.project import HISTORY, Project, history
from orchestrator.app.work.worker import Worker
from orchestrator.cli.main import run

from .seen import built, figures, look, shown, until, waiting
from .test_pages import HOSTILE, storage

assert storage  # a fixture that holds here, too

OIL = "test,v_mm_s,load_N,sigma_n_MPa,mu\n" + "".join(
    f"t{k},{1 + k % 3},{1 + k},{0.01 * (1 + k)},0.{90 - k}\n" for k in range(30)
)


def file(name: str, text: str) -> SmallFileUpload:
    return SmallFileUpload(name, "text/csv", text.encode())


def fields(user: User, kind: type[Any], label: str) -> list[Any]:
    assert user.client is not None
    return [e for e in user.client.elements.values() if isinstance(e, kind) and e.props.get("label") == label]


def upload(user: User) -> Any:
    assert user.client is not None
    return next(e for e in user.client.elements.values() if isinstance(e, ui.upload))


def numbers(values: Any) -> np.ndarray:
    """Return what plotly gets as a typed array; a list would fail here."""
    found: np.ndarray = np.frombuffer(base64.b64decode(values["bdata"]), np.dtype(values["dtype"]))
    return found


def test_from_a_dropped_table_to_a_data_set(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    project = Project.open(tmp_path / "new")

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements")
        await user.should_see("There are no data sets yet")
        await upload(user).handle_uploads([file("oil 20C.csv", OIL)])
        await until(lambda: (project.root / "raw/oil-20C/oil-20C.csv").is_file())
        await user.open("/measurements?raw=oil-20C")
        await until(lambda: "30 tests, 30 points" in shown(user))
        is_ = [f for f in user.find(ui.select).elements if str(f.props["label"]).endswith(" is")]
        assert [f.value for f in sorted(is_, key=lambda f: f.id)] == ["test_id", "v_rel", "", "sigma_n", "mu"]
        # Two pictures: mu over the loads, and every column in the units of the contract.
        assert len(figures(user)) == 2
        # An example stands below its field, where nobody takes it for a value.
        shared = fields(user, ui.input, "what all tests share")[0]
        assert shared.value == "" and shared.props["hint"] == "such as lubricant=MoS2; bore=15.5"
        low = fields(user, ui.number, "rows from")
        low[1].set_value(10.5)
        await until(lambda: "20 tests, 20 points" in shown(user))
        fields(user, ui.input, "unit")[1].set_value("m/s")
        columns = figures(user)[1]["data"]
        await until(lambda: numbers(figures(user)[1]["data"][0]["y"]).max() == pytest.approx(3000.0))
        assert numbers(columns[0]["y"]).max() == pytest.approx(3.0)
        fields(user, ui.input, "unit")[1].set_value("K")
        await until(lambda: "Not complete" in shown(user))
        fields(user, ui.input, "unit")[1].set_value("m/s")
        await until(lambda: "20 tests, 20 points" in shown(user))
        user.find("Make the data set").click()
        await until(lambda: bool(waiting(worker)))

    look(project, test)
    command = "tribofmu points raw/oil-20C/oil-20C.csv --map raw/oil-20C/points.yaml -o data/oil-20C"
    assert [e.get("file") for e in history.read(project.root / HISTORY)][-1] == "raw/oil-20C/points.yaml"
    monkeypatch.chdir(project.root)
    assert run(command.split()[1:]) == 0
    points = DataSet.load("data/oil-20C").points
    # Rows of 11 N and more; speeds of m/s.
    assert len(points) == 20 and set(points["v_rel"]) == {1000.0, 2000.0, 3000.0}


def test_a_data_set_of_others_is_brought_with_its_test_table(tmp_path: Path) -> None:
    project = Project.open(tmp_path / "new")

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements")
        text = "test_id,v_rel,mu\n" + "".join(f"t{k},{k},0.1\n" for k in range(9))
        table = "test_id,batch\n" + "".join(f"t{k},b{k % 2}\n" for k in range(9))
        await upload(user).handle_uploads([file("points.csv", text), file("tests.csv", table)])
        await until(lambda: (project.root / "raw/points/tests.csv").is_file())
        await user.open("/measurements?raw=points")
        await until(lambda: "9 tests, 9 points" in shown(user))
        await user.should_see("1 file (1 CSV)")
        await user.should_see("batch: taken from tests.csv")
        user.find("Make the data set").click()
        await until(lambda: bool(waiting(worker)))
        assert "tribofmu points raw/points/points.csv --map" in waiting(worker)[0]

    look(project, test)


def test_the_picture_of_many_short_tests_shows_them_all_along(tmp_path: Path) -> None:
    project = Project.open(tmp_path / "new")
    (project.root / "raw/rig").mkdir()
    rows = [f"t{k},{s},{10 + s},0.{50 + s}" for k in range(60) for s in range(25)]
    (project.root / "raw/rig/rig.csv").write_text("test_id,sd,v_rel,mu\n" + "\n".join(rows) + "\n")

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements?raw=rig")
        await until(lambda: "60 tests, 1500 points" in shown(user))
        # Which points are drawn does not depend on where they stand in their test.
        drawn = numbers(figures(user)[1]["data"][0]["y"])
        assert len(drawn) <= 600
        assert np.bincount(drawn.astype(int)).min() > 10
        assert "First file, 1500 rows, thinned to 600." in shown(user)

    look(project, test)


def test_records_are_mapped_with_units_phases_and_zero_readings(tmp_path: Path) -> None:
    project = Project.open(tmp_path / "new")
    (project.root / "raw/rig").mkdir()
    rows = []
    for k in range(400):
        t = k / 100
        loaded = 0.0 if t < 0.5 else min(1.0, (t - 0.5) / 0.3)
        way = 50.0 * max(0.0, min(t, 3.0) - 1.5)
        rows.append(
            f"{t:.2f};{90 * loaded + 0.3:.3f};{(7.2 * loaded if 0 < way < 75 else 0) + 0.05:.3f};{way:.3f}"
        )
    text = "Zeit;Kraft Z;Kraft X;Weg\ns;kN;kN;mm\n" + "\n".join(rows) + "\n"
    (project.root / "raw/rig/sct7.csv").write_text(text.replace(".", ","))

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements?raw=rig")
        await until(lambda: "Not complete: no plate temperature" in shown(user))
        fields(user, ui.number, "T_tool of all tests [degC]")[0].set_value(20)
        await until(lambda: "sliding begins [s]" in shown(user))
        said = shown(user)
        # 0.3 kN without load; friction 7.2 kN over 90 kN.
        assert "F_n without load, before the test [N]</th><td>300</td>" in said
        assert re.search(r"mean mu</th><td>0\.0(79\d*|8\d*)</td>", said)
        (chart,) = figures(user)
        assert len(chart["layout"]["shapes"]) == 6
        fields(user, ui.number, "zero reading (in its unit)")[1].set_value(0.3)
        await until(lambda: "F_n without load, before the test [N]</th><td>300" not in shown(user))
        assert re.search(
            r"F_n without load, before the test \[N\]</th><td>(0|-?\d\S*e-1\d)</td>", shown(user)
        )
        for label, value in (
            ("upsetting from", 0.5),
            ("upsetting to", 2.0),
            ("sliding from", 2.0),
            ("sliding to", 2.5),
        ):
            fields(user, ui.number, f"{label} [s]")[0].set_value(value)
        await until(lambda: "sliding begins [s]</th><td>2</td>" in shown(user))
        user.find("Save the map").click()
        await until(lambda: (project.root / "raw/rig/channels.yaml").is_file())
        assert "sliding" in (project.root / "raw/rig/channels.yaml").read_text()
        fields(user, ui.number, "moving mass [kg]")[0].set_value(25)
        await until(lambda: "moving_mass" in shown(user))
        user.find("Take in the records").click()
        await until(lambda: bool(waiting(worker)))
        assert waiting(worker) == ["tribofmu ingest raw/rig --map raw/rig/channels.yaml -o campaigns/rig"]
        # The map before is kept.
        assert "moving_mass" not in (project.root / "raw/rig/earlier/channels-001.yaml").read_text()

    look(project, test)


def test_a_test_table_is_changed_by_the_line_that_is_shown(
    example: Project, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements?tests=data/sct")
        (grid,) = (
            [e for e in user.client.elements.values() if isinstance(e, ui.aggrid)] if user.client else []
        )
        assert len(grid.options["rowData"]) == 111
        batch = next(c["field"] for c in grid.options["columnDefs"] if c["headerName"] == "batch")
        event = {"data": {"c0": "sct002"}, "colId": batch, "newValue": "new 'one'"}
        (listener,) = [x for x in grid._event_listeners.values() if x.type == "cellValueChanged"]
        grid._handle_event({"listener_id": listener.id, "args": event})
        fields(user, ui.input, "Value; empty clears")[0].set_value("test")
        fields(user, ui.input, "Tests: * is any text")[0].set_value("sct00*")
        user.find("Set").click()
        await user.should_see("Not saved yet: 10 cells changed")
        user.find("Save the table").click()
        await until(lambda: bool(waiting(worker)))
        (line,) = waiting(worker)
        assert line.startswith("tribofmu tests data/sct --set ")
        lines.append(line)

    import shlex

    lines: list[str] = []
    before = (example.root / "data/sct/tests.csv").read_bytes()
    look(example, test)
    monkeypatch.chdir(example.root)
    assert run(shlex.split(lines[0])[1:]) == 0
    tests = DataSet.load("data/sct").tests
    assert tests is not None
    found = tests.set_index("test_id")
    assert found.loc["sct002", "batch"] == "new 'one'" and found.loc["sct009", "role"] == "test"
    assert (example.root / "data/sct/earlier/tests-001.csv").read_bytes() == before


def test_roles_that_leave_nothing_to_learn_from_are_told(tmp_path: Path) -> None:
    project = Project.open(tmp_path / "new")
    (project.root / "data/oil").mkdir()
    (project.root / "data/oil/points.csv").write_text("test_id,v_rel,mu\na,1,0.1\nb,2,0.1\n")

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements?tests=data/oil")
        for which, role, told in (("*", "test", True), ("b", "", False)):
            fields(user, ui.input, "Value; empty clears")[0].set_value(role)
            fields(user, ui.input, "Tests: * is any text")[0].set_value(which)
            user.find("Set").click()
            await until(lambda told=told: ("All tests are held out" in shown(user)) == told)  # type: ignore[misc]
        assert "Not saved yet" in shown(user)
        for table, told in (("a,test\nb,test\n", True), ("a,test\nb,\n", False)):
            (project.root / "data/oil/tests.csv").write_text(f"test_id,role\n{table}")
            await user.open("/measurements")
            assert ("no test has the role train" in shown(user)) == told
        assert "1 test, 1 train" in shown(user)
        # Letters of this project are said in words.
        assert "psi (local surface expansion dA/dA0)" in shown(user)

    look(project, test)


def test_pictures_of_the_same_points_that_can_be_picked(example: Project) -> None:
    async def test(user: User, worker: Worker) -> None:
        await user.open("/explore")
        await until(lambda: len(figures(user)) == 2)
        over_distance, loads = figures(user)
        assert over_distance["layout"]["xaxis"]["title"]["text"] == "sd [mm]"
        clouds = [next(t for t in f["data"] if "customdata" in t) for f in (over_distance, loads)]
        assert numbers(clouds[0]["customdata"]).tolist() == numbers(clouds[1]["customdata"]).tolist()
        points = DataSet.load(example.root / "data/sct").points
        assert numbers(clouds[0]["y"]) == pytest.approx(points["mu"].to_numpy(), rel=1e-6)
        # The plan: what the tests were set to, once each.
        plan = next(t for t in loads["data"] if t.get("name") == "plan")
        assert {5.0, 200.0, 500.0} <= set(numbers(plan["x"]).tolist())
        for field, value in (("Across", "sigma_n"), ("Colour", "batch")):
            fields(user, ui.select, field)[0].set_value(value)
        await until(lambda: any(t.get("name") == "B" for f in figures(user) for t in f["data"]))
        fields(user, ui.input, "Part of a test name")[0].set_value("sct00")
        await until(lambda: "of 9 tests" in shown(user))
        plot = (
            next(e for e in user.client.elements.values() if isinstance(e, ui.plotly))
            if user.client
            else None
        )
        assert plot is not None
        (listener,) = [x for x in plot._event_listeners.values() if x.type == "plotly_selected"]
        plot._handle_event({"listener_id": listener.id, "args": [2, 4, 99, "x"]})
        await user.should_see("Picked: sct003, sct005")
        fields(user, ui.input, "Part of a test name")[0].set_value("nothing")
        await user.should_see("No test has such a name", retries=30)

    look(example, test)


def test_uploads_are_bounded_and_names_are_checked(example: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("orchestrator.app.pages.measurements.bring.LARGEST", 5000)

    async def test(user: User, worker: Worker) -> None:
        for name, text, said in (
            ("../../evil.csv", OIL, "raw/evil/evil.csv is in the project"),
            ("script.html", "x", "allowed: .asc, .bin, .csv"),
            ("large.csv", OIL * 20, "allowed: at most 5000"),
            ("nothing.csv", "", "the file is empty"),
            ("<img src=x onerror=alert(1)>.csv", OIL, "is in the project"),
        ):
            await user.open("/measurements")
            await upload(user).handle_uploads([file(name, text)])
            await user.should_see(said, retries=20)
        await user.open("/measurements?raw=evil")
        await upload(user).handle_uploads([file("evil.csv", OIL)])
        await user.should_see("is in the set already", retries=20)

    look(example, test)
    assert not (example.root.parent / "evil.csv").exists()
    names = sorted(p.name for p in (example.root / "raw").iterdir())
    assert "evil" in names and all(n.replace("-", "").isalnum() for n in names) and len(names) == 2


def test_no_address_leads_out_of_the_project(example: Project) -> None:
    async def test(user: User, worker: Worker) -> None:
        for query in ("raw=../..", "raw=nothing", "raw=.workbench", "raw=%3Cimg%20src=x%3E", "tests=../..", "tests=/etc", "tests=data", "tests=models/../data/sct"):  # fmt: skip
            await user.open(f"/measurements?{query}")
            await user.should_see("This cannot be shown", retries=20)

    look(example, test)


def test_columns_of_others_stay_text(tmp_path: Path) -> None:
    project = Project.open(tmp_path / "new")
    (project.root / "raw/bad").mkdir()
    rows = "".join(f"{k},0.1,{HOSTILE}\n" for k in range(12))
    (project.root / "raw/bad/a.csv").write_text(f":sd,mu,{HOSTILE}\n{rows}")
    (project.root / "raw/bad/points.yaml").write_text(
        f"columns: {{mu: mu, '{HOSTILE}': {{test_table: note}}}}\n"
    )
    (project.root / "raw/link.csv").symlink_to("/etc/passwd")
    (project.root / "raw/bad/out.csv").symlink_to("/etc/passwd")

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements?raw=bad")
        await until(lambda: "What each column is" in shown(user))
        await built(user)
        assert user.client is not None
        for element in user.client.elements.values():
            if isinstance(element, ui.html):
                assert "<img" not in element.content
        assert "1 file (" in shown(user) and "out.csv" not in shown(user)

    look(project, test)
