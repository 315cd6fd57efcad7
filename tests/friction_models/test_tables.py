"""Tables from spreadsheets and loggers: what is read, what is converted, what is refused by one sentence."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fmus.interface.quantities import load_conversion as fmu_conversion
from friction_models.common import InputError
from friction_models.common.files import read_json
from friction_models.common.units import UNITS, conversion, units_like
from friction_models.common.yaml_files import read_yaml
from friction_models.loads import LOAD_NAMES, LOADS, DataSet
from friction_models.loads.dataset import read_tests
from friction_models.loads.points import check_points
from friction_models.loads.table import read_table

#: One point by hand, in the contract's units and as other laboratories would write it.
HEADER = "test_id,t,v_rel,T,sigma_n,sd,psi,mu"
PLAIN = f"{HEADER}\na,0.5,50,100,1250,25,1.2,0.08\na,0.75,50,110,1250,37.5,1.25,0.075\n"


def read(folder: Path, content: str | bytes, name: str = "points.csv") -> pd.DataFrame:
    file = folder / name
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return DataSet.load(file).points


@pytest.fixture
def plain(tmp_path: Path) -> pd.DataFrame:
    return read(tmp_path, PLAIN, "plain.csv")


SAME = {
    "units in the header": "test_id,t [ms],v_rel [m/s],T [K],sigma_n [GPa],sd [m],psi,mu [%]\n"
    "a,500,0.05,373.15,1.25,0.025,1.2,8\na,750,0.05,383.15,1.25,0.0375,1.25,7.5\n",
    "units in round brackets": "test_id,t (s),v_rel (m/min),T (°F),sigma_n (N/mm²),sd (cm),psi (-),mu\n"
    "a,0.5,3,212,1250,2.5,1.2,0.08\na,0.75,3,230,1250,3.75,1.25,0.075\n",
    "a row of units": f"{HEADER}\n,ms,m/s,K,GPa,m,1,%\n"
    "a,500,0.05,373.15,1.25,0.025,1.2,8\na,750,0.05,383.15,1.25,0.0375,1.25,7.5\n",
    "semicolons and decimal commas": PLAIN.replace(",", ";").replace(".", ","),
    "tabs": PLAIN.replace(",", "\t"),
    "tabs and decimal commas": PLAIN.replace(",", "\t").replace(".", ","),
    "semicolons and decimal points": PLAIN.replace(",", ";"),
    "vertical bars": PLAIN.replace(",", "|"),
    "vertical bars and decimal commas": PLAIN.replace(",", "|").replace(".", ","),
    "vertical bars below what a logger says": "Logger 3000\nRig | A\n" + PLAIN.replace(",", " | "),
    "blanks": PLAIN.replace(",", " , "),
    "separators at the ends of lines": PLAIN.replace("\n", ",\n"),
    "separators at the ends of rows only": PLAIN.replace("\n", ",\n").replace("mu,\n", "mu\n"),
    "blank rows": PLAIN.replace("\na", "\n,,,,,,,\na") + ",,,,,,,\n\n",
    "a byte order mark": b"\xef\xbb\xbf" + PLAIN.encode(),
    "UTF-16": PLAIN.encode("utf-16"),
    "UTF-16, the other order": b"\xfe\xff" + PLAIN.encode("utf-16-be"),
    "UTF-32": PLAIN.encode("utf-32"),
    "UTF-32, the other order": b"\0\0\xfe\xff" + PLAIN.encode("utf-32-be"),
    "carriage returns": PLAIN.replace("\n", "\r\n"),
    "quotes": '"' + PLAIN.strip().replace(",", '","').replace("\n", '"\n"') + '"\n',
}


@pytest.mark.parametrize("what", SAME)
def test_the_same_points_in_other_clothes(tmp_path: Path, plain: pd.DataFrame, what: str) -> None:
    found = read(tmp_path, SAME[what])
    pd.testing.assert_frame_equal(found, plain, check_dtype=False, rtol=1e-12)


def test_a_mark_of_byte_order_does_not_hide_a_unit(tmp_path: Path, plain: pd.DataFrame) -> None:
    """The first column is the one behind the mark."""
    columns = ["T", "test_id", "t", "v_rel", "sigma_n", "sd", "psi", "mu"]
    kelvin = plain.assign(T=plain["T"] + 273.15)[columns].to_csv(index=False)
    head, _, body = kelvin.partition("\n")
    for text in (f"{head}\nK,,s,mm/s,MPa,mm,1,1\n{body}", f"{head.replace('T,', 'T [K],', 1)}\n{body}"):
        found = read(tmp_path, b"\xef\xbb\xbf" + text.encode())
        assert np.allclose(found["T"], plain["T"], rtol=0, atol=1e-9)


def test_windows_text_and_marks_in_yaml_and_json(tmp_path: Path) -> None:
    found = read(tmp_path, PLAIN.replace("T,", "T [°C],", 1).encode("cp1252"))
    assert found["T"].tolist() == [100.0, 110.0]
    (tmp_path / "a.json").write_bytes(b'\xef\xbb\xbf{"synthetic": true}')
    assert read_json(tmp_path / "a.json") == {"synthetic": True}
    (tmp_path / "a.yaml").write_bytes(b"\xef\xbb\xbfsynthetic: true\n")
    assert read_yaml(tmp_path / "a.yaml") == {"synthetic": True}
    for encoding in ("utf-16", "utf-32"):
        (tmp_path / "a.yaml").write_bytes("lubricant: Öl\n".encode(encoding))
        assert read_yaml(tmp_path / "a.yaml") == {"lubricant": "Öl"}
        (tmp_path / "a.json").write_bytes('{"lubricant": "Öl"}'.encode(encoding))
        assert read_json(tmp_path / "a.json") == {"lubricant": "Öl"}


def test_a_copy_of_a_test_is_named(tmp_path: Path) -> None:
    one = pd.DataFrame({"sd": np.arange(8.0), "mu": 0.08 + 0.01 * np.sin(np.arange(8.0))})
    tests = {"a": one, "b": one.assign(mu=one["mu"] + 1e-9), "c": one.iloc[::-1], "d": one}
    frame = pd.concat([t.assign(test_id=name, t=t["sd"]) for name, t in tests.items()])
    said = "tests 'a' and 'c' and 'd' hold the same numbers"
    assert [note for note in check_points(frame).notes if said in note]
    # Two points, friction that stays, or other loads: no copy is claimed.
    short = pd.concat([one.head(5).assign(test_id=name) for name in "ab"])
    still = pd.concat([one.assign(test_id=name, mu=0.08) for name in "ab"])
    other = pd.concat([one.assign(test_id=name, v_rel=speed) for name, speed in (("a", 5.0), ("b", 50.0))])
    for frame in (short, still, other):
        assert check_points(frame).notes == ()


def test_a_key_that_stands_twice_is_not_read_by_its_last_value(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("a:\n  - {b: 1, c: 2}\n  - b: 1\n    c: 2\n    b: 3\n")
    with pytest.raises(InputError, match=r"a\.yaml: key 'b' stands twice, again in line 5; allowed: once"):
        read_yaml(tmp_path / "a.yaml")
    (tmp_path / "a.yaml").write_text("a: 1\nc: {a: 2}\n")
    assert read_yaml(tmp_path / "a.yaml") == {"a": 1, "c": {"a": 2}}


REFUSED = {
    "twice": (PLAIN.replace("psi", "mu"), "column 'mu' stands twice in the header"),
    "twice in two units": (PLAIN.replace(",psi", ",T [K]"), "'T' stands twice in the header, as 'T' and as 'T .K.'"),
    "twice with a blank": (PLAIN.replace(",psi", ", mu "), "column 'mu' stands twice"),
    "twice in capitals": (PLAIN.replace(",t,", ",Mu,"), "column 'Mu'; allowed: 'mu' beside it"),
    "another quantity": (PLAIN.replace("T,", "T [MPa],", 1), "unit of column 'T' 'MPa'; allowed: K, degC, degF"),
    "no such unit": (PLAIN.replace("sd", "sd [mmm]"), "'mmm'; allowed: .*; did you mean 'mm'"),
    "values without a column": (PLAIN.replace("0.08\n", "0.08,7\n"), "row 0 has the value '7.0' in column 9"),
    "thousands": (PLAIN.replace(",", ";").replace(".", ",").replace("1250", "1.250,0"), "'1.250,0' is not a number"),
    "text with a unit": (PLAIN.replace("T,", "T [K],", 1).replace(",100,", ",warm,"), "row 0: value 'warm' is not a number"),
    "binary": (b"a,b\0,c\n" + bytes(100), "binary content"),
}  # fmt: skip


@pytest.mark.parametrize("what", REFUSED)
def test_refused_by_one_sentence(tmp_path: Path, what: str) -> None:
    content, sentence = REFUSED[what]
    with pytest.raises(InputError, match=sentence) as caught:
        read(tmp_path, content)
    assert str(tmp_path / "points.csv") in str(caught.value) and "\n" not in str(caught.value)


def test_tables_of_tests_and_plans_keep_the_same_rules(tmp_path: Path) -> None:
    file = tmp_path / "tests.csv"
    file.write_bytes(
        "\ufefftest_id;T_tool;v_set;Ra;role\n;K;m/s;um;\na;293,15;0,05;0,012;train\n".encode("utf-8")
    )
    row = read_table(file).iloc[0]
    assert (row["test_id"], row["v_set"], row["Ra"], row["role"]) == ("a", 50.0, 0.012, "train")
    assert row["T_tool"] == pytest.approx(20.0)
    file.write_text("test_id,role,role\na,train,test\n")
    with pytest.raises(InputError, match="'role' stands twice"):
        read_table(file)
    file.write_text("test_id,Role\na,test\n")
    with pytest.raises(InputError, match="column 'Role'; allowed: 'role'"):
        read_table(file)
    file.write_text("test_id,v_levels [m/s]\na,0.1;0.2\n")
    with pytest.raises(InputError, match=r"row 0: value '0.1;0.2' is not a number \[m/s\]"):
        read_table(file)


#: Written down from the definitions: (unit, value, in the project's unit).
BY_HAND = [
    ("in", 1.0, 25.4), ("um", 1.0, 1e-3), ("mm/min", 60.0, 1.0), ("m/min", 6.0, 100.0), ("bar", 10.0, 1.0),
    ("GPa", 2.0, 2000.0), ("kPa", 1.0, 1e-3), ("K", 273.15, 0.0), ("degF", 212.0, 100.0), ("min", 2.0, 120.0),
    ("h", 1.0, 3600.0), ("us", 1.0, 1e-6), ("MN", 1.0, 1e6), ("g", 1.0, 9806.65), ("%", 8.0, 0.08), ("cm/s", 1.0, 10.0),
]  # fmt: skip


@pytest.mark.parametrize(("unit", "value", "wanted"), BY_HAND)
def test_units_by_hand(unit: str, value: float, wanted: float) -> None:
    canonical = next(n for n, u in UNITS.items() if u.kind == UNITS[unit].kind)
    factor, offset = conversion(canonical, unit, "x")
    assert value * factor + offset == pytest.approx(wanted, abs=1e-9)


def test_units_of_tables_and_of_fmus_agree() -> None:
    """Two tables: this one in mm, N, s, that of FMI in SI base units."""
    for load in LOADS:
        for unit in units_like(load.unit):
            try:
                forth, shift = fmu_conversion(load.name, unit, "x")
            except InputError:
                continue  # the other table is shorter
            factor, offset = conversion(load.unit, unit, load.name)
            for value in (1.0, 77.5):
                assert factor * (forth * value + shift) + offset == pytest.approx(value, rel=1e-9)


def many(points: int = 300) -> pd.DataFrame:
    rng = np.random.default_rng(5)
    sd = np.tile(np.linspace(0.5, 30.0, points // 3), 3)
    return pd.DataFrame(
        {
            "test_id": np.repeat(["a", "b", "c"], points // 3),
            "t": sd / 50.0,
            "v_rel": 50.0,
            "T": 80.0 + sd,
            "sigma_n": np.repeat([500.0, 1000.0, 2000.0], points // 3),
            "sd": sd,
            "psi": 1.1,
            "mu": 0.06 + rng.normal(0.0, 0.002, points),
        }
    )


def load(folder: Path, frame: pd.DataFrame) -> DataSet:
    frame.to_csv(folder / "points.csv", index=False)
    return DataSet.load(folder / "points.csv")


def test_points_that_lack_a_number_are_left_out_and_counted(tmp_path: Path) -> None:
    frame = many()
    frame.loc[[3, 150], "mu"] = np.nan
    frame.loc[200, "T"] = np.nan
    found = load(tmp_path, frame)
    whole = frame.dropna().reset_index(drop=True)
    pd.testing.assert_frame_equal(found.points, whole, check_dtype=False)
    (note,) = found.notes
    assert "points.csv: 3 of 300 points left out: not a number: T in 1, mu in 2 (first: row 3)" in note
    assert found.info["points_left_out"] == 3


def test_many_points_or_a_whole_test_without_numbers_are_refused(tmp_path: Path) -> None:
    frame = many()
    frame.loc[frame.index % 9 == 4, "mu"] = np.nan
    with pytest.raises(InputError, match=r"column 'mu', row 4: value nan; 33 of 300 points .* at most 10%"):
        load(tmp_path, frame)
    frame = pd.concat([many(), many(3).iloc[:1].assign(test_id="d", mu=np.nan)])
    with pytest.raises(InputError, match=r"row 300: value nan; 1 of 301 .*no point of test 'd' is whole"):
        load(tmp_path, frame)


def test_the_zero_of_a_force_cell_may_lie_below_zero(tmp_path: Path) -> None:
    frame = many()
    frame.loc[[7, 8], "mu"] = [-0.004, -0.011]
    found = load(tmp_path, frame)
    assert found.points["mu"].tolist() == frame["mu"].tolist()
    assert "2 of 300 values of mu are below 0, the lowest -0.011" in found.notes[0]
    frame.loc[9, "mu"] = -0.401
    with pytest.raises(InputError, match=r"column 'mu', row 9: value -0\.401 is outside .* -0\.4 to 10"):
        load(tmp_path, frame)
    for turned in (frame["mu"].abs().mul(-0.5), -0.01):
        with pytest.raises(
            InputError, match=r"300 of 300 values are below 0.*is the sign of the force wrong"
        ):
            load(tmp_path, frame.assign(mu=turned))


def test_an_empty_column_of_time_is_none_and_a_gap_in_it_is_refused(tmp_path: Path) -> None:
    assert "t" not in load(tmp_path, many().assign(t=np.nan)).points
    frame = many()
    frame.loc[5, "t"] = np.nan
    with pytest.raises(InputError, match=r"points\.csv: test 'a', column 't', row 5: value nan"):
        load(tmp_path, frame)


def test_nearly_right_names_get_the_nearest(tmp_path: Path) -> None:
    for wrong, right in (("sigma_N", "sigma_n"), ("V_rel", "v_rel"), ("testid", "test_id")):
        with pytest.raises(InputError, match=f"'{right}'.* is missing.*is it '{wrong}'"):
            load(tmp_path, many().rename(columns={right: wrong}))
    assert set(LOAD_NAMES) <= set(load(tmp_path, many()).points)


def test_whole_numbers_that_no_float_holds(tmp_path: Path) -> None:
    """pandas hands them on as Python's own, which no float takes: one sentence, from tables, YAML and JSON."""
    long = "1" + "0" * 400
    (tmp_path / "points.csv").write_text(f"test_id,v_rel,T,sigma_n,sd,psi,mu\na,1,{long},100,0,1,0.1\n")
    with pytest.raises(InputError, match=r"column 'T', row 0: value inf"):
        DataSet.load(tmp_path / "points.csv")
    (tmp_path / "map.yaml").write_text(f"moving_mass: {long}\n")
    with pytest.raises(InputError, match="a number of 401 digits"):
        read_yaml(tmp_path / "map.yaml")
    (tmp_path / "card.json").write_text(f'{{"r": {long}}}')
    assert read_json(tmp_path / "card.json") == {"r": float("inf")}


