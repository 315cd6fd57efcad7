"""The page FMU: options of `pack`, and the page inside an FMU, which may be anybody's."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import zipfile
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("nicegui", reason="the extra [app] is not installed")

from fastapi import FastAPI
from nicegui import ui
from starlette.testclient import TestClient

from fmus import pack as pack_model
from friction_models import ConstantFriction
from orchestrator.app import commands
from orchestrator.app.fmu_facts import facts_of
from orchestrator.app.project import HISTORY, Project, history
from orchestrator.app.project.history import ACCEPTED, CHOSEN, ENDED, TAKEN_BACK
from orchestrator.app.serving import add_files, has_page, page_address
from orchestrator.cli.main import run

from .seen import labelled, look, shown, until, waiting


@pytest.fixture
def project(example: Project, monkeypatch: pytest.MonkeyPatch) -> Project:
    """The example with a trained model."""
    monkeypatch.chdir(example.root)
    assert run(["train", "linear", "--data", "data/sct", "-o", "models/linear"]) == 0
    return example


@pytest.mark.nightly
def test_the_options_of_pack_follow_the_fields(project: Project) -> None:
    lines = []
    wanted = "--fmi 3.0 --nodes 4 --interval -o fmus/linear-fmi3-4-interval.fmu"

    async def test(user: Any, worker: Any) -> None:
        await user.open("/fmu")
        labelled(user, ui.select, "FMI version").set_value("3.0")
        labelled(user, ui.number, "Contact points").set_value(4)
        interval, arrays = (
            next(c for c in user.find(ui.checkbox).elements if word in c.text)
            for word in ("mu_low", "arrays")
        )
        interval.set_value(True)
        await until(
            lambda: "--fmi 3.0 --nodes 4 --interval -o fmus/linear-fmi3-4-interval.fmu" in shown(user)
        )
        arrays.set_value(True)
        await until(lambda: "--interval --arrays -o" in shown(user))
        labelled(user, ui.select, "FMI version").set_value("2.0")
        await until(lambda: "Arrays of any length are part of FMI 3.0" in shown(user))
        arrays.set_value(False)
        platforms = labelled(user, ui.select, "Platforms")
        # The label is short enough to be read in its field; the rest stands below.
        assert platforms.props["label"] == "Platforms" and "this machine" in platforms.props["hint"]
        platforms.set_value(["x86_64-windows", "x86_64-linux"])
        await until(lambda: "--platforms x86_64-windows,x86_64-linux" in shown(user))
        labelled(user, ui.select, "Runs as").set_value("python")
        await until(lambda: "Platforms are chosen for C code only" in shown(user))
        labelled(user, ui.select, "Runs as").set_value("native")
        labelled(user, ui.select, "Platforms").set_value([])
        labelled(user, ui.select, "FMI version").set_value("3.0")
        await until(lambda: wanted in shown(user))
        labelled(user, ui.input, "Name inside").set_value("my friction")
        await until(lambda: "A name inside the FMU is one as in C" in shown(user))
        labelled(user, ui.input, "Name inside").set_value("press_4")
        await until(
            lambda: "--name press_4 --interval -o fmus/linear-fmi3-4-interval-press_4.fmu" in shown(user)
        )
        ssp = next(c for c in user.find(ui.checkbox).elements if "SSP" in c.text)
        ssp.set_value(True)
        await until(lambda: "--interval --ssp -o fmus/linear-fmi3-4-interval-press_4.ssp" in shown(user))
        user.find("Pack as FMU").click()
        ssp.set_value(False)
        labelled(user, ui.input, "Name inside").set_value("")
        await until(lambda: wanted in shown(user))
        user.find("Pack as FMU").click()
        lines.extend(waiting(worker))

    look(project, test)
    for line in lines:
        assert run(shlex.split(line)[1:]) == 0
    with zipfile.ZipFile(project.root / "fmus/linear-fmi3-4-interval-press_4.ssp") as system:
        (inner,) = [n for n in system.namelist() if n.endswith(".fmu")]
        with system.open(inner) as packed, zipfile.ZipFile(packed) as archive:
            assert 'modelIdentifier="press_4"' in archive.read("modelDescription.xml").decode()
    with zipfile.ZipFile(project.root / "fmus/linear-fmi3-4-interval.fmu") as archive:
        description = archive.read("modelDescription.xml").decode()
    assert 'fmiVersion="3.0"' in description and "mu_high" in description


def test_the_page_of_an_fmu_is_shown_without_scripts_and_bounded(example: Project) -> None:
    folder = example.root / "fmus"
    pack_model(ConstantFriction(0.1), folder / "own.fmu", target="python")
    (folder / "broken.fmu").write_bytes(b"PK no archive")
    with zipfile.ZipFile(folder / "bomb.fmu", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("documentation/index.html", b"0" * 20_000_000)
    with zipfile.ZipFile(folder / "none.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", "<x/>")
    assert [has_page(folder / f"{n}.fmu") for n in ("own", "broken", "bomb", "none", "missing")] == [True, *[False] * 4]  # fmt: skip
    app = FastAPI()
    add_files(app, example)
    client = TestClient(app)
    answer = client.get(page_address("fmus/own.fmu"))
    assert answer.status_code == 200 and "constant" in answer.text
    policy = answer.headers["content-security-policy"]
    assert "sandbox;" in policy and "script-src" not in policy and "default-src 'none'" in policy
    for path in (
        "fmus/broken.fmu",
        "fmus/bomb.fmu",
        "fmus/none.fmu",
        "fmus/missing.fmu",
        "project.yaml",
        "../own.fmu",
    ):
        assert client.get(page_address(path)).status_code == 404, path

    async def test(user: Any, worker: Any) -> None:
        await user.open("/fmu")
        await until(lambda: "bomb.fmu" in shown(user))
        links = [e for e in user.find(ui.link).elements if e.text == "Read its page"]
        assert [link.props["href"] for link in links] == ["/fmu-page/fmus/own.fmu"]

    look(example, test)


def test_a_card_says_what_an_fmu_is(project: Project) -> None:
    assert run(["pack", "models/linear", "-o", "fmus/linear.fmu"]) == 0
    assert run(["pack", "models/linear", "--fmi", "3.0", "--nodes", "4", "-o", "fmus/four.fmu"]) == 0
    assert run(["pack", "models/linear", "--nodes", "3", "--ssp", "-o", "fmus/three.ssp"]) == 0
    pack_model(ConstantFriction(0.1), project.root / "fmus/constant.fmu", target="python", nodes=3)
    facts = {name: dict(facts_of(project.root / f"fmus/{name}").rows) for name in ("linear.fmu", "four.fmu", "constant.fmu", "three.ssp")}  # fmt: skip
    one, four = facts["linear.fmu"], facts["four.fmu"]
    assert one["model"] == "friction linear" and one["FMI"] == "2.0, co-simulation and model exchange"
    assert four["FMI"].startswith("3.0") and "contact points" not in one
    assert (four["contact points"], facts["constant.fmu"]["contact points"]) == ("4", "3")
    assert one["inputs"] == four["inputs"] == "v_rel [mm/s], T [degC], sigma_n [MPa], sd [mm], psi [1]"
    assert one["outputs"].startswith("mu [1], domain_distance [1]") and facts["constant.fmu"]["outputs"].startswith("mu [1], ")  # fmt: skip
    assert re.fullmatch(r"compiled code for \w+; C sources", one["runs as"])
    assert facts["constant.fmu"]["runs as"] == "Python, which has to be installed"
    assert set(facts["three.ssp"]) == {"size", "written"}
    (project.root / "fmus/broken.fmu").write_bytes(b"PK no archive")
    assert "cannot be read" in facts_of(project.root / "fmus/broken.fmu").problem
    line = commands.fmus.check("fmus/linear.fmu").line

    async def test(user: Any, worker: Any) -> None:
        await user.open("/fmu")
        await until(lambda: shown(user).count("not yet") == 4 and "cannot be read" in shown(user))
        assert "v_rel [mm/s], T [degC]" in shown(user) and "friction linear" in shown(user)
        assert str(project.root) not in shown(user)
        history.add(project.root / HISTORY, ENDED, job=1, code=0, command=line)
        history.add(project.root / HISTORY, ENDED, job=2, code=130, command=line)
        await user.open("/fmu")
        await until(lambda: "passed, 20" in shown(user) and "is newer" not in shown(user))
        # A file that comes in the place of another one was not checked.
        os.utime(project.root / "fmus/linear.fmu", (4e9, 4e9))
        await user.open("/fmu")
        await until(lambda: "the file is newer than that" in shown(user))

    look(project, test)


def test_what_was_taken_back_is_not_offered_as_the_model_in_hand(project: Project) -> None:
    file, better = project.root / HISTORY, "models/linear-stribeck"
    shutil.copytree(project.root / "models/linear", project.root / better)
    history.add(file, CHOSEN, data="data/sct", model="linear")
    history.add(file, ENDED, job=1, code=0, **commands.models.refine("data/sct", "linear", ["stribeck"]).more)

    async def test(user: Any, worker: Any) -> None:
        await user.open("/fmu")
        field = labelled(user, ui.select, "Model")
        assert field.value == "models/linear" and field.options[better] == "linear-stribeck (not accepted)"
        history.add(file, ACCEPTED, model=better)
        await until(lambda: labelled(user, ui.select, "Model").value == better)
        assert labelled(user, ui.select, "Model").options[better] == "linear-stribeck"
        labelled(user, ui.select, "Model").set_value(better)
        history.add(file, TAKEN_BACK, model=better)
        await until(lambda: labelled(user, ui.select, "Model").value == "models/linear")
        field = labelled(user, ui.select, "Model")
        assert field.options[better] == "linear-stribeck (taken back)"
        # It can be packed all the same by whoever chooses it, and then the page says what it is.
        field.set_value(better)
        await until(lambda: "linear-stribeck is taken back: it is not the model in hand." in shown(user))
        assert "tribofmu pack models/linear-stribeck" in shown(user)

    look(project, test)


@pytest.fixture(autouse=True)
def storage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is stored where the tests run."""
    monkeypatch.chdir(tmp_path)
