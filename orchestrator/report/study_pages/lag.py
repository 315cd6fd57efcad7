"""The report of the study ``lag``."""

from __future__ import annotations

from collections.abc import Sequence

from friction_models.common.markup import bullets, escape, paragraph, table

from ...studies.lag.result import LagNumbers, LagRun, Quantity, Reference, groups
from ...studies.lag.study import Mode
from ...studies.lag.words import headline
from ..parts.chart import Chart
from ..parts.page import Page, footer
from ..parts.theme import COLORS

#: Colour of each mode.
_MODES: dict[Mode, str] = {"jacobi": COLORS[1], "gauss_seidel": COLORS[0], "iterated": COLORS[2]}
_LABELS: dict[Mode, str] = {
    "jacobi": "jacobi (two steps of lag)",
    "gauss_seidel": "gauss_seidel (one step)",
    "iterated": "iterated (none)",
}
_TITLES: dict[Quantity, str] = {
    "work_pct": "work [%]",
    "max_force_pct": "maximum force [%]",
    "rms_pct": "rms of the force [%]",
    "mu_mean": "mean change of mu",
}


def lag_page(values: LagNumbers) -> str:
    """Return the HTML of the numbers of the study."""
    settings = values["settings"]
    strokes = ", ".join(f"{p.upper()} ({s:g} mm of stroke)" for p, s in settings["stroke_mm"].items())
    page = Page(
        title=headline(values),
        kicker="tribofmu study lag: friction from the loads of the step before, against iterated coupling",
        lead=escape(
            f"{strokes} at {settings['speed_mm_s']:g} mm/s with tools of "
            f"{settings['T_tool_degC']:g} degC; {', '.join(settings['models'])}; communication steps of "
            f"{', '.join(f'{s:g}' for s in settings['steps_mm'])} mm, all compared every {settings['compared_every_mm']:g} mm of stroke."
        ),
        synthetic=bool(values["synthetic"]),
    )
    lagging = [r for r in values["rows"] if r.get("lag")]
    if lagging:
        page.plot(
            "cost",
            "What the lag costs",
            _deviations(lagging, "lag", ["work_pct", "rms_pct", "mu_mean"]),
            "Each run against the iterated run of the same step: what differs is the lag alone. Forming work, rms of the "
            "force in units of its maximum, and mu at the markers in contact.",
            "Deviation of work, force and mu over the communication step for jacobi and gauss_seidel.",
            _summary(values),
        )
    finest = [r for r in values["rows"] if r.get("to_finest")]
    if finest:
        page.plot(
            "finest",
            "Against the finest iterated run",
            _deviations(finest, "to_finest", ["work_pct", "max_force_pct", "rms_pct"]),
            f"Each run against the iterated run with {min(settings['steps_mm']):g} mm. The iterated runs differ from it because "
            "the solver itself then makes other steps.",
            "Deviation of work and force from the finest iterated run over the communication step.",
        )
        page.plot(
            "curves",
            "Over the stroke",
            _curves(values),
            f"Deviation of the force from the finest iterated run, longest step ({max(settings['steps_mm']):g} mm).",
            "Deviation of the punch force over the stroke for the three modes.",
        )
    page.add("runs", "Runs", _runs(values))
    failed = [
        f"{r['process']}, {r['model']}, {r['mode']}, {r['step_mm']:g} mm: {r['failed']}"
        for r in values["rows"]
        if r["failed"]
    ]
    if failed:
        page.add("failed", "Runs that broke off", bullets(failed))
    whose = "synthetic" if values["synthetic"] else "the user's"
    return page.render(footer(f"The friction models learned from {whose} measurements."))


