"""The report of a refined model: errors of every round, residuals and response curves before and after."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from friction_models.loads import DataSet

from .charts.residuals import residual_chart
from .charts.responses import CAPTION, response_chart
from .parts.markup import Change, cards, paragraph, table
from .parts.page import Page, figure
from .parts.theme import STYLES

if TYPE_CHECKING:
    from friction_models.discovery.refinement import Addition


def refinement_page(before: Any, after: Any, data: DataSet, label: str) -> str:
    """Return the HTML of a refined model.

    Parameters
    ----------
    before, after : FrictionModel
        Fitted; `after` holds the rounds of additions (``error_history_``).
    data : DataSet
        Held-out tests are drawn where there are some, else all.
    label : str
        Name of the model before.
    """
    history = list(getattr(after, "error_history_", []))
    held = data.select("test")
    none = held is data or not len(held.points)  # where no role is recorded, all tests train
    shown = data if none else held
    count = shown.points["test_id"].nunique()
    which = f"all {count} tests (none is held out)" if none else f"{count} held-out tests"
    page = Page(
        title=f"{label}: refined to {after.name}",
        kicker="tribofmu refinement",
        lead=f"Charts show {which}.",
        synthetic=data.synthetic,
    )
    page.add("history", "Errors of every round", *_history(history))
    predicted = {
        "before": before.predict_frame(shown.points, shown.tests),
        "after": after.predict_frame(shown.points, shown.tests),
    }
    page.add(
        "residual",
        "Residuals",
        figure(
            "residual",
            residual_chart(shown.points, predicted),
            f"Measured minus modelled mu on {which}; the intervals count a whole test as one observation.",
            "Mean residual against each load, before and after.",
        ),
    )
    page.add(
        "response",
        "Response curves",
        figure(
            "response",
            response_chart(
                shown.loads(),
                [("before", STYLES["before"], before), ("after", STYLES["after"], after)],
            ),
            CAPTION,
            "Response curves before and after.",
        ),
        table(["model", "law"], [("before", before.formula_text()), ("after", after.formula_text())]),
    )
    return page.render()


def _history(history: list[Addition]) -> list[str]:
    if not history:
        return [paragraph("No round was judged: there are too few tests to leave some out.")]
    last = history[-1]
    change = [
        Change(f"mu, {name} on tests not seen in the fit", float(last["before"][k]), float(last["after"][k]))
        for name, k in (("RMS error", "rmse"), ("mean absolute error", "mae"))
    ]
    rows = [
        (
            str(k),
            " + ".join(entry["added"]),
            entry["judged_by"],
            *(f"{entry[part][m]:.4f}" for m in ("rmse", "mae") for part in ("before", "after")),
        )
        for k, entry in enumerate(history, 1)
    ]
    headings = ["round", "added", "judged by", "RMSE before", "after", "MAE before", "after"]
    return [
        cards(change),
        table(
            headings,
            rows,
            numeric=(3, 4, 5, 6),
            caption="Each round against the ordinary fit of the model before it.",
        ),
    ]
