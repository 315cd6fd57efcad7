"""The report of a forming attribution: curves before and after, causes, fingerprints, what cannot be told apart."""

from __future__ import annotations

from friction_models.common.markup import bullets, paragraph, table
from friction_models.common.wording import counted
from friction_models.discovery.answer.wording import p_text
from friction_models.loads.contract import behind

from ...attribution.result import Attribution, Fit
from ..charts.attribution import deviation_chart, fingerprint_chart
from ..parts.page import Page

#: Causes that are listed.
_LISTED = 12


def attribution_page(found: Attribution, label: str) -> str:
    """Return the HTML of an attribution; `label` names the press curves."""
    page = Page(
        title=_headline(found),
        kicker=f"tribofmu attribution: {label} (attribution, not proof)",
        lead=f"{counted(len(found.levels), 'level')} of the press.",
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
        deviation_chart(found),
        "Measured minus simulated force at every level. Grey: scatter to expect of the mean of the repeats and of the mesh "
        "(two standard deviations)." + (" After: with what is named." if found.confusion_set else ""),
        "Deviation of the force over stroke, before and after, one panel a level.",
    )
    page.add("causes", "Causes, each alone", _causes(found))
    page.plot(
        "fingerprints",
        "Fingerprints",
        fingerprint_chart(found),
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
        return f"No cause stands out: the simulated curves lie {found.place}"
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
        f"{name + ' ' if name else ''}{v:+.3g} ({v - 1.96 * e:+.3g} to {v + 1.96 * e:+.3g})" + behind(unit)
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
