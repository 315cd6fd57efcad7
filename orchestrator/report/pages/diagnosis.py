"""The report of one diagnosis, from the verdict down to the response curves of what it names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

import pandas as pd

from friction_models.common import InputError
from friction_models.common.markup import bullets, escape, paragraph, table
from friction_models.common.wording import counted, listed
from friction_models.discovery import refine
from friction_models.discovery.answer.diagnosis import Diagnosis
from friction_models.discovery.answer.figures_data import load_map, meanings, structure_pair
from friction_models.discovery.answer.sentence import NOTHING, NOTHING_SEEN
from friction_models.discovery.answer.wording import interval_text
from friction_models.discovery.causes.run_order import JUMP
from friction_models.discovery.judged_addition import Addition
from friction_models.discovery.refinement_rounds import round_notes
from friction_models.effects import make_effect
from friction_models.loads import DataSet, FloatArray
from friction_models.loads.contract import with_unit

from ..charts.diagnosis import effect_chart, map_chart, predicted_mu, term_chart
from ..charts.residuals import residual_chart, worst_tests_chart
from ..parts.cards import judged
from ..parts.chart import figure
from ..parts.page import Page
from ..sections import evidence

#: Of more points every k-th of each test is taken, for the sake of time: what happens in a few points of a test may be missed.
MOST_POINTS = 100_000


def diagnosis_page(found: Diagnosis, label: str, confirmed: Addition | None = None, held_out: int = 0) -> str:
    """Return the HTML of the diagnosis of a model named `label`, with what `confirmed_addition` returned.

    So many tests of the data set were `held_out` of the diagnosis: `refine` judges by these.
    """
    content = cast(evidence.DiagnosisNumbers, found.to_dict())
    averages, named = found.averages, bool(found.effects)
    tests = averages["test_id"].nunique()
    points = int(averages["points"].sum())
    page = Page(
        title=f"{label}: {_headline(found)}",
        kicker="tribofmu diagnosis",
        lead=f"{counted(tests, 'test')}, {points} points of measured friction. "
        + (escape(evidence.MEANINGS[found.verdict]) if _sure(found) else ""),
        synthetic=found.synthetic,
    )
    verdict, proposed = evidence.verdict_text(content), evidence.next_tests_html(content)
    page.add("verdict", "Verdict", verdict, _confirmed(confirmed, tests, held_out), proposed)
    page.add("budget", "Error budget", evidence.budget_html(content))
    predicted = predicted_mu(found)
    what = f" After: with {listed(found.effects)}, fitted to the same tests." if named else ""
    interval = (
        "the intervals count a whole test as one observation"
        if tests > 1
        else "one test shows no scatter between tests, so there are no intervals"
    )
    page.plot(
        "residual",
        "Residuals",
        residual_chart(averages, predicted),
        f"Measured minus modelled mu against every load that varies; {interval}. "
        f"Before: what the {escape(found.model)} model leaves.{escape(what)}",
        "Mean residual against each load, before and after.",
        _maps(found, list(predicted)),
    )
    threshold = found.threshold if found.threshold == found.threshold else None
    ranking, remarks = evidence.ranking_html(content, threshold), evidence.remarks_html(content)
    page.add("evidence", "Evidence", ranking, _formulas(found), remarks)
    page.add("tests", "Worst tests", _worst(found, predicted))
    if named:
        page.add("response", "Response curves", _response(found))
    return page.render()


def confirmed_addition(model: Any, data: DataSet, effects: list[str]) -> Addition | None:
    """Return what `refine` notes about adding effects to a model: errors on tests that the fit did not see.

    None where it cannot be judged: nothing is named, a fixed base (an FMU, a constant), a fault of the data (a
    correction of the data, not of the model), too few tests.
    """
    try:
        if not effects or any(make_effect(e).kind == "fault" for e in effects):
            return None
        step = max(1, len(data.points) // MOST_POINTS)
        place = data.points.groupby("test_id", sort=False).cumcount()
        points = data.points[place % step == 0]
        history = refine(points, data.tests, model=model, add=effects, force=True).error_history_
    except InputError:
        return None
    if not history:
        return None
    found: Addition = history[-1].copy()
    if step > 1:
        found["judged_by"] += f" on one point in {step}, for the sake of time"
    return found


def _headline(found: Diagnosis) -> str:
    names = listed(found.named[name].label for name in found.effects)
    one = len(found.effects) < 2
    verb = "is" if one else "are"
    return {
        "explained": f"{names} {verb} missing",
        "partly_explained": f"{names} {verb} missing, and something else",
        "ambiguous": f"an effect is missing, {names} fits best"
        if one
        else f"effects are missing, {names} fit best",
        "unknown_structure": "something is missing that the catalogue does not know",
        "nothing_missing": NOTHING if _sure(found) else NOTHING_SEEN,
        "data_problem": _data_problem(found, names),
        "out_of_domain": "the data lie outside what it was trained on",
    }[found.verdict]


def _data_problem(found: Diagnosis, names: str) -> str:
    if found.sentence.startswith(JUMP):
        return "something was changed between two tests that is not recorded"
    return f"the data are at fault ({names})" if names else "the data are at fault"


def _sure(found: Diagnosis) -> bool:
    """Whether "nothing missing" means that nothing is missing, as the sentence of the answer says: thin tests can hide much."""
    return found.verdict != "nothing_missing" or found.sentence.startswith(NOTHING)


def _confirmed(entry: Addition | None, tests: int, held_out: int) -> str:
    if entry is None:
        return ""
    crossed = (
        f" (of the {counted(tests, 'test')} of this page)" if "cross-validation" in entry["judged_by"] else ""
    )
    by = f"Tests not seen in the fit: by {entry['judged_by']}{crossed}. tribofmu refine makes that model, and judges it "
    if held_out:
        by += (
            f"by the {counted(held_out, 'test')} of the data set that have another role than train. This page does not look at them, so "
            "the errors there are others."
        )
    else:
        by += "by the same tests on all points."
    # A page may show them beside what came of the addition.
    return judged(entry, entry, "if it is added: ") + bullets(round_notes(entry)) + paragraph(by)


def _maps(found: Diagnosis, parts: list[str]) -> str:
    pair = structure_pair(found)
    maps = [load_map(found.averages), load_map(found.averages, pair=pair) if pair else None]
    return "\n".join(
        figure(
            f"map-{over.x}-{over.y}",
            map_chart(over, parts),
            f"Mean residual in cells of {escape(over.x)} and {escape(over.y)}; every test counts once in a cell, "
            "cells without a test are blank. Red: friction is higher than modelled; blue: lower.",
            f"Map of the residual over {over.x} and {over.y}.",
        )
        for over in maps
        if over is not None
    )


def _formulas(found: Diagnosis) -> str:
    """Return the empirical terms that are offered, and that nothing adds them."""
    if not found.formulas:
        return ""
    rows = [
        (
            o.name,
            o.equation,
            f"{o.rms[0]:.4f} to {o.rms[1]:.4f}",
            f"{o.share:.0%}",
            f"{o.interval[0]:.0%} to {o.interval[1]:.0%}",
            f"{o.stability:.0%}" if o.stability > 0.0 else "none",
        )
        for o in found.formulas
    ]
    headings = ["empirical term", "equation", "rms error", "removes", "95 % interval", "first in resamples"]
    said = (
        "No effect of the catalogue explains what is left. These curves would lower the error on unseen tests: the terms were chosen and "
        "fitted anew without each part of the tests, and judged on it. Removes: share of the squared error that is known to be avoidable, "
        "by the flexible reference or by the term. No law stands behind them, they fade out beyond the tested range, and nothing adds them "
        "but tribofmu refine --add 'NAME'."
    )
    if any(o.stability == 0.0 for o in found.formulas):
        said += (
            " A term that was first in none of the resamples was chosen for its error on unseen tests alone."
        )
    pictures = [
        figure(
            f"term-{k}",
            term_chart(o.curves),
            f"{escape(o.name)}: what it would add to mu within the tested range, with the 95 % interval over the tests, its form "
            "taken as given. Its straight part belongs to the model.",
            f"Curves of {o.name}.",
        )
        for k, o in enumerate(found.formulas)
        if o.curves
    ]
    return (
        "<h3>Empirical terms</h3>"
        + paragraph(said)
        + table(headings, rows, numeric=(2, 3, 4, 5), narrow=True)
        + "\n".join(pictures)
    )


def _worst(found: Diagnosis, predicted: Mapping[str, FloatArray]) -> str:
    worst = [str(w["test_id"]) for w in found.worst_tests[:4]]
    averages = found.averages.assign(test_id=found.averages["test_id"].astype(str))
    left = _left_after(averages)
    rows = [
        (w["test_id"], f"{w['rms']:.4f}", *([f"{left[str(w['test_id'])]:.4f}"] if found.effects else []))
        for w in found.worst_tests[:8]
    ]
    headings = ["test", "RMS before", *(["RMS after"] if found.effects else [])]
    return figure(
        "worst",
        worst_tests_chart(averages, predicted, worst),
        "The tests on which the model is worst: averages of measured mu, and what the model makes of them.",
        f"Friction in the tests {', '.join(worst)}.",
    ) + table(headings, rows, numeric=(1, 2), narrow=True)


def _left_after(averages: pd.DataFrame) -> pd.Series[float]:
    """Return the RMS of what the named effects leave in each test."""
    after = averages.assign(square=averages["points"] * averages["after"] ** 2).groupby("test_id")
    return (after["square"].sum() / after["points"].sum()) ** 0.5


def _response(found: Diagnosis) -> str:
    parts = []
    chart = effect_chart(found)
    if chart is not None:
        caption = (
            "What each effect adds to mu. Grey: in the tests as they were run; line: by its formula, where the effect "
            "depends on the present loads only."
        )
        parts.append(figure("response", chart, caption, "Share of mu of each effect over its driving load."))
    for name, entry in found.parameters.items():
        told = meanings(found.named[name])
        title = f"{name}: {told['title']}" if told["title"] != name else name
        parts.append(f"<h3>{escape(title)}</h3><p><code>{escape(entry['equation'])}</code></p>")
        rows = [
            (
                k,
                told["parameters"].get(k, ""),
                f"{v['value']:.4g}",
                interval_text(v),
                "" if v["unit"] == "1" else v["unit"],
            )
            for k, v in entry["values"].items()
        ]
        headings = ["parameter", "meaning", "value", "95 % interval", "unit"]
        parts.append(table(headings, rows, numeric=(2, 3), narrow=True))
        drivers = ", ".join(with_unit(d) for d in told["driver"])
        notes = f"Driven by {drivers}. " if drivers else ""
        notes += f"Shows {told['where']}. " if told["where"] else ""
        notes += f"Source: {told['citation']}" if told["citation"] else ""
        if notes:
            parts.append(paragraph(notes))
    return "\n".join(parts)
