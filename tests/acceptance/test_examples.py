"""Examples are run, so that what the reader copies works."""

from __future__ import annotations

import importlib.util
from itertools import product
from pathlib import Path
from types import ModuleType

import numpy as np
import pandas as pd
import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"


def load(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_own_model_and_effect(tmp_path: Path) -> None:
    example = load("own_model_and_effect")
    points = example.made_up_points()
    plain, composed, fmu = example.main(tmp_path)
    errors = [np.abs(m.predict_frame(points) - points["mu"]).mean() for m in (plain, composed)]
    assert errors[1] < 1e-3 < 5e-3 < errors[0]
    assert fmu.is_file()


def test_what_the_whole_loop_imports_exists() -> None:
    assert callable(load("whole_loop").main)


@pytest.mark.nightly  # by day the tutorials make the same calls
def test_whole_loop_through_python(tmp_path: Path, capsys) -> None:
    example = load("whole_loop")
    settings = [
        *product((5.0, 50.0, 500.0), (20.0, 200.0), (500.0, 2000.0)),
        (20.0, 100.0, 1000.0),
        (200.0, 60.0, 1500.0),
    ]
    plan = pd.DataFrame(settings, columns=["v_set", "T_tool", "sigma_set"]).assign(sd_set=12.0, role="train")
    plan.loc[12:, "role"] = "test"
    before, after = example.main(tmp_path, plan=plan, stroke=1.0)
    said = capsys.readouterr().out
    assert "synthetic" in said.lower() and before.synthetic
    for run in (before, after):
        stroke, force = run["forming.stroke"], run["forming.force"]
        assert np.isclose(stroke[-1], 1.0) and np.all(np.diff(stroke) > 0)
        assert 20.0 < force.max() < 400.0
    assert not np.array_equal(before["forming.force"], after["forming.force"])
