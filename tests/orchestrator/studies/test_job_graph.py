"""Graphs of jobs: kept results, failures, killed processes, and the same numbers wherever the jobs run."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fmus.runtime.errors import SimulationError
from friction_models.common import InputError
from friction_models.common.cached_results import code_digest, path_digest
from orchestrator.jobs.executors import Cluster
from orchestrator.jobs.graph import Job, JobGraph, JobResult
from orchestrator.jobs.keys import deciding_code

HERE = "tests.orchestrator.graph_jobs"
#: Tiny jobs: only their own module counts as source.
CODE: tuple[str, ...] = ()


def numbers(
    name: str, seed: int, needs: tuple[str, ...] = (), files: dict[str, Path] | None = None, **more: Any
) -> Job:
    return Job(name, f"{HERE}:numbers", {"seed": seed, **more}, files or {}, needs)


def chain(log: Path, pause: float = 0.0) -> list[Job]:
    """Six jobs, of which the last needs two."""
    first = [numbers(f"n{k}", k, log=str(log), pause=pause) for k in range(5)]
    return [*first, numbers("sum", 9, ("n0", "n4"), log=str(log))]


def totals(results: dict[str, JobResult]) -> dict[str, float]:
    return {name: result.values["total"] for name, result in results.items()}


def calls(log: Path) -> list[int]:
    return sorted(int(line) for line in log.read_text().split()) if log.is_file() else []


def test_results_are_kept_and_only_what_changed_is_computed(tmp_path: Path) -> None:
    log, data = tmp_path / "log", tmp_path / "data.txt"
    data.write_text("1.0")

    def campaign(seed: int, code: tuple[str, ...] = CODE) -> JobGraph:
        jobs = [
            numbers("last", 3, ("first", "other"), log=str(log)),
            numbers("first", seed, (), {"data": data}, log=str(log)),
            numbers("other", 2, log=str(log)),
        ]
        return JobGraph(tmp_path / "study", jobs, code)

    before = campaign(1)
    assert (before.dry_run().kept, before.dry_run().to_do) == (0, 3)
    ticks: list[tuple[int, int, str]] = []
    results = before.run(jobs=1, progress=lambda *tick: ticks.append(tick))
    assert list(results) == ["last", "first", "other"]
    assert calls(log) == [1, 2, 3]
    assert [tick[0] for tick in ticks] == [0, 1, 2, 3]
    assert "left" in ticks[0][2]
    first = totals(results)
    assert first["last"] == pytest.approx(
        np.load(results["last"].folder / "drawn.npy").sum() + first["first"] + first["other"]
    )

    assert totals(campaign(1).run(jobs=1)) == first
    assert calls(log) == [1, 2, 3]  # nothing was done again
    assert totals(campaign(7).run(jobs=1))["other"] == first["other"]
    assert calls(log) == [1, 2, 3, 3, 7]  # another input, and what needs it
    elsewhere = data.rename(tmp_path / "moved.txt")
    data.symlink_to(elsewhere)
    assert campaign(7).dry_run().to_do == 0  # the content counts, not the place
    elsewhere.write_text("2.0")
    assert campaign(7).dry_run().to_do == 2
    assert campaign(7, ("orchestrator.force_curves.metrics",)).dry_run().to_do == 3  # other sources

    damaged = results["other"].folder / "result.json"
    damaged.write_text("{", encoding="utf-8")
    assert totals(campaign(1).run(jobs=1))["other"] == first["other"]

    second = totals(campaign(1).run(jobs=1))
    for spoil in (
        lambda file: file.write_bytes(file.read_bytes()[:60]),
        lambda file: file.write_bytes(bytes(file.stat().st_size)),  # as long as it was, and empty
        lambda file: file.unlink(),
    ):
        drawn = results["other"].folder / "drawn.npy"
        whole = drawn.read_bytes()
        spoil(drawn)
        assert campaign(1).dry_run().to_do == 1
        assert totals(campaign(1).run(jobs=1)) == second
        assert drawn.read_bytes() == whole
    # A list of files that leads out of the folder makes no result.
    content = json.loads(damaged.read_text(encoding="utf-8"))
    del content["sha256"]  # as of a version before
    content["files"] = {"../../../data.txt": [3, path_digest(data)]}
    damaged.write_text(json.dumps(content), encoding="utf-8")
    assert campaign(1).dry_run().to_do == 1


def test_the_sources_in_a_key_follow_from_the_imports(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    modules = {
        "__init__": "",
        "runs.__init__": "",
        "runs.form": "def form():\n    from ..solver.deep.mesh import size\n    return size\n",
        "solver.__init__": "from . import beside\n",
        "solver.beside": "from ..units import MM\n",
        "solver.deep.__init__": "",
        "solver.deep.mesh": "size = 1\n",
        "units.__init__": "MM = 1\n",
        "pages.__init__": "import workshop.runs.form\n",
    }
    for name, text in modules.items():
        file = tmp_path / "workshop" / f"{name.replace('.', '/')}.py"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))

    def key() -> str:
        code = deciding_code("workshop.runs.form", "workshop")
        assert code[4:] == ("workshop.runs", "workshop.solver", "workshop.units")
        return code_digest(code)

    keys = [key()]
    for name in ("runs.form", "solver.beside", "solver.deep.mesh", "units.__init__"):
        file = tmp_path / "workshop" / f"{name.replace('.', '/')}.py"
        file.write_text(file.read_text(encoding="utf-8") + "# changed\n", encoding="utf-8")
        keys.append(key())
    assert len(set(keys)) == len(keys)
    (tmp_path / "workshop" / "pages" / "colours.py").write_text("RED = 1\n", encoding="utf-8")
    assert key() == keys[-1]  # nothing that decides


def test_a_forming_run_depends_on_the_co_simulation_and_on_no_page() -> None:
    code = deciding_code("orchestrator.comparison.level_runs")
    assert {
        "friction_models",
        "forming",
        "sct_twin",
        "fmus",
        "orchestrator.cosim",
        "orchestrator.jobs",
    } < set(code)
    assert not {"orchestrator.report", "orchestrator.cli", "orchestrator.demo"} & set(code)
    assert deciding_code("elsewhere.jobs") == ("elsewhere.jobs",)


def test_a_failed_job_is_reported_and_stops_only_what_needs_it(tmp_path: Path) -> None:
    jobs = [
        Job("bad", f"{HERE}:refused", {"how": "input"}),
        Job("nan", f"{HERE}:refused", {"how": "nan"}),
        Job("crash", f"{HERE}:refused", {"how": "crash", "zero": 0}),
        Job("lost", f"{HERE}:no_such_function"),
        numbers("needs bad", 1, ("bad",)),
        numbers("fine", 2),
    ]
    campaign = JobGraph(tmp_path, jobs, CODE)
    assert list(campaign.run(jobs=1)) == ["fine"]
    with pytest.raises(
        SimulationError, match=r"4 of 6 jobs failed, 1 that need them were not run: bad: speed = -1"
    ):
        campaign.check()
    failed = {entry["name"]: entry for entry in json.loads((tmp_path / "failed.json").read_text())}
    assert failed["bad"]["inputs"] == {"how": "input"}
    assert "ZeroDivisionError" in failed["crash"]["error"]
    assert "graph_jobs.py" in failed["crash"]["traceback"]
    assert "no such function" in failed["lost"]["error"]
    assert "not run, because bad failed" in failed["needs bad"]["error"]
    again = JobGraph(tmp_path, jobs[-1:], CODE)
    again.run(jobs=1)
    again.check()
    assert not (tmp_path / "failed.json").exists()


def test_workers_that_are_killed(tmp_path: Path) -> None:
    """One that dies once is replaced, one that always dies fails alone; a pool gives the numbers of one process."""
    log = tmp_path / "log"
    for name in ("once", "always"):
        (tmp_path / name).mkdir()
    jobs = [
        Job("once", f"{HERE}:killed", {"marks": str(tmp_path / "once"), "times": 1}),
        Job("always", f"{HERE}:killed", {"marks": str(tmp_path / "always"), "times": 9}),
        *chain(log),
    ]
    campaign = JobGraph(tmp_path / "pool", jobs, CODE)
    results = campaign.run(jobs=2)
    assert list(campaign.failed) == ["always"]
    assert "killed 2 times" in campaign.failed["always"].error
    assert results["once"].values == {"total": 1.0}
    assert calls(log) == [0, 1, 2, 3, 4, 9]
    alone = JobGraph(tmp_path / "alone", chain(log), CODE)
    expected = alone.run(jobs=1)
    assert totals(expected) == {n: v for n, v in totals(results).items() if n != "once"}
    same = JobGraph(tmp_path / "pool", chain(log), CODE)
    assert same.manifest(same.run(jobs=1)) == alone.manifest(expected)  # measured times are no part of it


_MAIN = """
import sys
from pathlib import Path
from orchestrator.jobs.graph import JobGraph
from tests.orchestrator.studies.test_job_graph import CODE, chain