def _deviations(rows: Sequence[LagRun], which: Reference, panels: Sequence[Quantity]) -> Chart:
    shown = groups(rows)
    chart = Chart(
        len(shown), len(panels), titles=[f"{p.upper()}, {m}" for p, m in shown], shared_xaxes=True,
        shared_yaxes="rows", vertical_spacing=0.05, horizontal_spacing=0.03,
    )  # fmt: skip
    for column, group in enumerate(shown):
        for mode, color in _MODES.items():
            mine = sorted(
                (
                    (r["step_mm"], deviation)
                    for r in rows
                    if (r["process"], r["model"]) == group
                    and r["mode"] == mode
                    and (deviation := r.get(which)) is not None
                ),
                key=lambda found: found[0],
            )
            if not mine or (which == "lag" and mode == "iterated"):
                continue
            for row, name in enumerate(panels):
                chart.scatter(
                    row * len(shown) + column, [step for step, _ in mine], [deviation[name] for _, deviation in mine],
                    _LABELS[mode], f"{mode} %{{x:g}} mm: %{{y:.3g}}<extra></extra>", mode,
                    mode="lines+markers", line={"color": color, "width": 2},
                )  # fmt: skip
    height = 190 * len(panels) + 70
    return chart.dress(height, x="communication step [mm]", y=[_TITLES[name] for name in panels], margin_t=66)


def _curves(values: LagNumbers) -> Chart:
    longest = max(values["settings"]["steps_mm"])
    mine = [c for c in values["curves"] if c["step_mm"] == longest]
    shown = groups(mine) or [("", "")]
    chart = Chart(len(shown), titles=[f"{p.upper()}, {m}" for p, m in shown], horizontal_spacing=0.05)
    for panel, group in enumerate(shown):
        for curve in mine:
            if (curve["process"], curve["model"]) == group:
                mode = curve["mode"]
                chart.scatter(
                    panel, curve["stroke"], curve["deviation_kN"], _LABELS[mode], "%{x:.1f} mm: %{y:+.2f} kN<extra></extra>",
                    mode, line={"color": _MODES[mode], "width": 2},
                )  # fmt: skip
    return chart.dress(320, x="stroke [mm]", y="force deviation [kN]", margin_t=66)


def _summary(values: LagNumbers) -> str:
    rows = []
    for e in values["summary"]:
        if not e["runs"]:
            continue
        cost = e["timing"].get("relative")
        rows.append(
            (
                e["process"].upper(), e["model"], e["mode"], f"{e['work_pct_per_mm']:+.3f}", f"{e['max_force_pct_per_mm']:+.3f}",
                f"{e['rms_pct_per_mm']:.3f}", f"{e['mu_mean_per_mm']:.5f}", "-" if cost is None else f"{cost:.1f}",
            )
        )  # fmt: skip
    return paragraph(
        "Per millimetre of communication step, by least squares through zero: jacobi and gauss_seidel against the iterated "
        "run of the same step, iterated against the finest. Cost: time of a run, as a multiple of gauss_seidel."
    ) + table(
        ["process", "model", "mode", "work [%/mm]", "max force [%/mm]", "rms [%/mm]", "mu [1/mm]", "cost"],
        rows,
        numeric=range(3, 8),
    )


def _runs(values: LagNumbers) -> str:
    rows = []
    for r in values["rows"]:
        lag = r.get("lag")
        rows.append(
            (
                r["process"].upper(), r["model"], f"{r['step_mm']:g}", r["mode"] + (" (broke off)" if r["failed"] else ""),
                *(f"{r[k]:.1f}" if k in r else "-" for k in ("max_force_kN", "work_J")),
                f"{lag['work_pct']:+.3f}" if lag else "-", f"{lag['mu_max']:.4f}" if lag else "-",
                f"{r.get('repetitions_mean', 0):.1f}" if "steps" in r else "-",
                f"{r['timing']['run_s']:.1f}" if r.get("timing") else "-",
            )
        )  # fmt: skip
    return table(
        ["process", "model", "step [mm]", "mode", "max force [kN]", "work [J]", "lag in work [%]", "largest change of mu", "repetitions", "time [s]"],
        rows, numeric=(2, 4, 5, 6, 7, 8, 9), caption="Times depend on the machine and on what else it did.",
    )  # fmt: skip
