"""What further tests changed in an answer."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from benchmarks.discovery_campaigns import campaign
from friction_models.common import InputError
from friction_models.discovery import diagnose
from friction_models.discovery.answer.changes import changes_text, read_diagnosis


def test_more_tests_settle_what_few_could_not_and_the_text_says_so(tmp_path: Path) -> None:
    points, tests, _ = campaign("wear_out", seed=41, strength=1.5, thin=40, extra=0)
    few = points[points["test_id"].isin(tests["test_id"].iloc[:5])]
    before = diagnose(few, tests)
    file = tmp_path / "before.json"
    file.write_text(json.dumps(before.to_dict()))
    after = diagnose(points, tests)
    text = changes_text(read_diagnosis(file), after)
    assert f"verdict         {before.verdict} -> {after.verdict}" in text or before.verdict == after.verdict
    assert "wear_out" in text and "noise floor" in text
    unchanged = changes_text(after.to_dict(), after)
    assert "(unchanged)" in unchanged and "another one" not in unchanged and "other tests" not in unchanged
    elsewhere = [{**w, "test_id": f"other-{k}"} for k, w in enumerate(after.worst_tests)]
    assert "other tests (other-0, " in changes_text({**after.to_dict(), "worst_tests": elsewhere}, after)
    assert "Other values" not in text + unchanged
    renamed = {
        **after.to_dict(),
        "tests": dict(zip(after.tests, reversed(after.tests.values()), strict=True)),
    }
    assert "Other values of mu stand in" in changes_text(renamed, after)
    other = changes_text({**after.to_dict(), "model": "constant"}, after)
    assert "another one: constant -> linear" in other


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("[]", "before.json"),
        ("{}", "no diagnosis"),
        ('{"verdict": "explained", "effects": "wear_out"}', "effects = 'wear_out'"),
        (
            '{"verdict": "explained", "effects": [], "confusion_set": []}',
            "confidence or error_budget is missing",
        ),
        (
            '{"verdict": "explained", "effects": [], "confusion_set": [], "confidence": 0.5, "error_budget": {}, "tests": 3}',
            "tests = 3",
        ),
        (
            '{"verdict": "explained", "effects": [], "confusion_set": [], "sentence": ["a", "b"]}',
            r"sentence = \['a', 'b'\]; allowed: a text",
        ),
        ("{", "before.json"),
    ],
)
def test_another_file_is_refused_with_a_reason(content: str, said: str, tmp_path: Path) -> None:
    file = tmp_path / "before.json"
    file.write_text(content)
    with pytest.raises(InputError, match=said):
        read_diagnosis(file)


@pytest.mark.parametrize(
    ("confidence", "floor", "said"),
    [
        ("NaN", "0.002", "confidence = nan; allowed: 0 to 1"),
        ("1.5", "0.002", "confidence = 1.5; allowed: 0 to 1"),
        ("true", "0.002", "confidence = True; allowed: 0 to 1"),
        ("0.8", "Infinity", "error_budget.floor = inf; allowed: a finite number, 0 or larger"),
        ("0.8", "-0.1", "error_budget.floor = -0.1; allowed"),
        ("0.8", '"much"', "error_budget.floor = 'much'; allowed"),
    ],
)
def test_numbers_that_no_diagnosis_writes_are_refused(
    confidence: str, floor: str, said: str, tmp_path: Path
) -> None:
    """They were compared with the new ones: "confidence nan -> 0.94, noise floor inf -> 0.00267"."""
    file = tmp_path / "before.json"
    file.write_text(
        '{"verdict": "explained", "effects": [], "confusion_set": [], '
        f'"confidence": {confidence}, "error_budget": {{"floor": {floor}, "explained": null, "missing": 0}}}}'
    )
    with pytest.raises(InputError, match=re.escape(f"{file}: {said}")):
        read_diagnosis(file)
