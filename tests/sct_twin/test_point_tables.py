"""Point tables of other laboratories: columns, units, limits, what file names say, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_models.common import InputError
from friction_models.loads import DataSet
from orchestrator.cli.main import run
from sct_twin.ingest.point_guess import guess_point_columns
from sct_twin.ingest.point_map import FileNameParts, PointMap
from sct_twin.ingest.point_tables import read_point_tables
from sct_twin.readers import read_file

MU = {"COF": "mu", "p": {"quantity": "sigma_n", "unit": "MPa"}}


def german(folder: Path, name: str, kelvin: float, sign: str = "") -> Path:
    """A table as a German spreadsheet writes it: semicolon, decimal comma, a row of units, K and m/s."""
    rows = "".join(f"{0.1 * k:.1f};{0.2 + 0.01 * k:.3f};{kelvin:.2f};{sign}0,08{k}\n" for k in range(5))
    file = folder / name
    text = "Zeit;Geschwindigkeit;Temperatur;Reibwert\ns;m/s;K;-\n" + rows.replace(".", ",")
    file.write_bytes(text.encode("cp1252"))
    return file


def test_units_commas_and_names_of_files(tmp_path: Path) -> None:
    for k, kelvin in enumerate((293.15, 473.15)):
        german(tmp_path, f"MoS2_{100 + 100 * k}C_t{k}.csv", kelvin, "-")
    content: dict[str, object] = {
        "columns": {
            "Zeit": "t",
            "Geschwindigkeit": "v_rel",
            "Temperatur": "T",
            "Reibwert": {"quantity": "mu", "sign": -1},
        },
        "file_name": "{lubricant}_{T_tool}C_{test_id}",
        "metadata": {"lab": "north"},
    }
    found = read_point_tables(tmp_path, content).dataset
    # 0.2 m/s is 200 mm/s, 473.15 K is 200 degC: by hand.
    assert found.points["v_rel"].tolist() == pytest.approx([200, 210, 220, 230, 240] * 2)
    assert found.points["T"].tolist() == pytest.approx([20.0] * 5 + [200.0] * 5)
    assert found.points["mu"].tolist() == pytest.approx([0.080, 0.081, 0.082, 0.083, 0.084] * 2)
    assert found.tests is not None
    assert found.tests.to_dict("records") == [
        {"test_id": "t0", "lab": "north", "lubricant": "MoS2", "T_tool": 100.0},
        {"test_id": "t1", "lab": "north", "lubricant": "MoS2", "T_tool": 200.0},
    ]


def test_many_tests_in_one_file_with_limits_and_a_column_for_the_test_table(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    frame = pd.DataFrame({"run": np.repeat([7, 8, 9], 20), "p": np.tile(np.arange(20.0), 3), "oil": "x"})
    frame["COF"] = rng.uniform(0.05, 0.1, 60)
    frame.loc[frame["run"] == 9, "p"] = 0.5
    file = tmp_path / "all.csv"
    frame.to_csv(file, index=False)
    columns = {**MU, "run": "test_id", "oil": {"test_table": "lubricant"}}
    found = read_point_tables(file, {"columns": columns, "only": {"p": {"min": 4, "max": 10}}})
    assert found.dataset.points["test_id"].unique().tolist() == ["7", "8"]
    assert len(found.dataset.points) == 14
    assert found.dataset.points["mu"].to_numpy() == pytest.approx(
        frame["COF"][frame["p"].between(4, 10)].to_numpy()
    )
    assert found.dataset.tests is not None and found.dataset.tests["lubricant"].tolist() == ["x", "x"]
    assert any("46 of 60 rows" in note for note in found.notes)
    assert any("1 test without a row" in note for note in found.notes)


def test_the_draft_knows_usual_names_and_what_reads_with_it_is_what_stands_there(tmp_path: Path) -> None:
    file = tmp_path / "table.csv"
    file.write_text(
        "test,v_mm_s,load_N,sigma_n_MPa,Kontakttemperatur [K],COF,oil\n"
        + "".join(f"a{k},1.5,3,0.02,300,0.0{k},x\n" for k in range(1, 9))
    )
    columns = guess_point_columns(read_file(file))
    assert columns == {
        "test": {"quantity": "test_id"},
        "v_mm_s": {"quantity": "v_rel", "unit": "mm/s"},
        "sigma_n_MPa": {"quantity": "sigma_n", "unit": "MPa"},
        "Kontakttemperatur": {"quantity": "T"},
        "COF": {"quantity": "mu"},
        "oil": {"test_table": "oil"},
    }
    points = read_point_tables(file, {"columns": columns}).dataset.points
    assert points["T"].iloc[0] == pytest.approx(26.85) and points["mu"].iloc[-1] == 0.08


def test_the_draft_puts_what_stays_the_same_in_each_test_into_the_test_table(tmp_path: Path) -> None:
    rows = [
        f"P{k};{v};0,0{k};{('0,2', '0,8')[k % 2]};{t};{t % 2}"
        for k in range(1, 5)
        for t, v in enumerate((5, 6, 7))
    ]
    file = tmp_path / "lab.csv"
    file.write_text("Probe;Druck;Reibwert;Rauheit Ra;Zeile;Kanal\n" + "\n".join(rows), encoding="utf-8")
    columns = guess_point_columns(read_file(file))
    assert list(columns) == ["Probe", "Druck", "Reibwert", "Rauheit Ra"]  # not what changes within a test
    assert columns["Rauheit Ra"] == {"test_table": "Rauheit_Ra"}
    tests = read_point_tables(file, {"columns": columns}).dataset.tests
    assert tests is not None and tests["Rauheit_Ra"].tolist() == [0.8, 0.2, 0.8, 0.2]


def test_short_german_headings_are_known(tmp_path: Path) -> None:
    file = tmp_path / "table.csv"
    file.write_text("Gleitgeschw. [mm/s];A/A0;Reibzahl;dA/dA0\n1,5;1,2;0,08;1,2\n1,6;1,3;0,07;1,3\n")
    # The second of two headings for one load is left to the user.
    assert guess_point_columns(read_file(file)) == {
        "Gleitgeschw.": {"quantity": "v_rel"},
        "A/A0": {"quantity": "psi"},
        "Reibzahl": {"quantity": "mu"},
    }


def test_the_test_table_beside_the_files_is_used(tmp_path: Path) -> None:
    for k in range(3):
        german(tmp_path, f"t{k}.csv", 300.0)
    (tmp_path / "tests.csv").write_text("test_id;batch;lab\nt0;A;south\nt1;B;south\nt9;A;south\n")
    columns = {"Zeit": "t", "Geschwindigkeit": "v_rel", "Temperatur": "T", "Reibwert": "mu"}
    content: dict[str, Any] = {"columns": columns, "metadata": {"lab": "north"}}
    for source in (tmp_path, sorted(tmp_path.glob("t?.csv"))):
        found = read_point_tables(source, content)
        assert found.dataset.tests is not None
        # What the map says counts before what the table says.
        assert found.dataset.tests.fillna("").to_dict("list") == {
            "test_id": ["t0", "t1", "t2"],
            "lab": ["north"] * 3,
            "batch": ["A", "B", ""],
        }
        assert [note for note in found.notes if "tests.csv" in note] == [
            "batch: taken from tests.csv",
            "1 test not in tests.csv: t2",
            "1 test without points in tests.csv: t9",
        ]
    (tmp_path / "tests.csv").write_text("test_id,role\nx,train\n")
    assert "tests.csv names none of the tests and is not used" in read_point_tables(tmp_path, content).notes
    (tmp_path / "tests.csv").write_text("test_id,synthetic\nt0,True\n")
    assert read_point_tables(tmp_path, content).dataset.info["synthetic"]
    (tmp_path / "tests.tsv").write_text("test_id\tsynthetic\nt0\tTrue\n")
    with pytest.raises(InputError, match="one test table"):
        read_point_tables(tmp_path, content)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ({"columns": {"p": "sigma_n"}}, "no column is mu"),
        ({"columns": {"a": "mu", "b": "mu"}}, "'mu' is mapped 2 times"),
        ({"columns": {"a": "mu", "b": {"quantity": "v_rel", "unit": "K"}}}, "allowed"),
        ({"columns": {"a": {"quantity": "mu", "test_table": "b"}}}, "either quantity or test_table"),
        ({"columns": {"a": "mu", "b": {"test_table": "../x"}}}, "letters, digits and underscores"),
        ({"columns": {"a": "mu"}, "only": {"b": {"min": 2, "max": 1}}}, "min 2 above max 1"),
        ({"columns": {"a": "mu"}, "only": {"b": {"least": 2}}}, "unknown key 'least'"),
        ({"columns": {"a": "mu"}, "file_name": "{a}{b}"}, "file_name is"),
        ({"columns": {"a": "mu"}, "file_name": "test"}, "file_name is"),
        ({"columns": {"a": "mu"}, "metadata": {"a": [1]}}, "metadata is"),
        ({"kolumns": {}}, "did you mean 'columns'?"),
        ([], "holds a list"),
    ],
)
def test_a_bad_map_is_refused_in_a_sentence(content: Any, said: str, tmp_path: Path) -> None:
    import yaml

    file = tmp_path / "points.yaml"
    file.write_text(yaml.safe_dump(content))
    with pytest.raises(InputError, match=said.replace("?", r"\?")):
        PointMap.load(file)


def test_a_name_is_cut_where_the_texts_between_its_parts_stand() -> None:
    parts = FileNameParts.load("{oil}_{T}C-{test_id}_raw", "map")
    assert parts is not None
    assert parts.of("SAE_30_2,5C-7_raw") == {"oil": "SAE", "T": "30_2,5", "test_id": "7"}
    # One pass over the name: a template of many parts cannot make it slow.
    many = FileNameParts.load("a".join(f"{{p{k}}}" for k in range(12)) + "-end", "map")
    assert many is not None
    with pytest.raises(InputError, match="does not fit"):
        many.of("a" * 250 + "b" * 5 + "/")
    with pytest.raises(InputError, match="does not fit"):
        parts.of("SAE_30C_7_raw")


def test_files_that_do_not_fit_together_are_refused(tmp_path: Path) -> None:
    for name in ("one.csv", "two.csv"):
        (tmp_path / name).write_text("run,p,COF\n" + "".join(f"7,{k},0.08\n" for k in range(9)))
    columns = {**MU, "run": "test_id"}
    with pytest.raises(InputError, match=r"two\.csv: test '7' stands in one\.csv, too"):
        read_point_tables(tmp_path, {"columns": columns})
    with pytest.raises(InputError, match="'pp'"):
        read_point_tables(tmp_path, {"columns": {**columns, "pp": "sd"}})
    (tmp_path / "two.csv").write_text("run,p,COF\n" + "".join(f"8,{k},0.08\n" for k in range(9)))
    with pytest.raises(InputError, match="9 values in test '7'"):
        read_point_tables(tmp_path, {"columns": {"run": "test_id", "COF": "mu", "p": {"test_table": "load"}}})


def test_the_command_drafts_a_map_and_writes_a_data_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    file = german(tmp_path, "t1.csv", 300.0)
    assert run(["points", file.name, "--dry-run"]) == 0
    said = capsys.readouterr().out
    Path("points.yaml").write_text(said[said.index("columns:") :])
    assert run(["points", file.name, "--map", "points.yaml", "-o", "data"]) == 0
    said = capsys.readouterr().out
    assert "1 test, 5 points; not measured: sigma_n, sd, psi" in said
    assert "in it: v_rel 200 to " in said and " mm/s, T " in said and "psi" not in said.partition("in it:")[2]
    data = DataSet.load("data")
    assert data.points["v_rel"].iloc[0] == pytest.approx(200.0) and not data.synthetic
    assert run(["points", file.name]) == 2 and "-o is missing" in capsys.readouterr().err


def test_a_table_read_again_keeps_what_was_said_of_its_tests(tmp_path: Path) -> None:
    table, data = tmp_path / "oil.csv", tmp_path / "data"
    table.write_text("test_id,sigma_n,mu\na,500,0.1\nb,600,0.11\n")
    assert run(["points", str(table), "-o", str(data)]) == 0
    assert run(["tests", str(data), "--set", "b:role=test"]) == 0
    said = (data / "tests.csv").read_text()
    table.write_text("test_id,sigma_n,mu\na,500,0.1\nb,650,0.11\nc,700,0.12\n")
    assert run(["points", str(table), "-o", str(data)]) == 0
    again = pd.read_csv(data / "tests.csv", index_col="test_id")
    assert again["role"].fillna("").to_dict() == {"a": "", "b": "test", "c": ""}
    assert {p.name for p in (data / "earlier").iterdir()} == {"tests-001.csv", "tests-002.csv"}
    assert (data / "earlier" / "tests-002.csv").read_text() == said


@pytest.mark.parametrize("given", ["folder", "one file", "both files", "one file of a folder raw"])
def test_a_table_of_tests_beside_the_points_says_what_is_known_of_them(given: str, tmp_path: Path) -> None:
    folder = tmp_path / "raw" if "raw" in given else tmp_path
    folder.mkdir(exist_ok=True)
    points, beside = folder / "points.csv", folder / "tests.csv"
    points.write_text("test_id,v_rel,mu\na,1,0.1\na,2,0.1\nb,1,0.2\nd,1,0.3\n")
    beside.write_text("test_id,batch,oil\nb,old,y\na,new,y\nc,old,y\n")
    source = {"folder": tmp_path, "both files": [points, beside]}.get(given, points)
    found = read_point_tables(source, {"metadata": {"oil": "x"}})
    assert found.dataset.tests is not None
    # What the map says of the tests counts.
    assert found.dataset.tests.fillna("").to_dict("records") == [
        {"test_id": "a", "oil": "x", "batch": "new"},
        {"test_id": "b", "oil": "x", "batch": "old"},
        {"test_id": "d", "oil": "x", "batch": ""},
    ]
    assert found.notes == [
        "batch: taken from tests.csv",
        "1 test not in tests.csv: d",
        "1 test without points in tests.csv: c",
    ]


def test_a_table_of_points_may_be_called_as_one_of_tests(tmp_path: Path) -> None:
    file = tmp_path / "tests.csv"
    file.write_text("test_id,v_rel,mu\na,1,0.1\na,2,0.1\n")
    for source in (file, [file]):
        assert len(read_point_tables(source).dataset.points) == 2


def test_a_role_that_is_none_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "tests.csv").write_text("test_id\na\n")
    assert run(["tests", str(tmp_path / "tests.csv"), "--set", "a:role=tset"]) == 2
    assert "unknown role 'tset'; allowed: test, train; did you mean 'test'?" in capsys.readouterr().err
    assert "role" not in (tmp_path / "tests.csv").read_text()


@pytest.mark.parametrize("heading", ["sigma_n,T,T", "sigma_n,T [K],T [degC]"])
def test_a_quantity_that_stands_twice_is_refused(heading: str, tmp_path: Path) -> None:
    file = tmp_path / "twice.csv"
    file.write_text(f"test_id,{heading},mu\na,500,300,27,0.1\nb,600,310,37,0.1\n")
    with pytest.raises(InputError, match=r"column 'T' stands 2 times; allowed: once, or a point map"):
        read_point_tables(file)


def test_groups_of_thousands_are_said(tmp_path: Path) -> None:
    file = tmp_path / "grouped.csv"
    file.write_text("test_id;sigma_n;sd;mu\na;500,5;1.500;0,1\na;500,5;2.500;0,1\n")
    found = read_point_tables(file)
    assert found.dataset.points["sd"].tolist() == [1500.0, 2500.0]
    assert any("column 'sd': '.' taken as separator of thousands" in n for n in found.notes)


def test_metadata_without_control_characters(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"metadata 'lubricant'.*without control characters"):
        PointMap.load({"columns": {"f": "mu"}, "metadata": {"lubricant": "oil\x00"}})
