"""Pages as HTML, PDF and workbooks."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

import pytest

from friction_models.common import InputError
from friction_models.common.markup import table
from orchestrator.report import writing
from orchestrator.report.parts.page import Page
from orchestrator.report.writing import check_page_file, write_page_file


@pytest.fixture(scope="module")
def html() -> str:
    page = Page("A page", kicker="test")
    rows = [("linear", "0.0070"), ("=HYPERLINK(1)", "\u22120.5")]
    below = "<h3>What to test next</h3>" + table(["test"], [("7",)])
    page.add("errors", "Errors: of [models]", table(["model", "RMSE"], rows), table(["b"], [("1",)]), below)
    page.add("words", "Words", "<p>none</p>")
    return page.render()


def test_tables_become_sheets_and_texts_no_formulas(html: str, tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.load_workbook(write_page_file(tmp_path / "p.xlsx", html))
    assert book.sheetnames == ["Errors  of  models", "Errors  of  models 2", "What to test next"]
    sheet = book.worksheets[0]
    assert [[c.value for c in row] for row in sheet.rows] == [
        ["model", "RMSE"],
        ["linear", 0.007],
        ["=HYPERLINK(1)", -0.5],
    ]
    assert sheet["A3"].data_type == "s" and sheet["A1"].font.bold


@pytest.mark.parametrize(
    ("suffix", "begins"),
    [
        pytest.param("pdf", b"%PDF", marks=pytest.mark.nightly),
        ("xlsx", b"PK"),
        ("html", b"<!DOCTYPE html>"),
    ],
)
def test_the_same_page_gives_the_same_bytes(html: str, tmp_path: Path, suffix: str, begins: bytes) -> None:
    if suffix == "pdf" and not any(shutil.which(name) for name in writing.BROWSERS):
        pytest.skip("no browser that prints")
    if suffix == "xlsx":
        pytest.importorskip("openpyxl")
    first = write_page_file(tmp_path / f"a.{suffix}", html).read_bytes()
    assert first.startswith(begins)
    time.sleep(
        2.1 if suffix == "xlsx" else 1.1
    )  # ZIP archives count in steps of two seconds, others in seconds
    assert write_page_file(tmp_path / f"b.{suffix}", html).read_bytes() == first


def test_what_cannot_be_written_is_told_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(InputError, match=r"suffix '\.docx'; allowed: \.html, \.htm, \.pdf, \.xlsx"):
        check_page_file(tmp_path / "p.docx")
    monkeypatch.setattr(writing.shutil, "which", lambda name: None)
    with pytest.raises(InputError, match="needs a browser"):
        check_page_file(tmp_path / "p.pdf")
    with pytest.raises(InputError, match="holds no table"):
        write_page_file(tmp_path / "p.xlsx", "<html><body><p>none</p></body></html>")
    assert not [*tmp_path.iterdir()]


def test_names_that_no_workbook_holds_stay_readable(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    rows = "".join(f"<tr><td>{name}</td></tr>" for name in ("\x1b[2Jx", "nan", "inf", "=cmd|x"))
    book = openpyxl.load_workbook(write_page_file(tmp_path / "p.xlsx", f"<html><table>{rows}</table></html>"))
    cells = [cell for (cell,) in book.worksheets[0].iter_rows()]
    assert [cell.value for cell in cells] == ["\ufffd[2Jx", "nan", "inf", "=cmd|x"]
    assert {cell.data_type for cell in cells} == {"s"}
