"""The master against recursions written down by hand."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

import h5py
import numpy as np
import pytest

from friction_models.common import InputError
from orchestrator import Master, Run, SimulationError, System
from orchestrator.cosim.batch import RunTask, run_all
from tests.orchestrator.tiny_fmus import system_content

H, OFFSET, SLOPE = 0.1, 0.1, 0.5


def recursion(mode: str, steps: int = 10, offset: float = OFFSET, slope: float = SLOPE) -> np.ndarray:
    """Loads of the two points at every communication point."""
    gain = np.array([1.0, 2.0]) * H
    loads = [np.ones(2)]
    mu = offset + slope * np.ones(2)
    for _ in range(steps):
        if mode == "gauss_seidel":
            mu = offset + slope * loads[-1]
            loads.append(loads[-1] + gain * mu)
        elif mode == "jacobi":
            loads.append(loads[-1] + gain * mu)
            mu = offset + slope * loads[-2]
        else:
            loads.append((loads[-1] + gain * offset) / (1.0 - gain * slope))
    return np.array(loads)


@pytest.mark.parametrize("mode", ["gauss_seidel", "jacobi", "iterated"])
def test_modes_follow_their_recursion(tiny: dict[str, Path], tmp_path: Path, mode: str) -> None:
    system = System.from_dict(system_content(tiny["law"], tiny["process"]))
    run = Master(system, mode=mode).run(tmp_path / "run")
    tolerance = 1e-7 if mode == "iterated" else 1e-14
    np.testing.assert_allclose(run["forming.load"], recursion(mode), rtol=tolerance)
    np.testing.assert_allclose(run["forming.force"], recursion(mode).sum(axis=1), rtol=tolerance)
    np.testing.assert_allclose(run.time, np.arange(11) * H, atol=1e-15)


def test_swapping_the_friction_fmu_changes_only_the_friction(tiny: dict[str, Path], tmp_path: Path) -> None:
    system = System.from_dict(system_content(tiny["law"], tiny["process"]))
    other = system.swap("friction", tiny["other_law"])
    run = Master(other).run(tmp_path / "other")
    np.testing.assert_allclose(run["forming.load"], recursion("gauss_seidel", slope=0.2), rtol=1e-14)
    assert system.components["friction"].fmu == tiny["law"]
    assert other.components["forming"] == system.components["forming"]


def test_two_friction_fmus_in_one_process_give_their_own_values(
    tiny: dict[str, Path], tmp_path: Path
) -> None:
    system = System.from_dict(system_content(tiny["law"], tiny["process"]))
    first = Master(system).run(tmp_path / "a")
    second = Master(system.swap("friction", tiny["other_law"])).run(tmp_path / "b")
    again = Master(system).run(tmp_path / "c")
    assert not np.allclose(first["forming.load"][1:], second["forming.load"][1:])
    np.testing.assert_array_equal(first["forming.load"], again["forming.load"])


def test_run_folder_is_complete_and_can_be_loaded(tiny: dict[str, Path], tmp_path: Path) -> None:
    content = system_content(tiny["law"], tiny["process"], synthetic=True, provenance={"campaign_seed": 3})
    shares: list[float] = []
    run = Master(System.from_dict(content)).run(tmp_path / "run", progress=shares.append, csv=True)
    loaded = Run.load(tmp_path / "run")
    assert loaded.values.keys() == run.values.keys()
    for name, values in run.values.items():
        np.testing.assert_array_equal(loaded[name], values)
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    assert manifest["synthetic"] is True and loaded.synthetic
    assert manifest["seeds"] == {"campaign_seed": 3}
    assert len(manifest["components"]["friction"]["sha256"]) == 64
    assert shares[0] == 0.0 and shares[-1] == 1.0 and shares == sorted(shares)
    assert set(loaded["forming.high"]) == {0.0, 1.0}
    frame = loaded.to_frame()
    assert {"time", "forming.load[1]", "forming.load[2]", "forming.force"} <= set(frame.columns)
    assert (tmp_path / "run" / "results.csv").is_file()
    # the resolved system runs again from its own folder
    rerun = Master(System.load(tmp_path / "run" / "system.yaml")).run(tmp_path / "rerun")
    np.testing.assert_array_equal(rerun["forming.load"], run["forming.load"])


def test_a_failing_component_is_named_and_the_steps_until_then_are_kept(
    tiny: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A folder of its own: other tests run at the same time.
    scratch, runs = tmp_path / "scratch", tmp_path / "runs"
    scratch.mkdir()
    runs.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(scratch))
    system = System.from_dict(system_content(tiny["fragile_law"], tiny["process"]))
    with pytest.raises(
        SimulationError, match=r"component 'friction' failed at t = 0\.\d.*; kept in .*run: \d steps"
    ):
        Master(system).run(runs / "run")
    assert list(scratch.iterdir()) == []
    with pytest.raises(
        InputError, match=r"the run stopped \(component 'friction' failed at t = .*allowed: a complete"
    ):
        Run.load(runs / "run")
    kept = Run.load(runs / "run", stopped=True)
    whole = Master(System.from_dict(system_content(tiny["law"], tiny["process"]))).run(runs / "whole")
    n = len(kept.time)
    assert 2 <= n < len(whole.time) and kept.manifest["steps"] == n - 1 and not kept.complete
    assert np.array_equal(kept["forming.load"], whole["forming.load"][:n])
    assert f"failed at t = {kept.time[-1]:g} s" in kept.message
    assert "stopped: component 'friction'" in (runs / "run" / "log.txt").read_text()


def test_a_run_that_stopped_is_not_taken_for_the_same_run(tiny: dict[str, Path], tmp_path: Path) -> None:
    task = RunTask(System.from_dict(system_content(tiny["law"], tiny["process"])), tmp_path / "run")
    run_all([task], jobs=1)
    before = (tmp_path / "run" / "manifest.json").stat().st_mtime_ns
    run_all([task], jobs=1)
    assert (tmp_path / "run" / "manifest.json").stat().st_mtime_ns == before
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    (tmp_path / "run" / "manifest.json").write_text(
        json.dumps(manifest | {"status": "stopped", "message": "x"})
    )
    (again,) = run_all([task], jobs=1)
    assert again.complete


@pytest.mark.parametrize("damage", ["cut", "changed"])
def test_a_run_whose_results_are_not_as_it_left_them_is_run_again(
    tiny: dict[str, Path], tmp_path: Path, damage: str
) -> None:
    task = RunTask(System.from_dict(system_content(tiny["law"], tiny["process"])), tmp_path / "run")
    (first,) = run_all([task], jobs=1)
    results = tmp_path / "run" / "results.nc"
    if damage == "cut":
        results.write_bytes(results.read_bytes()[:2000])
    else:
        with h5py.File(results, "r+") as file:
            file["friction.mu"][...] *= 2.0
    (again,) = run_all([task], jobs=1)
    np.testing.assert_array_equal(again["friction.mu"], first["friction.mu"])


def test_unknown_mode_and_result(tiny: dict[str, Path], tmp_path: Path) -> None:
    system = System.from_dict(system_content(tiny["law"], tiny["process"]))
    with pytest.raises(InputError, match="did you mean 'jacobi'"):
        Master(system, mode="jacoby")
    run = Master(system).run(tmp_path / "run")
    with pytest.raises(InputError, match=r"did you mean 'forming\.force'"):
        run["forming.forse"]
    with pytest.raises(InputError, match="not a run folder"):
        Run.load(tmp_path)
