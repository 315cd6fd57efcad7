"""Learning curves: how many sliding compression tests a friction model needs, by data collection."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from friction_models.common import InputError

from ...jobs.graph import Job
from ..measurements import FULL_PLAN, QUICK_PLAN, VIRTUAL, data_jobs, data_name, read_own
from ..models import ADVANCED
from ..study import Study
from .jobs import AVERAGE, MEAN, SERIES, FactsInputs, LearnInputs, Parameters, learn

#: Typical accuracy of a tribometer in mu: the limit of the paper.
ACCURACY = 0.01
SIZES = (2, 3, 5, 9, 13, 17, 21, 25, 30, 40, 50, 60, 70, 81)
COLLECTIONS = (SERIES, AVERAGE)
#: Sizes a job of gradient boosting: jobs of some ten seconds each.
BOOSTING_SIZES = 3
#: Values to try by data collection, model and parameter.
Grids = Mapping[str, Mapping[str, Mapping[str, list[Any]]]]
#: Parameters to search, by model and data collection; what is not named stays as `train` has it.
NETWORKS: dict[str, list[Any]] = {"hidden": [[8], [16, 16], [32, 32]], "weight_decay": [0.1, 1.0, 4.0]}
GRIDS: Grids = {
    SERIES: {"gradient_boosting": {"min_points": [6, 12, 36]}, "ffnn": NETWORKS},
    AVERAGE: {"gradient_boosting": {"min_points": [1, 2, 4]}, "ffnn": NETWORKS},
}
QUICK_NETWORKS: dict[str, list[Any]] = {"hidden": [[8], [16, 16]]}
QUICK_GRIDS: Grids = {
    SERIES: {"gradient_boosting": {"min_points": [12]}, "ffnn": QUICK_NETWORKS},
    AVERAGE: {"gradient_boosting": {"min_points": [2]}, "ffnn": QUICK_NETWORKS},
}
#: Expected CPU time [s] of one fit by model, and of starting a job; for estimates.
FIT_SECONDS = {MEAN: 0.01, "linear": 0.02, "polynomial": 0.02, "power_law": 0.02, "gradient_boosting": 0.25}
START_SECONDS = 2.0
#: The same of the networks of a size: search and ten repeats, and what each test of a time series adds.
NETWORK_SECONDS, NETWORK_SECONDS_A_TEST = 10.0, 0.45


@dataclass(frozen=True)
class LearningCurvePlan:
    """What the study fits."""

    sizes: tuple[int, ...] = SIZES  # numbers of training tests within the data; all of them are the last
    repeats: int = 10  # random orders in which the training set grows
    models: tuple[str, ...] = ADVANCED  # families; the mean of the training tests is always beside them
    thin: int = 1  # every so many points of a time series are learned from
    search_thin: int = 25  # in the search, of these again every so many
    steps: int = 3200  # of the optimiser of a network, whatever the size of the training set
    parameters: Parameters = field(default_factory=dict)  # other than those of `train`
    grids: Grids = field(default_factory=lambda: GRIDS)
    accuracy: float = ACCURACY  # error in mu that is asked for
    tests: str = FULL_PLAN  # plan of the virtual laboratory
    lubricants: tuple[str, ...] = VIRTUAL  # of the virtual laboratory
    seed: int = 0  # of the laboratory, of the training sets and of the models

    @classmethod
    def quick(cls, seed: int = 0) -> LearningCurvePlan:
        """Return a size that only shows the way: fewer tests, three sizes, three repeats, small grids."""
        return cls(
            (3, 9, 27), 3, thin=10, search_thin=5, steps=600, grids=QUICK_GRIDS, tests=QUICK_PLAN, seed=seed
        )

    def to_dict(self) -> dict[str, object]:
        """Return plain data."""
        return asdict(self)


@dataclass(frozen=True)
class LearningCurveStudy(Study[LearningCurvePlan]):
    """The study as jobs, and the names to find their results by."""

    curves: Mapping[tuple[str, str], tuple[str, ...]]  # names of jobs by lubricant and data collection
    facts: Mapping[str, str]  # names of the jobs that describe the data of a lubricant
    virtual: bool  # whether the virtual laboratory measures
    name = "learning-curve"
    seeds = "study"

    @classmethod
    def of(cls, plan: LearningCurvePlan, data: Mapping[str, Path] | None = None) -> LearningCurveStudy:
        """Plan the jobs, on one's own data sets by lubricant or on those of the virtual laboratory."""
        if data is not None:
            plan = replace(plan, lubricants=tuple(data))
        measured = data_jobs(data, plan.lubricants, plan.tests, plan.seed)
        counts = {name: _training_tests(plan, None if data is None else data[name]) for name in measured}
        study = cls.of_counts(plan, counts, virtual=data is None)
        return replace(study, jobs=(*(job for own in measured.values() for job in own), *study.jobs))

    @classmethod
    def of_counts(
        cls, plan: LearningCurvePlan, counts: Mapping[str, int], virtual: bool
    ) -> LearningCurveStudy:
        """Return the study without the jobs that measure, to find results by; `counts`: training tests by lubricant."""
        jobs: list[Job] = []
        curves: dict[tuple[str, str], tuple[str, ...]] = {}
        names: dict[str, str] = {}
        for lubricant, count in counts.items():
            sizes = [*(s for s in plan.sizes if s < count), count]
            names[lubricant] = f"facts-{lubricant}"
            jobs.append(_facts_job(plan, lubricant))
            for collection in COLLECTIONS:
                mine = _curve_jobs(plan, lubricant, collection, sizes)
                curves[lubricant, collection] = tuple(job.name for job in mine)
                jobs += mine
        return cls(plan, tuple(jobs), curves, names, virtual)


