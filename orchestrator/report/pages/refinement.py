"""The report of a refined model: errors of every round, residuals and response curves before and after."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from friction_models.common.markup import bullets, paragraph, table
from friction_models.discovery.refinement_rounds import fault_note, round_notes
from friction_models.loads import DataSet

from ..charts.residuals import residual_chart
from ..charts.responses import caption, response_chart
from ..parts.cards import INTERVALS, chance, in_numbers, judged
from ..parts.page import Page
from ..parts.theme import STYLES

if TYPE_CHECKING:
    from friction_models import FrictionModel
    from friction_models.discovery.judged_addition import Addition


def refinement_page(before: FrictionModel, after: FrictionModel, data: DataSet, label: str) -> str:
    """Return the HTML of a refined model, whose name before was `label`.

    The models are fitted; `after` holds the rounds of additions. Held-out tests are drawn where there are some, else all.
    """
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
    page.add("history", "Errors of every round", *_history(list(getattr(after, "error_history_", []))))
    models = {"before": before, "after": after}
    page.plot(
        "residual",
        "Residuals",
        residual_chart(
            shown.points,
            {
                part: np.asarray(m.predict_frame(shown.points, shown.tests), dtype=np.float64)
                for part, m in models.items()
            },
        ),
        f"Measured minus modelled mu on {which}; the intervals count a whole test as one observation. "
        f"{fault_note(after)}".rstrip(),
        "Mean residual against each load, before and after.",
    )
    page.plot(
        "response",
        "Response curves",
        response_chart(shown.loads(), [(part, STYLES[part], m) for part, m in models.items()]),
        caption(shown.loads(), models.values()),
        "Response curves before and after.",
        table(["model", "law"], [(part, m.formula_text()) for part, m in models.items()]),
    )
    return page.render()


def _history(history: list[Addition]) -> list[str]:
    if not history:
        return [paragraph("No round was judged: there are too few tests to leave some out.")]
    names = {"rmse": "RMSE", "mae": "MAE"}
    rows = [
        (
            *((k, " + ".join(entry["added"]), entry["judged_by"]) if key == "rmse" else ("", "", "")), name,
            *in_numbers(entry, key), chance(entry) if key == "rmse" else "",
        )
        for k, entry in enumerate(history, 1)
        for key, name in names.items()
    ]  # fmt: skip
    headings = ["round", "added", "judged by", "error", "before [95 %]", "after [95 %]", "fall [95 %]", "the change is"]  # fmt: skip
    caption = (
        f"Each round against the ordinary fit of the model before it, over all points of the unseen tests. {INTERVALS} The error budget "
        "of a diagnosis averages the points first, so its numbers are smaller by the noise of the sensor."
    )
    notes = bullets(
        [*(note for entry in history for note in round_notes(entry)), *history[-1].get("warnings", [])]
    )
    return [judged(history[-1], history[-1]), notes, table(headings, rows, range(4, 7), caption=caption)]
