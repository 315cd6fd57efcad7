"""What further tests changed in a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from ...common import InputError
from ...common.files import read_json
from ...common.ranges import check_range, is_number
from ...common.wording import counted, first_names
from .diagnosis import VERDICTS
from .findings import Findings
from .wording import confidence_text, mu_format

#: Parts of an error budget.
PARTS: tuple[Literal["floor", "explained", "missing"], ...] = ("floor", "explained", "missing")


def read_diagnosis(path: Path) -> dict[str, object]:
    """Return what ``diagnose --json`` wrote earlier. Raises InputError: the file is no diagnosis."""
    content = read_json(path)
    if not isinstance(content, dict) or content.get("verdict") not in VERDICTS:
        raise InputError(f"{path}: no diagnosis; allowed: a file that diagnose --json wrote")
    for name in ("effects", "confusion_set"):
        names = content.get(name)
        if not isinstance(names, list) or not all(isinstance(n, str) for n in names):
            raise InputError(f"{path}: {name} = {names!r:.60}; allowed: a list of names of effects")
    for name in ("sentence", "model"):  # answers of earlier versions may lack them
        if not isinstance(content.get(name, ""), str):
            raise InputError(f"{path}: {name} = {content[name]!r:.60}; allowed: a text")
    confidence, budget = content.get("confidence"), content.get("error_budget")
    if confidence is None or not isinstance(budget, dict):
        raise InputError(
            f"{path}: confidence or error_budget is missing; allowed: a file that diagnose --json wrote"
        )
    check_range(str(path), "confidence", confidence, 0.0, 1.0, "")
    for part in PARTS:
        value = budget.get(part)  # nothing stands for what was not known
        if value is not None and not (is_number(value) and value >= 0.0):
            raise InputError(
                f"{path}: error_budget.{part} = {value!r:.60}; allowed: a finite number, 0 or larger"
            )
    tests = content.get("tests", {})  # answers of earlier versions have none
    if not isinstance(tests, dict) or not all(isinstance(d, str) for d in tests.values()):
        raise InputError(f"{path}: tests = {tests!r:.60}; allowed: the hash of each test by its name")
    return content


def changes_text(before: Mapping[str, object], after: Findings) -> str:
    """Return what is another answer now than in an earlier diagnosis, line by line."""
    lines = ["What changed since the earlier diagnosis"]

    def row(what: str, old: str, new: str) -> None:
        lines.append(f"  {what:<16}{old} -> {new}" if old != new else f"  {what:<16}{new} (unchanged)")

    earlier = before.get("model")
    if isinstance(earlier, str) and earlier != after.model:
        lines.append(
            f"  The model is another one: {earlier} -> {after.model}. Tests alone did not change this."
        )
    if gone := _of_other_tests(before, after):
        lines.append(
            f"  The earlier answer is of other tests ({first_names(gone)}), none of which are among these: nothing was added to them."
        )
    elif other := _measured_otherwise(before, after):
        lines.append(
            f"  Other values of mu stand in {counted(len(other), 'test')} of the same name ({first_names(other)}): not only tests were added."
        )
    elif left_out := [str(t) for t in _hashes(before) if after.tests and t not in after.tests]:
        lines.append(
            f"  {counted(len(left_out), 'test')} of the earlier answer are not among these ({first_names(left_out)})."
        )
    row("verdict", str(before["verdict"]), after.verdict)
    row("effects", _names(before["effects"]), _names(after.effects))
    row("not told apart", _names(before["confusion_set"]), _names(after.confusion_set))
    row("confidence", confidence_text(float(str(before["confidence"]))), confidence_text(after.confidence))
    budget = before["error_budget"]
    if isinstance(budget, Mapping):
        parts = [(part, budget.get(part), after.error_budget[part]) for part in PARTS]
        f = mu_format(max(value for _, *both in parts for value in both if is_number(value)))
        for part, old, value in parts:
            known = f"{old:{f}}" if is_number(old) else "unknown"
            row({"missing": "still missing", "floor": "noise floor"}.get(part, part), known, f"{value:{f}}")
    return "\n".join(lines) + "\n"


def _of_other_tests(before: Mapping[str, object], after: Findings) -> list[str]:
    """Return the tests that an earlier diagnosis names, where none of them is among those of this one."""
    worst = before.get("worst_tests")
    if not isinstance(worst, list) or "test_id" not in after.averages:
        return []
    named = [str(w["test_id"]) for w in worst if isinstance(w, Mapping) and "test_id" in w]
    return [] if {*named} & {*after.averages["test_id"].astype(str)} else named


def _measured_otherwise(before: Mapping[str, object], after: Findings) -> list[str]:
    """Return the tests of an earlier diagnosis in which something else was measured than in those of the same name in this one."""
    return [str(t) for t, digest in _hashes(before).items() if after.tests.get(str(t), digest) != digest]


def _hashes(before: Mapping[str, object]) -> Mapping[str, object]:
    """Return what was measured in each test of an earlier diagnosis; nothing in those of earlier versions."""
    tests = before.get("tests")
    return tests if isinstance(tests, Mapping) else {}


def _names(names: object) -> str:
    return ", ".join(map(str, names)) if isinstance(names, list) and names else "none"
