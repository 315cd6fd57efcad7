"""The study ``lag``: what friction from the loads of the step before costs, by the size of the step.

Every run is compared at the same strokes, multiples of the longest communication step: with the iterated
run of its own step, which differs by the lag alone, and with the iterated run of the finest step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from friction_models.common import InputError
from friction_models.loads import FloatArray

from ..comparison.level_runs import Level
from .coupled import SPEED, T_TOOL, check_names, chosen_level, coupled_job, run_of
from .measurements import FULL_PLAN, QUICK_PLAN, data_jobs, data_name
from .models import model_job

if TYPE_CHECKING:
    from ..cosim.run_folders import Run
    from ..jobs.campaign import Job, JobResult

MODES = ("jacobi", "gauss_seidel", "iterated")


@dataclass(frozen=True)
class LagStudy:
    """What is compared.

    Attributes
    ----------
    models : sequence of str
        Families.
    processes : sequence of str
    steps : sequence of float
        Communication steps [mm]; each divides the longest.
    stroke : float or None
        Punch travel [mm]; None for that of a usual run.
    speed, T_tool : float
        Level of the press: punch speed [mm/s], tool temperature [degC].
    lubricant, plan : str
        Of the virtual laboratory.
    seed : int
    """

    models: Sequence[str] = ("polynomial", "ffnn")
    processes: Sequence[str] = ("fre", "bce")
    steps: Sequence[float] = (0.05, 0.1, 0.2, 0.4, 0.8)
    stroke: float | None = None
    speed: float = SPEED
    T_tool: float = T_TOOL
    lubricant: str = "polymer"
    plan: str = FULL_PLAN
    seed: int = 0

    def __post_init__(self) -> None:
        check_names(self.models, self.processes)
        longest = max(self.steps)
        for step in self.steps:
            if not 0.001 <= step <= 5.0:
                raise InputError(f"communication step {step:g} mm, allowed: 0.001 to 5 mm")
            if abs(longest / step - round(longest / step)) > 1e-6:
                raise InputError(
                    f"communication step {step:g} mm does not divide the longest, {longest:g} mm; "
                    "allowed: steps that do, so that all runs can be compared at the same strokes"
                )

    @classmethod
    def quick(cls) -> LagStudy:
        """Return the quick size: one model, a short rod."""
        return cls(("polynomial",), ("fre",), (0.1, 0.4, 0.8), 4.0, plan=QUICK_PLAN)

    def jobs(self, data: Mapping[str, Path] | None = None) -> list[Job]:
        """Return all jobs: measurements, models, runs; `data` holds one's own data set by lubricant."""
        ((lubricant, jobs),) = data_jobs(data, (self.lubricant,), self.plan, self.seed).items()
        for family in self.models:
            model = model_job(family, data_name(lubricant))
            jobs.append(model)
            for process in self.processes:
                level = self._level(process)
                jobs += [
                    coupled_job(
                        _name(process, family, mode, step), level, model.name, mode, step, label=family
                    )
                    for step in self.steps
                    for mode in MODES
                ]
        return jobs

    def _level(self, process: str) -> Level:
        return chosen_level(process, self.stroke, max(self.steps), self.speed, self.T_tool)

    def evaluate(
        self, results: Mapping[str, JobResult], data: Mapping[str, Path] | None = None
    ) -> dict[str, Any]:
        """Return all numbers of the study; runs that failed or were not made say so.

        Returns
        -------
        dict
            ``rows``: one a run; ``curves``: deviation of the force over the stroke; ``summary``: one a model,
            process and mode; ``settings``, ``synthetic``.
        """
        (lubricant,) = data or (self.lubricant,)
        rows: list[dict[str, Any]] = []
        curves: list[dict[str, Any]] = []
        for process in self.processes:
            for family in self.models:
                runs = {
                    (mode, step): _sampled(
                        results.get(_name(process, family, mode, step)), round(max(self.steps) / step)
                    )
                    for step in self.steps
                    for mode in MODES
                }
                finest = runs["iterated", min(self.steps)]
                for (mode, step), sampled in runs.items():
                    row: dict[str, Any] = {"process": process, "model": family, "mode": mode, "step_mm": step}
                    result = results.get(_name(process, family, mode, step))
                    rows.append(row | _numbers(result, sampled, finest, runs["iterated", step]))
                    if sampled is not None and finest is not None and sampled.complete and finest.complete:
                        curves.append(
                            {
                                **row,
                                "stroke": sampled.stroke.tolist(),
                                "deviation_kN": (sampled.force - finest.force).tolist(),
                            }
                        )
        made = [r.values for r in results.values()]
        return {
            "settings": {
                "models": list(self.models),
                "processes": list(self.processes),
                "steps_mm": list(self.steps),
                "stroke_mm": {process: self._level(process).stroke for process in self.processes},
                "speed_mm_s": self.speed,
                "T_tool_degC": self.T_tool,
                "lubricant": lubricant,
                "compared_every_mm": max(self.steps),
            },
            "synthetic": any(bool(v.get("synthetic")) for v in made),
            "rows": rows,
            "curves": curves,
            "summary": _summary(rows, self.steps),
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


def _name(process: str, family: str, mode: str, step: float) -> str:
    return f"{process}-{family}-{mode}-{step:g}mm"


def _sampled(result: JobResult | None, stride: int) -> _Sampled | None:
    run: Run | None = run_of(result) if result is not None else None
    if run is None:
        return None
    rows = np.arange(0, len(run.time), stride)
    mu = np.atleast_2d(run["friction.mu"].T).T
    if run.manifest["mode"] == "jacobi":  # a step works with the mu that the step before gave
        mu = np.vstack([mu[:1], mu[:-1]])
    return _Sampled(
        run["forming.stroke"][rows],
        run["forming.force"][rows],
        mu[rows],
        np.atleast_2d(run["forming.active"].T).T[rows] > 0.5,
        float(run["forming.work"][-1]),
        run.complete,
    )


def _numbers(
    result: JobResult | None,
    sampled: _Sampled | None,
    finest: _Sampled | None,
    iterated: _Sampled | None,
) -> dict[str, Any]:
    if result is None:
        return {"failed": "not run"}
    values = result.values
    row: dict[str, Any] = {"failed": values["failed"], "steps": values["steps"]}
    repetitions = values["repetitions"]
    row["repetitions_mean"] = repetitions["mean"] if repetitions else 1.0
    row["repetitions_largest"] = repetitions["largest"] if repetitions else 1
    row["timing"] = {"run_s": sum(v for k, v in values["timing"].items() if k not in {"total", "setup"})}
    if sampled is None:
        return row
    row |= {"max_force_kN": float(sampled.force.max()), "work_J": sampled.work}
    if sampled.complete:
        row["to_finest"] = _difference(sampled, finest)
        row["lag"] = _difference(sampled, iterated)
    return row


def _difference(run: _Sampled, reference: _Sampled | None) -> dict[str, float] | None:
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


def _summary(rows: Sequence[Mapping[str, Any]], steps: Sequence[float]) -> list[dict[str, Any]]:
    """Return, by process, model and mode, how the work deviates from the iterated run per millimetre of step."""
    found: list[dict[str, Any]] = []
    for process, model in dict.fromkeys((r["process"], r["model"]) for r in rows):
        mine = [r for r in rows if (r["process"], r["model"]) == (process, model)]
        seconds = {(r["mode"], r["step_mm"]): r.get("timing", {}).get("run_s") for r in mine}
        for mode in MODES:
            # An iterated run differs from the finest by the step of the solver alone, the others by the lag too.
            which = "to_finest" if mode == "iterated" else "lag"
            used = [r for r in mine if r["mode"] == mode and r.get(which)]
            used = [r for r in used if mode != "iterated" or r["step_mm"] > min(steps)]
            entry: dict[str, Any] = {"process": process, "model": model, "mode": mode, "runs": len(used)}
            if used:
                h = np.array([r["step_mm"] for r in used])
                for name in ("work_pct", "max_force_pct", "rms_pct"):
                    y = np.array([r[which][name] for r in used])
                    entry[f"{name}_per_mm"] = float(h @ y / (h @ h))
                entry["mu_mean_per_mm"] = float(h @ np.array([r[which]["mu_mean"] for r in used]) / (h @ h))
                shares = [
                    seconds[mode, s] / seconds["gauss_seidel", s]
                    for s in steps
                    if seconds.get((mode, s)) and seconds.get(("gauss_seidel", s))
                ]
                entry["timing"] = {"relative": float(np.median(shares))} if shares else {}
            entry["failed"] = sum(bool(r["failed"]) for r in mine if r["mode"] == mode)
            found.append(entry)
    return found


def table(values: Mapping[str, Any]) -> str:
    """Return the summary as text."""
    lines = [
        f"{'process':8}{'model':20}{'mode':14}{'work %/mm':>11}{'force %/mm':>12}{'rms %/mm':>10}{'mu /mm':>10}{'cost':>7}{'failed':>8}"
    ]
    for entry in values["summary"]:
        head = f"{entry['process']:8}{entry['model']:20}{entry['mode']:14}"
        if not entry["runs"]:
            lines.append(f"{head}{'-':>11}{'-':>12}{'-':>10}{'-':>10}{'-':>7}{entry['failed']:>8}")
            continue
        cost = entry["timing"].get("relative")
        lines.append(
            f"{head}{entry['work_pct_per_mm']:>+11.3f}{entry['max_force_pct_per_mm']:>+12.3f}{entry['rms_pct_per_mm']:>10.3f}"
            f"{entry['mu_mean_per_mm']:>10.5f}{'-' if cost is None else f'{cost:.1f}x':>7}{entry['failed']:>8}"
        )
    lines.append(
        "jacobi and gauss_seidel: against the iterated run of the same step; iterated: against that of the finest"
    )
    return "\n".join(lines)
