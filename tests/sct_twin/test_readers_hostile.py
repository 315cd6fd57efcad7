"""Damaged and hostile measurement files: one sentence each, never a traceback, never a hang."""

from __future__ import annotations

import io
import os
import pickle
import struct
import zipfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from friction_models.common import InputError
from friction_models.common.processes import timed
from sct_twin.readers import csv as csv_reader
from sct_twin.readers import guarded, read_file

from .reader_files import SUFFIX, WRITERS, write_catman, write_excel, write_plain
from .test_readers import UNITS, needs

FRAME = pd.DataFrame(
    {"t": np.arange(80) / 1000.0, "F_n": np.linspace(-1.0, 1.0, 80) ** 3, "Weg": np.linspace(0.0, 2.0, 80)}
)
KINDS = list(WRITERS)


@pytest.fixture(autouse=True, scope="module")
def end_of_reading_process() -> Iterator[None]:
    yield
    guarded.close()


def sentence(path: Path) -> str:
    """Return the one sentence that a file gets."""
    with pytest.raises(InputError) as error:
        read_file(path)
    text = str(error.value)
    assert "\n" not in text and path.name in text and len(text) < 600
    return text


@cache
def valid(kind: str) -> bytes:
    needs(kind)
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"x{SUFFIX[kind]}"
        WRITERS[kind](path, FRAME, UNITS)
        return path.read_bytes()


@st.composite
def damage(draw: st.DrawFn) -> list[tuple[str, int, bytes]]:
    kinds = st.sampled_from(["set", "flip", "cut", "insert", "double"])
    place = st.integers(0, 10**6)
    blobs = st.binary(min_size=1, max_size=8) | st.sampled_from([b"\xff" * 8, b"\0" * 8, b"\x7f\xff\xff\xff"])
    return draw(st.lists(st.tuples(kinds, place, blobs), min_size=1, max_size=4))


