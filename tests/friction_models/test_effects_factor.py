"""Columns of the test table as effects, ``factor:COLUMN``: found, fitted, saved, packed; made-up campaigns."""

from __future__ import annotations

import copy
import pickle
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.prior import campaigns
from fmus import pack, read_friction_fmu
from friction_models import LinearFriction, OnnxModel, load_model
from friction_models.common import InputError
from friction_models.discovery import Diagnosis, diagnose, refine
from friction_models.effects import CATALOGUE, factor_effect, known_effect, make_effect
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.campaign.factors import factors_of
from friction_models.estimation.fit.pooling import shrinkage
from friction_models.families.composed import ComposedFriction

#: Scatter of mu from test to test, and along a test.
BETWEEN, WITHIN = 0.004, 0.001
#: Points a test.
POINTS = 12


def campaign(seed: int, count: int = 24) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return tests of a linear law, with operators, humidity and the like that have nothing to do with mu."""
    rng = np.random.default_rng([seed, 77])
    parts, rows = [], []
    for k in range(count):
        v, p = (5.0, 50.0, 300.0)[k % 3], (500.0, 1200.0, 2500.0)[k // 3 % 3]
        sd = np.linspace(0.5, 60.0, POINTS)
        T = rng.uniform(20.0, 200.0) + 30.0 * np.sqrt(sd / 60.0)
        loads = {
            "v_rel": v,
            "T": T,
            "sigma_n": p * (1.0 - 0.05 * sd / 60.0),
            "sd": sd,
            "psi": 1.0 + 0.02 * sd,
        }
        part = pd.DataFrame({"test_id": f"t{k:02d}", "t": sd / v} | loads)
        part["mu"] = (
            0.1 - 2e-5 * v - 4e-6 * p - 5e-5 * T + rng.normal(0.0, BETWEEN) + rng.normal(0.0, WITHIN, POINTS)
        )
        parts.append(part)
        rows.append(
            {
                "test_id": f"t{k:02d}",
                "operator": rng.choice(["anna", "bert", "cleo"]),
                "humidity": round(rng.uniform(30.0, 70.0), 1),
                "oven": rng.choice(["left", "right"]),
                "shift": int(rng.integers(1, 4)),
            }
        )
    return pd.concat(parts, ignore_index=True), pd.DataFrame(rows)


def shifted(data: pd.DataFrame, tests: pd.DataFrame, by: pd.Series) -> pd.DataFrame:
    """Return the points with mu of each test shifted."""
    return data.assign(mu=data["mu"] + by.set_axis(tests["test_id"])[data["test_id"]].to_numpy())


def one_operator(seed: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    data, tests = campaign(seed)
    return shifted(data, tests, 0.012 * (tests["operator"] == "bert")), tests


def damp_days(seed: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    data, tests = campaign(seed)
    return shifted(data, tests, 6e-4 * (tests["humidity"] - 50.0)), tests


#: Seeds of what is asked by night, of which one answer may be wrong.
SEEDS = range(5)


@cache
def answer_of(made: Callable[[int], tuple[pd.DataFrame, pd.DataFrame]], seed: int) -> Diagnosis:
    """Return the answer for made-up tests; several tests of this module ask for the same."""
    return diagnose(*made(seed))


@pytest.mark.nightly
def test_one_of_three_operators_who_lies_above_the_others_is_named() -> None:
    answers = [answer_of(one_operator, seed) for seed in SEEDS]
    named = [a for a in answers if a.effects == ["factor:operator"]]
    assert sum(a.verdict == "explained" for a in named) >= len(SEEDS) - 1
    assert not any(set(a.effects) - {"factor:operator"} for a in answers)
    values = [a.parameters["factor:operator"]["values"] for a in named]
    found = [[v[f"c[{who}]"]["value"] for who in ("anna", "bert", "cleo")] for v in values]
    assert np.mean(found, axis=0) == pytest.approx([-0.004, 0.008, -0.004], abs=0.002)


@pytest.mark.parametrize(
    ("seeds", "least"), [(range(4), 3), pytest.param(range(8), 5, marks=pytest.mark.nightly)]
)
def test_oils_that_all_differ_are_named_with_sixteen_tests(seeds: range, least: int) -> None:
    # no oil stands apart from all others; the spread of the four is six times the scatter from test to test
    named = 0
    for seed in seeds:
        data, tests = campaign(seed, 16)
        tests["oil"] = [f"oil {'ABCD'[k // 2 % 4]}" for k in range(len(tests))]
        offset = {"oil A": 0.012, "oil B": 0.004, "oil C": -0.004, "oil D": -0.012}
        named += diagnose(shifted(data, tests, tests["oil"].map(offset)), tests).effects == ["factor:oil"]
    assert named >= least


@pytest.mark.nightly  # by day test_test_numbers.py names it, with a cell that is none
def test_a_number_that_shifts_friction_linearly_is_named() -> None:
    answers = [answer_of(damp_days, seed) for seed in SEEDS]
    named = [a for a in answers if a.effects == ["factor:humidity"]]
    assert len(named) >= len(SEEDS) - 1
    slopes = [a.parameters["factor:humidity"]["values"] for a in named]
    found = [v["c"]["value"] / v["scale"]["value"] for v in slopes]
    assert float(np.mean(found)) == pytest.approx(6e-4, rel=0.2)


@pytest.mark.parametrize(
    ("seeds", "wrong"), [(range(2), 0), pytest.param(range(2, 12), 1, marks=pytest.mark.nightly)]
)
def test_columns_that_mean_nothing_are_hardly_ever_named(seeds: range, wrong: int) -> None:
    answers = [diagnose(*campaign(seed)) for seed in seeds]
    assert sum(bool(a.effects) for a in answers) <= wrong


@pytest.mark.nightly
def test_each_of_several_batches_has_an_offset(tmp_path: Path) -> None:
    """No batch stands apart from all others: one that deviates would leave most of what the others differ by."""
    data, tests = campaign(8, 48)
    tests["batch"] = [f"lot {'ABCD'[k // 2 % 4]}" for k in range(len(tests))]
    offset = {"lot A": 0.015, "lot B": 0.005, "lot C": -0.005, "lot D": -0.015}
    data = shifted(data, tests, tests["batch"].map(offset))
    found = diagnose(data, tests)
    assert found.effects == ["batch"] and found.verdict == "explained", found.sentence
    model = refine(data, tests, add="batch")
    assert isinstance(model, ComposedFriction)
    offsets = model.amplitudes_[0]
    # a diagnosis says what a fit has, also of a model that is judged as it is
    fixed = LinearFriction().fit_frame(data, tests)
    for one in (found, diagnose(data, tests, fixed)):
        values = one.parameters["batch"]["values"]
        assert list(values) == [f"c_b[{lot}]" for lot in offset] and one.verdict == "explained"
        assert [v["value"] for v in values.values()] == pytest.approx(list(offset.values()), abs=0.004)
    assert offsets == {k: v["value"] for k, v in found.parameters["batch"]["values"].items()}
    # what is left is the scatter from test to test
    assert model.error_history_[0]["after"]["rmse"] < 1.2 * np.hypot(BETWEEN, WITHIN)
    expected = model.predict_frame(data, tests)
    again = load_model(model.save(tmp_path / "model"))
    onnx = OnnxModel(tmp_path / "model" / "model.onnx")
    fmu = read_friction_fmu(pack(model, tmp_path / "batch.fmu", nodes=1))
    for one in (copy.deepcopy(model), again):
        np.testing.assert_array_equal(one.predict_frame(data, tests), expected)
    for exported in (onnx, fmu):
        np.testing.assert_allclose(exported.predict_frame(data, tests), expected, rtol=1e-12)


def test_every_operator_has_an_offset_and_few_tests_draw_it_towards_zero() -> None:
    data, tests = campaign(3)
    tests["operator"] = ["anna", "bert"] * 11 + ["cleo", "anna"]
    data = shifted(data, tests, tests["operator"].map({"anna": -0.01, "bert": 0.01, "cleo": 0.01}))
    model = refine(data, tests, add="factor:operator")
    assert isinstance(model, ComposedFriction)
    offsets = model.amplitudes_[0]
    assert list(offsets) == ["c[anna]", "c[bert]", "c[cleo]"]
    free = (LinearFriction() + factor_effect("operator")(deviating=2.0)).fit_frame(data, tests)
    assert offsets["c[bert]"] - offsets["c[anna]"] == pytest.approx(0.02, abs=0.005)
    # bert has eleven tests and cleo one; a given level is fitted as it is
    assert offsets["c[cleo]"] < free.amplitudes_[0]["c"]
    member = np.repeat(np.eye(2), [11, 1], axis=0)
    many, one = shrinkage(np.r_[np.linspace(-0.02, 0.0, 11), 0.02], member)
    assert one == pytest.approx(11.0 * many)
    assert list(free.amplitudes_[0]) == ["c"] and free.effects_[0] == factor_effect("operator")(deviating=2.0)
    table = tests.assign(operator="dora")
    levels = [model.predict_frame(data, tests.assign(operator=k)) for k in ("anna", "bert", "cleo")]
    np.testing.assert_allclose(model.predict_frame(data, table), np.mean(levels, axis=0), atol=2e-3)


def test_offsets_that_are_chance_vanish_and_strong_ones_stay() -> None:
    sizes = []
    for seed in range(10):
        model = (LinearFriction() + "factor:operator").fit_frame(*campaign(seed))
        sizes.append(max(map(abs, model.amplitudes_[0].values())))
    assert np.median(sizes) < 0.5 * BETWEEN
    model = (LinearFriction() + "factor:operator").fit_frame(*one_operator(0))
    a, b, c = model.amplitudes_[0].values()
    assert b - 0.5 * (a + c) == pytest.approx(0.012, abs=0.004)


def test_saved_and_packed_models_give_the_same_mu_for_every_label(tmp_path: Path) -> None:
    data, tests = one_operator(1)
    data = shifted(data, tests, 4e-4 * (tests["humidity"] - 50.0))
    model = refine(data, tests, add=["factor:operator", "factor:humidity"])
    assert model.name == "linear + factor:operator + factor:humidity"
    model.save(tmp_path / "model")
    again = load_model(tmp_path / "model")
    onnx = OnnxModel(tmp_path / "model" / "model.onnx")
    fmu = read_friction_fmu(pack(model, tmp_path / "factor.fmu", nodes=1))
    assert onnx.system_variables[0]["labels"] == ["anna", "bert", "cleo"]
    first = data[data["test_id"].isin(["t00", "t01"])]
    found = []
    # dora is unknown; without a table the commonest operator and the median humidity count
    for table in (*(tests.assign(operator=k) for k in ("anna", "bert", "cleo", "dora")), tests, None):
        expected = model.predict_frame(first, table)
        np.testing.assert_array_equal(again.predict_frame(first, table), expected)
        np.testing.assert_allclose(onnx.predict_frame(first, table), expected, rtol=1e-12)
        np.testing.assert_allclose(fmu.predict_frame(first, table), expected, rtol=1e-12)
        found.append(expected)
    apart = [float(mu[0] - found[3][0]) for mu in found[:3]]
    np.testing.assert_allclose(apart, list(model.amplitudes_[0].values()), atol=1e-12)  # type: ignore[attr-defined]


def test_the_choice_of_columns() -> None:
    data, tests = campaign(0)
    rng = np.random.default_rng(1)
    speed = tests["test_id"].map(data.groupby("test_id")["v_rel"].mean())
    tests = tests.assign(
        role="train",
        T_tool=20.0,
        Ra=rng.choice([0.1, 0.2, 0.4], len(tests)),
        speed_set=2.0 * speed + 1.0,
        program=speed.map({5.0: "slow", 50.0: "middle", 300.0: "fast"}),
        remark=[f"remark {k}" for k in range(len(tests))],
        machine="press 1",
        name_of_operator=tests["operator"].str.upper(),
        seldom=[1.0, 2.0, 3.0, 5.0] + [np.nan] * (len(tests) - 4),
    )
    tests["tool"] = tests["Ra"].map({0.1: "fine", 0.2: "middle", 0.4: "rough"})
    effects = [make_effect(e) for e in CATALOGUE.values()]
    found, notes = factors_of(prepare(data, tests), effects)
    assert [e.name for e in found] == [
        f"factor:{n}" for n in ("humidity", "name_of_operator", "oven", "shift")
    ]
    assert notes[0].endswith("are no factors: seldom is recorded for 4 of 24 tests")
    assert (
        "operator with name_of_operator, program with v_rel, speed_set with v_rel, tool with Ra" in notes[1]
    )
    backwards = factors_of(prepare(data, tests[tests.columns[::-1]]), effects)
    assert ([e.name for e in backwards[0]], backwards[1]) == ([e.name for e in found], notes)
    many = tests.assign(**{f"z{k:02d}": rng.normal(size=len(tests)) for k in range(20)})
    found, notes = factors_of(prepare(data, many), effects)
    assert len(found) == 12 and "first 12 by name" in notes[-1]


def test_a_column_that_divides_the_levels_of_another_stays_beside_it() -> None:
    data, tests = campaign(0)
    rng = np.random.default_rng(2)
    count = len(tests)
    to = rng.permutation(np.arange(count) % 2)
    tests = tests.assign(
        direction=np.where(to, "to", "fro"),  # runs 1 to 3 one way, 4 to 6 the other way
        run=3 * to + 1 + rng.integers(0, 3, count),
        Ra=rng.choice([0.1, 0.4], count),
        label=[f"n{k:02d}" for k in range(count)],  # a name for each test
    )
    tests["a_way"] = tests["direction"].str.upper()  # another word for the same
    tests["die"] = tests["Ra"].astype(str) + rng.choice(["left", "right"], count)  # two of each roughness
    tests["specimen"] = tests["operator"] + (tests.groupby("operator").cumcount() // 2).astype(str)
    effects = [make_effect(e) for e in CATALOGUE.values()]
    for table in (tests, tests.rename(columns={"run": "course", "direction": "way"})):
        found, notes = factors_of(prepare(data, table), effects)
        names = {e.name for e in found}
        assert {"factor:die", "factor:operator", "factor:specimen", "factor:a_way"} <= names
        assert names & {"factor:run", "factor:course"}  # whichever comes first by name
        assert "factor:label" not in names and not names & {"factor:direction", "factor:way"}
        assert len(notes) == 1 and notes[0].endswith(
            "others: direction with a_way" if table is tests else "others: way with a_way"
        )


def number_within_texts(seed: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return averages of three powders, each consolidated at other stresses, that raise mu."""
    data, tests = campaign(seed, count=36)
    data = data.groupby("test_id", as_index=False).mean(numeric_only=True).drop(columns="t")
    rng = np.random.default_rng([seed, 5])
    powder = rng.permutation(np.arange(len(tests)) % 3)
    stress = 1000.0 * rng.integers(1, 6, len(tests)) + 10.0 * powder
    tests = tests[["test_id", "oven"]].assign(powder=np.array(["a", "b", "c"])[powder], stress=stress)
    return shifted(data, tests, 6e-6 * (tests["stress"] - 3000.0)), tests


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.nightly)])
def test_a_number_that_varies_within_the_levels_of_a_text_is_named(seed: int) -> None:
    assert diagnose(*number_within_texts(seed)).effects == ["factor:stress"]


