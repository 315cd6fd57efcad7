"""Text files as real rigs and spreadsheet programs write them: what is read is what was written."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from friction_models.common import InputError
from sct_twin.readers import RawTable, read_file

ROWS = 120


def numbers() -> list[tuple[float, float, float, float]]:
    """Time, normal force, friction force, position: whole thousandths, so that every spelling is exact."""
    return [(k / 1000, k * k / 8 - 25.5, k / 4 - 3, 7 + k * k / 1000) for k in range(ROWS)]


def german(value: float, digits: int = 3) -> str:
    return f"{value:.{digits}f}".replace(".", ",")


def german_grouped(value: float) -> str:
    return f"{value:,.3f}".replace(",", "x").replace(".", ",").replace("x", ".")


def lines(write: Callable[[float], str] = german, delimiter: str = ";", tail: str = "") -> list[str]:
    return [delimiter.join(map(write, row)) + tail for row in numbers()]


def english(value: float) -> str:
    return f"{value:.3f}"


HEAD = ["Zeit;Normalkraft;Reibkraft;Weg", "s;N;N;mm"]
NAMES = ("Zeit", "Normalkraft", "Reibkraft", "Weg")
PADDED = ["Messprotokoll;;;", "Prüfer;Meier;;", "Datum;01.02.2026;;", "Durchmesser;15,00;mm;", ";;;"]

#: Dialect: text, encoding, names (None where they are NAMES).
DIALECTS: dict[str, tuple[list[str], str, tuple[str, ...]]] = {
    "padded preamble": ([*PADDED, *HEAD, *lines()], "utf-8", NAMES),
    "padded preamble, cp1252 and Windows line ends": (
        [*PADDED, "Zeit;Normalkraft;Reibkraft;Größe µ", "s;N;N;mm", *lines()],
        "cp1252",
        ("Zeit", "Normalkraft", "Reibkraft", "Größe µ"),
    ),
    "padded preamble with a byte order mark": ([*PADDED, *HEAD, *lines()], "utf-8-sig", NAMES),
    "padded preamble in UTF-16": ([*PADDED, *HEAD, *lines()], "utf-16", NAMES),
    "padded preamble in UTF-32": ([*PADDED, *HEAD, *lines()], "utf-32", NAMES),
    "key and value above a wider table": (
        [
            "Rig\tT3",
            "Mass\t25",
            "",
            "Zeit\tNormalkraft\tReibkraft\tWeg",
            "s\tN\tN\tmm",
            *lines(english, "\t"),
        ],
        "utf-8",
        NAMES,
    ),
    "key and value without a blank line": (
        ["Rig\tT3", "Mass\t25", "Zeit\tNormalkraft\tReibkraft\tWeg", "s\tN\tN\tmm", *lines(english, "\t")],
        "utf-8",
        NAMES,
    ),
    "one line of key and value": (
        ["Rig\tT3", "Zeit [s]\tNormalkraft [N]\tReibkraft [N]\tWeg [mm]", *lines(english, "\t")],
        "utf-8",
        NAMES,
    ),
    "two header rows, a title above": (
        ["Test 17", "Zeit,Normalkraft,Reibkraft,Weg", "[s],[N],[N],[mm]", *lines(english, ",")],
        "utf-8",
        NAMES,
    ),
    "groups above names with units": (
        [
            "Time,Force,Force,Motion",
            "Zeit [s],Normalkraft [N],Reibkraft [N],Weg [mm]",
            *lines(english, ","),
        ],
        "utf-8",
        NAMES,
    ),
    "groups, names, units": (
        ["Logger,Force,Force,Motion", "Zeit,Normalkraft,Reibkraft,Weg", "s,N,N,mm", *lines(english, ",")],
        "utf-8",
        NAMES,
    ),
    "blank columns behind": ([f"{h};;" for h in HEAD] + lines(tail=";;"), "utf-8", NAMES),
    "separator behind the numbers only": ([*HEAD, *lines(tail=";")], "utf-8", NAMES),
    "a blank column between": (
        ["Zeit;Normalkraft;;Reibkraft;Weg", "s;N;;N;mm"]
        + [";".join((german(a), german(b), "", german(c), german(d))) for a, b, c, d in numbers()],
        "utf-8",
        NAMES,
    ),
    "a column without a name": (
        ["Zeit;Normalkraft;;Weg", "s;N;N;mm", *lines()],
        "utf-8",
        ("Zeit", "Normalkraft", "column 3", "Weg"),
    ),
    "quoted cells": (
        ['"Zeit";"Normalkraft";"Reibkraft";"Weg; Platte"', '"s";"N";"N";"mm"']
        + [";".join(f'"{german(v)}"' for v in row) for row in numbers()],
        "utf-8",
        ("Zeit", "Normalkraft", "Reibkraft", "Weg; Platte"),
    ),
    "decimal comma in quotes between commas": (
        ["Zeit,Normalkraft,Reibkraft,Weg", "s,N,N,mm"]
        + [",".join(f'"{german(v)}"' for v in row) for row in numbers()],
        "utf-8",
        NAMES,
    ),
    "thousands with points": ([*HEAD, *lines(german_grouped)], "utf-8", NAMES),
    "thousands with commas": ([*HEAD, *lines(lambda v: f"{v:,.3f}")], "utf-8", NAMES),
    "thousands with fixed blanks": (
        [*HEAD, *lines(lambda v: f"{v:,.3f}".replace(",", "\u00a0").replace(".", ","))],
        "utf-8",
        NAMES,
    ),
    "a line behind the numbers": ([*HEAD, *lines(), "Ende der Messung"], "utf-8", NAMES),
    "lines of key and value behind the numbers": (
        [*HEAD, *lines(), ";;;", "Max. Kraft;1744,6;N;", "Dauer;0,119;s;", "Ende der Messung;;;"],
        "utf-8",
        NAMES,
    ),
    "a blank line below the names": ([HEAD[0], HEAD[1], "", *lines()], "utf-8", NAMES),
    "a column of clock times": (
        ["Uhrzeit;Zeit;Normalkraft;Reibkraft;Weg", ";s;N;N;mm"]
        + [f"12:00:{k % 60:02d};{line}" for k, line in enumerate(lines())],
        "utf-8",
        ("Uhrzeit", *NAMES),
    ),
}


def written(folder: Path, text: list[str], encoding: str = "utf-8", end: str = "\n") -> Path:
    path = folder / "SCT 017.csv"
    path.write_bytes((end.join(text) + end).encode(encoding))
    return path


def check(table: RawTable, names: tuple[str, ...] = NAMES) -> None:
    assert tuple(table.frame.columns) == names
    *_, time, normal, friction, place = names
    for name, unit, k in ((time, "s", 0), (normal, "N", 1), (friction, "N", 2), (place, "mm", 3)):
        assert table.units[name] == unit
        assert table.frame[name].tolist() == pytest.approx([round(row[k], 3) for row in numbers()], abs=5e-4)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("dialect", DIALECTS)
def test_what_a_rig_writes_is_what_is_read(tmp_path: Path, dialect: str, end: str) -> None:
    text, encoding, names = DIALECTS[dialect]
    check(read_file(written(tmp_path, text, encoding, end)), names)


@pytest.mark.parametrize(
    ("dialect", "note"),
    [
        ("padded preamble", "7 lines before the numbers: names in line 6"),
        ("a column without a name", "columns without a name: called 'column 3'"),
        ("thousands with points", "column 'Normalkraft': '.' taken as separator of thousands"),
        ("a line behind the numbers", "1 line behind the numbers passed over: 'Ende der Messung'"),
        (
            "lines of key and value behind the numbers",
            "4 lines behind the numbers passed over: 'Max. Kraft 1744,6 N'",
        ),
    ],
)
def test_what_was_done_is_said(tmp_path: Path, dialect: str, note: str) -> None:
    text, encoding, _ = DIALECTS[dialect]
    assert note in read_file(written(tmp_path, text, encoding)).notes


def test_names_that_stand_twice_are_told_apart(tmp_path: Path) -> None:
    path = written(tmp_path, ["Zeit;Kraft;Kraft;Weg", "s;N;N;mm", *lines()])
    table = read_file(path)
    check(table, ("Zeit", "Kraft (1)", "Kraft (2)", "Weg"))
    assert "column 'Kraft' stands 2 times: called 'Kraft (1)', 'Kraft (2)'" in table.notes


def test_numbers_without_names_are_called_by_their_places(tmp_path: Path) -> None:
    table = read_file(written(tmp_path, lines()))
    assert list(table.frame.columns) == ["column 1", "column 2", "column 3", "column 4"]
    assert len(table.frame) == ROWS
    assert "no row of names above the numbers: columns are called by their places" in table.notes


SECOND = "a second table of numbers begins in line 128, the first stands in"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ([*HEAD, *lines(), "", "Block 2", "", *HEAD, *lines()], SECOND),
        ([*HEAD, *lines(), "", "Block 2;;;", *HEAD, "", *(lines() * 40)], SECOND),
        # Only the parser sees the second one: the beginning of the file holds the first alone.
        ([*HEAD, *(lines() * 100), "Block 2", *lines()], "begins in line 12004, the first stands in"),
        ([*HEAD, *lines(), *lines(tail=";1;2")], "line 123: 6 cells, the table has 4"),
        ([*HEAD, *(lines() * 100), *lines(tail=";1;2")], "line 12003: 6 cells, the table has 4"),
        (["F_n;F_r;Weg", *lines()], "line 1: the row of names has 3 cells, the rows of numbers have 4"),
        (["F;G;s;T", *lines(lambda v: "0.5" if v < 0 else german(v))], "'0.5' and '0,000' do not say"),
        (HEAD, "no rows behind the header"),
        (["test,v,mu,oil", *(f"t{k},{k},0.1,x" for k in range(9))], "no row holds more numbers than text"),
        (["", ""], "the file is blank"),
    ],
)
def test_what_is_not_one_table_is_refused(tmp_path: Path, text: list[str], message: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(InputError) as error:
        read_file(path)
    said = str(error.value)
    assert message in said and str(path) in said and "allowed: " in said and "\n" not in said


def workbook(path: Path, rows: list[list[Any]]) -> Path:
    openpyxl = pytest.importorskip("openpyxl", reason="openpyxl is not installed (extra [daq])")
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append(row)
    book.save(path)
    return path


def test_a_sheet_with_lines_above_and_behind(tmp_path: Path) -> None:
    data = [
        [round(v, 3) for v in (row[0], row[1])] + [None] + [round(v, 3) for v in row[2:]] for row in numbers()
    ]
    above = [
        ["Messprotokoll"],
        ["Durchmesser", 15.0, "mm"],
        [],
        ["Zeit", "Normalkraft", None, "Reibkraft", "Weg"],
    ]
    sheet = [*above, ["s", "N", None, "N", "mm"], *data, [], ["Ende der Messung"]]
    table = read_file(workbook(tmp_path / "a.xlsx", sheet))
    check(table)
    assert "1 row behind the numbers passed over: 'Ende der Messung'" in table.notes
    with pytest.raises(
        InputError, match=r"row 128: a second table of numbers begins behind 'Ende der Messung'"
    ):
        read_file(workbook(tmp_path / "b.xlsx", [*sheet, *data]))
    twice: list[list[Any]] = [
        ["Zeit", "Kraft", "Kraft"],
        ["s", "N", "N"],
        *([k, 2 * k, 3 * k] for k in range(20)),
    ]
    assert list(read_file(workbook(tmp_path / "c.xlsx", twice)).frame) == ["Zeit", "Kraft (1)", "Kraft (2)"]


@pytest.mark.parametrize("tail", ["", ";ok", ";"])
def test_two_columns_with_decimal_commas(tmp_path: Path, tail: str) -> None:
    """Split at the commas, such rows would hold numbers, too: "0,5;1,5" is 0, "5;1", 5."""
    rows = [";".join(map(german, row[:2])) + tail for row in numbers()]
    (tmp_path / "two.csv").write_text("\n".join(["Zeit;Normalkraft", "s;kN", *rows]) + "\n", encoding="utf-8")
    found = read_file(tmp_path / "two.csv")
    assert tuple(found.frame.columns)[:2] == ("Zeit", "Normalkraft") and found.units["Normalkraft"] == "kN"
    assert [tuple(row) for row in found.frame[["Zeit", "Normalkraft"]].to_numpy(float)] == [
        row[:2] for row in numbers()
    ]
