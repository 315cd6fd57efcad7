"""HTML of a diagnosis: budget, ranking, what cannot be told apart, worst tests, what to measure next."""

from __future__ import annotations

from typing import NotRequired, TypedDict

from friction_models.common.markup import bullets, escape, paragraph, table
from friction_models.common.wording import listed
from friction_models.discovery.answer.figures_data import setpoints_text, where_text
from friction_models.discovery.answer.findings import (
    ORDER_OF_RANKING,
    OTHERS_BY_CHANCE,
    ErrorBudget,
    RankedEffect,
    TestGroups,
    WorstTest,
)
from friction_models.discovery.answer.uncertain_loads import from_loads_text
from friction_models.discovery.answer.wording import (
    about_next_tests,
    floor_source,
    in_hundred,
    meaning_of_numbers,
    mu_format,
    p_text,
    parts_of_floor,
    told_by,
)
from friction_models.discovery.further_tests.next_tests import NextTest
from friction_models.discovery.judge.verdict import LEVEL
from friction_models.estimation.noise.noise_floor import NoiseFloorNumbers
from friction_models.estimation.search.structure import StructurePlace

from ..charts.diagnosis import budget_chart, ranking_chart
from ..parts.chart import figure
from ..parts.theme import AFTER, CONSTANT, RIVAL

MEANINGS = {
    "explained": "What is named explains nearly all that can be predicted.",
    "partly_explained": "What is named lowers the error on unseen tests, and something else that can be predicted is left.",
    "ambiguous": "Several effects fit equally well; more tests are needed to tell them apart.",
    "unknown_structure": "Something systematic is missing that no effect in the catalogue explains.",
    "nothing_missing": "What is left of the error is as large as the noise: there is nothing to find.",
    "data_problem": "A fault of a sensor or of the twin explains the error better than physics.",
    "out_of_domain": "The data lies outside what the model was trained on.",
}


class DiagnosisNumbers(TypedDict):
    """A diagnosis as `diagnose --json` writes it, with its sentence; older files lack some of it."""

    verdict: str
    effects: list[str]
    ranking: list[RankedEffect]
    noise_floor: NoiseFloorNumbers
    error_budget: ErrorBudget
    worst_tests: list[WorstTest]
    sentence: NotRequired[str]
    confidence: NotRequired[float | None]
    confusion_set: NotRequired[list[str]]
    alternatives: NotRequired[list[list[str]]]
    where: NotRequired[list[StructurePlace]]
    unrecorded_factor: NotRequired[TestGroups | None]
    warnings: NotRequired[list[str]]
    next_tests: NotRequired[list[NextTest]]
    not_first: NotRequired[str]


def verdict_text(found: DiagnosisNumbers) -> str:
    """Return verdict and confidence in words (HTML)."""
    verdict, confidence = found["verdict"], found.get("confidence")
    said = found.get("sentence") or MEANINGS.get(verdict, "")
    said = said[:1].upper() + said[1:]
    sure = "" if confidence is None or "confidence" in said else f" Confidence {in_hundred(confidence)} %."
    # Behind a sentence that holds both numbers, the one seems to contradict the other.
    p = next((r["p_value"] for r in found["ranking"] if r["effect"] in found["effects"]), None)
    meaning = meaning_of_numbers(confidence, p if "p = " in said else None)
    answer = f"<p><strong>{escape(verdict.replace('_', ' ').capitalize())}.</strong> {escape(said)}{sure}</p>"
    return answer + (paragraph(meaning, "numbers-mean") if meaning else "")


def budget_html(found: DiagnosisNumbers) -> str:
    """Return the error budget with the noise floor in words."""
    noise, named = found["noise_floor"], found["effects"]
    low, high = noise.get("interval") or (None, None)
    source = "; ".join(s for s in (floor_source(noise, named), from_loads_text(noise)) if s)
    floor, explained, missing = (found["error_budget"][k] or 0.0 for k in ("floor", "explained", "missing"))
    f = mu_format((floor**2 + explained**2 + missing**2) ** 0.5, 4)
    interval = f" (95 % interval {low:{f}} to {high:{f}})" if low is not None and high is not None else ""
    parts = parts_of_floor(noise)
    chart = figure(
        "budget",
        budget_chart(floor, explained, missing, bool(named)),
        f"Averages of the tests, divided as the prediction of whole unseen tests shows it. Noise floor: {noise['total']:{f}}"
        f"{interval}{'; ' if source else ''}{source}. "
        f"{f'The floor has {parts}.' if parts else ''}",
        "Error budget before and after: noise floor, explained by what is named, still missing.",
    )

    def row(when: str, explained: float, shown: str) -> tuple[str, ...]:
        total = (floor**2 + explained**2 + missing**2) ** 0.5
        return when, f"{total:{f}}", f"{floor:{f}}", shown, f"{missing:{f}}"

    rows = [row("before", explained, f"{explained:{f}}" if named else "-")]
    rows += [row(f"after, with {listed(named)}", 0.0, "-")] if named else []
    headings = ["RMS of mu", "in all", "noise floor", "explained by what is named", "still missing"]
    return chart + table(headings, rows, numeric=(1, 2, 3, 4))