def spoil(content: bytes, faults: list[tuple[str, int, bytes]]) -> bytes:
    for what, place, blob in faults:
        at = place % max(1, len(content))
        if what == "set":
            content = content[:at] + blob + content[at + len(blob) :]
        elif what == "flip" and content:
            content = content[:at] + bytes([content[at] ^ 1 << blob[0] % 8]) + content[at + 1 :]
        elif what == "cut":
            content = content[:at]
        elif what == "insert":
            content = content[:at] + blob + content[at:]
        else:
            content = content[:at] + content[at // 2 :]
    return content


@pytest.mark.parametrize("kind", KINDS)
def test_fuzz_of_damaged_files(kind: str, tmp_path: Path) -> None:
    content = valid(kind)
    path = tmp_path / f"fuzz{SUFFIX[kind]}"

    @settings(max_examples=40, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(damage())
    def one(faults: list[tuple[str, int, bytes]]) -> None:
        path.write_bytes(spoil(content, faults))
        try:
            table = read_file(path)
        except InputError as error:
            assert "\n" not in str(error) and path.name in str(error)
        else:
            # Damage inside the numbers cannot be seen by a reader; the record checks them.
            assert set(table.units) == set(table.frame.columns)

    one()


@pytest.mark.parametrize("kind", KINDS)
def test_cut_anywhere(kind: str, tmp_path: Path) -> None:
    content = valid(kind)
    for share in (0.02, 0.3, 0.7):
        path = tmp_path / f"cut{SUFFIX[kind]}"
        path.write_bytes(content[: int(share * len(content))])
        try:
            table = read_file(path)
        except InputError as error:
            assert path.name in str(error)
        else:
            # Text and streamed formats keep what was written; never more than that.
            assert kind in {"comma", "semicolon", "tab", "catman ASCII", "TDMS", "MDF"}
            assert len(table.frame) < len(FRAME)


@pytest.mark.parametrize("suffix", sorted(set(SUFFIX.values())))
def test_a_pickle_posing_as_data(tmp_path: Path, suffix: str) -> None:
    class Trap:
        def __reduce__(self) -> tuple[object, ...]:
            return (Path.touch, (tmp_path / "sprung",))

    path = tmp_path / f"p{suffix}"
    path.write_bytes(pickle.dumps(Trap()))
    assert "pickle" in sentence(path)
    assert not (tmp_path / "sprung").exists()


@pytest.mark.parametrize("suffix", sorted(set(SUFFIX.values())))
def test_a_zip_bomb_posing_as_data(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"bomb{suffix}"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as package:
        package.writestr("xl/worksheets/sheet1.xml", b"0" * 60_000_000)
    text = sentence(path)
    assert "zip bomb" in text if suffix == ".xlsx" else "allowed: " in text


def test_entities_in_a_workbook(tmp_path: Path) -> None:
    pytest.importorskip("openpyxl", reason="openpyxl is not installed (extra [daq])")
    source, path = tmp_path / "good.xlsx", tmp_path / "entities.xlsx"
    write_excel(source, FRAME, UNITS)
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name.endswith("sheet1.xml"):
                text = content.decode().split("?>", 1)[-1]
                content = (
                    '<?xml version="1.0" encoding="utf-16"?><!DOCTYPE x [<!ENTITY a "b">]>' + text
                ).encode("utf-16")
            new.writestr(name, content)
    assert "declares a document type or entities" in sentence(path)


def test_parts_of_a_workbook_that_lie_about_their_size(tmp_path: Path) -> None:
    path = tmp_path / "liar.xlsx"
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as package:
        package.writestr("xl/workbook.xml", b" " * 50_000_000)
    content = buffer.getvalue().replace(struct.pack("<I", 50_000_000), struct.pack("<I", 100))
    path.write_bytes(content)
    assert "not a readable workbook" in sentence(path)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.csv", b"", "the file is empty"),
        ("a.bin", b"\x94\x13" + bytes(4), "truncated"),
        ("a.bin", b"\x8c\x13" + bytes(40), "version 5004; allowed: 5010"),
        (
            "a.mat",
            b"MATLAB 7.3 MAT-file" + bytes(105) + b"\x00\x02IM" + b"\x89HDF\r\n\x1a\n",
            "save with -v7",
        ),
        ("a.mat", b"\x89HDF\r\n\x1a\n" + bytes(600), "save with -v7"),
        ("a.mf4", b"UnFinMF 4.10    " + bytes(600), "never finalised"),
        ("a.xls", b"\xd0\xcf\x11\xe0" + bytes(600), "suffix '.xls' has no reader"),
        ("a.h5", b"\x89HDF\r\n\x1a\n", "suffix '.h5' has no reader"),
        ("a.xlsx", b"PK\x03\x04" + bytes(600), "not a readable workbook"),
        ("a.tdms", b"a,b\n1,2\n", "not that of a TDMS file"),
        ("a.parquet", b"PAR1" + bytes(600) + b"PAR1", "not a readable Parquet file"),
        ("a.csv", bytes(range(256)) * 4, "binary content"),
        ("a.csv", b"  t  F\n" + b"  0,02  -1,5\n" * 9, "blanks between numbers with decimal commas"),
        ("a.csv", b"t,\x8e\x9e\x8d\n" + b"1,2\n" * 9, "byte 0x8d is none of the encoding cp1252"),
    ],
)
def test_one_sentence(tmp_path: Path, name: str, content: bytes, message: str) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    if name.endswith(".mf4"):
        needs("MDF")
    assert message in sentence(path)


def test_counts_that_a_catman_file_cannot_hold(tmp_path: Path) -> None:
    path = tmp_path / "many.bin"
    write_catman(path, FRAME, UNITS)
    content = path.read_bytes()
    mark = struct.pack("<hi", 1, len(FRAME))
    assert content.count(mark) == 1
    path.write_bytes(content.replace(mark, struct.pack("<hi", 1, 19_000_000)))
    assert "needs 152000000 bytes" in sentence(path)
    path.write_bytes(content.replace(mark, struct.pack("<hi", 1, -5)))
    assert "-5 rows" in sentence(path)


def test_a_reader_that_hangs_or_dies_is_ended(tmp_path: Path) -> None:
    path = tmp_path / "x.parquet"
    path.write_bytes(valid("Parquet"))
    endless = tmp_path / "endless.parquet"
    os.mkfifo(endless)  # nobody writes into it
    with pytest.raises(InputError, match=r"endless\.parquet: reading it as Parquet takes longer than 1 s"):
        guarded.read_guarded(endless, "Parquet", patience=1.0)
    assert len(read_file(path).frame) == len(FRAME)
    process = guarded._reader
    assert process is not None
    process.process.kill()
    process.process.wait()
    assert len(read_file(path).frame) == len(FRAME)


@pytest.mark.nightly
def test_the_time_to_load_a_library_is_not_that_of_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "x.parquet"
    path.write_bytes(valid("Parquet"))
    late = tmp_path / "late"
    late.mkdir()
    # Every process that starts with this path is late.
    (late / "sitecustomize.py").write_text("import time; time.sleep(3.5)\n", encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(late))
    guarded.close()
    assert len(guarded.read_guarded(path, "Parquet", patience=3.0).frame) == len(FRAME)
    guarded.close()
    monkeypatch.setattr(timed, "START_LIMIT", 0.5)
    with pytest.raises(
        InputError, match=r"x\.parquet: the process that is to read it as Parquet is not ready"
    ):
        guarded.read_guarded(path, "Parquet")
    monkeypatch.undo()
    assert len(read_file(path).frame) == len(FRAME)


def test_an_interrupt_while_reading_is_no_bad_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "x.csv"
    write_plain(path, FRAME, UNITS)

    class Interrupted(io.FileIO):
        def readinto(self, buffer: object, /) -> int:
            raise KeyboardInterrupt

        def read(self, size: int | None = -1, /) -> bytes:
            raise KeyboardInterrupt

    monkeypatch.setattr(csv_reader.io, "FileIO", Interrupted)
    with pytest.raises(KeyboardInterrupt):
        csv_reader.read_csv(path)


def test_bytes_behind_the_beginning_that_are_no_text(tmp_path: Path) -> None:
    path = tmp_path / "late.csv"
    write_plain(path, pd.concat([FRAME] * 200), UNITS)
    content = path.read_bytes()
    path.write_bytes(content + b"0.1,\xff\xfe,0.2\n")
    assert "late.csv: byte 0xff is none of the encoding utf-8" in sentence(path)


def test_other_encodings_and_delimiters(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    write_plain(path, FRAME, UNITS, ";", ",")
    text = path.read_text().replace("Weg", "Größe")
    for encoding in ("cp1252", "utf-8", "utf-8-sig"):
        path.write_text(text, encoding=encoding)
        assert list(read_file(path).frame.columns) == ["t", "F_n", "Größe"]
    path.write_text(text.replace(";", "|"))
    assert "names one column only" in sentence(path)
    path.write_text(text.replace(";", " "))
    assert "names one column only" in sentence(path)
