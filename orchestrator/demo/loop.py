"""The loop of the demo, step by step; every step is kept and reused when its inputs are the same."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from friction_models.common import grown, write_json
from friction_models.common.folders import DEMO
from friction_models.loads import DataSet

from ..cosim.batch import RunTask, run_all
from ..cosim.ready_made import extrusion_system
from ..cosim.run_folders import Run
from ..force_curves.forces import LevelsComparison, LevelsNumbers, compare_force, read_press_curve
from ..jobs.job import Progress
from ..jobs.versions import versions
from ..prediction.predict_sct import PredictionNumbers
from ..report.sections.demo_folder import DemoSummary, FrictionEntry, RunFacts
from .prediction import PARTS, predict_held_out
from .scenario import Scenario
from .steps import StepBook

#: Opens the progress display of a step: ``with display("title") as tick: tick(done, total, what)``.
Display = Callable[[str], AbstractContextManager[Progress]]
STEPS = 10


@dataclass(frozen=True)
class DemoResult:
    """Where the demo wrote and what came out."""

    folder: Path
    report: Path
    summary: DemoSummary


class Demo:
    """The whole loop in one folder.

    Parameters
    ----------
    out : path-like
        Folder of the demo.
    scenario : Scenario, optional
        Plan, models, levels.
    jobs : int, optional
        Processes; all cores by default.
    display : callable, optional
        Progress display of each step.
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

    def run(self) -> DemoResult:
        """Do all steps that are not done yet; write ``demo.json`` and ``report.html``."""
        from ..report import write_report

        grown(self.out, DEMO)
        self.book = StepBook(self.out)
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
        diagnosis = json.loads((self.out / "diagnosis.json").read_text(encoding="utf-8"))
        parts = ["constant", "before", "other"]
        if diagnosis["effects"]:
            self._do("refine", {}, ["models/after"], lambda tick: self._refine(diagnosis["effects"]))
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
            summary = self._summarise(parts, runs, diagnosis, predicted)
            write_json(self.out / "demo.json", summary)
            report = write_report(self.out)
            tick(1, 1, "")
        return DemoResult(self.out, report, summary)

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
        from friction_models import make_model
        from friction_models.training import train

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
        from friction_models import load_model
        from friction_models.discovery import diagnose

        data = DataSet.load(self.out / "data").select("train")
        model = load_model(self.out / "models" / "before")
        diagnosis = diagnose(data.points, data.tests, model=model, seed=self.scenario.seed)
        write_json(self.out / "diagnosis.json", {**diagnosis.to_dict(), "sentence": diagnosis.sentence})
        tick(1, 1, diagnosis.verdict)

    def _refine(self, effects: list[str]) -> None:
        from friction_models import evaluate, load_model
        from friction_models.discovery import refine

        data = DataSet.load(self.out / "data")
        better = refine(
            data.points, data.tests, model=load_model(self.out / "models" / "before"), add=effects
        )
        for role, measures in evaluate(better, data).roles.items():
            better.record_errors(role, measures)
        better.save(self.out / "models" / "after")

    def _pack(self, parts: list[str]) -> None:
        from fmus import pack, pack_forming
        from friction_models import ConstantFriction

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
            diagnosis = json.loads((self.out / "diagnosis.json").read_text(encoding="utf-8"))
            return " + ".join([s.base, *diagnosis["effects"]])
        return s.base if part == "before" else s.other

    def _summarise(
        self,
        parts: list[str],
        runs: dict[tuple[str, str], Run],
        diagnosis: dict[str, object],
        predicted: dict[str, PredictionNumbers],
    ) -> DemoSummary:
        from friction_models import ConstantFriction, evaluate, load_model

        s, data = self.scenario, DataSet.load(self.out / "data")
        forces: dict[str, LevelsNumbers] = {}
        held_out: dict[str, dict[str, object]] = {}
        frictions: list[FrictionEntry] = []
        for part in parts:
            results = [
                compare_force(runs[part, level.name].force_curve(), read_press_curve(self._press_file(level.name)), self.label(part))
                for level in s.levels
            ]  # fmt: skip
            forces[part] = LevelsComparison(self.label(part), tuple(results)).to_dict()
            model = (
                ConstantFriction(s.constant) if part == "constant" else load_model(self.out / "models" / part)
            )
            held_out[part] = evaluate(model, data.select("test")).overall
            entry: FrictionEntry = {
                "part": part,
                "label": self.label(part),
                "fmu": f"fmus/{part}.fmu",
                "runs": {level.name: f"runs/{level.name}-{part}" for level in s.levels},
                "outside_domain": _outside([runs[part, level.name] for level in s.levels]),
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
            "run_facts": {f"runs/{name}-{part}": _facts(run) for (part, name), run in runs.items()},
            "seconds": self.book.seconds,
            "versions": versions(),
            "predicted": predicted,
        }

    def _press_file(self, level: str) -> Path:
        return self.out / "press" / f"{level}.csv"

    # --- bookkeeping --------------------------------------------------------------------------------

    def _title(self, name: str) -> AbstractContextManager[Progress]:
        self._step += 1
        return self._display(f"{self._step}/{STEPS} {name}")

    def _do(
        self, name: str, inputs: Mapping[str, object], outputs: list[str], work: Callable[[Progress], None]
    ) -> None:
        """Do a step with its progress display; it depends on all steps before it."""
        with self._title(name) as tick:
            self._chain = f"{getattr(self, '_chain', '')}/{name}{json.dumps(inputs, sort_keys=True)}"
            if not self.book.do(name, {"chain": self._chain}, outputs, lambda: work(tick)):
                tick(1, 1, "kept from before")
            else:
                tick(1, 1, "")


def _outside(runs: list[Run]) -> dict[str, float]:
    """Active contact points, over all steps of all runs, outside the trained domain: share and median distance."""
    parts = [run["friction.domain_distance"][run["forming.active"] > 0.5] for run in runs]
    distance = np.concatenate(parts)
    outside = distance[distance > 0.0]
    return {
        "share": len(outside) / max(len(distance), 1),
        "median_distance": float(np.median(outside)) if len(outside) else 0.0,
    }


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