def ranking_html(found: DiagnosisNumbers, threshold: float | None = None) -> str:
    """Return the ranked evidence as chart and table; `threshold` is the gain that an effect needs."""
    ranking, chosen, confusable = found["ranking"], found["effects"], found.get("confusion_set", [])
    if not ranking:
        return paragraph("No effect of the catalogue could be tried on these data.")
    chance = "chance alone gives gains like these"
    if (ranking[0]["p_value"] or 1.0) < LEVEL:
        chance = "what stands out lowers the error on unseen tests too little"
    none = {
        "unknown_structure": "None is accepted: what is missing has another shape than any of them.",
        "nothing_missing": f"None is accepted: {chance}.",
    }.get(found["verdict"], "None is accepted.")
    alike = [", ".join(names) for names in found.get("alternatives", [confusable]) if len(names) > 1]
    if alike:
        apart = f"The data cannot tell these apart: {escape('; nor these: '.join(alike))}."
    else:
        # the first of the ranking need not be the one that is named
        first = chosen[0] if chosen and ranking[0]["effect"] != chosen[0] else "the first one"
        apart = f"The data tells {escape(first)} from all others." if chosen else none
    needed = (
        ""
        if threshold is None or threshold <= 0.0
        else f"Where nothing is missing, the best of all effects gains more than {threshold:.1f} in {100 * LEVEL:g} % of data sets. "
    )

    def told(effect: str, named: str, rival: str, other: str) -> str:
        return named if effect in chosen else rival if effect in confusable else other

    chart = figure(
        "ranking",
        ranking_chart(
            [(r["effect"], r["gain"], told(r["effect"], AFTER, RIVAL, CONSTANT)) for r in ranking],
            threshold,
        ),
        "Gain (whitened squares, less 2 for each parameter) of every effect that was tried, with its physical sign enforced, in the order of "
        "the evidence: that is the "
        f"gain where the form of the effect may be somewhat wrong; {ORDER_OF_RANKING}. P-values: {OTHERS_BY_CHANCE}. {needed}{apart}",
        "Ranking of effects by evidence.",
    )
    rows = [
        (
            r["effect"], f"{r['evidence']:.1f}", f"{r['gain']:.1f}", p_text(r["p_value"]),
            told(r["effect"], "named", "not told apart", ""),
        )
        for r in ranking[:8]
    ]  # fmt: skip
    classes = [told(r["effect"], "after", "", "") for r in ranking[:8]]
    headings = ["effect", "evidence", "gain", "family-wise p of the gain", ""]
    said = found.get("not_first", "")
    reason = paragraph(said[:1].upper() + said[1:]) if said else ""
    return f"{chart}\n{table(headings, rows, numeric=(1, 2, 3), classes=classes)}{reason}"


def remarks_html(found: DiagnosisNumbers) -> str:
    """Return structure left over, an unrecorded factor and warnings."""
    factor = found.get("unrecorded_factor")
    parts = {
        "Where structure is left": bullets(where_text(w) for w in found.get("where", [])),
        "An unrecorded factor?": paragraph(factor["note"]) if factor else "",
        "Read this with care": bullets(found.get("warnings", [])),
    }
    return "\n".join(f"<h3>{heading}</h3>\n{html}" for heading, html in parts.items() if html)


def next_tests_html(found: DiagnosisNumbers) -> str:
    """Return the proposed tests as a table, empty where there are none."""
    rows = []
    for t in found.get("next_tests", []):
        pair = len(t["separates"]) > 1
        rows.append(
            (
                t["protocol"], setpoints_text(t["setpoints"]), told_by(t["separates"]),
                f"{t['expected_t']:.3g}" if pair else "-", t.get("repeats", "-"),
                f"{t['entropy_reduction']:.2f}" if pair and "entropy_reduction" in t else "-", len(t["plan"]),
            )
        )  # fmt: skip
    if not rows:
        return ""
    headings = ["protocol", "set points", "tells", "standard errors", "runs for 3 standard errors", "bits", "tests"]  # fmt: skip
    caption = "Bits: by how much the tests of a row together are expected to reduce the entropy of the answer; the most per test first."
    if about := about_next_tests(found["verdict"]):
        caption += f" {about[:1].upper()}{about[1:]}."
    return "<h3>What to test next</h3>" + table(headings, rows, numeric=(3, 4, 5, 6), caption=caption)
