"""The demo's summary for the terminal."""

from __future__ import annotations

from friction_models.discovery.answer.figures_data import setpoints_text

from ..force_curves.metrics import percent
from ..report.sections.demo_folder import DemoSummary, FrictionEntry
from .loop import DemoResult


def printed_summary(result: DemoResult) -> str:
    """Return verdict, errors before and after as they came out, and where the report is."""
    s = result.summary
    diagnosis = s["diagnosis"]
    effects = ", ".join(diagnosis["effects"]) or "none"
    lines = [
        "",
        "All measurements are SYNTHETIC: made by the virtual laboratory, not measured.",
        *_settling(s),
        f"Verdict on the {s['base']} model: {diagnosis['verdict']}; effect to add: {effects} "
        f"(hidden in the laboratory: {s['hidden'] or 'nothing'})",
        "",
        f"{'':26}{'held-out SCTs':>24}{'FRE maximum force':>24}{'FRE forming work':>22}",
        f"{'':26}{'MAE of mu':>12}{'RMS of mu':>12}{'MARE':>24}{'MARE':>22}",
    ]
    lines += [_row(s, entry) for entry in s["frictions"]]
    if any(e["part"] == "after" for e in s["frictions"]):
        lines += ["", "Before -> after, as it came out:"]
        lines += [_change(*item) for item in _changes(s)]
    lines += ["", f"Report: {result.report}", f"Everything else: {result.folder}"]
    return "\n".join(lines)


def _settling(s: DemoSummary) -> list[str]:
    """Say which further tests were run, and what they changed."""
    if not s["rounds"]:
        return []
    first, count = s["rounds"][0]["before"], sum(r["tests"] for r in s["rounds"])
    lines = [
        f"The first answer was ambiguous: {s['tests']['train']} tests cannot tell {', '.join(first)} apart.",
        f"So what the diagnosis proposed was run in the virtual laboratory ({count} more test{'s' if count > 1 else ''}):",
    ]
    for r in s["rounds"]:
        lines += [
            f"  {r['protocol']}: {setpoints_text(r['setpoints'])}",
            f"    expected to tell {' from '.join(r['separates'])} by {r['expected_t']:.3g} standard errors, {r['entropy_reduction']:.2f} bits",
            *(f"    {line}" for line in r["changed"].rstrip().splitlines()[1:]),
        ]
    return [*lines, ""]


def _row(s: DemoSummary, entry: FrictionEntry) -> str:
    part = entry["part"]
    sct, force, work = s["held_out"][part], s["forces"][part]["max_force"], s["forces"][part]["work"]
    shown = [percent(summary["mare"], summary["mare_std"]) for summary in (force, work)]
    return f"{entry['label'][:25]:26}{sct['mae']:12.4f}{sct['rmse']:12.4f}{shown[0]:>24}{shown[1]:>22}"


def _changes(s: DemoSummary) -> list[tuple[str, float, float, str]]:
    sct, forces = s["held_out"], s["forces"]
    loop = {part: s["predicted"][part]["summary"] for part in ("before", "after")}
    count = len(s["predicted"]["before"]["tests"])
    return [
        ("MAE of mu, held-out SCTs", sct["before"]["mae"], sct["after"]["mae"], ".4f"),
        ("RMS of mu, held-out SCTs", sct["before"]["rmse"], sct["after"]["rmse"], ".4f"),
        (f"RMS of mu, {count} SCTs, closed loop", loop["before"]["mu_rms"], loop["after"]["mu_rms"], ".4f"),
        (f"RMS of T [K], {count} SCTs, closed loop", loop["before"]["T_rms"], loop["after"]["T_rms"], ".1f"),
        ("MARE of the maximum force", forces["before"]["max_force"]["mare"], forces["after"]["max_force"]["mare"], ".1%"),
        ("MARE of the forming work", forces["before"]["work"]["mare"], forces["after"]["work"]["mare"], ".1%"),
    ]  # fmt: skip


def _change(name: str, before: float, after: float, form: str) -> str:
    word = "falls" if after < before else "RISES" if after > before else "stays"
    share = abs(after - before) / before if before else 0.0
    return f"  {name:33} {before:{form}} -> {after:{form}}   {word} by {share:.0%}"
