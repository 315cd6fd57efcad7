"""Run folders: results of a co-simulation with the system, the versions and the FMU hashes behind them."""

from __future__ import annotations

import os
import platform
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fmus.runtime.messages import WARNS
from friction_models.common import InputError, atomic_folder, given_path, unknown_name, write_json
from friction_models.common.cached_results import path_digest
from friction_models.common.files import read_json
from friction_models.common.folders import RUN
from friction_models.common.imports.drawn import Drawn
from friction_models.common.netcdf_files import Dataset, NetcdfVariable, write_dataset
from friction_models.common.wording import counted
from friction_models.loads import FloatArray

from ..force_curves.forces import ForceComparison, ForceCurve, compare_force, read_press_curve
from ..jobs.keys import running_code
from ..jobs.versions import versions
from .run_results import read_results
from .setup.description import SystemDescription
from .setup.wiring import Wiring

if TYPE_CHECKING:
    import pandas as pd


#: Different warnings of FMUs that are told of one run.
MOST_WARNINGS = 10
#: Share of the loads in contact that may lie outside the domain of a friction model without a word.
MOST_OUTSIDE = 0.02


def force_labels(recorded: Collection[str], where: str) -> tuple[str, str]:
    """Return which recorded values are stroke and force of one component.

    Examples
    --------
    >>> force_labels(["friction.mu", "forming.stroke", "forming.force"], "run")
    ('forming.stroke', 'forming.force')
    """
    for label in recorded:
        component, _, name = label.rpartition(".")
        if name == "force" and f"{component}.stroke" in recorded:
            return f"{component}.stroke", label
    raise InputError(
        f"{where}: no component recorded both 'stroke' and 'force'; recorded: {', '.join(recorded)}"
    )


@dataclass
class Course:
    """How the components of a run were coupled, and what happened in it beside its results."""

    mode: str
    tolerance: float  # mode ``iterated``: relative change that counts as agreement
    isolated: Collection[str]  # components that run in a process of their own
    warnings: Sequence[str]  # about open inputs, algebraic loops and friction that lags
    log: list[str] = field(default_factory=list)  # messages of the FMUs
    iterations: list[int] = field(default_factory=list)  # mode ``iterated``: repetitions of each step
    changes: list[float] = field(default_factory=list)  # largest relative one of a connection in the last
    #: Mode ``iterated``: values that did not settle in each step, and were left as at its start.
    lagging: list[int] = field(default_factory=list)
    ending: str = ""  # why the run ended before its stop time although nothing failed
    stopped: BaseException | None = None  # what stopped it otherwise
    #: Wall time by component, and of ``master``, ``setup`` and ``total`` [s].
    timing: dict[str, float] = field(default_factory=dict)
    loop_seconds: float = 0.0  # of the stepping alone

    @property
    def lagging_steps(self) -> int:
        """Number of steps in which some value did not settle."""
        return sum(count > 0 for count in self.lagging)

    def remarks(self) -> list[str]:
        """Return what to say of the run beside its warnings: those of the FMUs, and values that did not settle."""
        said = list(
            dict.fromkeys(line.replace(f": {WARNS}", ": ", 1) for line in self.log if f": {WARNS}" in line)
        )
        if len(said) > MOST_WARNINGS:
            said[MOST_WARNINGS:] = [f"{len(said) - MOST_WARNINGS} further warnings of FMUs in log.txt"]
        if self.lagging_steps:
            said.append(
                f"in {self.lagging_steps} of {counted(len(self.lagging), 'step')} up to {counted(max(self.lagging), 'value')} did not settle in the repetitions "
                "and stayed as at the start of the step: there friction lags by one step"
            )
        return said


