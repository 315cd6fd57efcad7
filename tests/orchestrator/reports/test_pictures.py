"""`plot` of models and answers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import plotly.graph_objects as go
import pytest

from friction_models import ConstantFriction, LinearFriction
from friction_models.common import InputError
from friction_models.common.imports import drawn
from friction_models.discovery import Diagnosis, compare, diagnose, refine
from orchestrator import Run
from orchestrator.report.pictures import PICTURES


@pytest.fixture(scope="module")
def data() -> pd.DataFrame:
    rng = np.random.default_rng(4)
    rows = [
        {"test_id": f"t{k:02d}", "v_rel": v, "T": T, "mu": 0.05 + 0.04 * np.exp(-v / 60.0) + e}
        for k, (v, T, e) in enumerate(
            zip(np.geomspace(5.0, 500.0, 30), np.tile([20.0, 90.0, 160.0], 10), rng.normal(0.0, 5e-4, 30))
        )
    ]
    return pd.DataFrame(rows)


@pytest.fixture(scope="module")
def found(data: pd.DataFrame) -> Diagnosis:
    return diagnose(data)


@pytest.mark.parametrize("what", ["", *PICTURES[Diagnosis]])
def test_every_picture_of_a_diagnosis_is_drawn(found: Diagnosis, what: str) -> None:
    figure = found.plot(what)
    assert isinstance(figure, go.Figure) and len(figure.data) > 0


def test_models_and_comparisons_are_drawn(data: pd.DataFrame) -> None:
    line = LinearFriction().fit_frame(data)
    better = refine(data, add="stribeck")
    assert len(line.plot().data) > 0
    steps = better.plot("rounds").data[0]
    assert len(steps.y) == 2 and steps.y[1] < steps.y[0]
    figure = compare({"line": line, "better": better}, data).plot()
    assert [trace.name for trace in figure.data] == ["better", "line"]  # the best first


def test_wrong_names_and_empty_pictures_are_told(found: Diagnosis, data: pd.DataFrame) -> None:
    with pytest.raises(InputError, match=r"unknown picture 'residuals'.*did you mean 'residual'"):
        found.plot("residuals")
    with pytest.raises(InputError, match="nothing to show in the picture 'rounds'"):
        ConstantFriction(0.1).plot("rounds")


def test_without_a_package_that_draws_it_says_so(found: Diagnosis, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawn, "entry_points", lambda group: [])
    with pytest.raises(InputError, match="no package that draws is installed"):
        found.plot()


def test_a_notebook_shows_the_report_and_no_markup_of_others(found: Diagnosis) -> None:
    assert len(repr(found)) < 200 and "stribeck" in repr(found)
    found.model, before = "<b>own</b>", found.model
    assert "<b>" not in found._repr_html_() and "&lt;b&gt;" in found._repr_html_()
    found.model = before


def test_a_run_names_itself_in_one_line() -> None:
    values = {"forming.sigma_n": np.random.default_rng(1).normal(size=(500, 40))}
    run = Run(
        Path("runs/a"),
        {"name": "rod", "status": "stopped"},
        np.arange(500.0),
        values,
        {"forming.sigma_n": "MPa"},
    )
    assert repr(run) == "Run('rod' in 'runs/a', 499 steps, 1 result, stopped)"
    assert "499 steps" in run._repr_html_()
