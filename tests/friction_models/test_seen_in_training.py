"""`compare` says where a model was trained on the tests that it is judged by."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fmus import pack, read_friction_fmu
from friction_models import ConstantFriction, LinearFriction, OnnxModel, load_model
from friction_models.discovery import compare, refine
from friction_models.loads import DataSet
from orchestrator.comparison.on_tests import compare_on_tests
from orchestrator.report.pages.comparison import comparison_page

from .made_up import campaign

FRAME = campaign(12, 12)
OTHER = campaign(12, 12, seed=7)  # the same names, other measurements
HALF = FRAME[FRAME["test_id"] < "t06"]
SAID = "was trained on 6 of the 12 tests that it is judged by: errors there say little about new tests"


def test_text_json_and_page_say_it(tmp_path: Path) -> None:
    models = {"half": LinearFriction().fit_frame(HALF), "other": LinearFriction().fit_frame(OTHER)}
    models["given"] = ConstantFriction(0.08)
    result = compare_on_tests(models, DataSet(FRAME, None))
    assert result.report().count(SAID) == 1 and f"half {SAID}" in result.report()
    assert "other was" not in result.report() and "given was" not in result.report()
    content = json.loads(json.dumps(result.to_dict()))
    assert content["models"]["half"]["trained_on_tests"] == [f"t{k:02d}" for k in range(6)]
    assert content["models"]["other"]["trained_on_tests"] == []
    assert f"half {SAID}" in content["remarks"] and SAID in comparison_page(result, None)
    unseen = FRAME[FRAME["test_id"] >= "t06"]
    assert "trained on" not in compare({"half": models["half"]}, unseen).report()


def test_files_know_it_too_and_rounding_does_not_hide_it(tmp_path: Path) -> None:
    model = LinearFriction().fit_frame(HALF)
    folder = model.save(tmp_path / "model")
    fmu = read_friction_fmu(pack(folder, tmp_path / "model.fmu"))
    # through a file whose numbers have twelve digits, in another order of the points
    FRAME.sample(frac=1.0, random_state=1).sort_values(["test_id", "t"]).to_csv(
        tmp_path / "points.csv", index=False, float_format="%.12g"
    )
    read = pd.read_csv(tmp_path / "points.csv")
    for given in (load_model(folder), OnnxModel(folder / "model.onnx"), fmu):
        assert SAID in compare({"it": given}, read).report()


def test_a_card_of_before_is_compared_by_names() -> None:
    model = LinearFriction().fit_frame(HALF)
    del model.training_["splits"]["digests"]
    assert "with the names of 6 of the 12 tests" in compare({"old": model}, OTHER).report()


@pytest.mark.parametrize("add", [[], ["stribeck"]])
def test_a_refined_model_knows_its_tests_though_spikes_were_repaired(add: list[str]) -> None:
    spiky = campaign(8, 60, noise=0.0004)
    spiky.loc[spiky.groupby("test_id").nth(30).index, "mu"] += 0.3
    model = refine(spiky, model="linear", add=add, force=True)
    assert "all 8 tests" in compare({"it": model}, spiky).report()
    assert not np.array_equal(model.predict_frame(spiky), spiky["mu"])