@pytest.mark.nightly
def test_answers_do_not_depend_on_the_order_of_columns_and_a_given_catalogue_has_no_factors() -> None:
    data, tests = one_operator(0)
    found = answer_of(one_operator, 0)
    assert found.effects == ["factor:operator"]
    assert diagnose(data, tests[tests.columns[::-1]]).to_dict() == found.to_dict()
    plain = diagnose(data, tests, catalogue=["stribeck", "thermal_softening", "wear_out"])
    assert not any(r["effect"].startswith("factor:") for r in plain.ranking)
    known = refine(data, tests, add="factor:operator")
    again = diagnose(data, tests, model=known)
    assert "factor:operator" not in [r["effect"] for r in again.ranking]


def test_names_and_errors() -> None:
    effect = make_effect("factor:operator")
    assert known_effect(effect.name) and type(effect) is factor_effect("operator")
    fixed = factor_effect("operator")(deviating=2.0)
    assert repr(fixed) == "Factor(deviating=2.0, column='operator')"
    for one in (effect, fixed, effect.with_levels({"operator": ["a", "b"]})):
        assert pickle.loads(pickle.dumps(one)) == one == copy.deepcopy(one)  # noqa: S301
    data, tests = campaign(0)
    with pytest.raises(
        InputError, match="this one has humidity, operator, oven, shift; did you mean 'humidity'"
    ):
        refine(data, tests, add="factor:humidty")
    with pytest.raises(InputError, match="needs the column 'operator' in the table of tests"):
        refine(data, add="factor:operator")
    with pytest.raises(InputError, match="batch: the column has the same level in all of the 24 tests"):
        refine(data, tests.assign(batch="A"), add="batch")
    with pytest.raises(InputError, match="batch: the column has another text in nearly each of the 24 tests"):
        refine(data, tests.assign(batch=[f"lot {k}" for k in range(24)]), add="batch")
    for name in ("factor:", "factor:v_rel"):
        with pytest.raises(InputError, match="allowed is factor:COLUMN"):
            make_effect(name)


