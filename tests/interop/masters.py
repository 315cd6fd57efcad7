"""The same coupled FMUs in our modes, in libcosim and in ecos."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from friction_models.loads import LOAD_NAMES, FloatArray
from orchestrator import Master, System

from .children.common import Found, Job
from .running import run_child, version
from .subjects import STEP, STEPS, Subjects

RECORDED = ("slider.work", "slider.sd", "slider.T", "slider.mu")


def coupled(subjects: Subjects, fmi: str = "2.0") -> System:
    """Return a sliding contact and friction with memory, each fed by the other."""
    return System.from_dict(
        {
            "name": "coupled",
            "communication_step": STEP,
            "stop_time": STEP * STEPS,
            "components": {
                "friction": {"fmu": str(subjects.friction("memory", fmi))},
                "slider": {"fmu": str(subjects.slider())},
            },
            "connections": [
                *(f"slider.{name} -> friction.{name}" for name in LOAD_NAMES),
                "friction.mu -> slider.mu",
            ],
            "record": [*RECORDED, "friction.mu"],
        }
    )


def ours(subjects: Subjects, mode: str, folder: Path, fmi: str = "2.0") -> FloatArray:
    """Return what our master records after each step: `RECORDED` and friction.mu, shape (steps, 5)."""
    run = Master(coupled(subjects, fmi), mode).run(folder)
    return np.column_stack([run[name] for name in (*RECORDED, "friction.mu")])[1:]


def theirs(subjects: Subjects, client: str, folder: Path, fmi: str = "2.0") -> FloatArray:
    """Return the same of `libcosim` or `ecos_python`."""
    return np.array(_run(subjects, client, folder, fmi, 0)["values"])


def seconds_a_step(subjects: Subjects, client: str, folder: Path, steps: int) -> float:
    """Return the time of one coupled step in `libcosim`, `ecos_python` or a mode of our master [s]."""
    if client in {"libcosim", "ecos_python"}:
        return float(_run(subjects, client, folder, "2.0", steps)["seconds"]) / steps
    system = coupled(subjects)
    system.stop_time = STEP * steps
    master = Master(system, client)
    master.run(folder)
    return master.course.loop_seconds / steps


def _run(subjects: Subjects, client: str, folder: Path, fmi: str, timed: int) -> Found:
    work: Job = {
        "fmus": {"slider": str(subjects.slider()), "friction": str(subjects.friction("memory", fmi))},
        "connections": [
            *((f"slider.{name}", f"friction.{name}") for name in LOAD_NAMES),
            ("friction.mu", "slider.mu"),
        ],
        "outputs": [*RECORDED, "friction.mu"],
        "step": STEP,
        "steps": STEPS,
        "timed": timed,
    }
    outcome = run_child(client, work, folder)
    assert outcome.result is not None, outcome.seen
    return outcome.result


def difference(a: FloatArray, b: FloatArray) -> float:
    """Return the largest difference relative to the largest value of each column."""
    return float(np.max(np.abs(a - b) / np.max(np.abs(b), axis=0)))


def seen_by_ecos(values: FloatArray) -> FloatArray:
    """Return a run of ours as ecos shows it: slider.mu is what friction has just passed on."""
    shown = values[:, :4].copy()
    shown[:, 3] = values[:, 4]
    return shown


def compare_masters(subjects: Subjects, folder: Path) -> list[tuple[str, str]]:
    """Return rows: what was compared, and the largest relative difference."""
    jacobi = ours(subjects, "jacobi", folder / "jacobi")
    gauss_seidel = ours(subjects, "gauss_seidel", folder / "gauss-seidel")
    iterated = ours(subjects, "iterated", folder / "iterated")
    rows = []
    if version("libcosimpy"):
        found = theirs(subjects, "libcosim", folder / "libcosim")
        rows.append(("`jacobi` and libcosim", f"{difference(jacobi, found):.1e}"))
    if version("ecospy") and version("tbb"):
        found = theirs(subjects, "ecos_python", folder / "ecos")
        rows.append(("`jacobi` and ecos", f"{difference(seen_by_ecos(jacobi), found[:, :4]):.1e}"))
    rows.append(("work of the slider: `jacobi` and `iterated` (no lag)", _work(jacobi, iterated)))
    rows.append(("work of the slider: `gauss_seidel` and `iterated` (no lag)", _work(gauss_seidel, iterated)))
    return rows


def _work(a: FloatArray, b: FloatArray) -> str:
    return f"{difference(a[:, :1], b[:, :1]):.1e}"
