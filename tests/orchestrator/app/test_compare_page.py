"""Compare: where models miss, from the cell to the curve of a test; models of others in ONNX."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

pytest.importorskip("nicegui", reason="the extra [app] is not installed")

from nicegui import ui

from friction_models import DataSet
from friction_models.common.wording import counted
from orchestrator.app.commands.models import compare, comparison_points, refine, train
from orchestrator.app.figures.residuals import between, cells, points_of
from orchestrator.app.project import HISTORY, Project, history
from orchestrator.cli.main import run

from .seen import figures, labelled, look, shown, until, waiting

MODELS = ["0.06", "0.08"]


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example after comparing two constants, by the line of the button."""
    root = Project.open(tmp_path_factory.mktemp("compared") / "project", example=True).root
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(root)
        assert run(compare("data/sct", MODELS).arguments) == 0
    return root


@pytest.fixture
def project(compared: Path, tmp_path: Path) -> Project:
    """A copy of it."""
    shutil.copytree(compared, tmp_path / "copy")
    return Project.open(tmp_path / "copy")


def test_a_cell_holds_the_residual_of_its_points(compared: Path) -> None:
    frame = points_of(compared / comparison_points("data/sct"))
    data = DataSet.load(compared / "data/sct")
    assert data.tests is not None
    held_out = data.tests.query("role == 'test'")
    ids = set(held_out["test_id"] if "test_id" in held_out.columns else held_out.index)
    measured = data.points[data.points["test_id"].isin(ids)]
    assert len(frame) == len(measured) and set(frame["test_id"]) == ids
    found = cells(frame, "0.08", "v_rel", "sigma_n")
    assert sum(len(c.tests) for c in found) >= len(ids)
    for cell in found:
        part = measured[
            measured["v_rel"].between(*cell.bounds[0]) & measured["sigma_n"].between(*cell.bounds[1])
        ]
        means = part.groupby("test_id")["mu"].mean() - 0.08
        assert cell.mean == pytest.approx(means.mean(), abs=1e-12)
        assert cell.tests == sorted(part["test_id"].unique())
        if len(means) > 2:
            # Every test is one observation: the textbook's interval of a mean.
            from scipy.stats import t

            half = t.ppf(0.975, len(means) - 1) * means.std() / np.sqrt(len(means))
            assert cell.half == pytest.approx(half, rel=0.02)


def test_the_page_says_on_what_it_compares_and_which_model_is_of_other_measurements(project: Project) -> None:
    """Two data sets: the model of one is neither chosen nor replaced for the other."""
    shutil.copytree(project.root / "data/sct", project.root / "data/zinc")
    for name in ("linear", "linear-stribeck"):
        (project.root / "models" / name).mkdir()
        (project.root / "models" / name / "card.json").write_text("{}")
    for command in (train("data/sct", "linear"), refine("data/zinc", "linear", ["stribeck"])):
        history.add(project.root / HISTORY, history.ENDED, job=1, code=0, command=command.line)

    async def test(user: Any, worker: Any) -> None:
        await user.open("/compare?data=data/zinc")
        assert labelled(user, ui.select, "Measurements").value == "data/zinc"
        chosen = labelled(user, ui.select, "Models")
        assert chosen.value == ["models/linear-stribeck", "0.08"]
        assert "was fitted to" not in shown(user)
        chosen.set_value(["models/linear", "models/linear-stribeck"])
        await until(lambda: "linear was fitted to sct" in shown(user))
        user.find("Compare 2 models").click()
        assert waiting(worker) == [compare("data/zinc", ["models/linear", "models/linear-stribeck"]).line]
        await user.should_see("tribofmu train linear --data data/zinc -o models/linear-zinc")
        await user.open("/compare?data=data/none")
        assert labelled(user, ui.select, "Measurements").value == "data/sct"
        assert labelled(user, ui.select, "Models").value == ["models/linear", "0.08"]
        await user.should_not_see("Train a linear model")

    look(project, test)


def test_from_a_cell_to_its_tests_to_a_curve(project: Project) -> None:
    frame = points_of(project.root / comparison_points("data/sct"))

    async def test(user: Any, worker: Any) -> None:
        await user.open("/compare")
        await until(lambda: "Over two loads" in shown(user))
        count = len(figures(user))
        labelled(user, ui.select, "Model that is looked at").set_value("0.08")
        labelled(user, ui.select, "Up").set_value("T")
        await until(
            lambda: any("T [degC]" in str(f["layout"].get("yaxis", {}).get("title")) for f in figures(user))
        )
        worst = max(cells(frame, "0.08", "v_rel", "T"), key=lambda c: c.apart)
        first, second = (between(bounds) for bounds in worst.bounds)
        user.find(f"v_rel [mm/s] {first}, T [degC] {second}").click()
        await until(lambda: f"{counted(len(worst.tests), 'test')}: " in shown(user))
        assert {b.text for b in user.find(ui.button).elements} >= set(worst.tests)
        user.find(worst.tests[0]).click()
        await until(lambda: len(figures(user)) == count + 1)
        curve = next(f for f in figures(user) if f["data"][0].get("name") == "measured")
        assert [trace["name"] for trace in curve["data"]] == ["measured", "0.06", "0.08"] or len(
            curve["data"]
        ) == 3
        # A cell of the map opens its tests, too, as plotly says it.
        plot = next(e for e in user.find(ui.plotly).elements if e.figure["data"][0].get("type") == "heatmap")
        # Its labels have room, also where it must be moved sideways.
        assert plot.style["min-width"] == f"{170 + 110 * len(plot.figure['data'][0]['text'][0])}px"
        (listener,) = [x for x in plot._event_listeners.values() if x.type == "plotly_click"]
        other = next(c for c in cells(frame, "0.08", "v_rel", "T") if c.place != worst.place)
        for points in ([{"x": other.place[0], "y": other.place[1]}], [{"x": "<b>"}], [], None, "x"):
            plot._handle_event({"listener_id": listener.id, "args": {"points": points}})
        await until(lambda: f"{counted(len(other.tests), 'test')}: " in shown(user))

    look(project, test)


def test_onnx_models_of_others_stand_beside_our_own(project: Project) -> None:
    (project.root / "models/theirs.onnx").write_bytes(b"as they are")

    async def test(user: Any, worker: Any) -> None:
        await user.open("/compare")
        await user.should_see("models/theirs.onnx")
        user.find("Compare 2 models").click()
        assert waiting(worker) == [compare("data/sct", ["models/theirs.onnx", "0.08"]).line]

    look(project, test)


@pytest.mark.parametrize("content", [b"no table", pd.DataFrame({"test_id": ["a"], "mu": [0.1]}), pd.DataFrame({"a": [1]})])  # fmt: skip
def test_a_table_of_others_is_a_sentence(project: Project, content: object) -> None:
    file = project.root / comparison_points("data/sct")
    if isinstance(content, bytes):
        file.write_bytes(content)
    else:
        content.to_parquet(file)  # type: ignore[attr-defined]

    async def test(user: Any, worker: Any) -> None:
        await user.open("/compare")
        # The rest of the page stays.
        await until(lambda: f"{file.name}: " in shown(user) and "Errors on tests" in shown(user))
        assert "This cannot be shown" not in shown(user)

    look(project, test)


@pytest.fixture(autouse=True)
def storage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is stored where the tests run."""
    monkeypatch.chdir(tmp_path)