@pytest.mark.parametrize("effect", ["batch", "factor:operator"])
@pytest.mark.parametrize(
    ("text", "named"), [("bert\x07", "U+0007"), ("be\nrt", "U+000A"), ("b\u202eert", "U+202E")]
)
def test_labels_that_no_card_and_no_fmu_can_hold_are_refused(effect: str, text: str, named: str) -> None:
    data, tests = campaign(0)
    column = effect.removeprefix("factor:")
    tests[column] = tests["operator"].replace("bert", text)
    with pytest.raises(InputError, match=re.escape(named)) as caught:
        (LinearFriction() + effect).fit_frame(data, tests)
    assert str(caught.value).isprintable() and repr(column) in str(caught.value)
    tests[column] = tests[column].replace(text, "b\xa0ert")  # as spreadsheets write blanks
    assert (LinearFriction() + effect).fit_frame(data, tests).is_fitted


def test_the_formula_of_numbers_is_a_line_and_earlier_files_are_read(tmp_path: Path) -> None:
    data, tests = damp_days(0)
    model = (LinearFriction() + "factor:humidity" + "factor:operator").fit_frame(data, tests)
    assert isinstance(model, ComposedFriction)
    said = model.formula_text()
    assert "; mu += c * (humidity - centre)/scale [c = " in said and "deviating" not in said
    assert list(model.shapes_[0]) == ["centre", "scale"]
    model.save(tmp_path / "model")
    # Files of earlier versions hold a level for columns of numbers, too; it had no meaning.
    file = tmp_path / "model" / "card.json"
    text = file.read_text().replace('"sha256"', '"told"')
    parameters = [p for p in (tmp_path / "model").iterdir() if '"centre"' in p.read_text(errors="replace")]
    assert parameters == [file]
    file.write_text(text.replace('"centre"', '"deviating": 0.0, "centre"', 1))
    again = load_model(tmp_path / "model")
    assert again.formula_text() == said
    np.testing.assert_array_equal(again.predict_frame(data, tests), model.predict_frame(data, tests))
    file.write_text(text.replace('"centre"', '"center"', 1))
    with pytest.raises(InputError, match="center"):
        load_model(tmp_path / "model")