@pytest.mark.parametrize("name", ["t", "t [ms]"])
@pytest.mark.parametrize("kind", ["timedelta64[ms]", "timedelta64[ns]", "datetime64[us]", "bool"])
def test_durations_dates_and_truths_of_parquet_are_no_numbers(tmp_path: Path, name: str, kind: str) -> None:
    """100 ms were 100 s, a date the microseconds since 1970, and True a 1."""
    frame = many().head(100).rename(columns={"t": name})
    frame[name] = pd.to_timedelta(frame[name], unit="s").astype("int64").astype(kind)
    frame.to_parquet(tmp_path / "points.parquet")
    with pytest.raises(InputError, match=r"points\.parquet: column 't', row 0: value .* is not a number"):
        DataSet.load(tmp_path / "points.parquet", need_mu=False)


def test_texts_in_the_first_row_of_a_test_are_no_units(tmp_path: Path) -> None:
    file = tmp_path / "tests.csv"
    file.write_text("test_id,T_tool\na,hot\nb,20\n")
    with pytest.raises(InputError, match=r"tests\.csv: column 'T_tool', row 0: value 'hot' is not a number"):
        read_tests(file)
    file.write_text("test_id,T_tool\nunit,K\nb,300\n")
    assert read_table(file)["T_tool"].tolist() == [pytest.approx(26.85)]
    with pytest.raises(InputError, match=r"column 'v_rel', row 0: value 'v_rel' is not a number"):
        read(tmp_path, PLAIN.replace(HEADER, f"{HEADER}\n{HEADER}"))


