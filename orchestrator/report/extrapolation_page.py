"""The report of the study ``extrapolation``."""

from __future__ import annotations

from typing import Any, Literal

from ..jobs.versions import versions
from ..studies.extrapolation.result import ExtrapolationNumbers, ExtrapolationRun
from ..studies.extrapolation.study import DataKind, Rule
from ..studies.extrapolation.words import headline
from .parts.markup import bullets, escape, paragraph, table
from .parts.page import Page, figure, footer
from .parts.palette import COLORS, looks
from .parts.theme import dress

_RULES: dict[Rule, str] = {"clamp": COLORS[0], "extrapolate": COLORS[1]}
_SIDES: dict[Literal["below", "above"], str] = {"below": COLORS[4], "above": COLORS[1]}
_DATA: dict[DataKind, str] = {"all": "all training tests", "reduced": "low pressure and temperature only"}


def extrapolation_page(values: ExtrapolationNumbers) -> str:
    """Return the HTML of the numbers of the study."""
    settings = values["settings"]
    page = Page(
        title=headline(values),
        kicker="tribofmu study extrapolation: friction models beyond the loads that they were trained on",
        lead=escape(
            f"{', '.join(settings['models'])} trained on all tests and on the lower half of the tested "
            f"{' and '.join(settings['reduced_by'])}; forming with loads clamped to the trained domain and with extrapolation."
        ),
        synthetic=bool(values["synthetic"]),
    )
    runs = [r for r in values["runs"] if "states" in r]
    if runs:
        page.add(
            "outside",
            "How much of the contact is outside",
            figure(
                "loads", _by_load(runs),
                "Share of the contact (area and time) beyond the trained range of each load, clamped runs of the first model.",
                "Bars of the share of contact outside the trained domain by load.",
            ),
            _exceedances(runs),
        )  # fmt: skip
        page.add(
            "mu",
            "Friction that was reached",
            figure(
                "mu", _mu(runs), "From the 5th to the 95th percentile of mu in the contact (bar), median (dot) and the extremes (line); cut where they leave the chart.",
                "Range of mu in the forming runs by model, training data and rule.",
            ),
        )  # fmt: skip
        page.add("rules", "Clamp against extrapolate", figure(
            "pairs", _pairs(values), "Extrapolated run over clamped run of the same model, training data and level.",
            "Change of maximum force and work by extrapolation."), _pair_table(values))  # fmt: skip
    page.add("models", "Models", _models(values))
    page.add("runs", "Runs", _runs(values))
    failed = [
        f"{r['level']}, {r['model']}, {r['data']}, {r['rule']}: {r['failed']}"
        for r in values["runs"]
        if r["failed"]
    ]
    page.add("failed", "Runs that broke off", bullets(failed) if failed else paragraph("None."))
    whose = "synthetic" if values["synthetic"] else "the user's"
    return page.render(footer(versions(), f"The friction models learned from {whose} measurements."))


def _first(runs: list[ExtrapolationRun]) -> list[ExtrapolationRun]:
    """Return the clamped runs of the first model: what the process asks for hardly depends on the model."""
    clamped = [r for r in runs if r["rule"] == "clamp"] or runs
    return [r for r in clamped if r["model"] == clamped[0]["model"]]


def _by_load(runs: list[ExtrapolationRun]) -> Any:
    from plotly.subplots import make_subplots

    mine = _first(runs)
    levels = list(dict.fromkeys(r["level"] for r in mine))
    kinds = [k for k in _DATA if any(r["data"] == k for r in mine)]
    chart = make_subplots(
        rows=len(kinds), cols=len(levels), shared_yaxes=True, shared_xaxes=True, vertical_spacing=0.12,
        horizontal_spacing=0.03, subplot_titles=[f"{level}, {kind}" for kind in kinds for level in levels],
    )  # fmt: skip
    for r in mine:
        row, column = kinds.index(r["data"]) + 1, levels.index(r["level"]) + 1
        for side, color in _SIDES.items():
            chart.add_bar(
                x=[i["load"] for i in r["loads"]], y=[100 * i[side]["share"] for i in r["loads"]],
                name=f"{side} the trained range", legendgroup=side, showlegend=row == column == 1, marker_color=color,
                row=row, col=column, hovertemplate="%{x}: %{y:.1f} %<extra></extra>",
            )  # fmt: skip
    dress(chart, 220 * len(kinds) + 60)
    chart.update_layout(margin_t=66, barmode="stack")
    chart.update_yaxes(range=[0, 100])
    for row in range(1, len(kinds) + 1):
        chart.update_yaxes(title_text="contact [%]", row=row, col=1)
    return chart


