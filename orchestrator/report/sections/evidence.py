"""HTML of a diagnosis: budget, ranking, what cannot be told apart, worst tests, what to measure next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from friction_models.discovery.figures_data import setpoints_text, where_text
from friction_models.discovery.verdict import LEVEL
from friction_models.discovery.wording import p_text

from ..charts.evidence import budget_chart, ranking_chart
from ..parts.markup import bullets, escape, paragraph, table
from ..parts.page import figure

MEANINGS = {
    "explained": "One effect, or a pair of them, stands out.",
    "ambiguous": "Several effects fit equally well; more tests are needed to tell them apart.",
    "unknown_structure": "Something systematic is missing that no effect in the catalogue explains.",
    "nothing_missing": "What is left of the error is as large as the noise: there is nothing to find.",
    "data_problem": "A fault of a sensor or of the twin explains the error better than physics.",
    "out_of_domain": "The data lies outside what the model was trained on.",
}


def verdict_text(diagnosis: Mapping[str, Any]) -> str:
    """Return verdict and confidence in words (HTML).

    Examples
    --------
    >>> verdict_text({"verdict": "nothing_missing", "confidence": 0.9})
    '<p><strong>Nothing missing.</strong> What is left of the error is as large as the noise: there is nothing to find. Confidence 90 %.</p>'
    """
    verdict = str(diagnosis["verdict"])
    confidence = diagnosis.get("confidence")
    sure = f" Confidence {100 * float(confidence):.0f} %." if confidence is not None else ""
    said = str(diagnosis.get("sentence") or MEANINGS.get(verdict, ""))
    said = said[0].upper() + said[1:] if said else said
    if "confidence" in said:
        sure = ""
    return f"<p><strong>{escape(verdict.replace('_', ' ').capitalize())}.</strong> {escape(said)}{sure}</p>"


def budget_html(diagnosis: Mapping[str, Any]) -> str:
    """Return the error budget with the noise floor in words."""
    floor, budget = diagnosis["noise_floor"], diagnosis["error_budget"]
    low, high = floor.get("interval") or (None, None)
    interval = f" (95 % interval {low:.4f} to {high:.4f})" if low is not None and high is not None else ""
    named = bool(diagnosis["effects"])
    values = {k: float(budget.get(k) or 0.0) for k in ("floor", "explained", "missing")}
    names = " and ".join(str(e) for e in diagnosis["effects"])
    rms = {"before": sum(v**2 for v in values.values()) ** 0.5}
    if named:
        rms["after"] = (values["floor"] ** 2 + values["missing"] ** 2) ** 0.5
    chart = figure(
        "budget",
        budget_chart(values["floor"], values["explained"], values["missing"], named),
        f"The noise floor has an RMS of {float(floor['total']):.4f}{interval}: "
        f"scatter between tests {float(floor['test']):.4f}, drift within a test {float(floor['drift']):.4f}, "
        f"sensor {float(floor['sensor']):.4f}. No model can be better than that.",
        "Error budget before and after: noise floor, explained by what is named, still missing.",
    )
    rows = [
        (f"{when}, with {names}" if when == "after" else when, f"{total:.4f}", f"{values['floor']:.4f}",
         f"{values['explained']:.4f}" if when == "before" and named else "-", f"{values['missing']:.4f}")
        for when, total in rms.items()
    ]  # fmt: skip
    headings = ["RMS of mu", "in all", "noise floor", "explained by what is named", "still missing"]
    return chart + table(headings, rows, numeric=(1, 2, 3, 4))


def ranking_html(diagnosis: Mapping[str, Any], threshold: float | None = None) -> str:
    """Return the ranked evidence as chart and table; `threshold` is the gain that an effect needs."""
    if not diagnosis["ranking"]:
        return paragraph("No effect of the catalogue could be tried on these data.")
    ranking, chosen = diagnosis["ranking"], list(diagnosis["effects"])
    confusable = [str(e) for e in diagnosis.get("confusion_set", [])]
    parts = [
        figure(
            "ranking",
            ranking_chart(ranking, chosen, confusable, threshold),
            "Gain of every effect that was tried, with its physical sign enforced, in the order of the evidence: that is the "
            "gain where the form of the effect may be somewhat wrong. "
            + (
                f"Where nothing is missing, the best of all effects gains more than {threshold:.1f} in {100 * LEVEL:g} % of data sets. "
                if threshold is not None
                else ""
            )
            + (
                f"The data cannot tell these apart: {escape(', '.join(confusable))}."
                if len(confusable) > 1
                else "The data tells the first one from all others."
                if chosen
                else "None is accepted: what is missing has another shape than any of them."
                if diagnosis["verdict"] == "unknown_structure"
                else "None is accepted: chance alone gives gains like these."
                if diagnosis["verdict"] == "nothing_missing"
                else "None is accepted."
            ),
            "Ranking of effects by evidence.",
        ),
        table(
            ["effect", "evidence", "gain", "family-wise p of the gain", ""],
            [
                (
                    r["effect"],
                    f"{float(r['evidence']):.1f}",
                    f"{float(r['gain']):.1f}",
                    p_text(r["p_value"]),
                    "named"
                    if r["effect"] in chosen
                    else "not told apart"
                    if r["effect"] in confusable
                    else "",
                )
                for r in ranking[:8]
            ],
            numeric=(1, 2, 3),
            classes=["after" if r["effect"] in chosen else "" for r in ranking[:8]],
        ),
    ]
    return "\n".join(parts)


def remarks_html(diagnosis: Mapping[str, Any]) -> str:
    """Return structure left over, an unrecorded factor and warnings."""
    parts: list[str] = []
    where = diagnosis.get("where") or []
    if where:
        parts.append("<h3>Where structure is left</h3>")
        parts.append(bullets(where_text(w) for w in where))
    factor = diagnosis.get("unrecorded_factor")
    if factor:
        parts.append("<h3>An unrecorded factor?</h3>")
        parts.append(paragraph(str(factor.get("note", "The offsets of the tests fall into two groups."))))
    warnings = [str(w) for w in diagnosis.get("warnings") or []]
    if warnings:
        parts.append("<h3>Read this with care</h3>")
        parts.append(bullets(warnings))
    return "\n".join(parts)


def next_tests_html(diagnosis: Mapping[str, Any]) -> str:
    """Return the proposed tests as a table, empty where there are none."""
    tests = diagnosis.get("next_tests") or []
    if not tests:
        return ""
    rows = [
        (
            t["protocol"],
            setpoints_text(t["setpoints"]),
            " / ".join(map(str, t["separates"])),
            f"{float(t['expected_t']):.1f}",
            str(t.get("repeats", "-")),
        )
        for t in tests
    ]
    headings = ["protocol", "set points", "tells apart", "standard errors", "tests for 3 of them"]
    return "<h3>What to test next</h3>" + table(headings, rows, numeric=(3, 4))
