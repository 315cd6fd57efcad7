"""Parameters of effects in saved models: those of earlier versions load, and what no fit could have written is refused."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_models import LinearFriction, load_model
from friction_models.common import InputError

from .made_up import campaign

#: Changes what a model has learned, as its card holds it.
Change = Callable[[dict[str, Any]], object]


@pytest.fixture(scope="module")
def data() -> tuple[pd.DataFrame, pd.DataFrame]:
    points = campaign(12, 10)
    names = points["test_id"].unique()
    tests = pd.DataFrame({"test_id": names, "batch": [f"lot{'ABCD'[k % 4]}" for k in range(len(names))]})
    return points, tests


@pytest.fixture(scope="module")
def saved(data: tuple[pd.DataFrame, pd.DataFrame], tmp_path_factory: pytest.TempPathFactory) -> Path:
    model = (LinearFriction() + "batch" + "surface_expansion" + "stribeck").fit_frame(*data)
    return model.save(tmp_path_factory.mktemp("models") / "model")


def edited(saved: Path, tmp_path: Path, change: Change) -> Path:
    """Return the model with other learned values, as an earlier version would have saved it."""
    folder = tmp_path / "edited"
    folder.mkdir()
    for file in saved.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    card = json.loads((folder / "card.json").read_text())
    card.pop("sha256")
    change(card["model"]["learned"])
    (folder / "card.json").write_text(json.dumps(card))
    return folder


def test_a_file_from_before_the_steepness_of_surface_expansion_has_the_old_law(
    saved: Path, tmp_path: Path, data: tuple[pd.DataFrame, pd.DataFrame]
) -> None:
    plain = load_model(edited(saved, tmp_path, lambda m: m["shapes"][1].update(n=1.0)))
    (tmp_path / "earlier").mkdir()
    earlier = load_model(edited(saved, tmp_path / "earlier", lambda m: m["shapes"][1].pop("n")))
    np.testing.assert_array_equal(earlier.predict_frame(*data), plain.predict_frame(*data))


def test_a_file_with_one_batch_among_several_predicts_as_before(
    saved: Path, tmp_path: Path, data: tuple[pd.DataFrame, pd.DataFrame]
) -> None:
    points, tests = data

    def one_batch(learned: dict[str, Any]) -> None:
        learned["amplitudes"][0] = {"c_b": 0.03}
        learned["shapes"][0] = {"deviating": 2.0}

    def none(learned: dict[str, Any]) -> None:
        learned["amplitudes"][0] = dict.fromkeys(learned["amplitudes"][0], 0.0)

    (tmp_path / "none").mkdir()
    without = load_model(edited(saved, tmp_path / "none", none)).predict_frame(points, tests)
    model = load_model(edited(saved, tmp_path, one_batch))
    offset = model.predict_frame(points, tests) - without
    deviates = points["test_id"].map(tests.set_index("test_id")["batch"]) == "lotC"
    np.testing.assert_allclose(offset, np.where(deviates, 0.03, 0.0), atol=1e-12)
    # and stays so when it is saved again
    again = load_model(model.save(tmp_path / "again"))
    np.testing.assert_array_equal(again.predict_frame(points, tests), model.predict_frame(points, tests))


@pytest.mark.parametrize("value", ["0.5", True, None, [0.1], {}, 1e308, float("nan"), float("inf"), 10**400])
def test_an_amplitude_that_is_no_number_is_refused(saved: Path, tmp_path: Path, value: Any) -> None:
    refused(
        edited(saved, tmp_path, lambda m: m["amplitudes"][0].update({"c_b[lotC]": value})),
        f"parameter 'c_b[lotC]' of effect 'batch' is {value!r:.40}",
        "allowed: a number from -1e+12 to 1e+12",
    )


@pytest.mark.parametrize(
    ("effect", "name", "value", "allowed"),
    [
        (1, "n", -1, "a number from 1 to 3"),
        (1, "n", 9.0, "a number from 1 to 3"),
        (1, "n", True, "a number from 1 to 3"),
        (1, "psi_c", 0, "a number from 0.001 to 100"),
        (2, "v_s", -5, "a number from 1e-09 to 100000 mm/s"),
        (2, "v_s", "20", "a number from 1e-09 to 100000 mm/s"),
        (2, "v_s", float("nan"), "a number from 1e-09 to 100000 mm/s"),
    ],
)
def test_a_shape_parameter_outside_its_bounds_is_refused(
    saved: Path, tmp_path: Path, effect: int, name: str, value: Any, allowed: str
) -> None:
    folder = edited(saved, tmp_path, lambda m: m["shapes"][effect].update({name: value}))
    refused(folder, f"parameter {name!r} of effect", f"is {value!r}", f"allowed: {allowed}")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda m: m["amplitudes"][0].pop("c_b[lotC]"), "parameter 'c_b[lotC]' of effect 'batch' is missing"),
        (lambda m: m["amplitudes"][0].update({"c_b[Q]": 0.0}), "no such parameter as 'c_b[Q]' here"),
        (lambda m: m["shapes"].pop(), "the parameters do not fit the effects"),
        (lambda m: m.update(amplitudes={}), "the parameters do not fit the effects"),
        (lambda m: m["shapes"].__setitem__(1, [1.0]), "parameters [1.0] of effect 'surface_expansion'"),
        (lambda m: m.update(levels=["lotA"]), "levels ['lotA']; allowed: a list of labels for each column"),
        (lambda m: m["levels"].update(batch="ABCD"), "levels of 'batch': 'ABCD'; allowed: a list of labels"),
        (lambda m: m["levels"].update(batch=["A", "A"]), "label 'A' stands twice"),
        (lambda m: m.update(system=[]), "system variable 'batch' is missing"),
        (lambda m: m.update(system={"name": "batch"}), "allowed: a list with one entry a system variable"),
        (lambda m: m["system"].append(m["system"][0]), "system variable 'batch' stands twice"),
        (lambda m: m["system"][0].update(name="bath"), "unknown system variable 'bath'; allowed: batch; did"),
        (lambda m: m["system"][0].update(start="A"), "'start' of system variable 'batch' is 'A'"),
        (lambda m: m["system"][0].update(start=9), "allowed: the number of a label, 0 to 3"),
        (lambda m: m["system"][0].pop("max"), "'max' of system variable 'batch' is None"),
        (lambda m: m["system"][0].update(foo=1), "system variable 'batch': unknown key 'foo'"),
    ],
)
def test_what_is_missing_or_no_parameter_is_named(
    saved: Path, tmp_path: Path, change: Change, words: str
) -> None:
    refused(edited(saved, tmp_path, change), words)


def test_the_one_that_is_missing_among_many_is_named(saved: Path, tmp_path: Path) -> None:
    def many(learned: dict[str, Any]) -> None:
        labels = [f"lot{k:03d}" for k in range(200)]
        learned["levels"]["batch"] = labels
        learned["amplitudes"][0] = {f"c_b[{label}]": 0.0 for label in labels if label != "lot150"}

    refused(edited(saved, tmp_path, many), "parameter 'c_b[lot150]' of effect 'batch' is missing", "188 more")


def test_any_single_edit_of_what_was_learned_loads_or_is_refused(
    saved: Path, tmp_path: Path, data: tuple[pd.DataFrame, pd.DataFrame]
) -> None:
    folder = edited(saved, tmp_path, lambda m: None)
    original = json.loads((folder / "card.json").read_text())
    places = [
        (part, k, name)
        for part in ("shapes", "amplitudes", "system")
        for k, entry in enumerate(original["model"]["learned"][part])
        for name in entry
    ]
    nonsense: list[Any] = [None, True, -1, 1e308, "x", [], {}, [[1]]]
    for part, k, name in places:
        for value in nonsense:
            card = copy.deepcopy(original)
            card["model"]["learned"][part][k][name] = value
            (folder / "card.json").write_text(json.dumps(card))
            try:
                mu = load_model(folder).predict_frame(*data)
            except InputError as error:
                assert "\n" not in str(error)
            else:
                assert np.isfinite(mu).all() and (mu >= 0).all(), (part, name, value)


def refused(folder: Path, *words: str) -> None:
    """The folder is refused in one short sentence that names it and holds the words."""
    with pytest.raises(InputError) as caught:
        load_model(folder)
    message = str(caught.value)
    assert all(part in message for part in (str(folder), *words)), message
    assert "\n" not in message and len(message) < 400 + len(str(folder))
