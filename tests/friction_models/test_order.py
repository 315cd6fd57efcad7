"""Points of a test that are mixed with others or run backwards: sorted by time, or refused where nothing orders them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fmus import pack
from fmus.runtime.fixed_friction import read_friction_fmu
from friction_models import LinearFriction
from friction_models.common import InputError
from friction_models.discovery import diagnose
from friction_models.estimation.fit.joint_problem import LEAST_TESTS
from friction_models.loads import DataSet, TriboLoads
from friction_models.loads.points import check_points
from friction_models.models.onnx_model import OnnxModel
from orchestrator.cli.main import run


def campaign() -> pd.DataFrame:
    """Eight tests whose friction rises with the friction work that was done."""
    rng = np.random.default_rng(1)
    parts = []
    for k in range(8):
        v, s = (20.0, 60.0, 150.0, 300.0)[k % 4], (500.0, 1000.0, 2000.0)[k % 3]
        sd = np.linspace(0.5, 40.0, 30)
        work = 0.06 * s * sd
        mu = 0.05 + 0.04 * (1.0 - np.exp(-work / 3e3)) + rng.normal(0.0, 5e-4, 30)
        parts.append(
            pd.DataFrame(
                {"test_id": f"t{k}", "t": sd / v + 0.1, "v_rel": v, "T": 20.0 + 30.0 * (k % 5) + 0.2 * sd,
                 "sigma_n": s, "sd": sd, "psi": 1.05 + 1e-3 * sd, "mu": mu}
            )
        )  # fmt: skip
    return pd.concat(parts, ignore_index=True)


@pytest.fixture(scope="module")
def points() -> pd.DataFrame:
    return campaign()


@pytest.fixture(scope="module")
def shuffled(points: pd.DataFrame) -> pd.DataFrame:
    return points.sample(frac=1.0, random_state=3).reset_index(drop=True)


@pytest.fixture(scope="module")
def model(points: pd.DataFrame):
    fitted = (LinearFriction() + "work_exhaustion").fit_frame(points)
    assert fitted.states and points["test_id"].nunique() >= LEAST_TESTS
    return fitted


@pytest.fixture(scope="module")
def forms(model, tmp_path_factory: pytest.TempPathFactory) -> dict:
    """The same law as a model, as an ONNX file and as an FMU."""
    folder = tmp_path_factory.mktemp("model")
    model.save(folder / "m")
    fmu = pack(model, folder / "m.fmu")
    return {"model": model, "onnx": OnnxModel(folder / "m" / "model.onnx"), "fmu": read_friction_fmu(fmu)}


FORMS = ("model", "onnx", "fmu")


def in_rows_of(shuffled: pd.DataFrame, points: pd.DataFrame, values: pd.Series) -> np.ndarray:
    """Return values of the points in order, in the rows of the shuffled table, by test and time."""
    keyed = pd.Series(values.to_numpy(), index=pd.MultiIndex.from_frame(points[["test_id", "sd"]]))
    return keyed.loc[pd.MultiIndex.from_frame(shuffled[["test_id", "sd"]])].to_numpy()


@pytest.mark.parametrize("form", FORMS)
def test_memory_follows_the_time_whatever_the_order_of_the_rows(forms, form, points, shuffled) -> None:
    wanted = forms[form].predict_frame(points)
    fresh = forms[form].predict_frame(points.assign(test_id=points.index.astype(str)))
    assert np.abs(wanted - fresh).max() > 0.02  # memory matters here
    for mixed in (shuffled, points.iloc[::-1].reset_index(drop=True)):
        found = forms[form].predict_frame(mixed)
        np.testing.assert_allclose(found, in_rows_of(mixed, points, wanted), rtol=0, atol=1e-12)


@pytest.mark.parametrize("form", FORMS)
def test_without_time_tests_may_be_mixed_but_not_shuffled(forms, form, points, shuffled) -> None:
    timeless = points.drop(columns="t")
    mixed = timeless.sort_values("sd", kind="stable").reset_index(drop=True)
    wanted = forms[form].predict_frame(timeless)
    np.testing.assert_allclose(
        forms[form].predict_frame(mixed), in_rows_of(mixed, timeless, wanted), rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(wanted, forms["model"].predict_frame(points), rtol=0, atol=2e-3)
    for bad in (shuffled.drop(columns="t"), timeless.iloc[::-1]):
        with pytest.raises(InputError, match=r"test 't\d', column 'sd', row \d+: [\d.]+ mm comes after"):
            forms[form].predict_frame(bad)


def test_a_fit_does_not_depend_on_the_order_of_the_rows(points, shuffled, model) -> None:
    again = (LinearFriction() + "work_exhaustion").fit_frame(shuffled)
    np.testing.assert_allclose(again.predict_frame(points), model.predict_frame(points), rtol=0, atol=1e-3)
    with pytest.raises(InputError, match="column 'sd'"):
        (LinearFriction() + "work_exhaustion").fit_frame(shuffled.drop(columns="t"))
    with pytest.raises(InputError, match="column 'sd'"):
        diagnose(shuffled.drop(columns="t"))
    LinearFriction().fit_frame(shuffled.drop(columns="t"))  # no memory, no order


def test_tests_that_run_backwards_are_sorted_each_by_itself(points: pd.DataFrame) -> None:
    two = points[points["test_id"].isin(["t0", "t1"])]
    backwards = pd.concat([test.iloc[::-1] for _, test in two.groupby("test_id")], ignore_index=True)
    found = check_points(backwards)
    pd.testing.assert_frame_equal(found.frame, two.reset_index(drop=True)[found.frame.columns.to_list()])
    assert found.notes == ("data: the points of a test are not in order: each test is taken as one, by time",)
    falling = two.assign(t=np.concatenate([test["t"].to_numpy()[::-1] for _, test in two.groupby("test_id")]))
    for read in (check_points, TriboLoads.from_frame):
        with pytest.raises(
            InputError, match=r"column 't', row 1: .* in the order of 't' the distance falls to"
        ):
            read(falling)


def test_times_that_order_nothing_are_refused(points: pd.DataFrame, model) -> None:
    two = points[points["test_id"].isin(["t0", "t1"])]
    copied = pd.concat([two, two], ignore_index=True)
    with pytest.raises(InputError, match=r"test 't0', column 't', row 60: .* 0\.125 s stands there twice"):
        TriboLoads.from_frame(copied)
    other = pd.concat(
        [two.assign(test_id="a"), two.iloc[:30].assign(test_id="a", t=two["t"].iloc[:30] + 0.01)]
    )
    with pytest.raises(InputError, match="in the order of 't' the distance falls to"):
        TriboLoads.from_frame(other)  # two tests under one name are no test
    with pytest.raises(InputError, match=r"test 't0', column 't', row 0: 1\.0 s at every point of the test"):
        model.predict_frame(two.assign(t=1.0))


def test_commands_sort_and_give_rows_back_as_they_came(
    points: pd.DataFrame, shuffled: pd.DataFrame, model, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model.save(tmp_path / "m")
    given = shuffled.assign(T=shuffled["T"] + 273.15, operator="Ann").rename(columns={"T": "T [K]"})
    given.loc[4, "v_rel"] = np.nan
    given[["operator", *given.columns[:-1]]].to_csv(tmp_path / "points.csv", index=False)
    words = ["predict", str(tmp_path / "m"), "--data", str(tmp_path / "points.csv")]
    assert run([*words, "-o", str(tmp_path / "out.csv")]) == 0
    said = capsys.readouterr().err
    assert "1 of 240 points left out: v_rel is not a number (first: row 4)" in said and "by time" in said
    found = pd.read_csv(tmp_path / "out.csv")
    pd.testing.assert_frame_equal(found.drop(columns="mu_model"), pd.read_csv(tmp_path / "points.csv"))
    assert np.flatnonzero(found["mu_model"].isna()).tolist() == [4]
    kept = found.index != 4
    lacking = points[~((points["test_id"] == shuffled["test_id"][4]) & (points["sd"] == shuffled["sd"][4]))]
    wanted = in_rows_of(shuffled[kept], lacking, model.predict_frame(lacking))
    np.testing.assert_allclose(found["mu_model"][kept], wanted, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    "words",
    [["evaluate", "{m}"], ["predict", "{m}", "-o", "{m}.csv"], ["compare", "--models", "0.1", "{m}"],
     ["diagnose", "--model", "linear"], ["refine", "--model", "linear", "--add", "work_exhaustion", "-o", "{m}2"]],
)  # fmt: skip
def test_every_command_refuses_what_has_no_order_by_file_and_row(
    words: list[str], shuffled: pd.DataFrame, model, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model.save(tmp_path / "m")
    file = tmp_path / "points.csv"
    shuffled.drop(columns="t").to_csv(file, index=False)
    assert run([word.format(m=tmp_path / "m") for word in words] + ["--data", str(file)]) == 2
    said = capsys.readouterr().err
    name = shuffled["test_id"]
    highest = shuffled["sd"].groupby(name).cummax()
    row = int(said.partition("row ")[2].partition(":")[0])
    assert f"{file}: test {name[row]!r}, column 'sd'" in said
    assert shuffled["sd"][row] < highest[row] - 0.01 * 39.5


def test_a_data_set_is_in_order_when_it_is_read(points, shuffled, tmp_path: Path) -> None:
    shuffled.to_csv(tmp_path / "points.csv", index=False)
    found = DataSet.load(tmp_path / "points.csv").points
    for name, part in found.groupby("test_id"):
        pd.testing.assert_frame_equal(
            part.reset_index(drop=True), points[points["test_id"] == name].reset_index(drop=True)
        )
    assert (found["test_id"] != found["test_id"].shift()).sum() == 8
