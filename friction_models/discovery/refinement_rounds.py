"""Rounds of additions in words: the errors before and after, what the fall is due to, and which effects are needed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..common.wording import listed
from ..families.refinement_history import chance_text, faults_of, rise_text
from ..models.base import FrictionModel

#: An error that does not fall below this share of the earlier one is said to be no better.
BETTER = 0.995
#: Share of a fall from which on it is said that the weights of the joint fit account for it.
MATTERS = 1.0 / 3.0


def history_text(history: Sequence[Mapping[str, Any]]) -> str:
    """Return the rounds of additions with the errors before and after, on tests that the fit did not see."""
    if not history:
        return "No round was judged: too few tests to leave some out."
    lines = [
        "Rounds of additions (RMSE and MAE of mu over the points of tests not seen in the fit; the error budget of diagnose averages points first)"
    ]
    for k, entry in enumerate(history, 1):
        before, after = entry["before"], entry["after"]
        lines.append(
            f"  {k}  + {' + '.join(entry['added']):<24} RMSE {before['rmse']:.5f} -> {after['rmse']:.5f}   "
            f"MAE {before['mae']:.5f} -> {after['mae']:.5f}   ({entry['judged_by']})"
            + ("" if after["rmse"] < BETTER * _best_without(entry) else "  NO BETTER")
        )
        lines += [*_sure(entry), *(f"     {note}" for note in round_notes(entry))]
        faults = entry.get("corrects_data", [])
        if faults:
            lines.append(
                f"     {listed(faults)}: correct{'s' if len(faults) == 1 else ''} the data the model is fitted to and judged by; "
                "not in its predictions, not in exported files"
            )
    if warnings := history[-1].get("warnings"):
        lines += ["Read the parameters with care", *(f"  - {w}" for w in warnings)]
    return "\n".join(lines) + "\n"


def round_notes(entry: Mapping[str, Any]) -> list[str]:
    """Return what a round says beside its errors: which part of the fall is not due to what is added, and which effects are needed.

    Examples
    --------
    >>> errors = {"before": {"rmse": 0.00915}, "after": {"rmse": 0.00883}, "refitted": {"rmse": 0.00883}}
    >>> round_notes({"added": ["factor:one"], **errors})
    ['The fall comes from the other weights of the joint fit, not from factor:one: with these weights alone RMSE 0.00883.']
    >>> round_notes({"added": ["factor:one"], **errors, "after": {"rmse": 0.00843}})
    ['0.00032 of the fall come from the other weights of the joint fit, not from factor:one: with these weights alone RMSE 0.00883.']
    """
    return [*_of_weights(entry), *_of_each(entry)]


def _of_weights(entry: Mapping[str, Any]) -> list[str]:
    """Return a sentence on the part of the fall that the weights of the joint fit account for; none where that is small."""
    before, after = entry["before"]["rmse"], entry["after"]["rmse"]
    alone = entry.get("refitted", entry["before"])["rmse"]
    if alone >= before or after >= BETTER * before:
        return []
    if after >= BETTER * alone:
        part = "The fall comes"
    elif before - alone > MATTERS * (before - after):
        part = f"{before - alone:.5f} of the fall come"
    else:
        return []
    return [
        f"{part} from the other weights of the joint fit, not from {' + '.join(map(str, entry['added']))}: "
        f"with these weights alone RMSE {alone:.5f}."
    ]


def _of_each(entry: Mapping[str, Any]) -> list[str]:
    """Return the error without each of several effects that were added, and whether it is needed beside the others."""
    lines = []
    for name, found in entry.get("without", {}).items():
        said = "it is needed" if found["needed"] else "it is not needed"
        # A rise that a single test, or few, may have made shows neither.
        if not found["needed"] and entry["after"]["rmse"] < BETTER * found["rmse"]:
            said = "it may be needed: the rise may be chance"
        lines.append(f"without {name} RMSE {found['rmse']:.5f} ({said})")
    return lines


def _best_without(entry: Mapping[str, Any]) -> float:
    """Return the smallest RMSE of the model of a round without what it adds, whatever the weights of its fit."""
    return float(min(entry[when]["rmse"] for when in ("before", "refitted") if when in entry))


def fault_note(model: FrictionModel) -> str:
    """Return that measurements hold the faults that a model leaves out; empty where it corrects the data for none."""
    faults = faults_of(model)
    if not faults:
        return ""
    return f"The measurements still hold {listed(faults)} here, which the model leaves out; only the rounds are judged without."


def _sure(entry: Mapping[str, Any]) -> list[str]:
    """Return a line with the 95 % intervals of the RMSE of a round, and whether it changed by more than chance; none where they are not known."""
    intervals = entry.get("intervals", {})
    found = [intervals.get(when, {}).get("rmse") for when in ("before", "after", "fall")]
    if any(f is None for f in found):
        return []
    before, after, fall = (f"{low:.5f} to {high:.5f}" for low, high in found)
    changed = rise_text(entry) or f"lower by {fall}: {chance_text(entry)}"
    return [f"     95 % of resampled tests: RMSE {before} -> {after}, {changed}"]
