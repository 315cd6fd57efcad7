"""Friction tables against the FMU, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fmus.exports import export
from fmus.exports.common import Reference
from fmus.exports.numbers.deviation import domain_points, system_values
from fmus.exports.numbers.table_target import tabulate
from fmus.runtime.running import RunningFmu
from fmus.source.reading import read_source
from friction_models import LinearFriction
from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES, LOADS
from tests.fmus.exported import (
    fmu_at,
    made,
)
from tests.fmus.graphs import Array
from tests.friction_models.made_up import campaign


@pytest.mark.parametrize(
    "name", ["constant", "polynomial", "ffnn", "gradient_boosting", "linear + tool_roughness"]
)
def test_table_is_as_good_as_it_says_against_the_fmu(name: str, tmp_path: Path) -> None:
    from scipy.interpolate import RegularGridInterpolator

    model = made(name)
    folder = export(model.source, tmp_path / "table", "table", tolerance=5e-4)
    head, units, *rows = (folder / "mu_table.csv").read_text().splitlines()
    assert (head, units) == ("sigma_n,T,psi,v_rel,mu", "MPa,degC,1,mm/s,1")
    data = np.array([[float(x) for x in r.split(",")] for r in rows])
    lines = [np.unique(column) for column in data.T[:4]]
    grid = data[:, 4].reshape([len(x) for x in lines])
    assert np.array_equal(data[:, :4], np.stack(np.meshgrid(*lines, indexing="ij"), -1).reshape(-1, 4))
    compact = [x for x in (folder / "mu_table.txt").read_text().splitlines() if not x.startswith("#")]
    assert [float(x) for x in " ".join(compact[2:9:2]).split()] == [x for axis in lines for x in axis]
    body = np.array([x.split() for x in compact[10:]], dtype=float)
    np.testing.assert_allclose(body.ravel(), data[:, 4], rtol=1e-6)
    rng = np.random.default_rng(8)
    points = rng.uniform([x[0] for x in lines], [x[-1] for x in lines], size=(300, 4))
    sd = model.source.interface(1).start(LOADS[3])

    def loads(at: Array) -> Array:
        return np.column_stack([at[:, 3], at[:, 1], at[:, 0], np.full(len(at), sd), at[:, 2]])

    some = rng.choice(len(data), size=min(40, len(data)), replace=False)
    with RunningFmu(model.fmu) as fmu:
        np.testing.assert_allclose(fmu_at(fmu, loads(data[some, :4])), data[some, 4], rtol=1e-6)
        off = np.abs(RegularGridInterpolator(lines, grid)(points) - fmu_at(fmu, loads(points)))
    summary = (folder / "README.txt").read_text()
    report = json.loads((folder / "table.json").read_text())
    assert report["rows"] == len(data)
    if name == "gradient_boosting":  # jumps cannot be interpolated; the rest of the loads must still be good
        assert "tolerance 0.0005 NOT met: mu jumps between grid lines" in summary
        assert report["largest error"] > 5e-4 > np.quantile(off, 0.97)
    else:
        assert "tolerance 0.0005 met" in summary
        assert report["largest error"] <= 5e-4
        assert off.max() <= 5e-4
    if name == "polynomial":
        coarse = tabulate(model.source, points=dict.fromkeys(("sigma_n", "T", "psi", "v_rel"), 2))
        assert coarse.largest > 5e-4 > off.max()


def test_table_says_when_the_tolerance_is_not_met_and_what_it_leaves_out() -> None:
    polynomial = made("polynomial").source
    small = tabulate(polynomial, tolerance=1e-6, max_rows=40)
    assert not small.met and small.mu.size <= 40 and "NOT met: max_rows is reached" in small.summary()
    assert small.left_out["sd"] > 1e-3
    outside = tabulate(polynomial, tolerance=1e-2, fixed={"sd": 9e3})
    assert outside.held()[0].startswith("sd is held at 9000 mm, OUTSIDE its trained range")
    full = tabulate(polynomial, axes=LOAD_NAMES, points={"sd": 4}, limits={"psi": (2.0, 9.0)}, fixed={})
    assert full.mu.shape[3] == 4 and full.axes["psi"][[0, -1]].tolist() == [2.0, 9.0] and full.left_out == {}
    typed = tabulate(polynomial, axes="T, sigma_n", tolerance="1e-3", max_rows=100.0)  # type: ignore[arg-type]
    assert list(typed.axes) == ["T", "sigma_n"] and typed.tolerance == 1e-3
    rough = made("linear + tool_roughness").source
    at = [tabulate(rough, axes=["T"], system={rough.system[0].name: x}).mu[0] for x in (0.1, 0.9)]
    assert at[0] != at[1]


@pytest.mark.parametrize("target", ["abaqus", "table", "radioss", "calculix"])
def test_hosts_of_numbers_say_where_they_hold_a_system_variable(target: str, tmp_path: Path) -> None:
    model = made("linear + tool_roughness")
    ra = model.source.system[0]
    folder = export(model.source, tmp_path / target, target)
    report = json.loads(
        (folder / ("table.json" if target in ("abaqus", "table") else "fit.json")).read_text()
    )
    [said] = [text for text in report["held"] if text.startswith(f"{ra.name} is held at {ra.start:.4g}")]
    assert said in (folder / "README.txt").read_text()
    loads = domain_points(model.source)[0]
    at = [Reference(model.source).mu(loads, system=[x]) for x in (ra.start, ra.lower, ra.upper)]
    off = np.abs(np.array(at[1:]) - at[0]).max()
    assert float(said.split("off by up to ")[1]) == pytest.approx(off, rel=0.2)
    assert off > 1e-5


def test_deviation_of_a_table_is_that_at_the_chosen_system_variables(tmp_path: Path) -> None:
    model = made("linear + tool_roughness")
    ra = model.source.system[0]
    at = [tabulate(model.source, system={ra.name: x}).mu.mean() for x in (ra.start, ra.start + 100.0)]
    assert abs(at[1] - at[0]) > 1e-2
    options = {"fields": ["sd", "psi"]}
    largest = []
    for k, value in enumerate((ra.start, ra.start + 100.0)):
        folder = export(
            model.source, tmp_path / str(k), "abaqus", system={ra.name: value}, tolerance=1e-4, **options
        )
        largest.append(json.loads((folder / "table.json").read_text())["remaining"]["largest deviation"])
    assert max(largest) < 1e-3


def test_a_system_variable_with_labels_is_held_at_a_label_or_its_number() -> None:
    data = campaign(9, 8)
    names = data["test_id"].unique()
    tests = pd.DataFrame({"test_id": names, "batch": [f"lot {'ABC'[k % 3]}" for k in range(len(names))]})
    source = read_source((LinearFriction() + "batch").fit_frame(data, tests))
    assert [system_values(source, {"batch": x}) for x in ("lot B", 1, 1.0)] == [{"batch": 1.0}] * 3
    for value in ("lot b", 99, -1, 0.5, True, None, [1]):
        with pytest.raises(
            InputError, match=r"unknown label .*; allowed: lot A, lot B, lot C.*number, 0 to 2"
        ):
            system_values(source, {"batch": value})


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("linear + work_exhaustion", {}, "a table has no memory and this model has"),
        ("polynomial", {"axes": ["sigma", "T"]}, "did you mean 'sigma_n'"),
        ("polynomial", {"axes": ["T", "T"]}, "one or more different loads"),
        ("polynomial", {"points": {"T": 1}}, "points of 'T' = 1, allowed: 2 to"),
        ("polynomial", {"limits": {"T": (300.0, 20.0)}}, "limits of 'T'"),
        ("polynomial", {"fixed": {"T": 20.0}}, "unknown name in fixed 'T'; allowed: sd"),
        ("polynomial", {"system": {"Ra": 1.0}}, "unknown name in system 'Ra'"),
        ("polynomial", {"points": {"T": 2.5}}, "points of 'T' = 2.5, allowed: a whole number"),
        ("polynomial", {"points": 5}, "points = 5, allowed: a mapping"),
        ("polynomial", {"limits": {"T": 5}}, "limits of 'T' are 5, allowed: two numbers"),
        ("polynomial", {"limits": {"T": (-300.0, 20.0)}}, "limit of 'T' = -300.0, allowed"),
        ("polynomial", {"tolerance": "small"}, "tolerance = 'small', allowed"),
        ("polynomial", {"tolerance": float("nan")}, "tolerance = nan, allowed"),
        ("polynomial", {"max_rows": 3}, "max_rows = 3, allowed: 16 to"),
        ("polynomial", {"tolerence": 1e-3}, "did you mean 'tolerance'"),
    ],
)
def test_bad_table_options(name: str, options: dict[str, object], words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=words):
        export(made(name).source, tmp_path / "t", "table", **options)
    assert list(tmp_path.iterdir()) == []


def test_a_fresh_point_of_a_model_with_memory_can_be_tabulated(tmp_path: Path) -> None:
    folder = export(made("linear + work_exhaustion").source, tmp_path / "t", "table", start_memory=True)
    assert "THIS MODEL HAS MEMORY" in (folder / "README.txt").read_text()
