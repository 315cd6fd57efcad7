"""The loop of the demo, step by step; every step is kept and reused when its inputs are the same."""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from friction_models import ConstantFriction, evaluate, load_model, make_model
from friction_models.common import InputError, grown, write_json
from friction_models.common.cached_results import path_digest
from friction_models.common.files import read_json
from friction_models.common.folders import DEMO
from friction_models.common.imports.extras import need
from friction_models.discovery import diagnose, refine
from friction_models.loads import DataSet
from friction_models.training import train

from ..comparison.level_runs import outside_domain
from ..cosim.batch import RunTask, run_all
from ..cosim.ready_made import extrusion_system
from ..cosim.run_folders import Run
from ..force_curves.forces import LevelsComparison, LevelsNumbers, compare_force, read_press_curve
from ..jobs.job import Progress
from ..jobs.keys import ResultKeys
from ..jobs.versions import versions
from ..prediction.predict_sct import PredictionNumbers
from ..report.sections.demo_folder import DemoSummary, FrictionEntry, RunFacts, SettlingRound
from .prediction import PARTS, predict_held_out
from .scenario import Scenario
from .settling_tests import FURTHER, SETTLED, all_tests, settle

if TYPE_CHECKING:
    from ..report.sections.evidence import DiagnosisNumbers

#: Opens the progress display of a step: ``with display("title") as tick: tick(done, total, what)``.
Display = Callable[[str], AbstractContextManager[Progress]]
STEPS = 11


class _Step(TypedDict):
    """A finished step, as ``steps.json`` holds it: the key of its inputs, how long it took [s], the hashes of its outputs."""

    key: str
    seconds: float
    sha256: dict[str, str]


@dataclass(frozen=True)
class DemoResult:
    """Where the demo wrote and what came out."""

    folder: Path
    report: Path
    summary: DemoSummary


