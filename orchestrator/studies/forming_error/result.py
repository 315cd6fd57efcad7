"""What the forming-error study says: errors of every run, their summaries, and the change against constant friction."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from friction_models.loads import LOAD_NAMES, FloatArray

from ...comparison.level_runs import force_curve
from ...force_curves.forces import compare_force
from ...force_curves.metrics import LevelSummary, ScalarError
from ...jobs.graph import JobResult
from ..measurements import data_name, load_measurements
from .rows import Change, ModelRow, RunError, Summary
from .study import FormingErrorStudy, Friction, run_name, trained_name

#: A group of levels that is summed up: of one process, one lubricant, or (None) of all.
ALL = None
#: Friction stress over shear yield stress that the paper's runs stayed below.
TAU_OVER_K = 0.6


@dataclass(frozen=True)
class FormingErrors:
    """All results of the study."""

    synthetic: bool
    frictions: tuple[Friction, ...]
    runs: tuple[RunError, ...]  # pairs of level and friction that were run and measured
    missing: int  # number of pairs without a result
    #: Lubricant, process and name of every level of the study, with results or without.
    planned: tuple[tuple[str, str, str], ...]
    models: tuple[ModelRow, ...]

    @classmethod
    def of(cls, study: FormingErrorStudy, results: Mapping[str, JobResult]) -> FormingErrors:
        """Compare every run with the press."""
        runs: list[RunError] = []
        missing = 0
        for item in study.levels:
            measured = item.measured(results)
            for friction in study.frictions:
                result = results.get(run_name(item, friction))
                if result is None or measured is None:
                    missing += 1
                    continue
                values = result.values
                outside = values["outside"]
                runs.append(
                    RunError(
                        item.lubricant,
                        item.level.process,
                        item.level.T_tool,
                        item.level.speed,
                        item.level.name,
                        friction.label,
                        compare_force(force_curve(values), measured, friction.label),
                        float(max(values["tau_over_k"])),
                        None if outside is None else float(outside["share"]),
                        None if outside is None else float(outside["median_distance"]),
                        values["timing"],
                    )
                )
        models: list[ModelRow] = [
            {
                "lubricant": lubricant,
                "family": found.values["family"],
                "mae_test": found.values["mae_test"],
                "points": found.values["points"],
                "tests": found.values["tests"],
            }
            for lubricant in study.plan.lubricants
            for family in study.plan.models
            if (found := results.get(trained_name(lubricant, family))) is not None
        ]
        planned = tuple((item.lubricant, item.level.process, item.level.name) for item in study.levels)
        return cls(study.synthetic(results), study.frictions, tuple(runs), missing, planned, tuple(models))

    def of_group(
        self, friction: str, lubricant: str | None = ALL, process: str | None = ALL
    ) -> list[RunError]:
        """Return the runs of a friction law, of one lubricant or process where one is named."""
        return [
            run
            for run in self.runs
            if run.friction == friction
            and lubricant in (ALL, run.lubricant)
            and process in (ALL, run.process)
        ]

    @property
    def lubricants(self) -> list[str]:
        """Lubricants in their order."""
        return list(dict.fromkeys(run.lubricant for run in self.runs))

    @property
    def processes(self) -> list[str]:
        """Processes in their order."""
        return list(dict.fromkeys(run.process for run in self.runs))

    def common(self, lubricant: str | None = ALL, process: str | None = ALL) -> set[tuple[str, str]]:
        """Return lubricant and name of the levels of a group that every friction law with a run in the group has.

        Where runs are missing, laws are compared over these only: a law without its worst level would look better.
        """
        sets = [
            {(run.lubricant, run.level) for run in runs}
            for friction in self.frictions
            if (runs := self.of_group(friction.label, lubricant, process))
        ]
        return set.intersection(*sets) if sets else set()

    def summary(
        self, friction: str, lubricant: str | None = ALL, process: str | None = ALL
    ) -> Summary | None:
        """Sum up a friction law over the `common` levels of a group; None where there is none.

        tau/k and run times are those of all its runs.
        """
        common = self.common(lubricant, process)
        runs = self.of_group(friction, lubricant, process)
        judged = [run for run in runs if (run.lubricant, run.level) in common]
        if not judged:
            return None
        shares = [run.friction_share for run in runs]
        planned = [p for p in self.planned if lubricant in (ALL, p[0]) and process in (ALL, p[1])]
        return Summary(
            lubricant,
            process,
            friction,
            len(planned),
            LevelSummary.of([run.force.max_force for run in judged]),
            LevelSummary.of([run.force.work for run in judged]),
            max(run.tau_over_k for run in runs),
            float(np.mean(shares)),
            max(shares),
        )

    def summaries(self) -> list[Summary]:
        """Return the summaries of every process and lubricant, and over all."""
        groups = [(lubricant, process) for lubricant in self.lubricants for process in self.processes]
        found = [
            self.summary(friction.label, lubricant, process)
            for lubricant, process in [*groups, (ALL, ALL)]
            for friction in self.frictions
        ]
        return [summary for summary in found if summary is not None]

    def changes(self) -> list[Change]:
        """Return how the error of every trained model differs from constant friction, over all levels that both ran."""
        constants = [f.label for f in self.frictions if f.constant]
        found = []
        for friction in self.frictions:
            if not friction.constant:
                against = [[label] for label in constants] + ([constants] if len(constants) > 1 else [])
                found += [self._change(friction.label, labels) for labels in against]
        return [change for change in found if change is not None]

    def _change(self, friction: str, constants: Sequence[str]) -> Change | None:
        table: dict[tuple[str, str], dict[str, ScalarError]] = {}
        for run in self.runs:
            table.setdefault((run.lubricant, run.level), {})[run.friction] = run.force.max_force
        wanted = (friction, *constants)
        rows = [errors for errors in table.values() if all(name in errors for name in wanted)]
        if not rows:
            return None
        measured = np.array([errors[friction].measured.mean for errors in rows])
        scatter = np.array([errors[friction].measured.std for errors in rows])
        mine, *others = (np.array([errors[name].simulated for errors in rows]) for name in wanted)

        def relative(statistic: Callable[[FloatArray], float]) -> Callable[[FloatArray], float]:
            def change(press: FloatArray) -> float:
                constant = float(np.mean([statistic(np.abs(other / press - 1.0)) for other in others]))
                return float(statistic(np.abs(mine / press - 1.0)) / max(constant, 1e-300) - 1.0)

            return change

        mean = relative(lambda are: float(are.mean()))
        spread = relative(lambda are: float(are.std(ddof=1)))
        return Change(
            friction,
            constants[0] if len(constants) == 1 else "",
            mean(measured),
            propagated(mean, measured, scatter),
            spread(measured) if len(rows) > 1 else None,
            propagated(spread, measured, scatter) if len(rows) > 1 else None,
        )

    def to_dict(self) -> dict[str, object]:
        """Return all numbers as plain data."""
        return {
            "synthetic": self.synthetic,
            "frictions": [f.label for f in self.frictions],
            "missing_runs": self.missing,
            "levels": len(self.planned),
            "models": list(self.models),
            "summaries": [s.to_dict() for s in self.summaries()],
            "changes": [c.to_dict() for c in self.changes()],
            "runs": [r.to_dict() for r in self.runs],
        }


def held_out(
    study: FormingErrorStudy, results: Mapping[str, JobResult]
) -> dict[tuple[str, str], tuple[FloatArray, FloatArray]]:
    """Return measured and predicted mu of the held-out tests by lubricant and trained model, of results that are there.

    Loads are clamped to the trained domain, as the FMUs do.
    """
    from friction_models import load_model

    found = {}
    for lubricant in study.plan.lubricants:
        data = results.get(data_name(lubricant))
        if data is None or "dataset" not in data.values:
            continue
        points = load_measurements(data).select("test").points
        for family in study.plan.models:
            trained = results.get(trained_name(lubricant, family))
            if len(points) and trained is not None:
                model = load_model(trained.file("model"))
                loads = model.domain.clamp(points[list(LOAD_NAMES)].to_numpy())
                found[lubricant, family] = (points["mu"].to_numpy(), np.asarray(model.predict(loads)))
    return found


def propagated(function: Callable[[FloatArray], float], values: FloatArray, std: FloatArray) -> float:
    """Return the uncertainty of a function of independent measured values, from their `std`, by Gaussian propagation.

    Both sides of a ratio follow from the same press curves, so derivatives are taken of the whole function.

    Examples
    --------
    Standard deviations of 0.3 and 0.4 are one of 0.5 in the sum:

    >>> round(propagated(lambda x: float(x.sum()), np.array([1.0, 2.0]), np.array([0.3, 0.4])), 6)
    0.5
    """
    total = 0.0
    for k in range(len(values)):
        step = 1e-4 * max(abs(values[k]), 1e-12)
        moved = np.zeros_like(values)
        moved[k] = step
        slope = (function(values + moved) - function(values - moved)) / (2.0 * step)
        total += (slope * std[k]) ** 2
    return float(np.sqrt(total))
