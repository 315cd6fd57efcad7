"""The report of a forming attribution: curves before and after, causes, fingerprints, what cannot be told apart."""

from __future__ import annotations

import numpy as np

from friction_models.common.markup import bullets, paragraph, table
from friction_models.discovery.answer.wording import p_text

from ..attribution.result import Attribution, Fit
from .parts.chart import Chart
from .parts.page import Page
from .parts.theme import AFTER, BEFORE, CONSTANT, OTHER, PRESS_BAND

_COLORS = (AFTER, BEFORE, OTHER, "#2f6da8", "#8a6d1d", CONSTANT)
#: Fingerprints that are drawn, and causes that are listed.
_DRAWN, _LISTED = 6, 12


def attribution_page(found: Attribution, label: str) -> str:
    """Return the HTML of an attribution; `label` names the press curves."""
    page = Page(
        title=_headline(found),
        kicker=f"tribofmu attribution: {label} (attribution, not proof)",
        lead=f"{len(found.levels)} level{'s' if len(found.levels) > 1 else ''} of the press.",
        synthetic=found.synthetic,
    )
    d = found.deviation
    deviations = {"before": d["before"]}
    if found.confusion_set:
        deviations["with what is named"] = d["after"]
    deviations["scatter to expect"] = d["scatter"]
    if d.get("mesh", 0.0) > 0.0:
        deviations["not judged: like the difference of two meshes"] = d["mesh"]
    rows = [(what, f"{rms:.2f}") for what, rms in deviations.items()]
    page.add(
        "verdict",
        "What the curves point to",
        paragraph(" ".join([found.sentence, found.left])),
        table(["deviation of the force", "RMS [kN]"], rows, numeric=(1,), narrow=True),
        '<p class="note">An attribution is not a proof: another cause with the same fingerprint would look the same. Effects of '
        "friction are found on tribometer data (<code>tribofmu diagnose</code>); force curves confirm them.</p>",
    )
    page.plot(
        "curves",
        "Deviation along the stroke",
        _deviations(found),
        "Measured minus simulated force at every level. Grey: scatter to expect of the mean of the repeats and of the mesh "
        "(two standard deviations)." + (" After: with what is named." if found.confusion_set else ""),
        "Deviation of the force over stroke, before and after, one panel a level.",
    )
    page.add("causes", "Causes, each alone", _causes(found))
    page.plot(
        "fingerprints",
        "Fingerprints",
        _fingerprints(found),
        "How each cause changes the force, scaled to the same largest change: causes whose lines coincide at every level "
        "cannot be told apart.",
        "Fingerprints of the best causes over stroke, one panel a level.",
        _groups(found),
    )
    if found.warnings:
        page.add("notes", "Read this with care", bullets(found.warnings))
    return page.render()


def _headline(found: Attribution) -> str:
    if not found.confusion_set:
        return "No cause stands out: the simulation lies within the scatter"
    named = found.confusion_set[0]
    beside = f", and beside it to {' or '.join(found.second)}" if found.second else ""
    rivals = len(found.confusion_set) - 1
    doubt = f" (or {rivals} more that look the same)" if rivals else ""
    return f"The curves point to {named}{doubt}{beside}"


def _causes(found: Attribution) -> str:
    told = dict.fromkeys(found.second, "beside it") | dict.fromkeys(found.confusion_set, "not told apart")
    told |= dict.fromkeys(found.confusion_set[:1], "first")
    listed = found.ranking[:_LISTED]
    rows = [
        (f.cause, f.title, _strength(f), f"{f.gain:.1f}", p_text(f.p_value), told.get(f.cause, "")) for f in listed
    ]  # fmt: skip
    return table(
        ["cause", "meaning", "strength (95 % interval)", "gain", "family-wise p", ""],
        rows,
        numeric=(3, 4),
        classes=["after" if told.get(f.cause) == "first" else "" for f in listed],
        caption="Strength if this cause is the only one; gain: drop of the whitened squared error less 2 for each strength.",
    )


def _strength(fit: Fit) -> str:
    return "; ".join(
        f"{name + ' ' if name else ''}{v:+.3g} ({v - 1.96 * e:+.3g} to {v + 1.96 * e:+.3g})"
        + (f" {unit}" if unit != "1" else "")
        for name, v, e, unit in fit.values
    )


def _groups(found: Attribution) -> str:
    parts = []
    if found.groups:
        parts.append("<h3>Not to be told apart by these curves, whatever the truth</h3>")
        parts.append(bullets(", ".join(g) for g in found.groups))
    if found.unseen:
        parts.append("<h3>Leaves no trace in these curves</h3>")
        parts.append(paragraph(", ".join(found.unseen)))
    return "\n".join(parts)


def _panels(found: Attribution) -> Chart:
    titles = [str(c["level"]) for c in found.curves]
    rows = -(-len(titles) // 3)
    gap = 0.34 * rows / (rows + 1)
    return Chart.of_panels(len(titles), gap=gap, titles=titles, horizontal_spacing=0.07)


def _dressed(chart: Chart, count: int, y: str) -> Chart:
    for panel in range(count):
        chart.axes(panel, x="stroke [mm]")
    return chart.dress(110 + 260 * chart.rows, y=y, margin_t=74)


def _deviations(found: Attribution) -> Chart:
    chart = _panels(found)
    for panel, curve in enumerate(found.curves):
        stroke, wide = curve["stroke"], 2.0 * curve["scatter"]
        chart.band(panel, stroke, -wide, wide, PRESS_BAND, "scatter to expect", "scatter")
        lines = {"before": (curve["measured"] - curve["simulated"], BEFORE)}
        if found.confusion_set:
            lines["after"] = curve["after"], AFTER
        for name, (values, color) in lines.items():
            said = f"%{{x:.2f}} mm<br>%{{y:+.2f}} kN<extra>{name}</extra>"
            chart.scatter(
                panel, stroke, values, name, said, mode="lines", line={"color": color, "width": 2.2}
            )
    return _dressed(chart, len(found.curves), "measured &#8722; simulated [kN]")


def _fingerprints(found: Attribution) -> Chart:
    chart = _panels(found)
    names = [f.cause for f in found.ranking[:_DRAWN]]
    keys = [k for n in names for k in found.curves[0]["fingerprints"] if k.partition(".")[0] == n]
    for key, color in zip(keys, _COLORS, strict=False):
        largest = max(float(np.abs(c["fingerprints"][key]).max()) for c in found.curves) or 1.0
        for panel, curve in enumerate(found.curves):
            values = curve["fingerprints"][key] / largest
            said = f"%{{x:.2f}} mm<br>%{{y:+.2f}}<extra>{key}</extra>"
            chart.scatter(
                panel, curve["stroke"], values, key, said, mode="lines", line={"color": color, "width": 2}
            )
    return _dressed(chart, len(found.curves), "change (largest = 1)")
