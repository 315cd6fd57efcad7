"""`compare --process`: a process of ours with several friction models, against the solver alone and a closed form."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from forming import Upsetting
from orchestrator import Run
from orchestrator.cli.main import run
from orchestrator.report.reading import read_page

#: Parameters of a run that takes half a second.
COARSE = {"height": 10.0, "mesh_size": 1.0, "n_points": 12}
STROKE = 1.0
SETTINGS = [part for name, value in COARSE.items() for part in ("--set", f"{name}={value:g}")]


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two constants at one level, laid over a press curve of two repeats, with errors of the loads."""
    folder = tmp_path_factory.mktemp("formed")
    rows = [f"{s},{100 + 30 * s + r},{r}" for r in (1, 2) for s in np.linspace(0, 1, 21)]
    (folder / "level.csv").write_text("\n".join(["stroke [mm],force [kN],repeat", *rows]))
    command = ["compare", "--process", "upsetting", *SETTINGS, "--level", "speed=20,T_tool=50", "--stroke", f"{STROKE:g}"]  # fmt: skip
    command += ["--models", "0.02", "0.12", "--press", str(folder / "level.csv"), "--local-errors"]
    command += ["--runs", str(folder / "runs"), "--report", str(folder / "page.html")]
    assert run([*command, "--json", str(folder / "answer.json"), "-j", "1"]) == 0
    return folder


def test_the_runs_are_those_of_the_solver_alone(place: Path) -> None:
    (level,) = json.loads((place / "answer.json").read_text())["levels"]
    assert level["level"] == "upsetting-speed-20-T_tool-50"
    forces = []
    for found, mu in zip(level["models"], (0.02, 0.12), strict=True):
        alone = Upsetting(speed=20.0, T_tool=50.0, **COARSE).run(mu, STROKE)
        assert found["force_kN"][-1] == pytest.approx(alone.force[-1], rel=2e-3)
        assert {e["load"] for e in found["stated_errors"]} == {"v_rel", "T", "sigma_n", "sd", "psi"}
        forces.append(found["force_kN"][-1])
        # The press is linear in the stroke: its mean and scatter are known.
        press = found["press"]["max_force_kN"]
        assert press["measured_std"] == pytest.approx(np.sqrt(0.5)) and press["measured"] == pytest.approx(
            131.5
        )
    # Siebel: mean pressure k_f (1 + 2 mu r / (3 h)), with r grown at constant volume.
    h, r = COARSE["height"] - STROKE, 7.5 * np.sqrt(COARSE["height"] / (COARSE["height"] - STROKE))
    expected = (1.0 + 2 * 0.12 * r / (3 * h)) / (1.0 + 2 * 0.02 * r / (3 * h))
    assert forces[1] / forces[0] == pytest.approx(expected, abs=0.02)


def test_the_slider_shows_the_loads_of_the_runs_along_the_surface(place: Path) -> None:
    contact = read_page(place / "page.html").section("run-contact")
    figure = contact.figure() if contact is not None else None
    assert figure is not None
    (slider,) = figure.layout["sliders"]
    folders = json.loads((place / "runs/upsetting-speed-20-T_tool-50/runs.json").read_text())
    kept = Run.load(place / "runs/upsetting-speed-20-T_tool-50" / folders["0.12"])
    step = slider["steps"][-1]
    assert float(step["label"]) == pytest.approx(STROKE)
    at = [t["name"] for t in figure.data].index("0.12")  # of mu, the first panel
    (restyled,) = step["args"]
    mu = np.array(restyled["y"][at], dtype=float)
    touching = kept["forming.active"][-1] > 0.5
    assert np.isfinite(mu).tolist() == touching.tolist() and 0 < touching.sum() < len(mu)
    assert mu[touching] == pytest.approx(0.12)
    # Both faces and the side of the cylinder as it is now: twice its radius and its height.
    place_of = np.array(restyled["x"][at])
    radius = kept["forming.r"][-1]
    outline = 2 * float(radius[touching].max()) + COARSE["height"] - STROKE
    assert np.all(np.diff(place_of) > 0) and place_of[-1] == pytest.approx(outline, rel=0.05)
    text = re.sub(r"<[^>]+>", " ", (place / "page.html").read_text().rpartition("<main")[2])
    assert "How far the loads at the contact points may be off" in text and "against the press" in text


@pytest.mark.nightly
def test_several_levels_are_sections_of_one_page(place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:  # fmt: skip
    command = [
        "compare",
        "--process",
        "upsetting",
        *SETTINGS,
        "--stroke",
        "0.2",
        "--models",
        "0.1",
        "-j",
        "1",
    ]
    command += ["--level", "speed=5", "--level", "speed=500", "--report", str(tmp_path / "page.html")]
    assert run([*command, "--json", str(tmp_path / "a.json")]) == 0
    slow, fast = json.loads((tmp_path / "a.json").read_text())["levels"]
    # Hensel-Spittel: the flow stress rises with the rate to the power m3.
    ratio = fast["models"][0]["force_kN"][-1] / slow["models"][0]["force_kN"][-1]
    assert ratio == pytest.approx(100**0.0253737, rel=0.02)
    anchors = [s.anchor for s in read_page(tmp_path / "page.html").sections]
    assert {"run-forces-1", "run-contact-1", "run-forces-2", "run-contact-2"} <= set(anchors)
    assert read_page(tmp_path / "page.html").title.startswith("2 levels: largest force")


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--process", "frr"], "did you mean 'fre'"),
        (["--process", "fre", "--set", "half_angel=30"], "half_angle"),
        (["--process", "fre", "--set", "half_angle=85"], "10 to 80 degrees"),
        (["--process", "fre", "--level", "half_angle=30"], "allowed: speed, T_tool, T_billet"),
        (["--process", "fre", "--level", "speed=5", "--level", "speed=5"], "given twice"),
        (["--process", "fre", "--level", "speed=fast"], "speed = 'fast'"),
        (["--process", "fre", "--stroke", "80"], "stroke = 80"),
        (["--set", "half_angle=30"], "--process"),
        (["--local-errors", "--data", "x.csv"], "--local-errors"),
        (["--process", "fre", "--system", "x.yaml", "--runs", "r"], "--system and --process"),
    ],
)
def test_what_cannot_be_is_a_sentence(more: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["compare", "--models", "0.1", *more]) == 2
    assert said in capsys.readouterr().err
