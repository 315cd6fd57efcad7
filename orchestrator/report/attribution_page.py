"""The report of a forming attribution: curves before and after, causes, fingerprints, what cannot be told apart."""

from __future__ import annotations

from typing import Any

import numpy as np

from friction_models.discovery.wording import p_text

from ..attribution.result import Attribution, Fit
from .parts.markup import bullets, paragraph, table
from .parts.page import Page, figure
from .parts.theme import AFTER, BEFORE, CONSTANT, OTHER, PRESS_BAND, dress

_COLORS = (AFTER, BEFORE, OTHER, "#2f6da8", "#8a6d1d", CONSTANT)
#: Fingerprints that are drawn, and causes that are listed.
_DRAWN, _LISTED = 6, 12
#: Levels beside each other.
_COLUMNS = 3


def attribution_page(found: Attribution, label: str) -> str:
    """Return the HTML of an attribution; `label` names the press curves."""
    page = Page(
        title=_headline(found),
        kicker=f"tribofmu attribution: {label} (attribution, not proof)",
        lead=f"{len(found.levels)} level{'s' if len(found.levels) > 1 else ''} of the press.",
        synthetic=found.synthetic,
    )
    d = found.deviation
    rows = [
        ("before", f"{d['before']:.2f}"),
        *([("with what is named", f"{d['after']:.2f}")] if found.confusion_set else []),
        ("scatter to expect", f"{d['scatter']:.2f}"),
        *(
            [("not judged: like the difference of two meshes", f"{d['mesh']:.2f}")]
            if d.get("mesh", 0.0) > 0.0
            else []
        ),
    ]
    page.add(
        "verdict",
        "What the curves point to",
        paragraph(" ".join([found.sentence, found.left])),
        table(["deviation of the force", "RMS [kN]"], rows, numeric=(1,), narrow=True),
        '<p class="note">An attribution is not a proof: another cause with the same fingerprint would look the same. Effects of '
        "friction are found on tribometer data (<code>tribofmu diagnose</code>); force curves confirm them.</p>",
    )
    page.add(
        "curves",
        "Deviation along the stroke",
        figure(
            "curves",
            _deviations(found),
            "Measured minus simulated force at every level. Grey: scatter to expect of the mean of the repeats and of the mesh "
            "(two standard deviations)." + (" After: with what is named." if found.confusion_set else ""),
            "Deviation of the force over stroke, before and after, one panel a level.",
        ),
    )
    page.add("causes", "Causes, each alone", _causes(found))
    page.add(
        "fingerprints",
        "Fingerprints",
        figure(
            "fingerprints",
            _fingerprints(found),
            "How each cause changes the force, scaled to the same largest change: causes whose lines coincide at every level "
            "cannot be told apart.",
            "Fingerprints of the best causes over stroke, one panel a level.",
        ),
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
    rows, classes = [], []
    for fit in found.ranking[:_LISTED]:
        named = (
            "first"
            if fit.cause in found.confusion_set[:1]
            else "not told apart"
            if fit.cause in found.confusion_set
            else "beside it"
            if fit.cause in found.second
            else ""
        )
        rows.append((fit.cause, fit.title, _strength(fit), f"{fit.gain:.1f}", p_text(fit.p_value), named))
        classes.append("after" if named == "first" else "")
    return table(
        ["cause", "meaning", "strength (95 % interval)", "gain", "family-wise p", ""],
        rows,
        numeric=(3, 4),
        classes=classes,
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


def _panels(found: Attribution, title: str) -> Any:
    from plotly.subplots import make_subplots

    count = len(found.curves)
    columns = min(_COLUMNS, count)
    rows = -(-count // columns)
    chart = make_subplots(
        rows=rows, cols=columns, horizontal_spacing=0.07, vertical_spacing=0.34 / (rows + 1),
        subplot_titles=[str(c["level"]) for c in found.curves],
    )  # fmt: skip
    for number in range(count):
        row, column = number // columns + 1, number % columns + 1
        chart.update_xaxes(title_text="stroke [mm]", row=row, col=column)
        if column == 1:
            chart.update_yaxes(title_text=title, row=row, col=column)
    dress(chart, 110 + 260 * rows)
    chart.update_layout(margin_t=74)
    return chart


def _deviations(found: Attribution) -> Any:
    chart = _panels(found, "measured &#8722; simulated [kN]")
    columns = min(_COLUMNS, len(found.curves))
    for number, curve in enumerate(found.curves):
        row, column, first = number // columns + 1, number % columns + 1, number == 0
        stroke, wide = curve["stroke"], 2.0 * curve["scatter"]
        chart.add_scatter(
            x=np.concatenate([stroke, stroke[::-1]]), y=np.concatenate([wide, -wide[::-1]]), fill="toself",
            fillcolor=PRESS_BAND, line={"width": 0}, mode="lines", hoverinfo="skip", name="scatter to expect",
            legendgroup="scatter", showlegend=first, row=row, col=column,
        )  # fmt: skip
        lines = [("before", curve["measured"] - curve["simulated"], BEFORE)]
        if found.confusion_set:
            lines.append(("after", curve["after"], AFTER))
        for name, values, color in lines:
            chart.add_scatter(
                x=stroke, y=values, mode="lines", name=name, line={"color": color, "width": 2.2}, legendgroup=name,
                showlegend=first, row=row, col=column,
                hovertemplate=f"%{{x:.2f}} mm<br>%{{y:+.2f}} kN<extra>{name}</extra>",
            )  # fmt: skip
    return chart


def _fingerprints(found: Attribution) -> Any:
    chart = _panels(found, "change (largest = 1)")
    columns = min(_COLUMNS, len(found.curves))
    names = [f.cause for f in found.ranking[:_DRAWN]]
    keys = [k for n in names for k in found.curves[0]["fingerprints"] if k.partition(".")[0] == n][
        : len(_COLORS)
    ]
    largest = {k: max(float(np.abs(c["fingerprints"][k]).max()) for c in found.curves) or 1.0 for k in keys}
    for number, curve in enumerate(found.curves):
        row, column = number // columns + 1, number % columns + 1
        for key, color in zip(keys, _COLORS, strict=False):
            chart.add_scatter(
                x=curve["stroke"], y=curve["fingerprints"][key] / largest[key], mode="lines", name=key,
                line={"color": color, "width": 2}, legendgroup=key, showlegend=number == 0, row=row, col=column,
                hovertemplate=f"%{{x:.2f}} mm<br>%{{y:+.2f}}<extra>{key}</extra>",
            )  # fmt: skip
    return chart
