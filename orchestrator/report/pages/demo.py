"""The report of the demo, from the verdict down to the manifest."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from friction_models.common.markup import escape, table
from friction_models.common.wording import listed
from friction_models.discovery.answer.figures_data import setpoints_text
from friction_models.effects import make_effect

from ...studies.forming_error.words import percent
from ..charts.force import force_chart
from ..charts.residuals import residual_chart, worst_tests_chart
from ..charts.responses import caption, response_chart
from ..parts.cards import Change, cards
from ..parts.chart import figure
from ..parts.page import VIRTUAL, Page, footer
from ..parts.theme import STYLES
from ..sections.demo_folder import DemoFolder
from ..sections.evidence import budget_html, next_tests_html, ranking_html, remarks_html, verdict_text
from ..sections.prediction import prediction_html


def demo_page(folder: Path) -> str:
    """Return the HTML of a finished demo folder."""
    demo = DemoFolder.read(folder)
    page = Page(
        title=_headline(demo),
        kicker="tribofmu demo: friction in cold forging",
        lead=_lead(demo),
        synthetic=bool(demo.summary["synthetic"]),
    )
    found = demo.diagnosis
    page.add(
        "verdict", "Verdict", _verdict(demo), cards(changes(demo)), _caveat(demo), next_tests_html(found)
    )
    if demo.summary["rounds"]:
        page.add("settled", "Further tests", _settled(demo))
    page.add("budget", "Error budget", budget_html(found))
    page.add("force", "Forming force", _force(demo))
    page.plot(
        "residual",
        "Residuals",
        residual_chart(demo.held_out.points, demo.predicted),
        "Measured minus modelled mu on the held-out tests. The intervals count a whole test as one observation, so they show "
        "what another set of tests might have given. A model that lacks nothing stays within its band around zero.",
        "Mean residual against each of the five loads, before and after.",
    )
    page.add("evidence", "Evidence", ranking_html(found), remarks_html(found))
    page.add("tests", "Worst tests", _worst(demo))
    page.add("predicted", "Tests not run", prediction_html(demo))
    page.add("response", "Response curves", _response(demo))
    page.add("runs", "Runs", _runs(demo))
    return page.render(footer(VIRTUAL, demo.summary["versions"]))


def changes(demo: DemoFolder) -> list[Change]:
    """Return the errors before and after, also where they rose."""
    summary = demo.summary
    sct, forces = summary["held_out"], summary["forces"]
    tests, count = sct["before"]["tests"], len(summary["levels"])
    levels = f"{count} levels" if count > 1 else "one level"

    def change(name: str, unit: str, decimals: int, values: Callable[[str], float]) -> Change:
        after = values("after") if "after" in sct else None
        return Change(name, values("before"), after, unit, decimals)

    return [
        change(f"mu, RMS error on {tests} held-out tests", "", 4, lambda p: sct[p]["rmse"]),
        change(f"mu, mean absolute error on {tests} held-out tests", "", 4, lambda p: sct[p]["mae"]),
        change(f"maximum force, mean error over {levels}", "%", 1, lambda p: 100 * forces[p]["max_force"]["mare"]),
        change(f"forming work, mean error over {levels}", "%", 1, lambda p: 100 * forces[p]["work"]["mare"]),
    ]  # fmt: skip


def _headline(demo: DemoFolder) -> str:
    before, effects = demo.label("before"), demo.diagnosis["effects"]
    if not effects:
        return f"The {before} model lacks nothing that this data can show"
    named = listed(make_effect(name).label for name in effects)
    change = changes(demo)[0].relative
    verb = "removes" if change < 0 else "adds"
    best, it = (" fits best", "it") if len(effects) == 1 else (" fit best", "them")
    doubt = best if demo.diagnosis["verdict"] == "ambiguous" else ""
    return f"Missing from the {before} model: {named}{doubt}. Adding {it} {verb} {abs(100 * change):.0f} % of its error on unseen tests"


def _lead(demo: DemoFolder) -> str:
    summary = demo.summary
    hidden = summary["hidden"]
    truth = (
        f"<strong>{escape(hidden)}</strong> was hidden in the laboratory's law, in another mathematical form than the catalogue's"
        if hidden
        else "nothing was hidden in the laboratory's law"
    )
    return (
        f"{summary['tests']['train']} virtual compression tests trained the models, {summary['tests']['test']} were held out; "
        f"{truth}. The diagnosis saw measurements only. Every friction model then ran as an FMU in a co-simulated "
        "forward rod extrusion."
    )


def _verdict(demo: DemoFolder) -> str:
    """Return the verdict, and which share of the error above the noise floor the effect removes."""
    text = verdict_text(demo.diagnosis)
    held_out, floor = demo.summary["held_out"], float(demo.diagnosis["noise_floor"]["total"])
    if "after" not in held_out:
        return text
    before, after = held_out["before"]["rmse"] ** 2, held_out["after"]["rmse"] ** 2
    if before <= floor**2:
        return text
    removed = 100 * (before - after) / (before - floor**2)
    return (
        text
        + f"<p>On the held-out tests, the addition removes about {removed:.0f} % of the mean square error above the noise floor, "
        "the part of the error that a better model can remove.</p>"
    )


def _settled(demo: DemoFolder) -> str:
    """Return which further tests were run, and what each was expected to tell and told."""
    rows = [
        (
            r["protocol"], setpoints_text(r["setpoints"]), " / ".join(r["separates"]), f"{r['expected_t']:.3g}",
            f"{r['entropy_reduction']:.2f}", ", ".join(r["before"]), ", ".join(r["after"]) or "none",
        )
        for r in demo.summary["rounds"]
    ]  # fmt: skip
    headings = ["protocol", "set points", "tells apart", "standard errors", "bits", "not told apart before", "after"]  # fmt: skip
    said = (
        "<p>The first answer was ambiguous. The tests that the diagnosis proposed were run in the virtual laboratory, with the same "
        "lubricant and new specimens, and all tests were diagnosed again. Bits: by how much a proposal was expected to reduce "
        "the entropy of the answer; one bit tells two equal rivals apart.</p>"
    )
    return said + table(headings, rows, numeric=(3, 4))


def _caveat(demo: DemoFolder) -> str:
    risen = [c.name for c in changes(demo) if c.rose]
    if not risen:
        return ""
    return f'<p class="note">Not everything fell: {escape("; ".join(risen))} rose. The numbers stand as they came out.</p>'


def _force(demo: DemoFolder) -> str:
    levels = {level["name"]: level["heading"] for level in demo.summary["levels"]}
    chart = figure(
        "force",
        force_chart(demo.lines, levels),
        "Top: punch force of forward rod extrusion with every friction FMU, one after the other in the same forming FMU, "
        "against the mean of the (synthetic) press curves with their scatter. Bottom: the same as a deviation from the press. On the rising flank the elastic give of the press shows, which the simulation does not have; friction shows after it.",
        "Force over stroke for each friction model and each level of tool temperature and press speed.",
    )
    forces = demo.summary["forces"]
    rows, classes = [], []
    for entry in demo.summary["frictions"]:
        result = forces[entry["part"]]
        force, work = result["max_force"], result["work"]
        rows.append(
            (
                entry["label"],
                percent(force["mare"], force["mare_std"]),
                percent(force["std"], force["std_std"]),
                percent(work["mare"], work["mare_std"]),
                f"{max(c['max_force_kN']['simulated'] for c in result['levels']):.0f} kN",
                _outside(entry["outside_domain"]),
            )
        )
        classes.append(entry["part"])
    listed = table(
        ["friction", "maximum force, MARE", "spread over levels", "forming work, MARE", "largest force", "outside domain"],
        rows,
        numeric=range(1, 6),
        classes=classes,
        caption="Mean absolute relative error over the levels; uncertainty by Gaussian propagation of the scatter between press "
        "strokes. Outside domain: share of active contact points beyond the loads that the model was trained on, and how far "
        "beyond, as a share of the trained range (median). The FMU moves such loads to the edge of the domain.",
    )  # fmt: skip
    return chart + listed


def _worst(demo: DemoFolder) -> str:
    points = demo.held_out.points
    square = (points["mu"].to_numpy() - demo.predicted["before"]) ** 2
    rms = points.assign(square=square).groupby("test_id")["square"].mean().pow(0.5)
    worst = [str(test) for test in rms.index[np.argsort(-rms.to_numpy())[:4]]]
    chart = figure(
        "worst",
        worst_tests_chart(points, demo.predicted, worst),
        "The held-out tests on which the model was worst before: mu over the sliding distance.",
        f"Friction over sliding distance in the tests {', '.join(worst)}.",
    )
    rows = [(w["test_id"], f"{w['rms']:.4f}") for w in demo.diagnosis["worst_tests"][:6]]
    caption = "Worst tests in the eyes of the diagnosis."
    headings = ["training test", "RMS of the residual"]
    return chart + table(headings, rows, numeric=(1,), caption=caption, narrow=True)


def _response(demo: DemoFolder) -> str:
    parts = [part for part in ("before", "other", "after") if part in demo.models]
    curves = [(demo.label(part), STYLES[part], demo.models[part]) for part in parts]
    loads = demo.held_out.loads()
    said = caption(loads, [model for *_, model in curves])
    chart = figure("response", response_chart(loads, curves), said, "Response curves of the friction models.")
    laws = [(label, _short(model.formula_text())) for label, _, model in curves]
    return chart + table(["model", "law"], laws)


def _runs(demo: DemoFolder) -> str:
    summary = demo.summary
    rows = []
    for entry in summary["frictions"]:
        for level in summary["levels"]:
            name = entry["runs"][level["name"]]
            facts = summary["run_facts"][name]
            rows.append(
                (
                    Path(name).name, entry["label"], level["heading"], facts["steps"], f"{facts['seconds']:.1f} s",
                    f"{100 * facts['share_friction']:.1f} %", f"{facts['master_us_per_step']:.0f} us",
                    f"{facts['max_tau_over_k']:.2f}", facts["friction_sha256"][:12],
                )
            )  # fmt: skip
    headings = ["run", "friction", "level", "steps", "time", "friction", "master a step", "max tau/k", "friction FMU"]  # fmt: skip
    runs = table(headings, rows, numeric=range(3, 8))
    settings = [
        ("seed", summary["seed"]),
        ("plan", summary["plan"]),
        ("hidden effect", summary["hidden"] or "none"),
        *((f"seconds: {k}", f"{v:.1f}") for k, v in summary["seconds"].items()),
        *sorted(summary["versions"].items()),
    ]
    return (
        runs
        + "<p>Every run has a folder of its own with the resolved system, the manifest with the hashes of its FMUs, results and log.</p>"
        + f"<details><summary>Manifest of the demo</summary>{table(['what', 'value'], settings, narrow=True)}</details>"
    )


def _outside(found: dict[str, float]) -> str:
    if not found["share"]:
        return "none"
    return f"{100 * found['share']:.0f} % by {100 * found['median_distance']:.0f} %"


def _short(text: str) -> str:
    return text if len(text) <= 260 else f"{text[:257]}..."
