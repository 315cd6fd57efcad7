"""The study ``extrapolation``: how friction models behave where forming asks beyond what they were trained on.

Each model is trained twice, on all training tests and on the half of the plan with low pressure and
temperature, and each then forms twice: with loads clamped to the trained domain and without.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from friction_models.common import InputError
from friction_models.loads import LOADS, FloatArray
from friction_models.models.domain import Domain

from .contact import Contact, exceedance, reference_areas, spread
from .coupled import check_names, chosen_level, coupled_job, run_of
from .measurements import FULL_PLAN, QUICK_PLAN, data_jobs, data_name
from .models import ADVANCED, load_data, model_job

if TYPE_CHECKING:
    from ..jobs.campaign import Job, JobResult

DATA_KINDS = ("all", "reduced")
#: Value of the FMU's parameter ``clamp_to_domain``.
RULES = {"clamp": True, "extrapolate": False}
#: Loads whose upper half of the tested range is left out of the reduced training data.
REDUCED_BY = ("sigma_n", "T")
#: Fewest tests of a reduced training set.
FEWEST = 4
STEP = 0.1


@dataclass(frozen=True)
class ExtrapolationStudy:
    """What is compared.

    Attributes
    ----------
    models : sequence of str
        Families.
    processes : sequence of str
    levels : sequence of (float, float)
        Tool temperature [degC] and punch speed [mm/s].
    stroke : float or None
        Punch travel [mm]; None for that of a usual run.
    lubricant, plan : str
        Of the virtual laboratory.
    seed : int
    """

    models: Sequence[str] = ADVANCED
    processes: Sequence[str] = ("fre", "bce")
    levels: Sequence[tuple[float, float]] = ((20.0, 5.0), (100.0, 100.0))
    stroke: float | None = None
    lubricant: str = "polymer"
    plan: str = FULL_PLAN
    seed: int = 0

    def __post_init__(self) -> None:
        check_names(self.models, self.processes)

    @classmethod
    def quick(cls) -> ExtrapolationStudy:
        """Return the quick size: two models, one level, short strokes."""
        return cls(("linear", "polynomial"), ("fre", "bce"), ((20.0, 50.0),), 3.0, plan=QUICK_PLAN)

    def jobs(self, data: Mapping[str, Path] | None = None) -> list[Job]:
        """Return all jobs: measurements, both training sets, models, runs."""
        from ..jobs.campaign import Job

        ((lubricant, jobs),) = data_jobs(data, (self.lubricant,), self.plan, self.seed).items()
        whole = data_name(lubricant)
        reduced = Job(f"{whole}-reduced", f"{__name__}:reduce", needs=(whole,), seconds=3.0)
        jobs.append(reduced)
        for family in self.models:
            for kind, source in zip(DATA_KINDS, (whole, reduced.name)):
                model = model_job(family, source)
                jobs.append(model)
                for process, level in self._levels():
                    for rule, clamped in RULES.items():
                        name = _name(process, level.name, family, kind, rule)
                        start = {"clamp_to_domain": clamped}
                        jobs.append(
                            coupled_job(
                                name,
                                level,
                                model.name,
                                step=STEP,
                                start=start,
                                label=f"{family}, {kind}, {rule}",
                            )
                        )
        return jobs

    def _levels(self) -> list[tuple[str, Any]]:
        return [
            (process, chosen_level(process, self.stroke, STEP, speed, T_tool))
            for process in self.processes
            for T_tool, speed in self.levels
        ]

    def evaluate(
        self, results: Mapping[str, JobResult], data: Mapping[str, Path] | None = None
    ) -> dict[str, Any]:
        """Return all numbers of the study; runs that broke off say so.

        Returns
        -------
        dict
            ``runs``: one a model, training set, rule and level; ``pairs``: clamped against extrapolated;
            ``domains``: trained ranges; ``settings``, ``synthetic``.
        """
        (lubricant,) = data or (self.lubricant,)
        whole = data_name(lubricant)
        sources = dict(zip(DATA_KINDS, (whole, f"{whole}-reduced")))
        runs: list[dict[str, Any]] = []
        domains: dict[str, Any] = {}
        models: list[dict[str, Any]] = []
        areas = {process: reference_areas(level) for process, level in self._levels()[:: len(self.levels)]}
        for family in self.models:
            for kind in DATA_KINDS:
                model = results.get(f"model-{family}-{sources[kind]}")
                if model is None:
                    continue
                domains[kind] = model.values["domain"]
                models.append(
                    {
                        "model": family,
                        "data": kind,
                        **{k: model.values[k] for k in ("points", "tests", "mae_test", "rmse_test")},
                    }
                )
                domain = Domain.from_dict(model.values["domain"])
                for process, level in self._levels():
                    for rule in RULES:
                        row = {
                            "process": process,
                            "level": level.name,
                            "model": family,
                            "data": kind,
                            "rule": rule,
                        }
                        result = results.get(_name(process, level.name, family, kind, rule))
                        runs.append(row | _numbers(result, domain, areas[process]))
        return {
            "settings": {
                "models": list(self.models),
                "processes": list(self.processes),
                "levels": [{"T_tool_degC": t, "speed_mm_s": v} for t, v in self.levels],
                "stroke_mm": {level.name: level.stroke for _, level in self._levels()},
                "communication_step_mm": STEP,
                "lubricant": lubricant,
                "reduced_by": list(REDUCED_BY),
            },
            "synthetic": any(bool(r.values.get("synthetic")) for r in results.values()),
            "domains": domains,
            "models": models,
            "runs": runs,
            "pairs": _pairs(runs),
        }


def _name(process: str, level: str, family: str, kind: str, rule: str) -> str:
    return f"{level}-{family}-{kind}-{rule}"


def reduce(
    inputs: Mapping[str, Any], files: Mapping[str, Path], needs: Mapping[str, JobResult], folder: Path
) -> dict[str, Any]:
    """Keep the training tests with low pressure and temperature: the lower half of the tested range of each.

    The tests held out stay all, so that errors beyond the reduced domain are seen.
    """
    from friction_models.loads import DataSet

    data = load_data(files, needs)
    training = data.select("train").points
    middle = training.groupby("test_id", sort=True)[list(REDUCED_BY)].median()
    limit = 0.5 * (middle.min() + middle.max())
    kept = middle.index[(middle <= limit).all(axis=1)]
    if len(kept) < FEWEST:
        raise InputError(
            f"{len(kept)} training tests lie in the lower half of the tested {' and '.join(REDUCED_BY)}; "
            f"allowed: at least {FEWEST} (the reduced training data need them)"
        )
    held_out = data.select("test").points["test_id"].unique()
    ids = {*kept, *held_out}
    points = data.points[data.points["test_id"].isin(ids)].reset_index(drop=True)
    tests = data.tests[data.tests["test_id"].isin(ids)].reset_index(drop=True)
    DataSet(points, tests, dict(data.info)).save(folder / "dataset")
    return {
        "dataset": "dataset",
        "train": len(kept),
        "limits": {name: float(limit[name]) for name in REDUCED_BY},
        "synthetic": bool(data.synthetic),
    }


def _numbers(result: JobResult | None, domain: Domain, areas: FloatArray) -> dict[str, Any]:
    if result is None:
        return {"failed": "not run"}
    values = result.values
    run = run_of(result)
    row: dict[str, Any] = {"failed": values["failed"], "steps": values["steps"], "timing": values["timing"]}
    if run is None:
        return row
    row |= {
        "stroke_mm": float(run["forming.stroke"][-1]),
        "max_force_kN": float(run["forming.force"].max()),
        "work_J": float(run["forming.work"][-1]),
        "tau_over_k": float(run["forming.max_tau_over_k"].max()),
    }
    contact = Contact.of(run, areas)
    if not len(contact.mu):
        return row
    distance = domain.distance(contact.loads)
    beyond = distance > 0.0
    outside = contact.share(beyond)
    row |= {
        "states": len(contact.mu),
        "friction_work_J": float(contact.work.sum()),
        "outside": outside["share"],
        "outside_work": outside["work"],
        "distance": spread(distance[beyond], contact.area[beyond]),
        "mu": {"low": float(contact.mu.min()), **spread(contact.mu, contact.area)},
        "mu_zero": contact.share(contact.mu <= 0.0)["share"],
        "loads": [exceedance(k, contact, domain) for k in range(len(LOADS))],
    }
    row["mu"]["high"] = row["mu"].pop("largest")
    return row


def _pairs(runs: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return extrapolated against clamped runs of the same model, training set and level."""
    found = []
    key = ("process", "level", "model", "data")
    for run in runs:
        if run["rule"] != "clamp":
            continue
        other = next(r for r in runs if r["rule"] == "extrapolate" and all(r[k] == run[k] for k in key))
        pair: dict[str, Any] = {k: run[k] for k in key}
        pair["failed"] = [rule for rule, r in (("clamp", run), ("extrapolate", other)) if r["failed"]]
        if not pair["failed"]:
            if "mu" not in run or "mu" not in other:
                continue  # too short a stroke to touch anything: nothing to compare
            pair |= {
                f"{name}_pct": 100.0 * (other[name] / run[name] - 1.0) for name in ("max_force_kN", "work_J")
            }
            pair["mu_clamp"] = [run["mu"]["low"], run["mu"]["high"]]
            pair["mu_extrapolate"] = [other["mu"]["low"], other["mu"]["high"]]
        found.append(pair)
    return found


def table(values: Mapping[str, Any]) -> str:
    """Return one line a run as text."""
    lines = [
        f"{'level':20}{'model':20}{'data':9}{'rule':13}{'outside':>9}{'by work':>9}{'distance':>10}{'mu':>18}{'max force':>11}{'work':>9}"
    ]
    for run in values["runs"]:
        head = f"{run['level']:20}{run['model']:20}{run['data']:9}{run['rule']:13}"
        if "states" not in run:
            lines.append(f"{head}  {run['failed'] or 'no contact'}")
            continue
        mu = f"{run['mu']['low']:.3f} - {run['mu']['high']:.3f}"
        lines.append(
            f"{head}{100 * run['outside']:>7.0f} %{100 * run['outside_work']:>7.0f} %{run['distance']['median']:>10.3f}{mu:>18}"
            f"{run['max_force_kN']:>8.1f} kN{run['work_J']:>7.0f} J"
            + (f"  broke off at {run['stroke_mm']:.1f} mm" if run["failed"] else "")
        )
    return "\n".join(lines)
