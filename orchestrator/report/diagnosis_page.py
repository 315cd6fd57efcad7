"""The report of one diagnosis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from friction_models.loads import DataSet

from ..runs import versions
from .charts_friction import residual_chart, worst_tests_chart
from .evidence import budget_html, ranking_html, remarks_html, verdict_text
from .markup import escape, table
from .page import Page, figure


def diagnosis_page(model: Any, data: DataSet, diagnosis: Mapping[str, Any], label: str) -> str:
    """Return the HTML of a diagnosis of `model` on `data`; residuals are drawn where the model can predict."""
    effects = [str(e) for e in diagnosis["effects"]]
    verdict = str(diagnosis["verdict"]).replace("_", " ")
    page = Page(
        title=f"{label}: {verdict}" + (f" - {' and '.join(effects)}" if effects else ""),
        kicker="tribofmu diagnosis",
        lead=f"{data.points['test_id'].nunique()} tests, {len(data.points)} points.",
        synthetic=data.synthetic,
    )
    page.add("verdict", "Verdict", verdict_text(diagnosis))
    page.add("budget", "Error budget", budget_html(diagnosis))
    page.add("evidence", "Evidence", ranking_html(diagnosis), remarks_html(diagnosis))
    worst = [str(w["test_id"]) for w in diagnosis["worst_tests"][:4]]
    listed = table(
        ["test", "RMS of the residual"],
        [(w["test_id"], f"{float(w['rms']):.4f}") for w in diagnosis["worst_tests"][:10]],
        numeric=(1,),
    )
    if getattr(model, "is_fitted", False):
        mu = {"before": model.predict_frame(data.points, data.tests)}
        page.add(
            "residual",
            "Residuals",
            figure(
                "residual",
                residual_chart(data.points, mu),
                "Measured minus modelled mu; the intervals count a whole test as one observation.",
                "Mean residual against each of the five loads.",
            ),
        )
        chart = worst_tests_chart(data.points, mu, worst)
        listed = (
            figure("worst", chart, "The tests on which the model is worst.", "Friction in the worst tests.")
            + listed
        )
    page.add("tests", "Worst tests", listed)
    return page.render(f"tribofmu {escape(versions()['tribofmu'])}")
