"""Changing the test table: what was not changed stays as it stands in the file, and the table before is kept."""

from __future__ import annotations

import sys
from pathlib import Path
from threading import Thread

import pandas as pd
import pytest

from friction_models.common import InputError
from friction_models.loads import DataSet, tests_table
from friction_models.loads.tests_table import ChangedMeanwhile, TableOfTests, change_tests
from orchestrator.cli.main import run

GERMAN = "Prüfer;Meier;\ntest_id;T_tool;charge\n;K;\n007;293,15;00012\n008;473,15;\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "tests.csv").write_bytes(GERMAN.encode("cp1252"))
    return tmp_path


def test_only_the_cells_that_were_named_change(folder: Path) -> None:
    table = TableOfTests.load(folder)
    assert table.tests == ("007", "008") and table.columns == ("test_id", "T_tool", "charge")
    kept = table.changed([("008", "charge", "9"), ("*", "role", "train"), ("0*7", "role", "test")]).save()
    assert (folder / "tests.csv").read_text() == (
        "Prüfer;Meier;\ntest_id;T_tool;charge;role\n;K;;\n007;293,15;00012;test\n008;473,15;9;train\n"
    )
    assert kept is not None and kept.read_bytes() == GERMAN.encode("cp1252")
    again = TableOfTests.load(folder).changed([("007", "charge", "")]).save()
    assert again is not None and again.name == "tests-002.csv"
    assert sorted(p.name for p in (folder / "earlier").iterdir()) == ["tests-001.csv", "tests-002.csv"]


def test_what_another_command_changes_meanwhile_is_not_lost(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ours = TableOfTests.load(folder).changed([("007", "batch", "A")])
    TableOfTests.load(folder).changed([("008", "batch", "B")]).save()
    with pytest.raises(ChangedMeanwhile, match="another command changed it meanwhile"):
        ours.save()
    assert [p.name for p in (folder / "earlier").iterdir()] == ["tests-001.csv"]

    # The command reads it again: both changes stay.
    load, others = TableOfTests.load, ["C"]

    def overtaken(path: str | Path) -> TableOfTests:
        table = load(path)
        while others:
            load(path).changed([("008", "batch", others.pop())]).save()
        return table

    monkeypatch.setattr(TableOfTests, "load", overtaken)
    assert run(["tests", str(folder), "--set", "007:batch=A"]) == 0
    assert [cells["batch"] for cells in load(folder).cells()] == ["A", "C"]


@pytest.mark.skipif(sys.platform == "win32", reason="no locks of folders")
def test_nobody_writes_between_the_last_look_and_the_new_file(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    keep, others = tests_table.keep, list[Thread]()

    def overtaken(table: Path, place: Path) -> Path:
        if not others:
            others.append(Thread(target=change_tests, args=(folder, [("008", "batch", "B")])))
            others[0].start()
            others[0].join(0.5)  # time enough to write, if nothing holds it back
        return keep(table, place)

    monkeypatch.setattr(tests_table, "keep", overtaken)
    change_tests(folder, [("007", "batch", "A")])
    others[0].join()
    assert [cells["batch"] for cells in TableOfTests.load(folder).cells()] == ["A", "B"]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("9", "role", "test"), "no test '9'"),
        (("007", "test_id", "x"), "test_id stays"),
        (("007", "a b", "x"), "letters, digits"),
        (("007", "note", "a\nb"), "one line"),
        (("007", "T_tool", "hot"), "not a number"),
    ],
)
def test_a_bad_change_leaves_everything_as_it_is(
    folder: Path, change: tuple[str, str, str], said: str
) -> None:
    with pytest.raises(InputError, match=said):
        TableOfTests.load(folder).changed([change]).save()
    assert (folder / "tests.csv").read_bytes() == GERMAN.encode("cp1252")
    assert [p.name for p in folder.iterdir()] == ["tests.csv"]


def test_a_data_set_without_a_table_gets_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    points = pd.DataFrame({"test_id": ["a", "a", "b"], "sigma_n": [1.0, 2.0, 3.0], "mu": [0.1, 0.2, 0.3]})
    DataSet(points).save(tmp_path / "data")
    monkeypatch.chdir(tmp_path)
    assert run(["tests", "data", "--set", "*:role=train", "--set", "b:role=test"]) == 0
    assert "2 cells changed, new: role" in capsys.readouterr().out
    training, held_out = DataSet.load("data").frames()
    assert training["mu"].tolist() == [0.1, 0.2] and held_out["mu"].tolist() == [0.3]
    assert run(["tests", "data"]) == 0
    assert "b        test" in capsys.readouterr().out
    # A data set with its earlier tables is still one that a command may replace.
    assert run(["tests", "data", "--set", "b:role=train"]) == 0
    DataSet(points).save(tmp_path / "data")
    for arguments in (["tests", "nowhere"], ["tests", "data", "--set", "role=test"]):
        assert run(arguments) == 2
