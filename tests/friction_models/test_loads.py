"""The loads contract: checks, data sets on disk, and the sentences a user reads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from friction_models.common import (
    InputError,
    atomic_folder,
    atomic_path,
    check_readable,
    nearest,
    unknown_name,
    write_json,
)
from friction_models.common.folders import RUN
from friction_models.loads import LOAD_NAMES, LOADS, MU, DataSet, TriboLoads, check_column

UNITS = {"v_rel": "mm/s", "T": "degC", "sigma_n": "MPa", "sd": "mm", "psi": "1"}


@pytest.fixture
def points() -> pd.DataFrame:
    return pd.DataFrame(
        {
            "test_id": ["a", "a", "b"],
            "t": [0.0, 0.5, 0.0],
            "v_rel": [0.0, 5.0, 200.0],
            "T": [20.0, 21.5, 100.0],
            "sigma_n": [500.0, 505.0, 1750.0],
            "sd": [0.0, 2.5, 0.1],
            "psi": [1.0, 1.07, 1.9],
            "mu": [0.08, 0.081, 0.05],
        }
    )


def test_order_and_units_are_the_contract() -> None:
    assert {q.name: q.unit for q in LOADS} == UNITS
    assert tuple(UNITS) == LOAD_NAMES


@given(arrays(np.float64, (4, 5), elements=st.floats(1e-3, 1e3)))
def test_array_round_trip(matrix: np.ndarray) -> None:
    assert np.array_equal(TriboLoads.from_array(matrix).as_array(), matrix)


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0])
@pytest.mark.parametrize("column", ["v_rel", "sigma_n", "sd", "psi"])
def test_bad_value_names_column_row_value_and_range(points: pd.DataFrame, column: str, value: float) -> None:
    points.loc[1, column] = value
    with pytest.raises(InputError) as caught:
        TriboLoads.from_frame(points)
    message = str(caught.value)
    assert (
        repr(column) in message
        and "row 1" in message
        and str(value) in message
        and "allowed range" in message
    )


def test_loads_that_are_no_numbers() -> None:
    for nonsense in ([["1", "20", "500", "1", "x"]], "loads", [[1.0], [2.0, 3.0]], [{}]):
        with pytest.raises(InputError, match=r"loads: .*; allowed: numbers, of shape \(n, 5\)"):
            TriboLoads.from_array(nonsense)  # type: ignore[arg-type]


def test_unequal_lengths() -> None:
    with pytest.raises(InputError, match="'psi' has 1 rows, 'v_rel' has 2"):
        TriboLoads(*(np.ones(2) for _ in range(4)), np.ones(1))


def test_time_backwards_within_a_test_but_not_between(points: pd.DataFrame) -> None:
    assert len(TriboLoads.from_frame(points)) == 3
    points["test_id"] = "a"
    with pytest.raises(InputError, match=r"row 2: time 0\.0 s comes after 0\.5 s"):
        TriboLoads.from_frame(points)


def test_segments_and_context(points: pd.DataFrame) -> None:
    tests = pd.DataFrame({"test_id": ["b", "a"], "Ra": [0.3, 0.1]})
    loads = TriboLoads.from_frame(points, tests)
    assert loads.segments() == [slice(0, 2), slice(2, 3)]
    assert loads.context_column("Ra").tolist() == [0.1, 0.1, 0.3]
    assert loads.context_column("batch") is None
    assert loads.take([2]).context_column("Ra").tolist() == [0.3]


def test_data_set_round_trip(points: pd.DataFrame, tmp_path: Path) -> None:
    tests = pd.DataFrame({"test_id": ["a", "b"], "role": ["train", "test"], "T_tool": [20.0, 100.0]})
    DataSet(points, tests, {"synthetic": True}).save(tmp_path / "set")
    again = DataSet.load(tmp_path / "set")
    pd.testing.assert_frame_equal(again.points, points, check_dtype=False)
    assert again.synthetic
    train, held_out = again.frames()
    assert train.attrs["synthetic"] is True
    assert train["test_id"].unique().tolist() == ["a"] and held_out["test_id"].unique().tolist() == ["b"]


def test_further_columns_keep_their_units(points: pd.DataFrame, tmp_path: Path) -> None:
    more = points.assign(T_max=points["T"] + 5.0, F_n=1e5)
    DataSet(more, None, {"extra_units": {"T_max": "degC", "F_n": "N", "mu": "no"}}).save(tmp_path / "set")
    head, units = (tmp_path / "set" / "points.csv").read_text().splitlines()[:2]
    known = dict(zip(head.split(","), units.split(","), strict=True))
    assert known["T_max"] == "degC" and known["F_n"] == "N" and known["mu"] == "1"
    pd.testing.assert_frame_equal(DataSet.load(tmp_path / "set").points, more, check_dtype=False)


def test_units_in_the_header_or_in_a_row(points: pd.DataFrame, tmp_path: Path) -> None:
    named = points.rename(columns={"T": "T [degC]", "v_rel": "v_rel [mm/s]"})
    named.to_csv(tmp_path / "header.csv", index=False)
    pd.testing.assert_frame_equal(DataSet.load(tmp_path / "header.csv").points, points, check_dtype=False)
    points.to_parquet(tmp_path / "p.parquet")
    pd.testing.assert_frame_equal(DataSet.load(tmp_path / "p.parquet").points, points, check_dtype=False)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda d: d.drop(columns="mu"), r"column 'mu' \[1\] is missing"),
        (
            lambda d: d.rename(columns={"sigma_n": "sigma_N"}),
            r"'sigma_n' \[MPa\] is missing.*is it 'sigma_N'",
        ),
        (lambda d: d.rename(columns={"T": "T [MPa]"}), "unit of column 'T' 'MPa'; allowed: K, degC, degF"),
        (lambda d: d.assign(mu=[0.1, np.nan, 0.1]), "column 'mu', row 1: value nan"),
        (lambda d: d.assign(mu=["x", 0.1, 0.1]), "column 'mu', row 0: value 'x' is not a number"),
        (lambda d: d.assign(t=[1.0, 0.0, 0.0]), r"column 't', row 1: time 0\.0 s comes after 1\.0 s"),
        (lambda d: d.iloc[:0], "the table has no rows"),
    ],
)
def test_bad_files_get_one_sentence(points: pd.DataFrame, tmp_path: Path, change, sentence: str) -> None:
    file = tmp_path / "points.csv"
    change(points).to_csv(file, index=False)
    with pytest.raises(InputError, match=sentence) as caught:
        DataSet.load(file)
    assert str(file) in str(caught.value) and "\n" not in str(caught.value)


def test_empty_missing_and_foreign_files(tmp_path: Path) -> None:
    (tmp_path / "empty.csv").touch()
    with pytest.raises(InputError, match="the file is empty"):
        DataSet.load(tmp_path / "empty.csv")
    with pytest.raises(InputError, match=r"none\.csv: no such file; allowed: a CSV or Parquet file"):
        DataSet.load(tmp_path / "none.csv")
    with pytest.raises(InputError, match=r": is a folder; allowed: a CSV or Parquet file"):
        check_readable(tmp_path, allowed="a CSV or Parquet file")
    (tmp_path / "x.pkl").write_bytes(b"\x80\x04N.")
    with pytest.raises(InputError, match=r"suffix '.pkl' is not readable, allowed: .csv, .parquet"):
        DataSet.load(tmp_path / "x.pkl")
    (tmp_path / "bin.csv").write_bytes(bytes(range(256)) * 8)
    with pytest.raises(InputError, match="not a readable table"):
        DataSet.load(tmp_path / "bin.csv")


def test_writing_leaves_nothing_half_written(tmp_path: Path) -> None:
    target = tmp_path / "a.txt"
    target.write_text("old")
    with pytest.raises(RuntimeError), atomic_path(target) as temporary:
        temporary.write_text("new")
        raise RuntimeError
    with pytest.raises(RuntimeError), atomic_folder(tmp_path / "folder", RUN) as folder:
        (folder / "x").touch()
        raise RuntimeError
    with pytest.raises(ValueError):
        write_json(tmp_path / "n.json", {"x": float("nan")})
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"] and target.read_text() == "old"


def test_nearest_name() -> None:
    assert nearest("stribek", ["stribeck", "viscous"]) == "stribeck"
    assert nearest("zzz", ["stribeck"]) is None
    assert nearest("process", ["abaqus", "native", "radioss", "ufric"]) is None
    assert nearest("poly", ["linear", "polynomial"]) == "polynomial" and nearest("", ["linear"]) is None
    assert "did you mean 'linear'?" in str(unknown_name("model", "liniar", ["linear", "ffnn"]))


@pytest.mark.parametrize("values", [np.array([0.1, 0.1 + 0.2j]), [0.1, 0.1 + 0.2j]])
def test_a_complex_number_is_none_of_friction(values: object) -> None:
    with pytest.raises(InputError, match=r"row [01]: value \(0\.1\+0(\.2)?j\) is not a number"):
        check_column(values, MU)  # type: ignore[arg-type]
