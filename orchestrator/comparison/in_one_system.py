"""Several friction models in one system, without measurements: their runs laid over each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from fmus.runtime.errors import SimulationError
from fmus.runtime.fmu_files import describe
from fmus.runtime.friction_names import FrictionNames
from friction_models.common import InputError
from friction_models.loads import LOADS

from ..cosim.local_errors import StatedError, forming_with_elements, state_local_errors, stated_errors
from ..cosim.master import Master
from ..cosim.run_folders import Run
from ..cosim.swapping import friction_component, swap_model, takes_loads
from ..cosim.system import System
from ..force_curves.forces import (
    SAMPLES,
    WINDOW,
    ForceComparison,
    ForceCurve,
    LevelsComparison,
    compare_force,
    levels_table,
)
from ..jobs.job import Files, Inputs, Job, Needs, Progress
from .contact_course import ContactCourse, PointHistory, contact_course, point_history, shown_points
from .study_folder import RUN, run_jobs, study_folder

#: The run without friction, which the others are held against; no model may be called so.
REFERENCE = "without friction"


@dataclass(frozen=True)
class Totals:
    """What a run comes to on the stroke that all runs cover."""

    max_force: float  # the largest, of the moving mean [kN]
    work: float  # of the punch [J]
    #: The part of the work that is there because of friction: one minus the work of the run without friction over this
    #: one; None where that run failed.
    friction_share: float | None


@dataclass(frozen=True)
class RunsComparison:
    """Runs of one system with several friction models, by their labels.

    Examples
    --------
    >>> curve = ForceCurve([0.0, 10.0], [0.0, 100.0])
    >>> totals = {"0.08": Totals(100.0, 500.0, 0.2), "law": Totals(110.0, 550.0, None)}
    >>> found = RunsComparison("rod", {"0.08": curve, "law": curve}, totals, {"0.08": [], "law": []}, (0.0, 10.0))
    >>> print(found.report())
    rod: stroke 0.00 to 10.00 mm, moving mean 0.5 mm
                  max force [kN]             work [J]           by friction
    0.08                  100.00                500.0                20.0 %
    law                   110.00  +10.0 %       550.0  +10.0 %            -
    """

    system: str
    curves: Mapping[str, ForceCurve]
    totals: Mapping[str, Totals]
    points: Mapping[str, Sequence[PointHistory]]  # the same in every run; none without contact points
    stroke: tuple[float, float]  # that all runs cover [mm]
    failed: Mapping[str, str] = field(default_factory=dict)  # why a run failed
    notes: Mapping[str, str] = field(default_factory=dict)  # that a component ended it early
    synthetic: bool = False
    #: Along the contact at every stroke; none for a process without contact points.
    contact: Mapping[str, ContactCourse] = field(default_factory=dict)
    #: How far the loads may be off, where that was asked.
    errors: Mapping[str, Sequence[StatedError]] = field(default_factory=dict)
    #: The run against a measured force curve, where there is one.
    press: Mapping[str, ForceComparison] = field(default_factory=dict)

    def against(self, measured: Sequence[ForceCurve]) -> RunsComparison:
        """Return the comparison with the runs held against the repeats of a press curve, too."""
        found = {label: compare_force(curve, measured, label) for label, curve in self.curves.items()}
        return replace(self, press=found)

    def to_dict(self) -> dict[str, object]:
        """Return JSON-able data: totals, force over stroke, loads and mu at the points."""
        return {
            "synthetic": self.synthetic,
            "system": self.system,
            "stroke_mm": list(self.stroke),
            "models": [
                {
                    "label": label,
                    "max_force_kN": total.max_force,
                    "work_J": total.work,
                    "friction_share": total.friction_share,
                    "stroke_mm": self.curves[label].stroke,
                    "force_kN": self.curves[label].force,
                    "points": [
                        {"point": p.point, "stroke_mm": p.stroke, **p.values} for p in self.points[label]
                    ],
                }
                | ({"press": self.press[label].to_dict()} if label in self.press else {})
                | (
                    {"stated_errors": [e._asdict() for e in self.errors[label]]}
                    if label in self.errors
                    else {}
                )
                for label, total in self.totals.items()
            ],
            "failed": [{"model": label, "error": error} for label, error in self.failed.items()],
            "remarks": self.remarks(),
        }

    def remarks(self) -> list[str]:
        """Return a sentence for each run that failed or ended early."""
        lost = [f"{label} failed: {error[:300]}" for label, error in self.failed.items()]
        return [*lost, *(f"{label}: {text}" for label, text in self.notes.items())]

    def report(self) -> str:
        """Return the table."""
        width = max([12, *(len(label) + 2 for label in self.totals)])
        first = next(iter(self.totals.values()), None)
        rows = [
            f"{self.system}: stroke {self.stroke[0]:.2f} to {self.stroke[1]:.2f} mm, moving mean {WINDOW:g} mm",
            f"{'':{width}}{'max force [kN]':>16}{'':>9}{'work [J]':>12}{'':>9}{'by friction':>13}",
        ]
        for label, total in self.totals.items():
            share = "-" if total.friction_share is None else f"{100 * total.friction_share:.1f} %"
            cells = ["", ""]
            if first is not None and total is not first:
                pairs = (total.max_force, first.max_force), (total.work, first.work)
                cells = [f"{100 * (this / that - 1):+.1f} %" if that else "" for this, that in pairs]
            rows.append(
                f"{label:{width}}{total.max_force:16.2f}{cells[0]:>9}{total.work:12.1f}{cells[1]:>9}{share:>13}"
            )
        if self.press:
            rows += ["", levels_table([LevelsComparison(n, (c,)) for n, c in self.press.items()])]
        for label, errors in self.errors.items():
            rows.append(f"{label}: stated errors of the loads, median, and below which 9 of 10 are")
            rows += [error.line() for error in errors]
        return "\n".join([*rows, *self.remarks()])


def compare_in_system(
    system: System,
    models: Mapping[str, str],
    runs: Path | None = None,
    names: Mapping[str, FrictionNames] | None = None,
    mode: str = "gauss_seidel",
    jobs: int | None = None,
    progress: Progress | None = None,
    local_errors: bool = False,
) -> RunsComparison:
    """Run a system with each friction model, and once without friction; a run that fails does not stop the others.

    A component of `system` takes loads and gives mu, another one publishes ``stroke`` and ``force``. `models` are by label
    a model folder, an ``.fmu`` or ``.onnx`` file, or a number for constant mu; `names`, by label, the variables of FMUs
    that call the loads otherwise. FMUs and runs are kept in the folder `runs` (a temporary one by default), where
    ``runs.json`` says which is which; runs of the same content are taken from there. With `local_errors` each model runs
    once more with smaller elements, which states how far the loads at the contact points may be off.

    Raises InputError where a model cannot be packed or does not fit, SimulationError where every run failed.
    """
    component = friction_component(system)
    process = _process(system, component)
    with study_folder(runs) as place:
        todo = []
        called: dict[str, FrictionNames] = {}
        for number, (label, model) in enumerate({**models, REFERENCE: "0"}.items(), 1):
            called[label] = (names or {}).get(label) or FrictionNames()
            packed = place / f"friction-{number}.fmu"
            other = _recording(
                swap_model(system, component, model, (names or {}).get(label), packed), process, called[label]
            )
            other.validate()
            inputs: dict[str, object] = {
                "system": other.to_dict(dict.fromkeys(other.components, "")),
                "mode": mode,
            }
            if local_errors and label != REFERENCE:
                inputs["local_errors"] = True
            files = {name: other.fmu_path(name) for name in other.components}
            todo.append(Job(label, f"{__name__}:run_system", inputs, files, seconds=0.1 * other.steps))
        results, failures = run_jobs(place, todo, jobs, progress)
        found = {label: Run.load(result.folder / RUN) for label, result in results.items()}
        failed = {label: failure.error for label, failure in failures.items()}
        compared = _compared(system, component, process, found, called, failed)
        unknown = {
            label: str(results[label].values["errors"])
            for label in compared.totals
            if local_errors and label not in compared.errors and results[label].values["errors"]
        }
        return replace(compared, notes={**unknown, **compared.notes})


def run_system(inputs: Inputs, files: Files, needs: Needs, folder: Path) -> dict[str, object]:
    """Run a system into a folder; the function of the jobs of `compare_in_system`."""
    content = dict(inputs["system"])
    content["components"] = {n: c | {"fmu": str(files[n])} for n, c in content["components"].items()}
    master = Master(System.from_dict(content), mode=str(inputs["mode"]))
    if inputs.get("local_errors"):  # what cannot be stated is refused before it runs
        forming_with_elements(master)
    run = master.run(folder / RUN)
    said = state_local_errors(run, master) if inputs.get("local_errors") and not run.message else ""
    return {"steps": int(run.manifest["steps"]), "timing": dict(run.manifest["timing_s"]), "errors": said}


def _process(system: System, friction: str) -> str:
    """Return the component that publishes force and stroke; every model replaces the FMU of `friction`, which need not exist."""
    for name in system.components:
        if name != friction and {"force", "stroke"} <= set(describe(system.fmu_path(name)).arrays):
            return name
    raise InputError(
        f"{system.source}: no component has the outputs 'force' and 'stroke'; allowed: a forming process that has"
    )


def _recording(system: System, process: str, names: FrictionNames) -> System:
    """Add what is compared to what a system records."""
    if system.record is None:
        return system
    known = describe(system.fmu_path(process)).arrays
    shown = ("stroke", "force", "active", "r", "z", *(q.name for q in LOADS))
    wanted = [f"{process}.{n}" for n in shown if n in known]
    wanted += [f"{n}.{names.mu}" for n in system.components if takes_loads(system, n)]
    return system.changed(record=list(dict.fromkeys([*system.record, *wanted])))


def _compared(
    system: System,
    component: str,
    process: str,
    runs: Mapping[str, Run],
    called: Mapping[str, FrictionNames],
    failed: Mapping[str, str],
) -> RunsComparison:
    labels = [label for label in called if label in runs and label != REFERENCE]
    if not labels:
        said = "; ".join(f"{label}: {error[:300]}" for label, error in list(failed.items())[:3])
        raise SimulationError(f"no run of {system.source} came to its end: {said}")
    curves = {n: ForceCurve(r[f"{process}.stroke"], r[f"{process}.force"]) for n, r in runs.items()}
    start, end = max(c.stroke[0] for c in curves.values()), min(c.stroke[-1] for c in curves.values())
    if not end > start:
        raise SimulationError(f"{system.source}: the runs have no stroke in common")
    grid = np.linspace(start, end, SAMPLES)
    work = {label: curve.work(start, end) for label, curve in curves.items()}
    totals = {}
    for label in labels:
        share = 1.0 - work[REFERENCE] / work[label] if REFERENCE in work and work[label] > 0.0 else None
        totals[label] = Totals(float(curves[label].on(grid).max()), work[label], share)
    chosen = shown_points(runs[labels[0]], process)
    histories = {
        label: [point_history(runs[label], process, f"{component}.{called[label].mu}", k) for k in chosen]
        for label in labels
    }
    return RunsComparison(
        system.name,
        {label: curves[label] for label in labels},
        totals,
        histories,
        (float(start), float(end)),
        failed,
        {label: runs[label].message for label in labels if runs[label].message},
        any(run.synthetic for run in runs.values()),
        {
            label: course
            for label in labels
            if (course := contact_course(runs[label], process, f"{component}.{called[label].mu}")) is not None
        },
        {label: stated for label in labels if (stated := stated_errors(runs[label]))},
    )
