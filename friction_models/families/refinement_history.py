"""Check the refinement history in a model file: what each round added, and the errors before and after. The file is not trusted."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..common import InputError
from ..common.errors import shown
from ..common.ranges import is_number

#: By these errors an addition to a model is judged.
JUDGED = ("rmse", "mae")


def checked_round(entry: Any) -> dict[str, Any]:
    """Return a round of additions as `refine` records it; raise InputError for another.

    Examples
    --------
    >>> errors = {"rmse": 0.005, "mae": 0.004}
    >>> checked_round({"added": ["stribeck"], "judged_by": "9 tests", "before": errors, "after": errors})["added"]
    ['stribeck']
    """
    good = (
        isinstance(entry, dict)
        and isinstance(entry.get("judged_by"), str)
        and all(_are_texts(entry.get(name, [])) for name in ("added", "corrects_data"))
        and "added" in entry
        and all(_are_measures(entry.get(name)) for name in ("before", "after"))
        and not strange_parts(entry)
    )
    if not good:
        raise InputError(
            f"error_history: {shown(entry, 80)} is no round of additions; allowed: added, judged_by, and rmse and mae "
            f"before and after, with or without {', '.join(OPTIONAL)}"
        )
    return dict(entry)


def strange_parts(entry: Mapping[str, Any]) -> list[str]:
    """Return which of the parts that a round may have are not what `refine` records.

    Examples
    --------
    >>> strange_parts({"clear": True, "rose": 3, "refitted": {"rmse": 0.005}})
    ['rose', 'refitted']
    """
    return [name for name, good in OPTIONAL.items() if name in entry and not good(entry[name])]


def left_out_tests(model: object) -> list[str]:
    """Return the tests that the last round left out, as they lie far off all others; none of a model that was not refined.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> left_out_tests(SimpleNamespace(error_history_=[{"added": ["stribeck"], "left_out": ["t07"]}])), left_out_tests(3)
    (['t07'], [])
    """
    history = getattr(model, "error_history_", [])
    return list(history[-1].get("left_out", [])) if history else []


def faults_of(model: object) -> list[str]:
    """Return the faults of the data that a model knows, and that its predictions leave out; none for models without effects."""
    return [effect.name for effect in getattr(model, "effects_", []) if effect.kind == "fault"]


def rise_text(entry: Mapping[str, Any]) -> str:
    """Return by how much the RMSE of a round rose (95 %), where it rose by more than chance; else an empty text.

    Files older than the key ``rose`` say so by their interval alone.

    Examples
    --------
    >>> rise_text({"intervals": {"fall": {"rmse": [-0.00042, -0.00009]}}, "clear": False, "rose": True})
    'higher by 0.00009 to 0.00042: more than chance'
    >>> rise_text({"intervals": {"fall": {"rmse": [-0.004, 0.001]}}, "clear": False, "rose": False})
    ''
    """
    fall = entry.get("intervals", {}).get("fall", {}).get("rmse")
    if fall is None or fall[1] >= 0.0 or not entry.get("rose", True):
        return ""
    return f"higher by {-fall[1]:.5f} to {-fall[0]:.5f}: more than chance"


def chance_text(entry: Mapping[str, Any]) -> str:
    """Return in words whether the error of a round changed by more than chance; empty where that is not known.

    An interval that is printed without zero says nothing where it is that of a few tests: resampling them is not reliable.

    Examples
    --------
    >>> chance_text({"clear": True}), chance_text({"clear": False}), chance_text({})
    ('more than chance', 'may be chance', '')
    >>> chance_text({"clear": False, "intervals": {"fall": {"rmse": [0.0005, 0.0009]}}})
    'may be chance, of so few tests'
    >>> chance_text({"clear": False, "intervals": {"fall": {"rmse": [-0.00042, -0.00009]}}})
    'higher by 0.00009 to 0.00042: more than chance'
    """
    if said := rise_text(entry):
        return said
    if (clear := entry.get("clear")) is None:
        return ""
    if clear:
        return "more than chance"
    fall = entry.get("intervals", {}).get("fall", {}).get("rmse")
    few = fall is not None and round(fall[0], 5) > 0.0
    return "may be chance" + (", of so few tests" if few else "")


def are_intervals(found: object) -> bool:
    """Whether these are the intervals of a round; those of older files are empty.

    Examples
    --------
    >>> known, unknown = {"rmse": [0.004, 0.006], "mae": [0.003, 0.005]}, {"rmse": None, "mae": None}
    >>> are_intervals({"before": known, "after": known, "fall": unknown}), are_intervals({}), are_intervals({"after": 3})
    (True, True, False)
    """
    return found == {} or (
        isinstance(found, dict)
        and all(
            isinstance(part := found.get(when), dict) and all(_is_interval(part.get(n)) for n in JUDGED)
            for when in ("before", "after", "fall")
        )
    )


def _is_interval(found: object) -> bool:
    return found is None or (isinstance(found, list) and len(found) == 2 and all(map(is_number, found)))


def _are_texts(values: Any) -> bool:
    return isinstance(values, list) and all(isinstance(v, str) for v in values)


def _are_measures(values: Any) -> bool:
    return isinstance(values, dict) and all(is_number(values.get(n)) for n in JUDGED)


def _are_left_out(found: Any) -> bool:
    """Whether these are errors without each effect, with whether it is needed."""
    return isinstance(found, dict) and all(
        isinstance(name, str) and _are_measures(part) and _is_truth(part.get("needed"))
        for name, part in found.items()
    )


def _is_truth(found: object) -> bool:
    return isinstance(found, bool)


#: What a round has beside its errors, and how it is checked; older files lack some of it.
OPTIONAL: dict[str, Callable[[Any], bool]] = {
    "intervals": are_intervals,
    "clear": _is_truth,
    "rose": _is_truth,
    "refitted": _are_measures,
    "without": _are_left_out,
    "warnings": _are_texts,
}
