"""The benchmark of the diagnosis: what it is made of, and that it can be interrupted."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from friction_models.effects import CATALOGUE
from tests.benchmarks.discovery import study
from tests.benchmarks.discovery.generator import (
    EFFECTS,
    NOISE_LEVELS,
    NULLS,
    OUTSIDE,
    PAIRS,
    SCATTER,
    campaign,
)


def test_the_cases_are_those_that_are_asked_for() -> None:
    cases = list(study.cases(12))
    assert len(EFFECTS) >= 14 and set(EFFECTS) <= set(CATALOGUE) and not set(OUTSIDE) & set(CATALOGUE)
    assert len(NULLS) == 3 and len(OUTSIDE) == 4 and len(PAIRS) == 3 and len(NOISE_LEVELS) == 3
    kinds = [c.kind for c in cases]
    assert kinds.count("null") >= 200 and kinds.count("single") >= 200
    assert {c.left_out for c in cases if c.kind == "left_out"} == set(EFFECTS)
    assert len({c.key for c in cases}) == len(cases)


@pytest.mark.parametrize("name", [*list(EFFECTS)[::4], *OUTSIDE])
def test_hidden_parts_have_the_strength_they_claim(name: str) -> None:
    points, tests, part, strength = campaign(3, (name,))
    assert 0.5 <= strength <= 2.0 and np.std(part) == pytest.approx(strength * SCATTER)
    assert points["test_id"].nunique() == 111 and (tests["role"] == "train").sum() == 81


def test_a_study_goes_on_where_it_was_and_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []

    def fake(case: study.Case) -> dict[str, Any]:
        done.append(case.key)
        right = case.kind != "null"
        return {
            "kind": case.kind, "hidden": list(case.hidden), "null": case.null, "noise": case.noise, "left_out": case.left_out,
            "verdict": "explained" if right else "nothing_missing", "effects": list(case.hidden), "confidence": 1.0,
            "first": case.hidden[0] if right else "", "confusion_set": list(case.hidden), "strength": 1.0,
        }  # fmt: skip

    monkeypatch.setattr(study, "run_case", fake)
    results = study.run_all(tmp_path, 1, lambda text: None)
    study.run_all(tmp_path, 1, lambda text: None)
    assert len(done) == len(results) == len(set(done))
    text = "\n".join(study.summary(results)["lines"])
    assert "| right effect first | 18 of 18 (100 %) | 82 to 100 % | at least 90 % |" in text
    assert "| false alarms, nothing missing | 0 of 18 (0 %) | 0 to 18 % |" in text


def test_wilson_intervals() -> None:
    assert study.wilson(5, 10) == pytest.approx((0.2366, 0.7634), abs=1e-4)
    assert study.wilson(0, 200)[1] == pytest.approx(0.0188, abs=1e-4)


def test_one_case_of_each_kind_runs() -> None:
    single = study.run_case(study.Case("single", ("wear_out",), 49_001))
    assert single["verdict"] in {"explained", "ambiguous"} and single["hidden"] == ("wear_out",)
    assert single["after"] < single["before"] and single["removed"] > 0.3
    null = study.run_case(study.Case("null", (), 49_002, "curved noise"))
    assert null["verdict"] == "nothing_missing" and "removed" not in null