@pytest.mark.nightly
def test_tests_over_the_same_speeds_are_not_told_apart_by_their_speed() -> None:
    """Their means differ by where a record ends: a direction that went with them was no column of its own."""
    rng = np.random.default_rng(3)
    frames = []
    for k in range(12):
        v = np.repeat([5.0, 20.0, 60.0, 120.0, 200.0, 300.0], 8)[: 48 - (k < 6)]
        mu = (
            0.1
            + 0.03 * np.exp(-v / 40.0)
            + 0.02 * (k < 6)
            + rng.normal(0.0, 0.001)
            + rng.normal(0.0, 0.001, len(v))
        )
        sd = np.cumsum(0.02 * v)
        frames.append(
            pd.DataFrame(
                {"test_id": f"t{k:02d}", "t": 0.02 * np.arange(len(v)), "v_rel": v, "sd": sd, "mu": mu}
            )
        )
    tests = pd.DataFrame(
        {"test_id": [f"t{k:02d}" for k in range(12)], "direction": ["up"] * 6 + ["down"] * 6}
    )
    found = diagnose(pd.concat(frames), tests)
    assert "factor:direction" in [r["effect"] for r in found.ranking]
    assert not any("from test to test" in w for w in found.warnings)
    # along each of them the speed steps up with the distance
    assert any("along the tests" in w and "move together" in w for w in found.warnings)


@pytest.mark.nightly
def test_an_effect_that_shows_nothing_beside_a_factor_has_no_amplitude() -> None:
    """What rounding made of it was divided by the size of a column that is left out: offsets of the lots were no numbers, a crash."""
    made = campaigns.campaign(600032)
    found = diagnose(made.points, made.tests)
    assert "factor:lot" in found.effects
