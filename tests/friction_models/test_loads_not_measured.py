"""A model knows which loads it was given: the others have no domain and no influence, in every file and command."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fmus import pack, read_friction_fmu
from friction_models import ConstantFriction, OnnxModel, TriboLoads, evaluate, load_model
from friction_models.common import InputError
from friction_models.discovery import compare, diagnose, refine
from friction_models.families.registry import FAMILIES, make_model
from friction_models.loads import LOAD_NAMES, DataSet, FloatArray
from friction_models.models.base import FrictionModel
from friction_models.models.domain import Domain

from .made_up import anywhere, campaign

SMALL: dict[str, dict[str, int | tuple[int, ...]]] = {
    "ffnn": {"hidden": (6,), "members": 1, "epochs": 5},
    "gradient_boosting": {"trees": 20, "min_points": 10},
}
LACKING = ("T", "psi")
FRAME = campaign(12, 12)
LESS = FRAME.drop(columns=list(LACKING))
#: `viscous` reads the temperature, too; `rate_state` remembers.
NAMES = [*sorted(FAMILIES), "linear + viscous", "linear + rate_state"]


def fresh(name: str) -> FrictionModel:
    family, *effects = name.split(" + ")
    model = make_model(family, **SMALL.get(family, {}))
    for effect in effects:
        model = model + effect
    return model


@pytest.fixture(scope="module", params=NAMES)
def model(request: pytest.FixtureRequest) -> FrictionModel:
    return fresh(request.param).fit_frame(LESS)


def moved(loads: FloatArray) -> FloatArray:
    """Return loads with other values of those that were not measured."""
    other = loads.copy()
    for k, name in enumerate(LACKING):
        j = LOAD_NAMES.index(name)
        other[:, j] = (loads[:, j] * 1.7 + 3.0 + k)[::-1]
    return other


def test_no_domain_and_no_influence_in_any_file(model: FrictionModel, tmp_path: Path) -> None:
    assert model.domain.absent == LACKING
    loads = anywhere(200, seed=1)
    mu = model.predict(loads)
    np.testing.assert_array_equal(model.predict(moved(loads)), mu)
    inside = loads.clip(model.domain.lower, model.domain.upper)
    extreme = inside.copy()
    extreme[:, [LOAD_NAMES.index(n) for n in LACKING]] = [1900.0, 900.0]
    assert model.domain.contains(extreme).all() and not model.domain.contains([[9e4, 20, 900, 1, 1]]).any()
    folder = model.save(tmp_path / "model")
    same, onnx = load_model(folder), OnnxModel(folder / "model.onnx")
    assert same.domain == onnx.domain == model.domain
    np.testing.assert_array_equal(same.predict(moved(loads)), mu)
    np.testing.assert_allclose(onnx.predict(moved(loads)), mu, rtol=0, atol=1e-9)
    card = json.loads((folder / "card.json").read_text())
    assert [n for n in LOAD_NAMES if card["domain"][n] is None] == list(LACKING)
    text = (folder / "card.md").read_text()
    assert text.count("not measured | no influence") == 2 and " 80 |" not in text
    assert model.view().layout.annotations[1].text == "T [degC] (not measured)"


def test_every_way_to_measure_a_model_takes_such_data(model: FrictionModel) -> None:
    measured = evaluate(model, LESS)
    assert measured.overall["outside_domain"] == 0.0 and measured.overall["rmse"] < 0.05
    assert compare({"it": model}, LESS).errors["it"].rmse == pytest.approx(measured.overall["rmse"])
    # Data with more than the model was given are data like any other: nothing of it is outside.
    assert evaluate(model, FRAME).overall == measured.overall
    some = LESS[LESS["test_id"].isin(LESS["test_id"].unique()[::2])]  # in half the time
    assert diagnose(some, model=model, catalogue=["stribeck"]).verdict != "out_of_domain"
    assert refine(LESS, model=model).domain == model.domain


@pytest.mark.parametrize("name", [n for n in NAMES if n != "constant"])
def test_a_model_that_needs_a_load_says_so(name: str, tmp_path: Path) -> None:
    model = fresh(name).fit_frame(FRAME)
    folder = model.save(tmp_path / "model")
    for given in (model, OnnxModel(folder / "model.onnx")):
        with pytest.raises(InputError, match="given T and psi in training, which these data lack"):
            evaluate(given, LESS)
        with pytest.raises(InputError, match="T and psi"):
            compare({"it": given}, LESS)


def test_a_constant_needs_no_load(tmp_path: Path) -> None:
    fitted = ConstantFriction().fit_frame(FRAME)
    file = fitted.to_onnx(tmp_path / "constant.onnx")
    for model in (fitted, ConstantFriction(0.07), OnnxModel(file)):
        measured = evaluate(model, LESS).overall
        assert measured["outside_domain"] in {0.0, None}


@pytest.mark.parametrize(
    ("effect", "lacking", "said"),
    [
        ("stribeck", "v_rel", "'stribeck' needs v_rel"),
        ("flash_temperature", "sigma_n", "'flash_temperature' needs sigma_n"),
        ("running_in", "sd", "'running_in' needs sd"),
        ("thermal_softening", "T", "'thermal_softening' needs T"),
    ],
)
def test_an_effect_of_a_load_that_was_not_measured_is_refused(effect: str, lacking: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        refine(FRAME.drop(columns=lacking), add=effect)
    with pytest.raises(InputError, match=said):
        (make_model("linear") + effect).fit_frame(FRAME.drop(columns=lacking))


def test_the_interval_does_not_follow_loads_that_were_not_measured() -> None:
    model = make_model("linear").fit_frame(campaign(45, 8).drop(columns=list(LACKING)))
    data = campaign(45, 8)
    # Errors that grow with the speed: the width follows the loads.
    data["mu"] += 2e-4 * data["v_rel"] * np.resize([1.0, -0.5], len(data)) + 0.05
    model = make_model("linear").fit_frame(data.drop(columns=list(LACKING)))
    less = TriboLoads.from_frame(data.drop(columns=list(LACKING)))
    model.calibrate(less, data["mu"])
    assert model.interval is not None
    slopes = dict(zip(LOAD_NAMES, model.interval.slopes))
    assert slopes["T"] == slopes["psi"] == 0.0 != slopes["v_rel"]
    loads = anywhere(50)
    for a, b in zip(model.predict_interval(loads), model.predict_interval(moved(loads))):
        np.testing.assert_array_equal(a, b)


def test_an_fmu_has_the_inputs_and_they_have_no_influence(tmp_path: Path) -> None:
    model = fresh("linear + viscous").fit_frame(LESS)
    fmu = read_friction_fmu(pack(model, tmp_path / "less.fmu"))
    loads = anywhere(40, seed=3).clip(model.domain.lower, model.domain.upper)
    np.testing.assert_allclose(fmu.predict(loads), model.predict(loads), rtol=1e-9)
    np.testing.assert_array_equal(fmu.predict(moved(loads)), fmu.predict(loads))
    assert fmu.domain == model.domain
    assert evaluate(fmu, LESS).overall["outside_domain"] == 0.0
    starts = {n: fmu._fmu.variables[n].starts[0] for n in LOAD_NAMES}
    assert starts["T"] == 80.0 and starts["psi"] == 1.2
    with pytest.raises(InputError, match=r"less\.fmu was given sd in training"):
        fmu.predict_frame(LESS.drop(columns="sd"))


def test_a_data_set_without_a_load_is_read_and_a_misspelt_one_refused(tmp_path: Path) -> None:
    DataSet(LESS, None).save(tmp_path / "data")
    data = DataSet.load(tmp_path / "data")
    assert list(data.points.columns) == ["test_id", "t", "v_rel", "sigma_n", "sd", "mu"]
    assert data.loads().absent == LACKING and data.loads().take([0, 1]).absent == LACKING
    LESS.rename(columns={"sigma_n": "sigma"}).to_csv(tmp_path / "wrong.csv", index=False)
    with pytest.raises(InputError, match=r"wrong\.csv: column 'sigma_n' .* missing.*is it 'sigma'"):
        DataSet.load(tmp_path / "wrong.csv")


def test_a_table_without_any_load_is_told_what_is_needed(tmp_path: Path) -> None:
    tests = pd.DataFrame({"test_id": FRAME["test_id"].unique()})
    tests["leg"] = np.resize(["left", "right"], len(tests))
    bare = FRAME[["test_id", "mu"]].groupby("test_id", as_index=False).mean()
    bare.to_csv(tmp_path / "bare.csv", index=False)
    said = (
        r"the columns of all loads are missing; present: test_id, mu; allowed: at least one of 'v_rel' \[mm/s\], "
        r"'T' \[degC\], .*'psi' \[1\], beside which columns of the test table count, but not alone$"
    )
    with pytest.raises(InputError, match=rf"bare\.csv: {said}"):
        DataSet.load(tmp_path / "bare.csv")
    with pytest.raises(InputError, match=said):
        diagnose(bare, tests)
    with pytest.raises(InputError, match=r"column 'sigma_n' .* is missing.*is it 'sigma'"):
        diagnose(bare.assign(sigma=900.0), tests)
    with pytest.raises(InputError, match=r"varies.*nor about columns of the test table \(leg\) alone;"):
        diagnose(bare.assign(v_rel=10.0), tests)


def test_a_domain_from_before_is_read_as_it_was() -> None:
    old = {n: [1.0, 2.0] for n in LOAD_NAMES}
    assert Domain.from_dict(old) == Domain((1.0,) * 5, (2.0,) * 5) and not Domain.from_dict(old).absent
    for bad in ({**old, "psi": []}, {n: v for n, v in old.items() if n != "psi"}, {**old, "psi": "no"}):
        with pytest.raises(InputError, match="is not a domain"):
            Domain.from_dict(bad)  # type: ignore[arg-type]


def test_a_table_of_a_load_that_was_not_measured_has_two_lines_of_it(tmp_path: Path) -> None:
    model = make_model("linear").fit_frame(LESS)
    pack(model, tmp_path / "table", target="table")
    report = json.loads((tmp_path / "table" / "table.json").read_text())
    assert len(report["axes"]["T"]) == 2 and "+0 T/(degC)" in model.formula_text()


def test_no_set_point_is_invented_for_a_load_that_was_not_measured() -> None:
    catalogue = ["stribeck", "pressure_power", "pressure_saturation", "force_zero"]
    found = diagnose(FRAME.drop(columns="T"), model="constant", catalogue=catalogue)
    assert found.next_tests
    for proposal in found.next_tests:
        assert not any(k.startswith("T") for k in proposal["setpoints"])
        assert not any("T_tool" in row for row in proposal["plan"])
