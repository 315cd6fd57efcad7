"""What the FMUs have to say of a run, and loads that a friction model was not trained on: manifest, terminal, report."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from fmus import pack, pack_forming
from fmus.runtime.messages import WARNS
from friction_models import LinearFriction
from orchestrator import Master, System
from orchestrator.cli.app import app
from orchestrator.cosim.run_folders import MOST_WARNINGS, Course, Run
from orchestrator.report.pages.run import run_page

N = 12
#: The flow curve of 16MnCr5 ends at 500 degC.
HOT = "forming: material '16MnCr5': temperature reached "


@pytest.fixture(scope="module")
def friction(tmp_path_factory: pytest.TempPathFactory) -> Path:
    rng = np.random.default_rng(3)
    rows = pd.DataFrame(
        {
            "test_id": np.repeat(["a", "b", "c", "d"], 10),
            "v_rel": rng.uniform(1.0, 50.0, 40),
            "T": rng.uniform(20.0, 100.0, 40),
            "sigma_n": rng.uniform(200.0, 900.0, 40),
            "sd": rng.uniform(0.1, 5.0, 40),
            "psi": rng.uniform(1.0, 1.5, 40),
        }
    )
    model = LinearFriction().fit_frame(rows.assign(mu=0.08 - 1e-5 * rows["T"]))
    return pack(model, tmp_path_factory.mktemp("friction") / "friction.fmu", nodes=N)


def system(friction: Path, forming: Path, T_billet: float) -> System:
    loads = [f"forming.{name} -> friction.{name}" for name in ("v_rel", "T", "sigma_n", "sd", "psi")]
    return System.from_dict(
        {
            "communication_step": 0.002,
            "stop_time": 0.01,
            "components": {
                "friction": {"fmu": str(friction)},
                "forming": {"fmu": str(forming), "start": {"T_billet": T_billet, "T_tool": T_billet}},
            },
            "connections": ["friction.mu -> forming.mu", *loads],
        }
    )


@pytest.mark.nightly
@pytest.mark.parametrize(("target", "isolate"), [("python", True), ("process", False)])
def test_a_run_ends_with_what_the_solver_has_to_say(
    friction: Path, tmp_path: Path, target: str, isolate: bool
) -> None:
    options = {"n_points": N, "mesh_size": 0.9, "speed": 100.0}
    forming = pack_forming(tmp_path / "forming.fmu", target=target, **options)
    run = Master(system(friction, forming, 495.0), isolate=isolate).run(tmp_path / "hot")
    hot, outside = (t for t in run.manifest["warnings"] if " points touch " not in t)
    assert hot.startswith(HOT) and hot.endswith("the flow curve is known for 0 to 500 degC")
    reached = float(hot.removeprefix(HOT).split()[0])
    assert reached >= run["forming.T"].max() - 1.0  # the end of the run, not the first step that was too hot
    assert outside.startswith("friction: 100 % of the loads in contact lie outside")
    # trained up to 100 degC in a range of 80 K; friction gets the loads of the step before
    farthest = float(outside.partition("farthest by ")[2].split()[0])
    assert farthest == pytest.approx((run["forming.T"][:-1].max() - 100.0) / 80.0, rel=0.1)
    page = run_page(run.folder)
    assert "Read this with care" in page and "temperature reached" in page and "lie outside" in page
    cold = Master(system(friction, forming, 20.0), isolate=isolate).run(tmp_path / "cold")
    assert not any("degC" in text for text in cold.manifest["warnings"])


def test_the_terminal_says_so_too(friction: Path, tmp_path: Path) -> None:
    forming = pack_forming(tmp_path / "forming.fmu", n_points=N, mesh_size=0.9, speed=100.0)
    file = tmp_path / "hot.yaml"
    file.write_text(system(friction, forming, 495.0).to_yaml(relative_to=tmp_path))
    done = CliRunner().invoke(app, ["simulate", str(file), "-o", str(tmp_path / "run")])
    said = " ".join(done.output.split())
    assert (
        done.exit_code == 0 and f"note: {HOT}" in said and "lie outside what the model was trained on" in said
    )


def test_loads_within_the_domain_and_points_without_contact_need_no_word() -> None:
    distance, pressure = np.zeros((3, 2)), np.array([[0.0, 0.0], [100.0, 0.0], [100.0, 0.0]])
    distance[:, 1] = 5.0
    values = {"friction.domain_distance": distance, "forming.sigma_n": pressure}
    assert Run(Path("run"), {}, np.arange(3.0), values, {}).outside_domain() == []
    distance[2, 0] = 0.3
    (said,) = Run(Path("run"), {}, np.arange(3.0), values, {}).outside_domain()
    assert said.startswith("friction: 50 % of the loads in contact") and "by 0.3 times" in said


def test_an_fmu_that_warns_again_and_again_fills_no_manifest() -> None:
    course = Course("jacobi", 1e-4, (), [])
    course.log += [f"a: {WARNS}step {k}" for k in range(40)] * 2 + ["a: no warning"]
    said = course.remarks()
    assert said[:2] == ["a: step 0", "a: step 1"]
    assert said[MOST_WARNINGS:] == [f"{40 - MOST_WARNINGS} further warnings of FMUs in log.txt"]
