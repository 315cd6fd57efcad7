"""The section of the demo's page on held-out tests that were predicted in a closed loop."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import pandas as pd

from friction_models.common.markup import escape, table

from ..charts.prediction import prediction_chart
from ..parts.chart import figure
from .demo_folder import PREDICTED, DemoFolder

if TYPE_CHECKING:
    from ...prediction.predict_sct import PredictionNumbers


def prediction_html(demo: DemoFolder) -> str:
    """Return chart and table of held-out tests in a closed loop of friction FMU and twin FMU."""
    found: Mapping[str, PredictionNumbers] = demo.summary["predicted"]
    labels = {part: demo.label(part) for part in found}
    shown = [str(row["test_id"]) for row in found["before"]["tests"]]
    points = demo.held_out.points
    measured = {test: points[points["test_id"] == test] for test in shown}
    predicted = {}
    for part in found:
        frame = pd.read_csv(demo.folder / PREDICTED / part / "predicted.csv", dtype={"test_id": str})
        predicted[part] = {test: frame[frame["test_id"] == test] for test in shown}
    chart = figure(
        "predicted",
        prediction_chart(
            {test: _heading(demo, test) for test in shown},
            measured,
            predicted,
            {part: f"{part}: {label}" for part, label in labels.items()},
        ),
        "Friction FMU and twin FMU in a closed loop: normal force, motion and tool temperature of a held-out test go in, friction "
        "and the heat that it makes come out. Nothing else is known of the test. Shown are the tests on which the "
        f"{escape(labels['before'])} model is best, in between and worst under the measured loads. The measured T is that of the twin under the measured friction.",
        f"Friction and contact temperature over sliding distance, measured and predicted, in the tests {', '.join(shown)}.",
    )
    return chart + _table(found)


def _table(found: Mapping[str, PredictionNumbers]) -> str:
    """Errors by test, the last row over all of them."""
    parts = list(found)
    headings = ["test", "measured mu", *(f"{p}: RMS of mu" for p in parts)]
    headings += ["measured T [°C]", *(f"{p}: RMS of T [K]" for p in parts)]
    rows: list[tuple[object, ...]] = []
    for number, first in enumerate(found[parts[0]]["tests"]):
        errors = [found[p]["tests"][number]["errors"] or {} for p in parts]
        rows.append(
            (
                first["test_id"], f"{errors[0]['mu_measured']:.4f}", *(f"{e['mu_rms']:.4f}" for e in errors),
                f"{errors[0]['T_measured']:.0f}", *(f"{e['T_rms']:.1f}" for e in errors),
            )
        )  # fmt: skip
    totals = [found[p]["summary"] or {} for p in parts]
    rows.append(
        ("all", "", *(f"{t['mu_rms']:.4f}" for t in totals), "", *(f"{t['T_rms']:.1f}" for t in totals))
    )
    return table(
        headings,
        rows,
        numeric=range(1, len(headings)),
        caption="Predicted minus measured. An error of mu heats or cools the contact, and that acts back on mu.",
    )


def _heading(demo: DemoFolder, test: str) -> str:
    """Name of a test with its setting."""
    tests = demo.held_out.tests
    assert tests is not None
    row = tests[tests["test_id"] == test].iloc[0]
    said = [test]
    for name, unit in (("v_set", "mm/s"), ("T_tool", "°C")):
        if name in row and pd.notna(row[name]):
            said.append(f"{float(row[name]):.0f} {unit}")
    return ", ".join(said)