@dataclass
class Run(Drawn):
    """A written run: complete, or the beginning of one that stopped.

    Attributes
    ----------
    folder : Path
        Where it lies: ``system.yaml``, ``manifest.json``, ``results.nc``, ``log.txt``.
    manifest : dict
        Versions, file hashes, mode, timing, the synthetic flag; ``"status"`` is ``"ok"``, or ``"stopped"`` and
        ``"message"`` says which component failed, when and why. ``"message"`` of a complete run names a component that
        ended it before the stop time. ``"warnings"``: open inputs, algebraic loops, friction that lags too far, warnings of the FMUs,
        loads outside the domain of a friction model.
    time : ndarray, shape (steps + 1,)
        Communication points [s].
    values : dict of str to ndarray
        ``"forming.force"`` (steps + 1,) or ``"forming.sigma_n"`` (steps + 1, N).
    units : dict of str to str
        Unit of each value.

    Examples
    --------
    >>> run = Run(
    ...     Path("run"), {"status": "ok", "synthetic": False}, np.array([0.0, 0.1]),
    ...     {"forming.stroke": np.array([0.0, 1.0]), "forming.force": np.array([0.0, 50.0])},
    ...     {"forming.stroke": "mm", "forming.force": "kN"},
    ... )
    >>> run["forming.force"][-1], run.force_curve().work(0.0, 1.0), run.complete
    (np.float64(50.0), 25.0, True)
    """

    folder: Path
    manifest: dict[str, Any]
    time: FloatArray
    values: dict[str, FloatArray]
    units: dict[str, str]

    @classmethod
    def load(cls, folder: str | os.PathLike[str], stopped: bool = False) -> Run:
        """Read a run folder.

        Parameters
        ----------
        stopped : bool
            Also read a run that stopped before its end.

        Raises
        ------
        InputError
            Not a run folder, its files cannot be read, or the run stopped.
        """
        place = given_path(folder, "a run folder")
        for name in ("manifest.json", "results.nc"):
            if not (place / name).is_file():
                raise InputError(f"{place}: not a run folder ({name} is missing); `simulate -o` writes one")
        manifest = read_json(place / "manifest.json")
        run = cls(place, manifest, *read_results(place / "results.nc"))
        if not stopped and not run.complete:
            raise InputError(f"{place}: the run stopped ({run.message[:300]}); allowed: a complete run")
        return run

    def __repr__(self) -> str:
        ended = "" if self.complete else ", stopped"
        size = f"{counted(len(self.time) - 1, 'step')}, {counted(len(self.values), 'result')}"
        return f"Run({self.name!r} in {str(self.folder)!r}, {size}{ended})"

    def __getitem__(self, name: str) -> FloatArray:
        if name not in self.values:
            raise unknown_name("result", name, self.values, str(self.folder))
        return self.values[name]

    @property
    def synthetic(self) -> bool:
        """Whether something in the run came from a virtual laboratory."""
        return bool(self.manifest.get("synthetic", False))

    @property
    def complete(self) -> bool:
        """Whether the run reached its stop time, or the end that a component gave it."""
        return self.manifest.get("status", "ok") == "ok"

    @property
    def message(self) -> str:
        """Which component failed or ended the run, when and why; empty where the stop time was reached."""
        return str(self.manifest.get("message", ""))

    @property
    def name(self) -> str:
        """Name of the system that ran."""
        return str(self.manifest.get("name", self.folder.name))

    def force_curve(self) -> ForceCurve:
        """Return force over stroke of the component that recorded both.

        Raises
        ------
        InputError
            No component recorded ``stroke`` and ``force``, or they make no curve.
        """
        stroke, force = force_labels(self.values, str(self.folder))
        try:
            return ForceCurve(self.values[stroke], self.values[force])
        except InputError as error:
            raise InputError(f"{self.folder}: {error}") from None

    def few_points(self) -> list[str]:
        """Return a sentence for each component of whose contact points too few touch for means over them; see `forming`."""
        from forming.results.few_points import few_points

        contacts = {
            label.removesuffix(".active"): values[1:] > 0.5
            for label, values in self.values.items()
            if label.endswith(".active") and values.ndim == 2
        }
        return [f"{name}: {said}" for name, active in contacts.items() if (said := few_points(active))]

    def columns(self) -> dict[str, FloatArray]:
        """Return the values with one column a contact point, shape (steps + 1, points); of a single number one column."""
        return {label: v if v.ndim == 2 else v[:, None] for label, v in self.values.items()}

    def outside_domain(self) -> list[str]:
        """Return a sentence for each friction model that was asked beyond what it was trained on, at points in contact."""
        columns = self.columns()
        said = []
        for label, distance in columns.items():
            if not label.endswith(".domain_distance"):
                continue
            pressures = (
                v for n, v in columns.items() if n.endswith(".sigma_n") and v.shape == distance.shape
            )
            touching = next((v > 0.0 for v in pressures), None)
            if touching is None or not touching.any():
                continue
            far = distance[touching]
            if (share := float(np.mean(far > 0.0))) > MOST_OUTSIDE:
                said.append(
                    f"{label.rpartition('.')[0]}: {100.0 * share:.0f} % of the loads in contact lie outside what the model was "
                    f"trained on, the farthest by {far.max():.2g} times the trained range of a load; nobody measured mu there"
                )
        return said

    def remarks(self) -> list[str]:
        """Return what to keep in mind with these results."""
        return [*self.few_points(), *self.outside_domain()]

    def compare_force(self, press: str | os.PathLike[str]) -> ForceComparison:
        """Compare the force-stroke curve with a measured one (CSV: stroke [mm], force [kN], repeat)."""
        return compare_force(self.force_curve(), read_press_curve(press), label=self.name)

    def to_frame(self) -> pd.DataFrame:
        """Return one row a communication point; elements of vectors as ``forming.sigma_n[3]``."""
        import pandas as pd

        columns: dict[str, FloatArray] = {"time": self.time}
        for label, values in self.values.items():
            if values.ndim == 1:
                columns[label] = values
            else:
                columns |= {f"{label}[{k + 1}]": values[:, k] for k in range(values.shape[1])}
        return pd.DataFrame(columns)


