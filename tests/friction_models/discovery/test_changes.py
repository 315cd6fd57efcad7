"""What further tests changed in an answer."""

from __future__ import annotations

import json
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
    assert "(unchanged)" in changes_text(after.to_dict(), after)


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
        ("{", "before.json"),
    ],
)
def test_another_file_is_refused_with_a_reason(content: str, said: str, tmp_path: Path) -> None:
    file = tmp_path / "before.json"
    file.write_text(content)
    with pytest.raises(InputError, match=said):
        read_diagnosis(file)
