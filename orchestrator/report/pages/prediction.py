"""The report of tests that were predicted in a closed loop (`predict-sct`)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from friction_models.common import InputError
from friction_models.common.markup import escape, table

from ..charts.prediction import prediction_chart
from ..parts.page import Page

if TYPE_CHECKING:
    from ...prediction.predict_sct import PredictedTest, PredictionNumbers

#: Tests that the chart shows.
SHOWN = 3


def prediction_page(folder: Path) -> str:
    """Return the HTML of a folder with ``prediction.json`` and ``predicted.csv``.

    Raises InputError: a file is missing or damaged.
    """
    try:
        content = json.loads((folder / "prediction.json").read_text(encoding="utf-8"))
        points = pd.read_csv(folder / "predicted.csv", dtype={"test_id": str})
        return _page(content, points)
    except (KeyError, TypeError, ValueError, OSError) as error:
        raise InputError(
            f"{folder}: not a complete prediction ({type(error).__name__}: {error}); run predict-sct again"
        ) from None


def _page(content: PredictionNumbers, points: pd.DataFrame) -> str:
    rows, total = content["tests"], content["summary"]
    count = f"{len(rows)} tests" if len(rows) > 1 else "one test"
    title = f"{content['friction']}: {count} predicted"
    if total is not None:
        title += f", mu within {total['mu_rms']:.4f} (RMS)"
    page = Page(
        title=title,
        kicker="tribofmu predict-sct: friction FMU and twin FMU in a closed loop",
        lead="Normal force, motion and tool temperature went in; friction and the heat that it makes came out.",
        synthetic=bool(content["synthetic"]),
    )
    examples = _example_tests(rows)
    predicted = {test: points[points["test_id"] == test] for test in examples}
    measured = {}
    if {"mu", "T_measured"} <= set(points.columns):
        measured = {
            test: frame[["sd", "mu", "T_measured"]].dropna().rename(columns={"T_measured": "T"})
            for test, frame in predicted.items()
        }
    chart = prediction_chart(
        {test: test for test in examples}, measured, {"after": predicted}, {"after": str(content["friction"])}
    )
    said = (
        "the tests with the smallest, a middle and the largest error of mu. The measured T is that of the twin under the "
        "measured friction."
        if total
        else "some of the tests. Nobody has run them."
    )
    page.plot(
        "predicted",
        "Friction and temperature",
        chart,
        f"Shown: {said}",
        f"Friction and contact temperature over sliding distance in the tests {', '.join(examples)}.",
    )
    page.add("tests", "All tests", _table(rows, total))
    return page.render(f"Friction: {escape(content['friction'])}.")


def _example_tests(rows: list[PredictedTest]) -> list[str]:
    """Return tests with the smallest, middle and largest error; of unmeasured ones the first, middle and last."""
    ranked = sorted(rows, key=lambda row: row["errors"]["mu_rms"] if row["errors"] else 0.0)
    places = sorted({round(k * (len(ranked) - 1) / (SHOWN - 1)) for k in range(SHOWN)})
    return [str(ranked[k]["test_id"]) for k in places]


def _table(rows: list[PredictedTest], total: dict[str, float] | None) -> str:
    headings = ["test", "measured mu", "model", "RMS", "measured T [°C]", "model", "RMS [K]", "outside domain"]  # fmt: skip
    lines: list[tuple[str, ...]] = []
    for row in rows:
        e, outside = row["errors"] or {}, row["outside_domain"]
        lines.append(
            (
                row["test_id"], _number(e.get("mu_measured"), 4), _number(e.get("mu_predicted", row["mu_mean"]), 4),
                _number(e.get("mu_rms"), 4), _number(e.get("T_measured"), 0), _number(e.get("T_predicted", row["T_mean"]), 0),
                _number(e.get("T_rms"), 1), "not known" if outside is None else f"{100 * outside:.0f} %",
            )
        )  # fmt: skip
    if total is not None:
        lines.append(("all", "", "", _number(total["mu_rms"], 4), "", "", _number(total.get("T_rms"), 1), ""))
    return table(
        headings,
        lines,
        numeric=range(1, len(headings)),
        caption="Means over the sliding, and RMS of predicted minus measured. Outside domain: share of the steps beyond the "
        "loads that the friction model was trained on.",
    )


def _number(value: float | None, decimals: int) -> str:
    return "-" if value is None else f"{float(value):.{decimals}f}"