def write_run(
    folder: Path,
    system: SystemDescription,
    wiring: Wiring,
    course: Course,
    history: dict[str, FloatArray],
    csv: bool = False,
) -> Run:
    """Write a run folder, beside its place first, and return the run."""
    failure = str(course.stopped or "")
    points = len(next(iter(history.values()))) if history else system.steps + 1
    time: FloatArray = np.arange(points, dtype=np.float64) * system.communication_step
    values = {item.label: history[item.label] for item in wiring.recorded}
    values = {label: array[:, 0] if array.shape[1] == 1 else array for label, array in values.items()}
    units = {item.label: item.elements[0].unit for item in wiring.recorded}
    files = {
        name: {
            "fmu": description.path.name,
            "sha256": description.sha256,
            "model": description.raw.modelName,
            "guid": description.raw.guid,
            "generator": description.raw.generationTool or "",
            "synthetic": description.synthetic,
            "start": dict(system.components[name].start),
            "instances": wiring.points.get(name, 1),
            "steps": system.parts(name),
            "isolated": name in course.isolated,
        }
        for name, description in wiring.descriptions.items()
    }
    manifest: dict[str, object] = {
        "name": system.name,
        "synthetic": system.synthetic or any(part["synthetic"] for part in files.values()),
        "mode": course.mode,
        "communication_step": system.communication_step,
        "stop_time": system.stop_time,
        "steps": points - 1,
        "status": "stopped" if failure else "ok",
        "message": failure or course.ending,
        "seeds": {k: v for k, v in system.provenance.items() if k.endswith("seed")},
        "provenance": system.provenance,
        "components": files,
        "timing_s": {name: round(seconds, 6) for name, seconds in course.timing.items()},
        "versions": versions(),
        "code": running_code(__package__),
        "platform": platform.platform(terse=True),
        "written": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    if course.mode == "iterated":
        manifest["iterations"] = {
            "mean": float(np.mean(course.iterations or [0])),
            "largest": max(course.iterations, default=0),
            "total": sum(course.iterations),
            "largest_change": max(course.changes, default=0.0),
            "tolerance": course.tolerance,
            "lagging_steps": course.lagging_steps,
            "most_lagging": max(course.lagging, default=0),
        }
    run = Run(folder, manifest, time, values, units)
    manifest["warnings"] = [*course.warnings, *course.remarks(), *run.remarks()]
    with atomic_folder(folder, RUN) as place:
        moved = {n: folder.resolve() / p.relative_to(place) for n, p in system.bundle(place).items()}
        text = system.to_yaml(relative_to=folder.resolve(), moved=moved)
        (place / "system.yaml").write_text(text, encoding="utf-8")
        _write_netcdf(run, place / "results.nc")
        manifest["results_sha256"] = path_digest(place / "results.nc")
        write_json(place / "manifest.json", manifest)
        if csv:
            run.to_frame().to_csv(place / "results.csv", index=False, lineterminator="\n")
        (place / "log.txt").write_text("\n".join([*_summary(run), *course.log]) + "\n", encoding="utf-8")
    return run


def _write_netcdf(run: Run, path: Path) -> None:
    variables = {
        label: NetcdfVariable(
            ("time",) if a.ndim == 1 else ("time", f"point_{a.shape[1]}"), a, {"units": run.units[label]}
        )
        for label, a in run.values.items()
    }
    coordinates = {"time": NetcdfVariable(("time",), run.time, {"units": "s"})}
    for width in sorted({a.shape[1] for a in run.values.values() if a.ndim == 2}):
        points = f"point_{width}"
        coordinates[points] = NetcdfVariable((points,), np.arange(1, width + 1), {})
    about = {"name": run.name, "synthetic": int(run.synthetic), "mode": run.manifest["mode"]}
    write_dataset(Dataset(variables, coordinates, about), path)


def _summary(run: Run) -> list[str]:
    manifest = run.manifest
    origin = "synthetic data involved" if run.synthetic else "no synthetic data declared"
    lines = [
        f"{manifest['written']} {run.name}: {manifest['steps']} steps of {manifest['communication_step']:g} s, "
        f"mode {manifest['mode']}, {origin}"
    ]
    lines += [f"{'ended' if run.complete else 'stopped'}: {run.message}"] if run.message else []
    lines += [f"note: {text}" for text in manifest["warnings"]]
    lines += [
        f"{name}: {part['fmu']} sha256 {part['sha256'][:16]}" for name, part in manifest["components"].items()
    ]
    total = max(manifest["timing_s"]["total"], 1e-9)
    lines += [f"{name}: {s:.3f} s ({100 * s / total:.1f} %)" for name, s in manifest["timing_s"].items()]
    return lines
