"""The numbers of the study ``extrapolation``, as ``extrapolation.json`` holds them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Required, TypedDict

from friction_models.loads import LOADS, FloatArray
from friction_models.models.domain import Domain

from ...jobs.graph import JobResult
from ..contact import Contact, Exceedance, Spread, exceedance, reference_areas, spread
from ..forming_jobs import run_of, synthetic
from ..models import model_name
from ..tables import write_study
from .study import (
    DATA_KINDS,
    RULES,
    DataKind,
    ExtrapolationSettings,
    ExtrapolationStudy,
    Rule,
    data_of,
    run_name,
)


class ReachedMu(TypedDict):
    """Percentiles of mu over the contact area, and its extremes."""

    low: float
    p5: float
    median: float
    p95: float
    high: float


class ExtrapolationRun(TypedDict, total=False):
    """One run. Only `failed` is there where it was not made; what follows `tau_over_k` is missing without contact."""

    process: Required[str]
    level: Required[str]
    model: Required[str]
    data: Required[DataKind]
    rule: Required[Rule]
    failed: str
    steps: int
    timing: dict[str, float]
    stroke_mm: float
    max_force_kN: float
    work_J: float
    tau_over_k: float
    states: int  # markers in contact, over all steps
    friction_work_J: float
    outside: float  # share of the contact beyond the trained domain
    outside_work: float  # its share of the friction work
    distance: Spread  # of that share, in trained ranges
    mu: ReachedMu
    mu_zero: float
    loads: list[Exceedance]


class Pair(TypedDict, total=False):
    """The extrapolated run over the clamped one; `failed` names those that broke off."""

    process: Required[str]
    level: Required[str]
    model: Required[str]
    data: Required[DataKind]
    failed: list[Rule]
    max_force_kN_pct: float
    work_J_pct: float
    mu_clamp: list[float]
    mu_extrapolate: list[float]


class TrainedModel(TypedDict):
    """A model, and what it was trained on."""

    model: str
    data: DataKind
    points: int
    tests: int
    mae_test: float | None
    rmse_test: float | None


class ExtrapolationNumbers(TypedDict):
    """All numbers of the study; `settings` are those of `ExtrapolationPlan.to_dict`, `domains` the trained ranges."""

    settings: ExtrapolationSettings
    synthetic: bool
    domains: dict[str, dict[str, list[float] | None]]
    models: list[TrainedModel]
    runs: list[ExtrapolationRun]
    pairs: list[Pair]


def evaluate(study: ExtrapolationStudy, results: Mapping[str, JobResult]) -> ExtrapolationNumbers:
    """Return all numbers of the study; runs that broke off say so."""
    plan = study.plan
    runs: list[ExtrapolationRun] = []
    models: list[TrainedModel] = []
    domains: dict[str, dict[str, list[float] | None]] = {}
    levels = plan.levels()
    areas = {level.process: reference_areas(level) for level in levels[:: len(plan.conditions)]}
    for family in plan.models:
        for kind in DATA_KINDS:
            model = results.get(model_name(family, data_of(plan, kind)))
            if model is None:
                continue
            values = model.values
            domains[kind] = values["domain"]
            models.append(
                {
                    "model": family,
                    "data": kind,
                    "points": values["points"],
                    "tests": values["tests"],
                    "mae_test": values["mae_test"],
                    "rmse_test": values["rmse_test"],
                }
            )
            domain = Domain.from_dict(values["domain"])
            for level in levels:
                for rule in RULES:
                    run: ExtrapolationRun = {
                        "process": level.process,
                        "level": level.name,
                        "model": family,
                        "data": kind,
                        "rule": rule,
                    }
                    result = results.get(run_name(level, family, kind, rule))
                    _add_numbers(run, result, domain, areas[level.process])
                    runs.append(run)
    return {
        "settings": plan.to_dict(),
        "synthetic": synthetic(results),
        "domains": domains,
        "models": models,
        "runs": runs,
        "pairs": _pairs(runs),
    }


def _add_numbers(row: ExtrapolationRun, result: JobResult | None, domain: Domain, areas: FloatArray) -> None:
    if result is None:
        row["failed"] = "not run"
        return
    values = result.values
    run = run_of(result)
    row["failed"], row["steps"], row["timing"] = values["failed"], values["steps"], values["timing"]
    if run is None:
        return
    row["stroke_mm"] = float(run["forming.stroke"][-1])
    row["max_force_kN"] = float(run["forming.force"].max())
    row["work_J"] = float(run["forming.work"][-1])
    row["tau_over_k"] = float(run["forming.max_tau_over_k"].max())
    contact = Contact.of(run, areas)
    if not len(contact.mu):
        return
    distance = domain.distance(contact.loads)
    beyond = distance > 0.0
    outside = contact.share(beyond)
    mu = spread(contact.mu, contact.area)
    row["states"] = len(contact.mu)
    row["friction_work_J"] = float(contact.work.sum())
    row["outside"], row["outside_work"] = outside["share"], outside["work"]
    row["distance"] = spread(distance[beyond], contact.area[beyond])
    row["mu"] = {
        "low": float(contact.mu.min()),
        "p5": mu["p5"],
        "median": mu["median"],
        "p95": mu["p95"],
        "high": mu["largest"],
    }
    row["mu_zero"] = contact.share(contact.mu <= 0.0)["share"]
    row["loads"] = [exceedance(k, contact, domain) for k in range(len(LOADS))]


def write_results(folder: Path, numbers: ExtrapolationNumbers, page: str) -> None:
    """Write ``extrapolation.json``, ``extrapolation.csv`` and ``report.html``."""
    write_study(folder, "extrapolation", numbers, map(_row, numbers["runs"]), numbers["synthetic"], page)


def _row(run: ExtrapolationRun) -> dict[str, object]:
    """Return a run with its share beyond the trained range of each load as columns."""
    row: dict[str, object] = {name: value for name, value in run.items() if name != "loads"}
    for item in run.get("loads", []):
        row[f"{item['load']}_below"] = item["below"]["share"]
        row[f"{item['load']}_above"] = item["above"]["share"]
    return row


def _pairs(runs: Sequence[ExtrapolationRun]) -> list[Pair]:
    """Return extrapolated against clamped runs of the same model, training set and level."""
    by_name = {(r["level"], r["model"], r["data"], r["rule"]): r for r in runs}
    found: list[Pair] = []
    for run in runs:
        if run["rule"] != "clamp":
            continue
        other = by_name[run["level"], run["model"], run["data"], "extrapolate"]
        pair: Pair = {
            "process": run["process"],
            "level": run["level"],
            "model": run["model"],
            "data": run["data"],
            "failed": [r["rule"] for r in (run, other) if r["failed"]],
        }
        if not pair["failed"]:
            if "mu" not in run or "mu" not in other:
                continue  # too short a stroke to touch anything: nothing to compare
            pair["max_force_kN_pct"] = 100.0 * (other["max_force_kN"] / run["max_force_kN"] - 1.0)
            pair["work_J_pct"] = 100.0 * (other["work_J"] / run["work_J"] - 1.0)
            pair["mu_clamp"] = [run["mu"]["low"], run["mu"]["high"]]
            pair["mu_extrapolate"] = [other["mu"]["low"], other["mu"]["high"]]
        found.append(pair)
    return found
