"""What `plot` of each answer draws: the figures of the pages, by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from friction_models import FrictionModel
from friction_models.common import InputError, unknown_name
from friction_models.discovery import Comparison, Diagnosis
from friction_models.discovery.answer.figures_data import load_map

from ..attribution.result import Attribution
from ..cosim.run_folders import Run
from ..coverage.tested_loads import Coverage
from .charts.attribution import deviation_chart, fingerprint_chart
from .charts.comparison import per_test_chart
from .charts.coverage import pairs_chart, shares_chart
from .charts.diagnosis import budget_chart, effect_chart, map_chart, predicted_mu, ranking_chart
from .charts.residuals import residual_chart, worst_tests_chart
from .charts.rounds import rounds_chart
from .charts.runs import run_force_chart, run_loads_chart
from .parts.chart import Chart
from .parts.theme import AFTER, BEFORE, CONSTANT

if TYPE_CHECKING:
    import plotly.graph_objects as go

#: A chart, or None where the answer has nothing to show in it.
Draws = Callable[[Any], "Chart | None"]
#: Tests that `plot("tests")` of a diagnosis shows.
WORST = 4


def picture(answer: object, what: str = "") -> go.Figure:
    """Return a picture of an answer as a plotly figure; `Drawn.plot` calls this.

    Raises InputError: no such picture, or nothing to draw in it.
    """
    kind = next((k for k in PICTURES if isinstance(answer, k)), None)
    if kind is None:
        raise InputError(
            f"plot: a {type(answer).__name__} cannot be drawn; allowed: {', '.join(k.__name__ for k in PICTURES)}"
        )
    if isinstance(answer, FrictionModel) and what in {"", "response"}:
        return answer.view()
    drawn = PICTURES[kind]
    if what and what not in drawn:
        names = ["response", *drawn] if kind is FrictionModel else drawn
        raise unknown_name("picture", what, names, f"plot of a {kind.__name__}")
    name = what or next(iter(drawn))
    chart = drawn[name](answer)
    if chart is None:
        raise InputError(f"plot: this {kind.__name__} has nothing to show in the picture {name!r}")
    return chart.figure


def _budget(found: Diagnosis) -> Chart:
    budget = found.error_budget
    return budget_chart(budget["floor"], budget["explained"], budget["missing"], bool(found.effects))


def _ranking(found: Diagnosis) -> Chart | None:
    colours = {**dict.fromkeys(found.confusion_set, BEFORE), **dict.fromkeys(found.effects, AFTER)}
    gains = [(r["effect"], float(r["gain"]), colours.get(r["effect"], CONSTANT)) for r in found.ranking]
    limit = found.threshold if found.threshold == found.threshold else None
    return ranking_chart(gains, limit) if gains else None


def _map(found: Diagnosis) -> Chart | None:
    over = load_map(found.averages)
    return None if over is None else map_chart(over, list(predicted_mu(found)))


def _worst(found: Diagnosis) -> Chart:
    averages = found.averages.assign(test_id=found.averages["test_id"].astype(str))
    worst = [str(w["test_id"]) for w in found.worst_tests[:WORST]]
    return worst_tests_chart(averages, predicted_mu(found), worst)


def _rounds(model: FrictionModel) -> Chart | None:
    history = getattr(model, "error_history_", [])
    return rounds_chart(history) if history else None


#: Class of the answer -> its pictures by name, the usual one first.
PICTURES: dict[type, dict[str, Draws]] = {
    Diagnosis: {
        "residual": lambda found: residual_chart(found.averages, predicted_mu(found)),
        "budget": _budget,
        "ranking": _ranking,
        "map": _map,
        "response": effect_chart,
        "tests": _worst,
    },
    Comparison: {"tests": lambda found: per_test_chart(found.per_test, found.ranking)},
    Run: {"force": lambda run: run_force_chart(run.force_curve()), "contact": run_loads_chart},
    Coverage: {
        "pairs": lambda found: pairs_chart(found) if len(found.loads) > 1 else None,
        "loads": shares_chart,
    },
    Attribution: {"curves": deviation_chart, "fingerprints": fingerprint_chart},
    FrictionModel: {"rounds": _rounds},
}
