"""A compression test that was not run: friction FMU and twin FMU in a closed loop, compared with the measurement.

The source of signals gives normal force, speed and tool temperature; the twin FMU answers with the loads
of the contact mean; the friction FMU answers these with mu, one step later. Nothing measured but force,
motion and tool temperature goes in: friction and the heat that it makes are predicted.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypedDict

import numpy as np
import pandas as pd

from fmus.runtime.friction_names import FrictionNames
from forming.materials.materials import as_material
from friction_models.common import InputError, atomic_path, grown, write_json
from friction_models.common.folders import PREDICTION
from friction_models.loads import LOAD_NAMES, MU, FloatArray

from ..cosim.batch import RunTask, run_all
from ..cosim.run_folders import Run
from ..jobs.job import Progress
from .closed_loop import TwinParameters, sct_system, uncertainties_of
from .schedule import SctSchedule


@dataclass(frozen=True, eq=False)
class SctPrediction:
    """A predicted test.

    Examples
    --------
    A made-up run of two steps:

    >>> plan = {"test_id": "t1", "F_set": 50e3, "v_set": 20.0, "sd_set": 10.0, "T_tool": 20.0}
    >>> loads = {f"twin.{name}": np.array([1.0, 2.0, 3.0]) for name in LOAD_NAMES}
    >>> values = {"friction.mu": np.array([0.0, 0.1, 0.12]), **loads}
    >>> run = Run(Path("t1"), {"synthetic": False}, np.array([0.0, 0.25, 0.5]), values, {})
    >>> test = SctPrediction(SctSchedule.from_plan(plan), run)
    >>> test.mu, test.errors() is None, list(test.frame()["sd"])
    (array([0.1 , 0.12]), True, [1.0, 2.0])
    >>> several = SctPredictions("a law", [test])
    >>> several.summary() is None, round(several.to_dict()["tests"][0]["mu_mean"], 6)
    (True, 0.11)
    """

    schedule: SctSchedule  # what drove it, and the measurement where there is one
    run: Run  # the co-simulation: `friction.mu`, the five loads `twin.T` ..., the inputs `inputs.F_n` ...
    output: str = MU.name  # what mu is called in the friction FMU
    #: `u_sigma_n`, `u_psi`, `u_T` at the times of the run, by `uncertainties_of`; empty where they were not computed.
    uncertainties: Mapping[str, FloatArray] = field(default_factory=dict)

    @property
    def mu(self) -> FloatArray:
        """Coefficient of friction of every step."""
        return self.run[f"friction.{self.output}"][1:]

    def frame(self) -> pd.DataFrame:
        """Return one row a step: `test_id, t`, the five loads, `mu_model`, and what the loads may be off by.

        Where the test was measured also `mu` and `T_measured` at the same sliding distance, without value beyond
        the measured distances.
        """
        run = self.run
        # A step begins with the loads of the step before: mu and the loads it belongs to stand in one row.
        loads = {name: run[f"twin.{name}"][:-1] for name in LOAD_NAMES}
        frame = pd.DataFrame({"t": run.time[1:], **loads, "mu_model": self.mu})
        frame.insert(0, "test_id", self.schedule.test_id)
        frame = frame.assign(**{name: values[:-1] for name, values in self.uncertainties.items()})
        measured = self.schedule.measured
        for name, column in (("mu", "mu"), ("T_measured", "T")):
            if measured is not None and column in measured:
                known, values = measured["sd"].to_numpy(), measured[column].to_numpy()
                frame[name] = np.interp(loads["sd"], known, values, left=np.nan, right=np.nan)
        return frame

    def at(self, sd: FloatArray) -> dict[str, FloatArray]:
        """Return predicted `mu` and `T` [degC] at sliding distances [mm]."""
        frame = self.frame()
        known = frame["sd"].to_numpy()
        return {
            "mu": np.interp(sd, known, frame["mu_model"].to_numpy()),
            "T": np.interp(sd, self.run["twin.sd"], self.run["twin.T"]),
        }

    def errors(self) -> dict[str, float] | None:
        """Return predicted minus measured at the measured points; None for a test that was never run.

        `mu_rms, mu_mae, mu_bias` [1], `T_rms, T_bias` [K]; the means of both; `points`.
        """
        measured = self.schedule.measured
        if measured is None or "mu" not in measured:
            return None
        found = self.at(measured["sd"].to_numpy())
        mu = found["mu"] - measured["mu"].to_numpy()
        result = {
            "points": float(len(mu)),
            "mu_measured": float(measured["mu"].mean()),
            "mu_predicted": float(found["mu"].mean()),
            "mu_rms": float(np.sqrt(np.mean(mu**2))),
            "mu_mae": float(np.mean(np.abs(mu))),
            "mu_bias": float(mu.mean()),
        }
        if "T" in measured:
            T = found["T"] - measured["T"].to_numpy()
            result |= {
                "T_measured": float(measured["T"].mean()),
                "T_predicted": float(found["T"].mean()),
                "T_rms": float(np.sqrt(np.mean(T**2))),
                "T_bias": float(T.mean()),
            }
        return result

    def outside_domain(self) -> float | None:
        """Return the share of steps outside the loads that the friction model was trained on; None if it does not say."""
        distance = self.run.values.get("friction.domain_distance")
        return None if distance is None else float(np.mean(distance[1:] > 0.0))


class PredictedTest(TypedDict):
    """Errors of one test; None for a test that was never run, and a share outside that is not known."""

    test_id: str
    run: str  # name of its folder
    errors: dict[str, float] | None
    mu_mean: float
    T_mean: float
    outside_domain: float | None


class PredictionNumbers(TypedDict):
    """Content of ``prediction.json``; `summary` is None without measurements."""

    friction: str
    synthetic: bool
    summary: dict[str, float] | None
    tests: list[PredictedTest]


@dataclass(frozen=True, eq=False)
class SctPredictions:
    """Predicted tests of one friction FMU, in the order of the schedules."""

    label: str
    tests: Sequence[SctPrediction]
    #: Up to which temperature the data of the workpiece are known [degC]; None: not said.
    T_known: float | None = None

    @property
    def synthetic(self) -> bool:
        """Whether a test comes from a virtual laboratory, or the friction model learned from one."""
        return any(test.run.synthetic for test in self.tests)

    def summary(self) -> dict[str, float] | None:
        """Return errors over all measured points (`mu_rms, mu_mae, T_rms`) and `tests`; None without measurements."""
        found = [e for e in (test.errors() for test in self.tests) if e is not None]
        if not found:
            return None
        points = np.array([e["points"] for e in found])
        result = {
            "tests": float(len(found)),
            "mu_mae": float(np.average([e["mu_mae"] for e in found], weights=points)),
        }
        for name in ("mu_rms", "T_rms"):
            if all(name in e for e in found):
                square = np.array([e[name] ** 2 for e in found])
                result[name] = float(np.sqrt(np.average(square, weights=points)))
        return result

    def frame(self) -> pd.DataFrame:
        """Return the points of all tests, see `SctPrediction.frame`."""
        return pd.concat([test.frame() for test in self.tests], ignore_index=True)

    def to_dict(self) -> PredictionNumbers:
        """Return errors by test and over all as plain data."""
        rows: list[PredictedTest] = [
            {
                "test_id": test.schedule.test_id,
                "run": test.run.folder.name,
                "errors": test.errors(),
                "mu_mean": float(test.mu.mean()),
                "T_mean": float(test.run["twin.T"][1:].mean()),
                "outside_domain": test.outside_domain(),
            }
            for test in self.tests
        ]
        return {"friction": self.label, "synthetic": self.synthetic, "summary": self.summary(), "tests": rows}

    def table(self) -> str:
        """Return the tests as text, one line each, and the errors over all of them."""
        lines = [
            f"friction: {self.label}" + ("  (synthetic data)" if self.synthetic else ""),
            f"{'test':16}{'mean mu':>18}{'RMS':>9}{'MAE':>9}{'mean T [degC]':>20}{'RMS [K]':>9}{'outside':>9}",
            f"{'':16}{'measured':>9}{'model':>9}{'':18}{'measured':>10}{'model':>10}{'':9}{'domain':>9}",
        ]
        for test in self.tests:
            e = test.errors()
            run = test.run
            mu, T = float(test.mu.mean()), float(run["twin.T"][1:].mean())
            if e is None:
                cells = f"{'-':>9}{mu:9.4f}{'-':>9}{'-':>9}{'-':>10}{T:10.1f}{'-':>9}"
            else:
                cells = f"{e['mu_measured']:9.4f}{e['mu_predicted']:9.4f}{e['mu_rms']:9.4f}{e['mu_mae']:9.4f}"
                cells += (
                    f"{e['T_measured']:10.1f}{e['T_predicted']:10.1f}{e['T_rms']:9.1f}"
                    if "T_rms" in e
                    else f"{'-':>10}{T:10.1f}{'-':>9}"
                )
            outside = test.outside_domain()
            share = "-" if outside is None else f"{100 * outside:.0f}%"
            lines.append(f"{test.schedule.test_id[:15]:16}{cells}{share:>9}")
        total = self.summary()
        if total is not None:
            text = f"over {total['tests']:.0f} tests: mu RMS {total['mu_rms']:.4f}, MAE {total['mu_mae']:.4f}"
            lines.append(text + (f", T RMS {total['T_rms']:.1f} K" if "T_rms" in total else ""))
        return "\n".join([*lines, *self.remarks()])

    def remarks(self) -> list[str]:
        """Return a sentence on each test that gets hotter than the workpiece's data reach."""
        hottest = [(test.schedule.test_id, float(np.max(test.run["twin.T"]))) for test in self.tests]
        return [
            f"{test_id}: the contact reaches {T:.0f} degC, the data of the workpiece end at {self.T_known:g} degC (is the force, the "
            "speed or a size in another unit?)"
            for test_id, T in hottest
            if self.T_known is not None and self.T_known < T
        ]

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Write `predicted.csv` (all points) and `prediction.json` (errors) into a folder."""
        place = grown(folder, PREDICTION)
        with atomic_path(place / "predicted.csv") as temporary:
            self.frame().to_csv(temporary, index=False, lineterminator="\n")
        write_json(place / "prediction.json", self.to_dict())
        return place


def predict_sct(
    friction: str | os.PathLike[str],
    schedules: Sequence[SctSchedule],
    out: str | os.PathLike[str],
    *,
    twin: TwinParameters | None = None,
    label: str | None = None,
    names: FrictionNames | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> SctPredictions:
    """Predict tests with a friction FMU and the twin FMU in a closed loop; none of them needs to have been run.

    Parameters
    ----------
    friction : path-like
        Friction FMU for one contact point.
    schedules : sequence of SctSchedule
        What drives the tests.
    out : path-like
        Folder: ``fmus/``, a run folder a test under ``runs/``, ``predicted.csv``, ``prediction.json``. Runs that are there
        already, of the same FMUs, versions and sources, are not computed again.
    twin : mapping, optional
        Parameters of the twin for all tests; what the test table says about specimen and punch goes before them.
    label : str, optional
        Name of the friction model; that of the file by default.
    names : FrictionNames, optional
        Variables of an FMU that others made; those of the contract by default.
    jobs : int, optional
        Processes; all cores by default.
    progress : callable, optional
        Called with (done, total, test_id).

    Raises
    ------
    InputError
        No tests, a parameter or an FMU that does not fit.
    SimulationError
        A component failed.

    Examples
    --------
    >>> predict_sct("no-such.fmu", [], "predicted")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: predict_sct: no tests given; allowed: at least one
    """
    if not schedules:
        raise InputError("predict_sct: no tests given; allowed: at least one")
    place = grown(out, PREDICTION)
    name = label or Path(friction).stem
    output = MU.name if names is None else names.mu
    tasks = [
        RunTask(
            sct_system(friction, schedule, place / "fmus", twin=twin, label=name, names=names),
            place / "runs" / schedule.test_id,
        )
        for schedule in schedules
    ]
    runs = run_all(tasks, jobs, progress)
    off_by = uncertainties_of(schedules, runs, twin=twin, output=output, jobs=jobs)
    tests = [SctPrediction(s, run, output, u) for s, run, u in zip(schedules, runs, off_by)]
    known = as_material((twin or {}).get("material")).T_range
    found = SctPredictions(name, tests, None if known is None else known[1])
    found.save(place)
    return found
