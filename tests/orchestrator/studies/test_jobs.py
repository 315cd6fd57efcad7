"""Runs in a pool: the same results as one by one, and nothing is computed twice."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from orchestrator import Master, Run, SimulationError, System
from orchestrator.cosim.batch import RunTask, run_all
from orchestrator.jobs.keys import deciding_code
from tests.orchestrator.tiny_fmus import system_content


@pytest.mark.parametrize("jobs", [1, pytest.param(2, marks=pytest.mark.nightly)])
def test_a_pool_gives_the_same_runs_and_keeps_them(tiny: dict[str, Path], tmp_path: Path, jobs: int) -> None:
    system = System.from_dict(system_content(tiny["law"], tiny["process"]))
    other = system.swap("friction", tiny["other_law"])
    tasks = [RunTask(system, tmp_path / "a"), RunTask(other, tmp_path / "b")]
    runs = run_all(tasks, jobs=jobs)
    alone = Master(other).run(tmp_path / "alone")
    np.testing.assert_array_equal(runs[1]["forming.load"], alone["forming.load"])

    before = {name: (tmp_path / name / "results.nc").stat().st_mtime_ns for name in ("a", "b")}
    ticks: list[tuple[int, int, str]] = []
    run_all(tasks, jobs=1, progress=lambda *tick: ticks.append(tick))
    assert ticks == [(2, 2, "")]
    assert {n: (tmp_path / n / "results.nc").stat().st_mtime_ns for n in before} == before

    changed = system.model_copy(deep=True)
    changed.components["friction"].start["offset"] = 0.2
    run_all([RunTask(changed, tmp_path / "a"), RunTask(other, tmp_path / "b", "jacobi")], jobs=1)
    after = {name: (tmp_path / name / "results.nc").stat().st_mtime_ns for name in ("a", "b")}
    assert all(after[name] > before[name] for name in before)


def test_a_run_of_an_older_state_of_the_sources_is_computed_again(
    tiny: dict[str, Path], tmp_path: Path
) -> None:
    """An FMU of a process runs the solver that is installed: its own hash says nothing about that."""
    task = RunTask(System.from_dict(system_content(tiny["law"], tiny["process"])), tmp_path / "a")
    run_all([task], jobs=1)
    manifest = task.folder / "manifest.json"
    now = json.loads(manifest.read_text(encoding="utf-8"))
    assert {"forming", "sct_twin"} <= set(deciding_code("orchestrator.cosim"))
    for other in ({**now, "code": "0" * 64}, {k: v for k, v in now.items() if k != "code"}):
        manifest.write_text(json.dumps(other), encoding="utf-8")
        before = (task.folder / "results.nc").stat().st_mtime_ns
        run_all([task], jobs=1)
        assert (task.folder / "results.nc").stat().st_mtime_ns > before
        assert json.loads(manifest.read_text(encoding="utf-8"))["code"] == now["code"]


def test_a_failing_run_is_heard_and_finished_ones_stay(tiny: dict[str, Path], tmp_path: Path) -> None:
    system = System.from_dict(system_content(tiny["law"], tiny["process"]))
    fragile = system.swap("friction", tiny["fragile_law"])
    with pytest.raises(SimulationError, match="component 'friction' failed"):
        run_all([RunTask(system, tmp_path / "a"), RunTask(fragile, tmp_path / "b")], jobs=1)
    assert (tmp_path / "a" / "manifest.json").is_file()
    assert not Run.load(tmp_path / "b", stopped=True).complete


def test_kept_runs_that_were_damaged_or_exchanged_are_computed_again(
    tiny: dict[str, Path], tmp_path: Path
) -> None:
    system = System.from_dict(system_content(tiny["law"], tiny["process"]))
    tasks = []
    for name, offset in (("a", 0.1), ("b", 0.2)):
        changed = system.model_copy(deep=True)
        changed.components["friction"].start["offset"] = offset
        tasks.append(RunTask(changed, tmp_path / name, key=f"run {name}"))
    first = [run["forming.load"].copy() for run in run_all(tasks, jobs=1)]
    assert not np.array_equal(*first)
    results, other = (task.folder / "results.nc" for task in tasks)
    whole = results.read_bytes()
    # A sound file of the same layout with other numbers; one that is cut; one that is gone; the folder of the other.
    for damage in (
        lambda: results.write_bytes(other.read_bytes()),
        lambda: results.write_bytes(whole[:200]),
        lambda: results.unlink(),
        lambda: shutil.copytree(tasks[1].folder, tasks[0].folder, dirs_exist_ok=True),
    ):
        damage()
        again = [run["forming.load"] for run in run_all(tasks, jobs=1)]
        np.testing.assert_array_equal(again, first)
    before = results.stat().st_mtime_ns
    run_all(tasks, jobs=1)
    assert results.stat().st_mtime_ns == before
