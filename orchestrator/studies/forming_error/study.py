"""Forming error: how far each friction model is from the press, at every level, for both processes and lubricants."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from friction_models.common import InputError
from friction_models.common.cached_results import path_digest

from ...comparison.level_runs import level_job
from ...jobs.graph import JobResult
from ..forming_jobs import synthetic
from ..measurements import FULL_PLAN, QUICK_PLAN, VIRTUAL, data_jobs, data_name
from ..models import ADVANCED, CONSTANTS, constant_job, model_job, model_name
from ..press_levels import StudyLevel, own_levels, virtual_levels
from ..study import Study

#: Punch travel [mm]: the rod passes its steady force, the cup is as deep as the virtual press draws it.
STROKES = {"fre": 20.0, "bce": 12.0}
QUICK_STROKES = {"fre": 5.0, "bce": 3.0}


@dataclass(frozen=True)
class Plan:
    """What the study runs."""

    models: tuple[str, ...] = ADVANCED  # families that are trained
    constants: tuple[float, ...] = CONSTANTS  # coefficients of friction beside them
    #: Tool temperature [degC] and punch speed [mm/s] of the virtual press.
    conditions: tuple[tuple[float, float], ...] = ()
    strokes: Mapping[str, float] = field(default_factory=lambda: dict(STROKES))  # by process [mm]
    lubricants: tuple[str, ...] = VIRTUAL
    tests: str = FULL_PLAN  # plan of the compression tests of the virtual laboratory
    repeats: int = 5  # strokes of the press a level
    seed: int = 0  # of the virtual laboratory

    @classmethod
    def full(cls, seed: int = 0) -> Plan:
        """Return the size of the paper: 252 pairs of level and friction."""
        from sct_twin.virtual_lab.press import NINE_LEVELS

        return cls(conditions=NINE_LEVELS, seed=seed)

    @classmethod
    def quick(cls, seed: int = 0) -> Plan:
        """Return a size that only shows the way: one lubricant, two models, two levels, short strokes."""
        return cls(
            models=("linear", "polynomial"),
            conditions=((20.0, 5.0), (100.0, 100.0)),
            strokes=dict(QUICK_STROKES),
            lubricants=VIRTUAL[:1],
            tests=QUICK_PLAN,
            seed=seed,
        )

    def frictions(self) -> tuple[Friction, ...]:
        """Return the friction laws: constants, then trained models."""
        constants = (Friction(f"constant {mu:g}", True) for mu in self.constants)
        return (*constants, *(Friction(family, False) for family in self.models))

    def to_dict(self) -> dict[str, object]:
        """Return plain data."""
        return {
            "models": list(self.models),
            "constants": list(self.constants),
            "strokes_mm": dict(self.strokes),
            "lubricants": list(self.lubricants),
            "tests": self.tests,
            "repeats": self.repeats,
            "seed": self.seed,
        }


@dataclass(frozen=True)
class Friction:
    """A friction law as the study names it, a family or a constant that does not follow from the measurements."""

    label: str
    constant: bool


@dataclass(frozen=True)
class FormingErrorStudy(Study[Plan]):
    """The study as jobs, and the names to find their results by."""

    virtual: bool  # whether virtual laboratory and press stand in for measurements of one's own
    levels: tuple[StudyLevel, ...]
    name = "forming-error"

    @property
    def frictions(self) -> tuple[Friction, ...]:
        """The friction laws: constants, then trained models."""
        return self.plan.frictions()

    @classmethod
    def of(
        cls,
        plan: Plan,
        data: Mapping[str, Path] | None = None,
        press: Sequence[tuple[str, Path]] | None = None,
    ) -> FormingErrorStudy:
        """Plan the study.

        `data` are one's own data sets by lubricant, `press` one's own press curves of the same lubricants
        (`press_levels.chosen_press`); without both the virtual laboratory measures.
        """
        if bool(data) != bool(press):
            given, other = ("--data", "--press") if data else ("--press", "--data")
            raise InputError(
                f"{given} without {other}: models of one lubricant cannot be judged by press curves of another; "
                "allowed: both, or neither (the virtual laboratory then supplies both, labelled synthetic)"
            )
        if data and press:
            plan = replace(plan, lubricants=tuple(data))
            levels, jobs = own_levels(press, plan.lubricants, plan.strokes)
        else:
            levels, jobs = virtual_levels(
                plan.lubricants, plan.conditions, plan.strokes, plan.repeats, plan.seed
            )
        measuring = data_jobs(data, plan.lubricants, plan.tests, plan.seed)
        constants = [constant_job(mu) for mu in plan.constants]
        models = [model_job(family, data_name(name)) for name in plan.lubricants for family in plan.models]
        runs = []
        for item in levels:
            laws = [job.name for job in constants] + [trained_name(item.lubricant, f) for f in plan.models]
            runs += [
                level_job(run_name(item, friction), item.level, law)
                for friction, law in zip(plan.frictions(), laws)
            ]
        # What takes long and needs nothing comes first; runs follow as their models are ready.
        every = [
            *(job for jobs_of in measuring.values() for job in jobs_of),
            *constants,
            *models,
            *jobs,
            *runs,
        ]
        return cls(plan, tuple(every), not press, tuple(levels))

    def synthetic(self, results: Mapping[str, JobResult]) -> bool:
        """Return whether any measurement is synthetic: of this study, or data of one's own that say so."""
        names = {data_name(lubricant) for lubricant in self.plan.lubricants}
        data = {name: result for name, result in results.items() if name in names}
        return any(item.synthetic for item in self.levels) or synthetic(data)

    def settings(self, results: Mapping[str, JobResult]) -> dict[str, object]:
        """Return what the manifest says of the study: sizes, levels, and hashes of one's own press curves."""
        levels = [
            {
                "lubricant": item.lubricant,
                "level": item.level.name,
                "stroke_mm": item.level.stroke,
                **({} if item.file is None else {"press_sha256": path_digest(item.file)}),
            }
            for item in self.levels
        ]
        plan = self.plan.to_dict()
        if not self.virtual:  # what only the virtual laboratory has
            plan = {k: v for k, v in plan.items() if k not in ("tests", "repeats", "strokes_mm")}
        return {**plan, "synthetic": self.synthetic(results), "levels": levels}


def run_name(item: StudyLevel, friction: Friction) -> str:
    """Return the name of the job that forms a level with a friction law."""
    return f"run-{item.lubricant}-{item.level.name}-{friction.label.replace(' ', '-')}"


def trained_name(lubricant: str, family: str) -> str:
    """Return the name of the job that trains a family for a lubricant."""
    return model_name(family, data_name(lubricant))