def _exceedances(runs: list[ExtrapolationRun]) -> str:
    rows = []
    for r in _first(runs):
        for item in r["loads"]:
            for side in _SIDES:
                s = item[side]
                if s["share"] > 0.0005:
                    rows.append(
                        (
                            r["level"], r["data"], f"{item['load']} {side}", "{:.4g} to {:.4g}".format(*item["trained"]),
                            "{:.4g} to {:.4g}".format(*item["reached"]), f"{100 * s['share']:.1f}", f"{100 * s['work']:.1f}",
                            f"{s['median']:.3g} {item['unit']}".replace(" 1", ""), f"{s['median_ranges']:.3f}",
                        )
                    )  # fmt: skip
    return table(
        ["level", "trained on", "load", "trained", "reached", "contact [%]", "friction work [%]", "median beyond", "in ranges"],
        rows, numeric=(5, 6, 7, 8), caption="A range is the width of the trained domain in this load.",
    )  # fmt: skip


def _mu(runs: list[ExtrapolationRun]) -> Any:
    from plotly.subplots import make_subplots

    kinds = [k for k in _DATA if any(r["data"] == k for r in runs)]
    chart = make_subplots(
        rows=1,
        cols=len(kinds),
        shared_yaxes=True,
        horizontal_spacing=0.03,
        subplot_titles=[_DATA[k] for k in kinds],
    )
    models = list(dict.fromkeys(r["model"] for r in runs))
    for column, kind in enumerate(kinds, 1):
        for place, (rule, color) in zip((-0.17, 0.17), _RULES.items()):
            mine = [
                (m, [r for r in runs if (r["model"], r["data"], r["rule"]) == (m, kind, rule)])
                for m in models
            ]
            mine = [(m, found) for m, found in mine if found]
            x = [models.index(m) + place for m, _ in mine]
            low = [min(r["mu"]["low"] for r in found) for _, found in mine]
            high = [max(r["mu"]["high"] for r in found) for _, found in mine]
            p5 = [min(r["mu"]["p5"] for r in found) for _, found in mine]
            p95 = [max(r["mu"]["p95"] for r in found) for _, found in mine]
            middle = [sorted(r["mu"]["median"] for r in found)[len(found) // 2] for _, found in mine]
            for ends, width in (((low, high), 1.5), ((p5, p95), 9)):
                for k, at in enumerate(x):
                    chart.add_scatter(
                        x=[at, at], y=[ends[0][k], ends[1][k]], mode="lines", line={"color": color, "width": width}, opacity=0.75,
                        showlegend=False, hoverinfo="skip", row=1, col=column,
                    )  # fmt: skip
            chart.add_scatter(
                x=x, y=middle, mode="markers", marker={"color": color, "size": 11, "line": {"color": "white", "width": 1.5}},
                name=rule, legendgroup=rule, showlegend=column == 1, row=1, col=column,
                customdata=list(zip(low, high)), hovertemplate="median %{y:.4f}, %{customdata[0]:.4f} to %{customdata[1]:.4f}<extra></extra>",
            )  # fmt: skip
        chart.update_xaxes(tickvals=list(range(len(models))), ticktext=models, row=1, col=column)
    dress(chart, 360)
    chart.update_layout(margin_t=66)
    chart.update_xaxes(zeroline=False)
    # A model that runs away must not flatten all others.
    top = min(0.3, 1.3 * max(0.1, *(r["mu"]["p95"] for r in runs)))
    chart.update_yaxes(range=[0, top])
    chart.update_yaxes(title_text="mu in the contact", row=1, col=1)
    return chart


def _pairs(values: ExtrapolationNumbers) -> Any:
    from plotly.subplots import make_subplots

    pairs = [p for p in values["pairs"] if "work_J_pct" in p]
    kinds = list(_DATA)
    chart = make_subplots(
        rows=2, cols=2, shared_xaxes=True, shared_yaxes="rows", vertical_spacing=0.06, horizontal_spacing=0.03,
        subplot_titles=[_DATA[k] for k in kinds],
    )  # fmt: skip
    styles = looks(dict.fromkeys(p["model"] for p in pairs))
    for column, kind in enumerate(kinds, 1):
        for model, style in styles.items():
            mine = [p for p in pairs if p["data"] == kind and p["model"] == model]
            changes = [p["max_force_kN_pct"] for p in mine], [p["work_J_pct"] for p in mine]
            for row, change in enumerate(changes, 1):
                chart.add_bar(
                    x=[p["level"] for p in mine], y=change, name=model, legendgroup=model,
                    showlegend=row == column == 1, marker_color=style["color"], row=row, col=column,
                    hovertemplate=f"{model} %{{y:+.2f}} %<extra></extra>",
                )  # fmt: skip
    dress(chart, 420)
    chart.update_layout(margin_t=66, barmode="group")
    chart.update_yaxes(title_text="max force [%]", row=1, col=1)
    chart.update_yaxes(title_text="work [%]", row=2, col=1)
    return chart


def _pair_table(values: ExtrapolationNumbers) -> str:
    rows = []
    for p in values["pairs"]:
        head = (p["level"], p["model"], p["data"])
        if p["failed"]:
            rows.append((*head, f"broke off: {', '.join(p['failed'])}", "-", "-", "-"))
            continue
        rows.append(
            (
                *head, f"{p['max_force_kN_pct']:+.2f}", f"{p['work_J_pct']:+.2f}",
                "{:.3f} to {:.3f}".format(*p["mu_clamp"]), "{:.3f} to {:.3f}".format(*p["mu_extrapolate"]),
            )
        )  # fmt: skip
    return table(
        ["level", "model", "trained on", "max force [%]", "work [%]", "mu clamped", "mu extrapolated"],
        rows,
        numeric=(3, 4, 5, 6),
    )


def _models(values: ExtrapolationNumbers) -> str:
    rows = [
        (
            m["model"],
            m["data"],
            m["tests"],
            m["points"],
            "-" if m["mae_test"] is None else f"{m['mae_test']:.4f}",
        )
        for m in values["models"]
    ]
    return table(["model", "trained on", "tests", "points", "MAE on held-out tests"], rows, numeric=(2, 3, 4))


def _runs(values: ExtrapolationNumbers) -> str:
    rows = []
    for r in values["runs"]:
        head = (r["level"], r["model"], r["data"], r["rule"] + (" (broke off)" if r["failed"] else ""))
        if "states" not in r:
            rows.append((*head, *"--------"))
            continue
        rows.append(
            (
                *head, f"{100 * r['outside']:.1f}", f"{100 * r['outside_work']:.1f}", f"{r['distance']['median']:.3f}",
                f"{r['distance']['largest']:.3f}", f"{r['max_force_kN']:.1f}", f"{r['work_J']:.0f}", f"{r['friction_work_J']:.0f}",
                f"{r['tau_over_k']:.2f}",
            )
        )  # fmt: skip
    return table(
        ["level", "model", "trained on", "rule", "outside [%]", "by work [%]", "distance", "largest", "max force [kN]", "work [J]", "friction [J]", "tau/k"],
        rows, numeric=range(4, 12), caption="Distance: median beyond the domain, of the contact outside, in units of the trained range. Contact counts by "
        "the area that a marker stands for; friction: work of mu times pressure and speed on that area.",
    )  # fmt: skip