def test_a_truth_is_no_friction(tmp_path: Path) -> None:
    for mu in (True, [True, None] * 150):
        with pytest.raises(InputError, match=r"points\.csv: column 'mu', row 0: value True is not a number"):
            load(tmp_path, many().assign(mu=mu))


def test_a_file_that_is_none_is_called_what_it_is(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.csv")
    (tmp_path / "loop.csv").symlink_to("loop.csv")
    (tmp_path / "gone.csv").symlink_to("nowhere.csv")
    (tmp_path / "folder.csv").mkdir()
    for name, words in (
        ("pipe.csv", "is a pipe or a device"),
        ("loop.csv", "is a link that leads to no file"),
        ("gone.csv", "is a link that leads to no file"),
        ("folder.csv", "is a folder"),
        ("none.csv", "no such file"),
    ):
        with pytest.raises(InputError, match=rf"{name}: {words}; allowed: a CSV or Parquet file"):
            read_table(tmp_path / name)


def test_a_table_of_other_tests_is_refused(tmp_path: Path) -> None:
    points = pd.DataFrame({"test_id": ["a", "b"], "sigma_n": [500.0, 600.0], "mu": [0.08, 0.07]})
    points.to_csv(tmp_path / "points.csv", index=False)
    table = pd.DataFrame({"test_id": ["a", "x"], "role": "test"})
    table.to_csv(tmp_path / "t.csv", index=False)
    assert DataSet.load(tmp_path / "points.csv", tmp_path / "t.csv").tests is not None
    table.assign(test_id=["x", "y"]).to_csv(tmp_path / "t.csv", index=False)
    with pytest.raises(InputError, match=r"t\.csv: test_id 'x' and all others .*points\.csv; .* as 'a'"):
        DataSet.load(tmp_path / "points.csv", tmp_path / "t.csv")
