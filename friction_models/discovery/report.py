"""Text reports for the terminal."""

from __future__ import annotations

import math
from typing import Any

from .diagnosis import Diagnosis


def text_report(diagnosis: Diagnosis) -> str:
    """Return a diagnosis as text, the verdict in one sentence first."""
    d = diagnosis
    lines = [f"{d.verdict.upper()}: {d.sentence}", *(["(synthetic data)"] if d.synthetic else []), ""]
    floor, budget = d.noise_floor, d.error_budget
    low, high = floor["interval"]
    lines += [
        f"Error budget of the {d.model} model (rms of mu)",
        f"  noise floor   {budget['floor']:.5f}   (95 %: {low:.5f} to {high:.5f}; test scatter {floor['test']:.5f}, "
        f"drift {floor['drift']:.5f}, sensor {floor['sensor']:.5f})",
        f"  explained     {budget['explained']:.5f}   "
        + (f"by {' and '.join(d.effects)}" if d.effects else ""),
        f"  still missing {budget['missing']:.5f}",
        "",
        "Ranked evidence (gain: drop of the whitened squared error less 2 per parameter; p: family-wise)",
    ]
    lines += [f"  {r['effect']:<22} gain {r['gain']:9.1f}   p {r['p_value']:.3f}" for r in d.ranking[:6]]
    if len(d.confusion_set) > 1:
        lines += ["", "The data cannot tell apart: " + ", ".join(d.confusion_set)]
    if d.parameters:
        lines += ["", "Fitted parameters"]
        for effect, entry in d.parameters.items():
            values = ", ".join(
                f"{k} = {v['value']:.4g}" + (f" {v['unit']}" if v["unit"] != "1" else "")
                for k, v in entry["values"].items()
            )
            lines += [f"  {effect}: {entry['equation']}", f"    {values}"]
    if d.where:
        lines += ["", "Where structure is left"]
        lines += [
            f"  {' x '.join(w['variables'])}: {w['region']}, {w['shape']} ({100 * w['share']:.0f} %)"
            for w in d.where
        ]
    lines += ["", "Worst tests"] + [f"  {w['test_id']:<16} rms {w['rms']:.5f}" for w in d.worst_tests[:5]]
    if d.bias:
        lines += ["", "Residual of the base against each load (mean, 95 % interval over tests)"]
        lines += [
            f"  {b['load']:<8} {b['low']:10.4g} to {b['high']:10.4g}: {b['bias']:+.5f} {_over_tests(b)}"
            for b in d.bias
        ]
    if d.unrecorded_factor:
        u = d.unrecorded_factor
        lines += ["", f"Unrecorded factor? {u['note']}"]
    if d.next_tests:
        lines += ["", "Tests that would tell more"]
        lines += [f"  {n['protocol']}: {_setpoints(n['setpoints'])}; separates {' from '.join(n['separates'])}"
                  f" (expected t {n['expected_t']:.1f})" for n in d.next_tests]  # fmt: skip
    if d.warnings:
        lines += ["", "Note"] + [f"  - {w}" for w in d.warnings]
    return "\n".join(lines) + "\n"


def _over_tests(entry: dict[str, Any]) -> str:
    low, high = entry["interval"]
    if not math.isfinite(low + high):
        return "(one test: no interval)"
    return f"[{low:+.5f}, {high:+.5f}]  ({entry['tests']} tests)"


def _setpoints(setpoints: dict[str, object]) -> str:
    return ", ".join(f"{k} = {v}" for k, v in setpoints.items())
