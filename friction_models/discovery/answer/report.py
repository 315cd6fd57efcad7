"""The text report of a diagnosis, for the terminal: what the page shows, in the same order."""

from __future__ import annotations

import math

import numpy as np

from ...common.errors import shown
from ...common.wording import listed
from ...loads.contract import behind, with_unit
from ..formulas.offers import offer_lines
from .figures_data import (
    LoadMap,
    effect_curve,
    load_map,
    setpoints_text,
    structure_pair,
    where_text,
)
from .findings import ORDER_OF_RANKING, OTHERS_BY_CHANCE, Findings, ParameterValue
from .uncertain_loads import from_loads_text
from .wording import (
    about_next_tests,
    floor_source,
    interval_text,
    mu_format,
    p_text,
    parts_of_floor,
    told_by,
)

#: Cells of the map along each load, and places of a response curve.
CELLS = 6
PLACES = 6


def text_report(findings: Findings) -> str:
    """Return findings as text, the verdict in one sentence first."""
    d = findings
    lines = [f"{d.verdict.upper()}: {d.sentence}", *(["(synthetic data)"] if d.synthetic else [])]
    for part in (_next, _budget, _residuals, _map, _evidence, _structure, _formulas, _worst, _response):
        found = part(d)
        if found:
            lines += ["", *found]
    if d.warnings:
        lines += ["", "Read this with care"] + [f"  - {w}" for w in d.warnings]
    return "\n".join(lines) + "\n"


def _next(d: Findings) -> list[str]:
    if not d.next_tests:
        return []
    lines = [
        "What to test next (bits: entropy of the answer that it should remove, 1 between two that are equally likely; standard errors by "
        "which it tells two apart)"
    ]
    if about := about_next_tests(d.verdict):
        lines.append(f"  ({about})")
    for n in d.next_tests:
        pair = len(n["separates"]) > 1
        tests = f" by {n['tests']} tests" if n["tests"] > 1 else ""
        parts = [
            f"  {n['protocol']}: {setpoints_text(n['setpoints'])}",
            *([f"{n['entropy_reduction']:.2f} bits{tests}"] if pair else []),
            told_by(n["separates"]) + (f": {n['expected_t']:.3g}" if pair else ""),
        ]
        lines.append("; ".join(parts))
    return lines


def _budget(d: Findings) -> list[str]:
    floor, budget = d.noise_floor, d.error_budget
    low, high = floor["interval"]
    after = math.hypot(budget["floor"], budget["missing"])
    before = math.hypot(after, budget["explained"])
    f, parts = mu_format(before), parts_of_floor(floor)
    lines = [
        f"Error budget of the {d.model} model (rms of mu in the averages; the squares add up, and whole unseen tests divide them)",
        f"  before        {before:{f}}",
        f"  noise floor   {budget['floor']:{f}}   (95 %: {low:{f}} to {high:{f}}{f'; {parts}' if parts else ''})",
    ]
    if source := floor_source(floor, d.effects):
        lines.append(f"                ({source})")
    if from_loads := from_loads_text(floor):
        lines.append(f"                ({from_loads})")
    if d.effects:
        lines.append(f"  explained     {budget['explained']:{f}}   by {listed(d.effects)}")
    lines.append(f"  still missing {budget['missing']:{f}}")
    return lines + ([f"  after         {after:{f}}"] if d.effects else [])


def _residuals(d: Findings) -> list[str]:
    if not d.bias:
        return []
    named = bool(d.effects)
    lines = [
        "Measured minus modelled mu against each load (mean, 95 % interval over whole tests)",
        f"  {'':<16}{'from':>10}{'to':>10}   {'before':<20}" + (f"{'after':<20}" if named else "") + "tests",
    ]
    shown = ""
    for b in d.bias:
        name = with_unit(b["load"]) if b["load"] != shown else ""
        shown = b["load"]
        values = _interval(b["bias"], b["interval"])
        if named:
            values += _interval(b["after"], b["after_interval"])
        lines.append(f"  {name:<16}{b['low']:>10.4g}{b['high']:>10.4g}   {values}{b['tests']:>5}")
    return lines


def _interval(mean: float, interval: list[float]) -> str:
    half = (interval[1] - interval[0]) / 2.0
    text = f"{mean:+.4f}" + (f" +- {half:.4f}" if math.isfinite(half) else "")
    return f"{text:<20}"


