"""The paper's studies through the command line: time of the quick and of the full size, on all cores.

Full-size results stay in ``build/benchmarks/studies``. A study that goes on from kept results is no measurement of
its whole time; the sum over its jobs is shown in any case.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from friction_models.common import write_json
from friction_models.common.processes.pool import default_jobs

from .common import Section, Table, section

STUDIES = ("learning-curve", "forming-error", "lag", "extrapolation")
#: Longest times that were asked for [min]; the quick size has two minutes.
LIMITS = {"learning-curve": 40, "forming-error": 40}
QUICK_LIMIT = 2


class Took(NamedTuple):
    """How long a study took from an empty folder (0 where it went on from kept results) and over its jobs [s]; how many jobs."""

    wall: float
    work: float
    jobs: int


def measure(kept: Path) -> Section:
    """Run every study in both sizes."""
    table = Table(
        ["study", "size", "jobs done", "wall time [min]", "sum over the jobs [min]", "asked for [min]"]
    )
    for name in STUDIES:
        with tempfile.TemporaryDirectory(prefix="tribofmu-bench-") as place:
            quick = run(name, Path(place) / name, quick=True)
        full = run(name, kept / "studies" / name)
        for size, took, limit in (("quick", quick, QUICK_LIMIT), ("full", full, LIMITS.get(name, ""))):
            wall = f"{took.wall / 60:.1f}" if took.wall else "in several parts"
            table.rows.append((name, size, took.jobs, wall, f"{took.work / 60:.1f}", limit))
    return section(
        "The paper's studies",
        f"`tribofmu study NAME` from an empty folder, with the measurements of the virtual laboratory (synthetic), on {default_jobs()} "
        "processes, imports and the compilation of the kernels included.",
        table,
    )


def run(name: str, folder: Path, quick: bool = False) -> Took:
    """Run a study into a folder.

    Raises
    ------
    RuntimeError
        The study failed; what it said stands in the message.
    """
    note = folder.parent / f"{name}.wall.json"
    fresh = not folder.exists()
    began = time.perf_counter()
    command = [
        sys.executable,
        "-c",
        "from orchestrator.cli import main; main()",
        "study",
        name,
        "-o",
        str(folder),
    ]
    done = subprocess.run(
        [*command, *(["--quick"] if quick else [])], capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(f"study {name}: {done.stderr.strip()[-500:]}")
    if fresh:
        write_json(note, {"wall": time.perf_counter() - began})
    wall = json.loads(note.read_text(encoding="utf-8"))["wall"] if note.is_file() else 0.0
    jobs = [json.loads(p.read_text(encoding="utf-8")) for p in (folder / "jobs").glob("*/result.json")]
    return Took(wall, sum(job["seconds"] for job in jobs), len(jobs))