place = Path(sys.argv[1])
JobGraph(place / "study", chain(place / "log", pause=0.3), CODE).run(jobs=2)
"""


def test_a_killed_study_goes_on(tmp_path: Path) -> None:
    log = tmp_path / "log"
    main = subprocess.Popen([sys.executable, "-c", _MAIN, str(tmp_path)])
    jobs = tmp_path / "study" / "jobs"
    deadline = time.monotonic() + 60
    while not list(jobs.glob("*/result.json")):  # in the middle: one is done, two are in hand
        assert main.poll() is None and time.monotonic() < deadline
        time.sleep(0.01)
    with pytest.raises(InputError, match="another run of this study"):
        JobGraph(tmp_path / "study", chain(log), CODE).run(jobs=1)
    workers = _children(main.pid)
    os.kill(main.pid, signal.SIGKILL)
    main.wait()
    while any(_alive(pid) for pid in workers):  # they end with it
        assert time.monotonic() < deadline
        time.sleep(0.01)

    kept = JobGraph(tmp_path / "study", chain(log, pause=0.3), CODE)
    done = kept.dry_run().kept
    assert 1 <= done < 6
    before = len(calls(log))
    results = kept.run(jobs=1)
    assert len(calls(log)) - before == 6 - done
    assert before - done <= 2  # lost: what was in hand
    fresh = JobGraph(tmp_path / "fresh", chain(log), CODE)
    assert totals(fresh.run(jobs=1)) == totals(results)
    assert not list(jobs.glob(".work-*"))


def _children(pid: int) -> list[int]:
    found = Path(f"/proc/{pid}/task/{pid}/children")
    if not found.is_file():
        pytest.skip("children of a process are read from /proc")
    return [int(child) for child in found.read_text().split()]


def _alive(pid: int) -> bool:
    stat = Path(f"/proc/{pid}/stat")
    try:
        return stat.read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_a_cluster_gives_the_same_numbers(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed", reason="extra [cluster] is not installed")
    expected = JobGraph(tmp_path / "here", chain(tmp_path / "log"), CODE)
    one = expected.manifest(expected.run(jobs=1))
    # Two workers that live in this process: quick, and everything still goes through the scheduler.
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": False, "protocol": "tcp"}
    with distributed.LocalCluster(**options, dashboard_address=None) as cluster:
        jobs = [*chain(tmp_path / "log"), Job("bad", f"{HERE}:refused", {"how": "input"})]
        campaign = JobGraph(tmp_path / "cluster", jobs, CODE)
        results = campaign.run(scheduler=cluster.scheduler_address)
        assert list(campaign.failed) == ["bad"]
        assert "speed = -1" in campaign.failed["bad"].error
    assert campaign.manifest(results)["jobs"] == one["jobs"]


def test_a_cluster_is_waited_for_and_may_grow(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    distributed = pytest.importorskip("distributed", reason="extra [cluster] is not installed")
    monkeypatch.setattr("orchestrator.jobs.executors.ASK_AGAIN", 0.0)
    options = {"n_workers": 0, "threads_per_worker": 1, "processes": False, "protocol": "tcp"}
    with distributed.LocalCluster(**options, dashboard_address=None) as cluster:
        address = cluster.scheduler_address
        with pytest.raises(InputError, match=f"{address}: it has no workers; start some: dask worker"):
            Cluster(address, patience=0.3)
        late = threading.Timer(0.5, cluster.scale, (1,))
        late.start()
        with Cluster(address) as place:
            assert (place.workers, place.capacity) == (1, 2)
            cluster.scale(3)
            cluster.wait_for_workers(3)
            assert (place.workers, place.capacity) == (3, 6)
        planned = JobGraph(tmp_path, chain(tmp_path / "log"), CODE).dry_run(scheduler=address)
        assert "6 to do" in planned.report() and "on 3 processes of the cluster" in planned.report()
    with pytest.raises(InputError, match="no scheduler answers there"):
        Cluster(address, patience=0.3)


def test_what_cannot_be_a_graph_is_refused(tmp_path: Path) -> None:
    job = numbers("a", 1)
    for jobs, words in (
        ([job, job], "two jobs are called 'a'"),
        ([numbers("b", 1, ("aa",)), job], "did you mean 'a'"),
        ([numbers("a", 1, ("b",)), numbers("b", 1, ("a",))], "without a circle"),
        ([numbers("a", 1, x=float("nan"))], "inputs of a"),
        ([numbers("a", 1, x={1, 2})], "inputs of a"),
        ([numbers("a", 1, files={"f": tmp_path / "none"})], "none: cannot be read"),
    ):
        with pytest.raises(InputError, match=words):
            JobGraph(tmp_path, jobs, CODE)
    with pytest.raises(InputError, match="no_package"):
        JobGraph(tmp_path, [job], ("no_package",))
    campaign = JobGraph(tmp_path, [job], CODE)
    with pytest.raises(InputError, match="jobs = 0"):
        campaign.run(jobs=0)
    with pytest.raises(InputError, match="not an address"):
        campaign.run(scheduler="localhost")
    campaign.run(jobs=1)
    with pytest.raises(InputError, match="not an address"):  # also where nothing is left to do
        campaign.run(scheduler="localhost")


def test_results_that_were_changed_or_exchanged_are_computed_again(tmp_path: Path) -> None:
    log = tmp_path / "log"
    jobs = [numbers("one", 1, log=str(log)), numbers("two", 2, log=str(log))]
    first = JobGraph(tmp_path / "study", jobs, CODE).run(jobs=1)
    expected, (one, two) = totals(first), (r.folder for r in first.values())

    def again() -> list[int]:
        log.unlink()
        assert totals(JobGraph(tmp_path / "study", jobs, CODE).run(jobs=1)) == expected
        return calls(log)

    one.rename(tmp_path / "aside")
    two.rename(one)
    (tmp_path / "aside").rename(two)
    assert again() == [1, 2]
    content = json.loads((one / "result.json").read_text(encoding="utf-8"))
    content["values"]["total"] += 1.0
    (one / "result.json").write_text(json.dumps(content), encoding="utf-8")
    assert again() == [1]
