"""The numbers of the study ``lag``, as ``lag.json`` holds them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Required, TypedDict

import numpy as np

from friction_models.loads import FloatArray

from ...jobs.graph import JobResult
from ..contact import by_marker
from ..forming_jobs import run_of, synthetic
from ..tables import write_study
from .study import MODES, LagSettings, LagStudy, Mode, run_name

#: With which run another one is compared: the iterated one of the same step, or of the finest step.
Reference = Literal["lag", "to_finest"]


class Deviation(TypedDict):
    """How a run differs from its reference; `rms` is that of the force, `mu` over the markers in contact."""

    max_force_pct: float
    work_pct: float
    rms_kN: float
    rms_pct: float
    mu_mean: float
    mu_max: float


Quantity = Literal["max_force_pct", "work_pct", "rms_pct", "mu_mean"]


class LagRun(TypedDict, total=False):
    """One run. Only `failed` is there where it was not made; the deviations are missing where it broke off."""

    process: Required[str]
    model: Required[str]
    mode: Required[Mode]
    step_mm: Required[float]

    failed: str
    steps: int
    repetitions_mean: float
    repetitions_largest: int
    timing: dict[Literal["run_s"], float]
    max_force_kN: float
    work_J: float
    to_finest: Deviation | None
    lag: Deviation | None


class LagCurve(TypedDict):
    """Deviation of the force from the finest iterated run over the stroke [mm]."""

    process: str
    model: str
    mode: Mode
    step_mm: float

    stroke: list[float]
    deviation_kN: list[float]


class LagSummary(TypedDict, total=False):
    """Deviations per millimetre of step of one process, model and mode, and the time as a multiple of gauss_seidel.

    `runs` of them were compared.
    """

    process: str
    model: str
    mode: Mode
    runs: int
    work_pct_per_mm: float
    max_force_pct_per_mm: float
    rms_pct_per_mm: float
    mu_mean_per_mm: float
    timing: dict[Literal["relative"], float]
    failed: int


class LagNumbers(TypedDict):
    """All numbers of the study; `settings` are those of `LagPlan.to_dict`."""

    settings: LagSettings
    synthetic: bool
    rows: list[LagRun]
    curves: list[LagCurve]
    summary: list[LagSummary]


def evaluate(study: LagStudy, results: Mapping[str, JobResult]) -> LagNumbers:
    """Return all numbers of the study; runs that failed or were not made say so."""
    plan = study.plan
    rows: list[LagRun] = []
    curves: list[LagCurve] = []
    for process in plan.processes:
        for family in plan.models:
            made = {
                (mode, step): results.get(run_name(process, family, mode, step))
                for step in plan.steps
                for mode in MODES
            }
            runs = {
                (mode, step): _sampled(result, round(max(plan.steps) / step))
                for (mode, step), result in made.items()
            }
            finest = runs["iterated", min(plan.steps)]
            for (mode, step), run in runs.items():
                row: LagRun = {"process": process, "model": family, "mode": mode, "step_mm": step}
                _add_numbers(row, made[mode, step], run, finest, runs["iterated", step])
                rows.append(row)
                if run is not None and finest is not None and run.complete and finest.complete:
                    curves.append(
                        {
                            "process": process,
                            "model": family,
                            "mode": mode,
                            "step_mm": step,
                            "stroke": run.stroke.tolist(),
                            "deviation_kN": (run.force - finest.force).tolist(),
                        }
                    )
    return {
        "settings": plan.to_dict(),
        "synthetic": synthetic(results),
        "rows": rows,
        "curves": curves,
        "summary": _summary(rows, plan.steps),
    }


@dataclass(frozen=True)
class _Sampled:
    """A run at the strokes at which all runs are compared."""

    stroke: FloatArray
    force: FloatArray
    mu: FloatArray
    active: np.ndarray
    work: float
    complete: bool


def _sampled(result: JobResult | None, stride: int) -> _Sampled | None:
    run = run_of(result) if result is not None else None
    if run is None:
        return None
    rows = np.arange(0, len(run.time), stride)
    mu = by_marker(run, "friction.mu")
    if run.manifest["mode"] == "jacobi":  # a step works with the mu that the step before gave
        mu = np.vstack([mu[:1], mu[:-1]])
    return _Sampled(
        run["forming.stroke"][rows],
        run["forming.force"][rows],
        mu[rows],
        by_marker(run, "forming.active")[rows] > 0.5,
        float(run["forming.work"][-1]),
        run.complete,
    )


def _add_numbers(
    row: LagRun,
    result: JobResult | None,
    run: _Sampled | None,
    finest: _Sampled | None,
    iterated: _Sampled | None,
) -> None:
    if result is None:
        row["failed"] = "not run"
        return
    values = result.values
    repetitions = values["repetitions"]
    row["failed"] = values["failed"]
    row["steps"] = values["steps"]
    row["repetitions_mean"] = repetitions["mean"] if repetitions else 1.0
    row["repetitions_largest"] = repetitions["largest"] if repetitions else 1
    row["timing"] = {"run_s": sum(v for k, v in values["timing"].items() if k not in {"total", "setup"})}
    if run is None:
        return
    row["max_force_kN"] = float(run.force.max())
    row["work_J"] = run.work
    if run.complete:
        row["to_finest"] = _deviation(run, finest)
        row["lag"] = _deviation(run, iterated)


def _deviation(run: _Sampled, reference: _Sampled | None) -> Deviation | None:
    """Compare two runs at their common strokes; None without a complete reference."""
    if reference is None or not reference.complete:
        return None
    size = float(reference.force.max())
    rms = float(np.sqrt(np.mean((run.force - reference.force) ** 2)))
    # In the first row nothing touches yet in most processes, and no mu was passed on.
    touching = run.active[1:] & reference.active[1:]
    change = np.abs(run.mu[1:] - reference.mu[1:])[touching]
    return {
        "max_force_pct": 100.0 * (float(run.force.max()) / size - 1.0),
        "work_pct": 100.0 * (run.work / reference.work - 1.0),
        "rms_kN": rms,
        "rms_pct": 100.0 * rms / size,
        "mu_mean": float(np.mean(change)) if len(change) else 0.0,
        "mu_max": float(np.max(change, initial=0.0)),
    }


def write_results(folder: Path, numbers: LagNumbers, page: str) -> None:
    """Write ``lag.json``, ``lag.csv`` and ``report.html``."""
    write_study(folder, "lag", numbers, numbers["rows"], numbers["synthetic"], page)


def groups(rows: Sequence[LagRun] | Sequence[LagCurve]) -> list[tuple[str, str]]:
    """Return process and model of each group of rows."""
    return list(dict.fromkeys((r["process"], r["model"]) for r in rows))


def _summary(rows: Sequence[LagRun], steps: Sequence[float]) -> list[LagSummary]:
    """Return, by process, model and mode, how runs deviate per millimetre of step."""
    found: list[LagSummary] = []
    for process, model in groups(rows):
        mine = [r for r in rows if (r["process"], r["model"]) == (process, model)]
        seconds = {(r["mode"], r["step_mm"]): r["timing"]["run_s"] for r in mine if "timing" in r}
        for mode in MODES:
            # An iterated run differs from the finest by the step of the solver alone, the others by the lag too.
            which: Reference = "to_finest" if mode == "iterated" else "lag"
            used = [
                (r["step_mm"], deviation)
                for r in mine
                if r["mode"] == mode
                and (deviation := r.get(which)) is not None
                and (mode != "iterated" or r["step_mm"] > min(steps))
            ]
            entry: LagSummary = {"process": process, "model": model, "mode": mode, "runs": len(used)}
            if used:
                entry["work_pct_per_mm"] = _slope(used, "work_pct")
                entry["max_force_pct_per_mm"] = _slope(used, "max_force_pct")
                entry["rms_pct_per_mm"] = _slope(used, "rms_pct")
                entry["mu_mean_per_mm"] = _slope(used, "mu_mean")
                shares = [
                    seconds[mode, s] / seconds["gauss_seidel", s]
                    for s in steps
                    if seconds.get((mode, s)) and seconds.get(("gauss_seidel", s))
                ]
                entry["timing"] = {"relative": float(np.median(shares))} if shares else {}
            entry["failed"] = sum(bool(r["failed"]) for r in mine if r["mode"] == mode)
            found.append(entry)
    return found


def _slope(deviations: Sequence[tuple[float, Deviation]], quantity: Quantity) -> float:
    """Return a deviation per millimetre of step, by least squares through zero."""
    h = np.array([step for step, _ in deviations])
    y = np.array([deviation[quantity] for _, deviation in deviations])
    return float(h @ y / (h @ h))