def _map(d: Findings) -> list[str]:
    pair = structure_pair(d)
    return _grid(d, load_map(d.averages, CELLS)) + (
        _grid(d, load_map(d.averages, CELLS, pair)) if pair else []
    )


def _grid(d: Findings, found: LoadMap | None) -> list[str]:
    if found is None:
        return []
    lines = [f"The same over {found.x} and {found.y}, in 0.001 (blank: no test there)"]
    parts = ["before", *(["after"] if d.effects else [])]
    head = f"  {with_unit(found.y):>14} "
    across = [f"{x:.4g}" for x in found.x_measured]
    cells = {p: [[_cell(v) for v in row] for row in found.mean[p]] for p in parts}
    # At least one blank between columns, whatever stands in them.
    width = max(7, *(len(c) + 1 for c in [*across, *(c for p in parts for row in cells[p] for c in row)]))
    axis = "".join(f"{m:>{width}}" for m in across)
    lines.append(head + "   ".join(f"{p + ', ' + with_unit(found.x):<{width * CELLS}}" for p in parts))
    lines.append(" " * len(head) + "   ".join([axis] * len(parts)))
    for k in reversed(range(CELLS)):
        rows = ["".join(f"{c:>{width}}" for c in cells[p][k]) for p in parts]
        lines.append(f"  {found.y_measured[k]:>14.4g} " + "   ".join(rows))
    return [x.rstrip() for x in lines]


def _cell(value: float) -> str:
    return f"{1000 * value:+.1f}" if math.isfinite(value) else ""


def _evidence(d: Findings) -> list[str]:
    lines = [
        "Ranked evidence, each effect alone beside the model (gain: drop of the whitened squared error less 2 per parameter; p: family-wise)",
        f"(evidence: the gain where the form of the effect may be somewhat wrong; {ORDER_OF_RANKING})",
        f"({OTHERS_BY_CHANCE})",
        *(
            f"  {r['effect']:<22} evidence {r['evidence']:9.1f}   gain {r['gain']:9.1f}   p {p_text(r['p_value'])}"
            for r in d.ranking[:6]
        ),
    ]
    if not d.ranking:
        lines.append("  no effect of the catalogue could be tried on these data")
    lines += [
        "  not told apart by these data: " + ", ".join(group) for group in d.alternatives if len(group) > 1
    ]
    return [*lines, *([f"  {d.not_first}"] if d.not_first else [])]


def _structure(d: Findings) -> list[str]:
    lines = []
    if d.where:
        lines += ["Where structure is left"]
        lines += [f"  {where_text(w)}" for w in d.where]
    if d.unrecorded_factor:
        lines += [f"Unrecorded factor? {d.unrecorded_factor['note']}"]
    return lines


def _formulas(d: Findings) -> list[str]:
    return offer_lines(d.formulas)


def _worst(d: Findings) -> list[str]:
    if not d.worst_tests:
        return []
    f = mu_format(d.worst_tests[0]["rms"])
    return ["Worst tests (rms before)"] + [
        f"  {shown(w['test_id'], 40):<16} {w['rms']:{f}}" for w in d.worst_tests[:5]
    ]


def _response(d: Findings) -> list[str]:
    lines: list[str] = []
    for name, entry in d.parameters.items():
        effect = d.named[name]
        values = entry["values"]
        lines.append(f"{name}: {entry['equation']}")
        lines.append("  " + ", ".join(f"{k} = {_with(v)}" for k, v in values.items()) + "   (95 % intervals)")
        numbers = {k: v["value"] for k, v in values.items()}
        for driver in effect.driver:
            curve = effect_curve(effect, numbers, d.averages, driver)
            if curve is None:
                continue
            places = np.linspace(0, len(curve[0]) - 1, PLACES).round().astype(int)
            lines.append(f"  {with_unit(driver):<16}" + "".join(f"{curve[0][k]:>10.4g}" for k in places))
            lines.append(f"  {'share of mu':<16}" + "".join(f"{curve[1][k]:>+10.4f}" for k in places))
    return lines


def _with(value: ParameterValue) -> str:
    interval = f" ({interval_text(value)})" if "interval" in value else ""
    return f"{value['value']:.4g}{interval}{behind(value['unit'])}"