def _training_tests(plan: LearningCurvePlan, place: Path | None) -> int:
    """Return how many training tests there are, the largest size."""
    from sct_twin.virtual_lab.plans import parse_plan

    if place is None:
        return parse_plan(plan.tests)[0].count
    count = int(read_own(place, plan.seed).select("train").points["test_id"].nunique())
    if count < 2:
        raise InputError(f"{place}: {count} training test; allowed: two or more for a learning curve")
    return count


def _curve_jobs(plan: LearningCurvePlan, lubricant: str, collection: str, sizes: Sequence[int]) -> list[Job]:
    """Return the jobs of a data collection: quick models at once, boosting by a few sizes, networks size by size."""
    fast = [MEAN, *(m for m in plan.models if m not in {"gradient_boosting", "ffnn"})]
    work: list[tuple[str, list[str], Sequence[int]]] = [("fast", fast, sizes)]
    if "gradient_boosting" in plan.models:
        # Sizes far apart go together, so that the jobs take about as long.
        parts = -(-len(sizes) // BOOSTING_SIZES)
        work += [(f"gradient_boosting-{k + 1}", ["gradient_boosting"], sizes[k::parts]) for k in range(parts)]
    if "ffnn" in plan.models:
        # The largest first: they take longest.
        work += [(f"ffnn-{size}", ["ffnn"], [size]) for size in sorted(sizes, reverse=True)]
    return [_learning_job(plan, lubricant, collection, *one) for one in work]


def _learning_job(
    plan: LearningCurvePlan,
    lubricant: str,
    collection: str,
    label: str,
    models: list[str],
    sizes: Sequence[int],
) -> Job:
    grid = {m: dict(plan.grids[collection][m]) for m in models if m in plan.grids[collection]}
    fits = plan.repeats + (15 if grid else 0)
    seconds = START_SECONDS + len(sizes) * fits * sum(FIT_SECONDS.get(m, 0.0) for m in models)
    if "ffnn" in models:
        seconds += sum(_network_seconds(plan, collection, size) for size in sizes)
    inputs: LearnInputs = {
        "models": models,
        "collection": collection,
        "sizes": list(sizes),
        "repeats": plan.repeats,
        "seed": plan.seed,
        "thin": plan.thin,
        "search_thin": plan.search_thin,
        "grid": grid,
        "parameters": _parameters(plan, models),
    }
    name, needs = f"{lubricant}-{collection}-{label}", (data_name(lubricant),)
    return Job(name, f"{learn.__module__}:learn", inputs, needs=needs, seconds=seconds)


def _facts_job(plan: LearningCurvePlan, lubricant: str) -> Job:
    inputs: FactsInputs = {
        "models": list(plan.models),
        "parameters": _parameters(plan, plan.models),
        "thin": plan.thin,
        "seed": plan.seed,
    }
    seconds = START_SECONDS + _network_seconds(plan, AVERAGE, 0)
    needs = (data_name(lubricant),)
    return Job(f"facts-{lubricant}", f"{learn.__module__}:facts", inputs, needs=needs, seconds=seconds)


def _network_seconds(plan: LearningCurvePlan, collection: str, size: int) -> float:
    length = size * 5 / plan.thin if collection == SERIES else 0.0
    work = NETWORK_SECONDS + NETWORK_SECONDS_A_TEST * length
    return work * plan.steps / 3200 * (5 + plan.repeats) / 15


def _parameters(plan: LearningCurvePlan, models: Sequence[str]) -> Parameters:
    given = {
        m: dict(plan.parameters.get(m, {})) | ({"steps": plan.steps} if m == "ffnn" else {}) for m in models
    }
    return {m: parameters for m, parameters in given.items() if parameters}
