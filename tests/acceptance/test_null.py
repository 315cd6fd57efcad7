"""A campaign in which nothing is hidden, from raw records to the verdict."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.acceptance.conftest import short_plan

Tribofmu = Callable[..., str]


@pytest.mark.nightly  # by day loads without a hidden effect, in tests/friction_models/discovery/test_diagnosis.py
@pytest.mark.parametrize("every", [3, 2])
def test_nothing_is_accused_where_nothing_is_hidden(every: int, tmp_path: Path, tribofmu: Tribofmu) -> None:
    plan = short_plan(tmp_path / "plan.csv", "reduced-27", 11, held_out=0, sliding=20.0, every=every)
    tribofmu("lab", "--plan", plan, "--seed", 11, "--jobs", 1, "-o", tmp_path / "lab")
    tribofmu("twin", tmp_path / "lab", "-o", tmp_path / "data", "--jobs", 1)
    out = ["--json", tmp_path / "diagnosis.json"]
    tribofmu("diagnose", "--data", tmp_path / "data", "--model", "linear", *out)
    found = json.loads((tmp_path / "diagnosis.json").read_text(encoding="utf-8"))
    assert found["verdict"] == "nothing_missing"
    assert found["effects"] == []
