"""The report of the study ``extrapolation``."""

from __future__ import annotations

from typing import Literal

from friction_models.common.markup import bullets, escape, paragraph, table
from friction_models.common.wording import listed

from ...studies.extrapolation.result import ExtrapolationNumbers, ExtrapolationRun
from ...studies.extrapolation.study import DataKind, Rule
from ...studies.extrapolation.words import headline
from ..parts.chart import Chart
from ..parts.page import Page, footer
from ..parts.theme import COLORS, looks

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
            f"{listed(settings['reduced_by'])}; forming with loads clamped to the trained domain and with extrapolation."
        ),
        synthetic=bool(values["synthetic"]),
    )
    runs = [r for r in values["runs"] if "states" in r]
    if runs:
        page.plot(
            "outside",
            "How much of the contact is outside",
            _by_load(runs),
            "Share of the contact (area and time) beyond the trained range of each load, clamped runs of the first model.",
            "Bars of the share of contact outside the trained domain by load.",
            _exceedances(runs),
        )
        page.plot(
            "mu",
            "Friction that was reached",
            _mu(runs),
            "From the 5th to the 95th percentile of mu in the contact (bar), median (dot) and the extremes (line); cut where "
            "they leave the chart.",
            "Range of mu in the forming runs by model, training data and rule.",
        )
        page.plot(
            "rules",
            "Clamp against extrapolate",
            _pairs(values),
            "Extrapolated run over clamped run of the same model, training data and level.",
            "Change of maximum force and work by extrapolation.",
            _pair_table(values),
        )
    page.add("models", "Models", _models(values))
    page.add("runs", "Runs", _runs(values))
    failed = [
        f"{r['level']}, {r['model']}, {r['data']}, {r['rule']}: {r['failed']}"
        for r in values["runs"]
        if r["failed"]
    ]
    page.add("failed", "Runs that broke off", bullets(failed) if failed else paragraph("None."))
    whose = "synthetic" if values["synthetic"] else "the user's"
    return page.render(footer(f"The friction models learned from {whose} measurements."))


def _first(runs: list[ExtrapolationRun]) -> list[ExtrapolationRun]:
    """Return the clamped runs of the first model: what the process asks for hardly depends on the model."""
    clamped = [r for r in runs if r["rule"] == "clamp"] or runs
    return [r for r in clamped if r["model"] == clamped[0]["model"]]


def _by_load(runs: list[ExtrapolationRun]) -> Chart:
    mine = _first(runs)
    levels = list(dict.fromkeys(r["level"] for r in mine))
    kinds = [k for k in _DATA if any(r["data"] == k for r in mine)]
    chart = Chart(
        len(levels), len(kinds), titles=[f"{level}, {kind}" for kind in kinds for level in levels],
        shared_yaxes=True, shared_xaxes=True, vertical_spacing=0.12, horizontal_spacing=0.03,
    )  # fmt: skip
    for r in mine:
        panel = kinds.index(r["data"]) * len(levels) + levels.index(r["level"])
        for side, color in _SIDES.items():
            chart.bars(
                panel, [i["load"] for i in r["loads"]], [100 * i[side]["share"] for i in r["loads"]],
                f"{side} the trained range", "%{x}: %{y:.1f} %<extra></extra>", marker_color=color,
            )  # fmt: skip
    chart.dress(220 * len(kinds) + 60, y="contact [%]", margin_t=66, barmode="stack")
    chart.figure.update_yaxes(range=[0, 100])
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


def _mu(runs: list[ExtrapolationRun]) -> Chart:
    kinds = [k for k in _DATA if any(r["data"] == k for r in runs)]
    titles = [_DATA[k] for k in kinds]
    chart = Chart(len(kinds), titles=titles, shared_yaxes=True, horizontal_spacing=0.03)
    models = list(dict.fromkeys(r["model"] for r in runs))
    for panel, kind in enumerate(kinds):
        for place, (rule, color) in zip((-0.17, 0.17), _RULES.items()):
            x, middle, extremes = list[float](), list[float](), list[tuple[float, float]]()
            for number, model in enumerate(models):
                found = [r["mu"] for r in runs if (r["model"], r["data"], r["rule"]) == (model, kind, rule)]
                if not found:
                    continue
                x.append(number + place)
                middle.append(sorted(mu["median"] for mu in found)[len(found) // 2])
                extremes.append((min(mu["low"] for mu in found), max(mu["high"] for mu in found)))
                most = min(mu["p5"] for mu in found), max(mu["p95"] for mu in found)
                for ends, width in ((extremes[-1], 1.5), (most, 9)):
                    line = {"color": color, "width": width}
                    chart.scatter(panel, [x[-1]] * 2, ends, mode="lines", line=line, opacity=0.75)
            chart.scatter(
                panel, x, middle, rule, "median %{y:.4f}, %{customdata[0]:.4f} to %{customdata[1]:.4f}<extra></extra>",
                mode="markers", marker={"color": color, "size": 11, "line": {"color": "white", "width": 1.5}},
                customdata=extremes,
            )  # fmt: skip
    chart.figure.update_xaxes(tickvals=list(range(len(models))), ticktext=models)
    chart.dress(360, y="mu in the contact", margin_t=66)
    chart.figure.update_xaxes(zeroline=False)
    # A model that runs away must not flatten all others.
    top = min(0.3, 1.3 * max(0.1, *(r["mu"]["p95"] for r in runs)))
    chart.figure.update_yaxes(range=[0, top])
    return chart


def _pairs(values: ExtrapolationNumbers) -> Chart:
    pairs = [p for p in values["pairs"] if "work_J_pct" in p]
    chart = Chart(
        len(_DATA), 2, titles=list(_DATA.values()), shared_xaxes=True, shared_yaxes="rows",
        vertical_spacing=0.06, horizontal_spacing=0.03,
    )  # fmt: skip
    for model, style in looks(dict.fromkeys(p["model"] for p in pairs)).items():
        for column, kind in enumerate(_DATA):
            mine = [p for p in pairs if p["data"] == kind and p["model"] == model]
            levels, said = [p["level"] for p in mine], f"{model} %{{y:+.2f}} %<extra></extra>"
            changes = [p["max_force_kN_pct"] for p in mine], [p["work_J_pct"] for p in mine]
            for row, change in enumerate(changes):
                panel = row * len(_DATA) + column
                chart.bars(panel, levels, change, model, said, marker_color=style["color"])
    titles = ["max force [%]", "work [%]"]
    return chart.dress(420, y=titles, margin_t=66, barmode="group")


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
        (m["model"], m["data"], m["tests"], m["points"], "-" if m["mae_test"] is None else f"{m['mae_test']:.4f}")
        for m in values["models"]
    ]  # fmt: skip
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