class Demo:
    """The whole loop in one folder.

    `jobs` are processes, all cores by default; `display` is the progress display of each step.
    """

    def __init__(
        self,
        out: str | os.PathLike[str],
        scenario: Scenario | None = None,
        jobs: int | None = None,
        display: Display | None = None,
    ) -> None:
        self.out = Path(out)
        self.scenario = scenario or Scenario()
        self.jobs = jobs
        self._display = display or (lambda title: nullcontext(lambda done, total, what: None))
        self._step = 0
        self._chain = ""
        self._keys = ResultKeys(__package__)
        self._steps: dict[str, _Step] = {}

    def run(self) -> DemoResult:
        """Do all steps that are not done yet; write ``demo.json`` and ``report.html``."""
        self._check_libraries()
        from ..report import write_report

        grown(self.out, DEMO)
        with contextlib.suppress(InputError):  # not there or unreadable: everything is done
            self._steps = read_json(self.out / "steps.json")
        s = self.scenario
        self._do(
            "campaign", {"plan": s.plan, "hidden": s.hidden, "seed": s.seed}, ["campaign"], self._campaign
        )
        levels = [asdict(level) for level in s.levels]
        self._do(
            "press", {"levels": levels, "stroke": s.stroke, "repeats": s.repeats}, ["press"], self._press
        )
        self._do("twin", {}, ["data"], self._twin)
        training = {"base": s.base, "other": s.other, "parameters": s.other_parameters}
        self._do("train", training, ["models/before", "models/other"], self._train)
        self._do("diagnose", {}, ["diagnosis.json"], self._diagnose)
        self._do("settle", {}, [SETTLED, FURTHER], lambda tick: settle(self.out, s.seed, self.jobs, tick))
        settled = read_json(self.out / SETTLED)
        diagnosis: DiagnosisNumbers = settled["diagnosis"]
        rounds: list[SettlingRound] = settled["rounds"]
        parts = ["constant", "before", "other"]
        if diagnosis["effects"]:
            self._do(
                "refine", {}, ["models/after"], lambda tick: self._refine(diagnosis["effects"], len(rounds))
            )
            parts.append("after")
        else:
            self._step += 1
        self._do("pack", {"constant": s.constant}, ["fmus"], lambda tick: self._pack(parts))
        with self._title("co-simulate") as tick:
            runs = self._simulate(parts, tick)
        with self._title("predict unrun tests") as tick:
            labels = {part: self.label(part) for part in PARTS if part in parts}
            predicted = predict_held_out(self.out, DataSet.load(self.out / "data"), labels, self.jobs, tick)
        with self._title("report") as tick:
            summary = self._summarise(parts, runs, diagnosis, rounds, predicted)
            write_json(self.out / "demo.json", summary)
            report = write_report(self.out)
            tick(1, 1, "")
        return DemoResult(self.out, report, summary)

    def _check_libraries(self) -> None:
        """Say at once what a later step lacks, not after minutes of work."""
        need("numba", "solvers", "the demo")
        need("plotly", "reports", "the demo")
        trained = (self.out / "models" / "other").exists()
        if not trained and "ffnn" in (self.scenario.base, self.scenario.other):
            need("torch", "train-networks", "the demo, which trains a neural network,")

    # --- steps ------------------------------------------------------------------------------------

    def _campaign(self, tick: Progress) -> None:
        from sct_twin import virtual_lab

        s = self.scenario
        virtual_lab.Campaign(plan=s.plan, hidden=s.hidden, seed=s.seed).run(
            out=self.out / "campaign", jobs=self.jobs, progress=tick
        )

    def _press(self, tick: Progress) -> None:
        from sct_twin.virtual_lab.press import press_curves

        s = self.scenario
        press_curves(
            self.out / "campaign",
            [(level.T_tool, level.speed) for level in s.levels],
            self.out / "press",
            stroke=s.stroke,
            repeats=s.repeats,
            seed=s.seed,
            jobs=self.jobs,
            progress=tick,
        )

    def _twin(self, tick: Progress) -> None:
        from sct_twin import SctTwin

        SctTwin().run(self.out / "campaign", out=self.out / "data", jobs=self.jobs, progress=tick)

    def _train(self, tick: Progress) -> None:
        s, data = self.scenario, DataSet.load(self.out / "data")
        for number, (part, family, parameters) in enumerate(
            (("before", s.base, {}), ("other", s.other, s.other_parameters))
        ):
            tick(number, 2, family)
            model = make_model(family, **parameters)
            train(model, data)
            model.save(self.out / "models" / part)
        tick(2, 2, "")

    def _diagnose(self, tick: Progress) -> None:
        data = DataSet.load(self.out / "data").select("train")
        model = load_model(self.out / "models" / "before")
        diagnosis = diagnose(data.points, data.tests, model=model, seed=self.scenario.seed)
        write_json(self.out / "diagnosis.json", diagnosis.to_dict())
        tick(1, 1, diagnosis.verdict)

    def _refine(self, effects: list[str], rounds: int) -> None:
        data = all_tests(self.out, rounds)
        better = refine(
            data.points, data.tests, model=load_model(self.out / "models" / "before"), add=effects
        )
        for role, measures in evaluate(better, DataSet.load(self.out / "data")).roles.items():
            better.record_errors(role, measures)
        better.save(self.out / "models" / "after")

    def _pack(self, parts: list[str]) -> None:
        from fmus import pack, pack_forming

        folder = self.out / "fmus"
        folder.mkdir(exist_ok=True)
        for level in self.scenario.levels:
            pack_forming(folder / f"{level.name}.fmu", speed=level.speed, T_tool=level.T_tool)
        for part in parts:
            model: Any = self.out / "models" / part
            if part == "constant":
                model = ConstantFriction(self.scenario.constant)
            pack(model, folder / f"{part}.fmu", nodes=80)
            if part in PARTS:
                pack(model, folder / f"{part}-point.fmu")

    def _simulate(self, parts: list[str], tick: Progress) -> dict[tuple[str, str], Run]:
        s = self.scenario
        pairs = [(part, level) for part in parts for level in s.levels]
        tasks = [
            RunTask(
                extrusion_system(
                    self.out / "fmus" / f"{part}.fmu",
                    self.out / "fmus" / f"{level.name}.fmu",
                    level.speed,
                    stroke=s.stroke,
                    name=f"{level.name}, {self.label(part)}",
                    synthetic=True,
                    provenance={"campaign_seed": s.seed, "plan": s.plan, "friction": self.label(part)},
                ),
                self.out / "runs" / f"{level.name}-{part}",
            )
            for part, level in pairs
        ]
        runs = run_all(tasks, self.jobs, tick)
        return {(part, level.name): run for (part, level), run in zip(pairs, runs)}

    # --- what came out ------------------------------------------------------------------------------

    def label(self, part: str) -> str:
        """Return the name of a friction model for readers."""
        s = self.scenario
        if part == "constant":
            return f"constant {s.constant:g}"
        if part == "after":
            return " + ".join([s.base, *read_json(self.out / SETTLED)["diagnosis"]["effects"]])
        return s.base if part == "before" else s.other

    def _summarise(
        self,
        parts: list[str],
        runs: dict[tuple[str, str], Run],
        diagnosis: DiagnosisNumbers,
        rounds: list[SettlingRound],
        predicted: dict[str, PredictionNumbers],
    ) -> DemoSummary:
        s, data = self.scenario, DataSet.load(self.out / "data")
        forces: dict[str, LevelsNumbers] = {}
        held_out: dict[str, dict[str, object]] = {}
        frictions: list[FrictionEntry] = []
        for part in parts:
            label = self.label(part)
            made = [runs[part, level.name] for level in s.levels]
            results = [
                compare_force(
                    run.force_curve(), read_press_curve(self.out / "press" / f"{level.name}.csv"), label
                )
                for run, level in zip(made, s.levels)
            ]
            forces[part] = LevelsComparison(label, tuple(results)).to_dict()
            model = (
                ConstantFriction(s.constant) if part == "constant" else load_model(self.out / "models" / part)
            )
            held_out[part] = {**evaluate(model, data.select("test")).overall}
            distances = [run["friction.domain_distance"][run["forming.active"] > 0.5] for run in made]
            entry: FrictionEntry = {
                "part": part,
                "label": label,
                "fmu": f"fmus/{part}.fmu",
                "runs": {level.name: f"runs/{level.name}-{part}" for level in s.levels},
                "outside_domain": outside_domain(np.concatenate(distances)),
            }
            if part != "constant":
                entry["folder"] = f"models/{part}"
            frictions.append(entry)
        tests = data.tests
        assert tests is not None
        return {
            "synthetic": True,
            "hidden": s.hidden,
            "seed": s.seed,
            "plan": s.plan,
            "base": s.base,
            "data": "data",
            "tests": {role: int((tests["role"] == role).sum()) for role in ("train", "test")},
            "levels": [
                {"name": level.name, "heading": level.heading, "press": f"press/{level.name}.csv"}
                for level in s.levels
            ],
            "frictions": frictions,
            "held_out": held_out,
            "forces": forces,
            "diagnosis": diagnosis,
            "rounds": rounds,
            "run_facts": {f"runs/{name}-{part}": _facts(run) for (part, name), run in runs.items()},
            "seconds": {name: float(step["seconds"]) for name, step in self._steps.items()},
            "versions": versions(),
            "predicted": predicted,
        }

    # --- bookkeeping --------------------------------------------------------------------------------

    def _title(self, name: str) -> AbstractContextManager[Progress]:
        self._step += 1
        return self._display(f"{self._step}/{STEPS} {name}")

    def _do(
        self, name: str, inputs: Mapping[str, object], outputs: list[str], work: Callable[[Progress], None]
    ) -> None:
        """Do a step with its progress display, unless it is done: same inputs, all steps before it, and outputs as it left them.

        `outputs` are files or folders, relative to the folder, that the step leaves behind. Their hashes tell what an
        interrupted run with other inputs has replaced.
        """
        with self._title(name) as tick:
            self._chain += f"/{name}{json.dumps(inputs, sort_keys=True)}"
            key = self._keys.of({"chain": self._chain})
            found = self._steps.get(name)
            kept = found is not None and found["key"] == key and found.get("sha256") == self._hashes(outputs)
            if not kept:
                began = time.perf_counter()
                work(tick)
                seconds = round(time.perf_counter() - began, 3)
                self._steps[name] = {"key": key, "seconds": seconds, "sha256": self._hashes(outputs)}
                write_json(self.out / "steps.json", self._steps)
            tick(1, 1, "kept from before" if kept else "")

    def _hashes(self, outputs: Sequence[str]) -> dict[str, str]:
        """Return the hash of each output that is there."""
        return {o: path_digest(self.out / o) for o in outputs if (self.out / o).exists()}


def _facts(run: Run) -> RunFacts:
    timing = run.manifest["timing_s"]
    return {
        "steps": run.manifest["steps"],
        "seconds": timing["total"],
        "share_friction": timing["friction"] / timing["total"],
        "master_us_per_step": 1e6 * timing["master"] / run.manifest["steps"],
        "max_tau_over_k": float(run["forming.max_tau_over_k"].max()),
        "friction_sha256": run.manifest["components"]["friction"]["sha256"],
    }
