"""Examples are run, so that what the reader copies works."""

from __future__ import annotations

import importlib.util
from itertools import product
from pathlib import Path
from types import ModuleType

import numpy as np
import pandas as pd
import pytest

from fmus import check, pack
from friction_models import ConstantFriction
from friction_models.discovery import diagnose

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


def test_an_own_effect_that_remembers(tmp_path: Path) -> None:
    """At one pressure the film closes as ``1 - exp(-sd/L)``: fit, diagnosis and FMU find that law."""
    example = load("own_model_and_effect")
    points = example.made_up_points()
    share = points["sigma_n"] / (1000.0 + points["sigma_n"])
    closed = share * (1.0 - np.exp(-points["sd"] / 8.0))
    noise = np.random.default_rng(1).normal(0.0, 2e-4, len(points))
    data = points.assign(mu=0.06 + 0.03 * closed + noise)
    model = (ConstantFriction() + example.FilmForming()).fit_frame(data)
    assert model.amplitudes_[0]["delta"] == pytest.approx(0.03, rel=0.02)
    assert model.shapes_[0]["L"] == pytest.approx(8.0, rel=0.05)
    found = diagnose(data, model="constant", catalogue=["stribeck", "running_in", example.FilmForming()])
    assert found.effects == ["film_forming"], found.sentence
    assert check(pack(model, tmp_path / "film.fmu")).ok


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
