"""HTML of a diagnosis: budget, ranking, what cannot be told apart, worst tests, what to measure next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .charts_evidence import budget_chart, ranking_chart
from .markup import bullets, escape, p_value, paragraph, table
from .page import figure

MEANINGS = {
    "explained": "One effect stands out, and the error falls on tests that the model has not seen.",
    "ambiguous": "Several effects fit equally well; more tests are needed to tell them apart.",
    "unknown_structure": "Something systematic is missing that no effect in the catalogue explains.",
    "nothing_missing": "What is left of the error is as large as the noise: there is nothing to find.",
    "data_problem": "A fault of a sensor or of the twin explains the error better than physics.",
    "out_of_domain": "The data lies outside what the model was trained on.",
}


def verdict_text(diagnosis: Mapping[str, Any]) -> str:
    """Return verdict and confidence in words (HTML)."""
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
    squares = {k: float(budget.get(k) or 0.0) ** 2 for k in ("floor", "explained", "missing")}
    return figure(
        "budget",
        budget_chart(squares),
        f"Shares of the mean square error of mu. The noise floor has an RMS of {float(floor['total']):.4f}{interval}: "
        f"scatter between tests {float(floor['test']):.4f}, drift within a test {float(floor['drift']):.4f}, "
        f"sensor {float(floor['sensor']):.4f}. No model can be better than that.",
        "Error budget: noise floor, explained by the effect, still missing.",
    )


def ranking_html(diagnosis: Mapping[str, Any]) -> str:
    """Return the ranked evidence as chart and table."""
    ranking, chosen = diagnosis["ranking"], list(diagnosis["effects"])
    confusable = [str(e) for e in diagnosis.get("confusion_set", [])]
    parts = [
        figure(
            "ranking",
            ranking_chart(ranking, chosen, confusable),
            "Gain of every effect that was tried, with its physical sign enforced. "
            + (
                f"The data cannot tell these apart: {escape(', '.join(confusable))}."
                if len(confusable) > 1
                else "The data tells the first one from all others."
                if chosen
                else "None is accepted: chance alone gives gains like these."
            ),
            "Ranking of effects by evidence.",
        ),
        table(
            ["effect", "gain", "family-wise p", ""],
            [
                (
                    r["effect"],
                    f"{float(r['gain']):.1f}" if r.get("gain") is not None else "-",
                    p_value(r.get("p_value")),
                    "added"
                    if r["effect"] in chosen
                    else "not told apart"
                    if r["effect"] in confusable
                    else "",
                )
                for r in ranking[:8]
            ],
            numeric=(1, 2),
            classes=["after" if r["effect"] in chosen else "" for r in ranking[:8]],
        ),
    ]
    return "\n".join(parts)


def remarks_html(diagnosis: Mapping[str, Any]) -> str:
    """Return structure left over, an unrecorded factor, proposed tests and warnings."""
    parts: list[str] = []
    where = diagnosis.get("where") or []
    if where:
        parts.append("<h3>Where structure is left</h3>")
        parts.append(
            bullets(
                f"{' x '.join(map(str, w['variables']))}: {w['region']}, {w['shape']} ({100 * float(w['share']):.0f} %)"
                for w in where
            )
        )
    factor = diagnosis.get("unrecorded_factor")
    if factor:
        parts.append("<h3>An unrecorded factor?</h3>")
        parts.append(paragraph(str(factor.get("note", "The offsets of the tests fall into two groups."))))
    tests = diagnosis.get("next_tests") or []
    if tests:
        parts.append("<h3>Tests that would tell more</h3>")
        parts.append(
            table(
                ["protocol", "set points", "tells apart", "expected t"],
                [
                    (t["protocol"], _setpoints(t["setpoints"]), " / ".join(map(str, t["separates"])), f"{float(t['expected_t']):.1f}")
                    for t in tests
                ],
                numeric=(3,),
            )
        )  # fmt: skip
    warnings = [str(w) for w in diagnosis.get("warnings") or []]
    if warnings:
        parts.append("<h3>Read this with care</h3>")
        parts.append(bullets(warnings))
    return "\n".join(parts)


def _setpoints(values: object) -> str:
    if isinstance(values, Mapping):
        return ", ".join(f"{k} = {v}" for k, v in values.items())
    return str(values)
