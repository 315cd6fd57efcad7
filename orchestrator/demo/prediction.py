"""Prediction of held-out tests: the models before and after, each in a closed loop with the twin."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from friction_models import load_model
from friction_models.loads import DataSet

from ..cosim.batch import RunTask, run_all
from ..jobs.job import Progress
from ..prediction.closed_loop import sct_system, uncertainties_of
from ..prediction.predict_sct import PredictionNumbers, SctPrediction, SctPredictions
from ..prediction.schedule import held_out_schedules
from ..report.sections.demo_folder import PREDICTED

#: Friction models that are compared, and number of tests.
PARTS = ("before", "after")
COUNT = 3


def predict_held_out(
    out: Path,
    data: DataSet,
    labels: dict[str, str],
    jobs: int | None,
    tick: Progress,
) -> dict[str, PredictionNumbers]:
    """Predict held-out tests with the friction FMUs ``fmus/PART-point.fmu``; return errors by part.

    `out` is the folder of the demo, `data` the campaign after the twin; `labels` are parts and the names of their
    models.
    """
    chosen = example_tests(load_model(out / "models" / "before"), data.select("test"))
    schedules = sorted(held_out_schedules(data, chosen), key=lambda s: chosen.index(s.test_id))
    pairs = [(part, schedule) for part in labels for schedule in schedules]
    tasks = [
        RunTask(
            sct_system(
                out / "fmus" / f"{part}-point.fmu", schedule, out / PREDICTED / "fmus", label=labels[part]
            ),
            out / PREDICTED / part / "runs" / schedule.test_id,
        )
        for part, schedule in pairs
    ]
    runs = run_all(tasks, jobs, tick)
    off_by = uncertainties_of([schedule for _, schedule in pairs], runs, jobs=jobs)
    found = {}
    for part, label in labels.items():
        mine = [
            SctPrediction(s, run, uncertainties=u) for (p, s), run, u in zip(pairs, runs, off_by) if p == part
        ]
        predictions = SctPredictions(label, mine)
        predictions.save(out / PREDICTED / part)
        found[part] = predictions.to_dict()
    return found


def example_tests(model: Any, held_out: DataSet) -> list[str]:
    """Return the tests in which a model is best, worst and in between under the measured loads, best first."""
    square = (held_out.points["mu"] - model.predict_frame(held_out.points, held_out.tests)) ** 2
    ranked = square.groupby(held_out.points["test_id"]).mean().sort_values().index
    places = np.unique(np.linspace(0, len(ranked) - 1, COUNT).round().astype(int))
    return [str(ranked[k]) for k in places]
