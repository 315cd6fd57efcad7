"""A page as the file that its name asks for: HTML, PDF through a browser, or its tables as a workbook."""

from __future__ import annotations

import importlib.util
import io
import math
import os
import re
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from friction_models.common import InputError, atomic_path, write_text
from friction_models.common.imports.extras import need

#: Browsers that print a page without a window, in the order in which they are looked for.
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome", "microsoft-edge", "msedge")
#: Longest time to print a page [s].
PATIENCE = 120.0
#: When a file was made, as browsers and openpyxl write it.
_PDF_DATES = re.compile(rb"/(?:Creation|Mod)Date \(D:[^()]*\)")
#: How a browser numbers what stands on a page: from where it happens to be with counting.
_PDF_NODES = re.compile(rb"\(node(\d{8})\)")
_BOOK_DATES = re.compile(rb"<dcterms:(created|modified)\b.*?</dcterms:\1>")
_CONTROLS = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f]")
#: Longest name of a sheet, and what none may hold.
SHEET, NOT_IN_SHEETS = 31, re.compile(r"[\[\]:*?/\\]")


def check_page_file(path: Path) -> Path:
    """Return the path of a page that can be written here.

    Raises InputError: another suffix, or what writes it is not installed.

    Examples
    --------
    >>> check_page_file(Path("diagnosis.html")).name
    'diagnosis.html'
    >>> check_page_file(Path("diagnosis.doc"))
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: diagnosis.doc: suffix '.doc'; allowed: .html, .htm, .pdf, .xlsx
    """
    suffix = path.suffix.lower()
    if suffix not in _WRITERS:
        raise InputError(f"{path}: suffix {path.suffix!r}; allowed: {', '.join(_WRITERS)}")
    need("plotly", "reports", f"{path}: a page with pictures")
    if suffix == ".pdf" and _browser() is None:
        raise InputError(
            f"{path}: printing a PDF needs a browser, and none of {', '.join(BROWSERS)} is on the path; "
            "allowed: .html, which any browser prints"
        )
    if suffix == ".xlsx" and importlib.util.find_spec("openpyxl") is None:
        raise InputError(f"{path}: a workbook needs openpyxl; allowed: .html, or pip install 'tribofmu[daq]'")
    return path


def write_page_file(path: Path, html: str) -> Path:
    """Write a page as HTML, PDF or workbook, by the suffix of the path; return it.

    Raises InputError: as `check_page_file`; a page without a table as a workbook; the browser fails.
    """
    return _WRITERS[check_page_file(path).suffix.lower()](path, html)


def _browser() -> str | None:
    return next((found for name in BROWSERS if (found := shutil.which(name))), None)


def _pdf(path: Path, html: str) -> Path:
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as place:
        page, printed = Path(place) / "page.html", Path(place) / "page.pdf"
        page.write_text(html, encoding="utf-8")
        command = [
            *(str(_browser()), "--headless", "--disable-gpu", "--no-first-run"),
            *(["--no-sandbox"] if getattr(os, "geteuid", lambda: 1)() == 0 else []),  # root has none
            # The charts of a page are drawn by its own script: wait for them in the time of the page.
            *("--virtual-time-budget=10000", "--no-pdf-header-footer", f"--user-data-dir={place}/profile"),
            *(f"--print-to-pdf={printed}", page.as_uri()),
        ]
        try:
            subprocess.run(command, check=True, capture_output=True, timeout=PATIENCE)
            content = printed.read_bytes()
        except (OSError, subprocess.SubprocessError) as error:
            raise InputError(
                f"{path}: the browser {command[0]} does not print it ({type(error).__name__}); allowed: .html"
            ) from None
    with atomic_path(path) as temporary:
        temporary.write_bytes(_same_bytes(content))
    return path


def _same_bytes(content: bytes) -> bytes:
    """Return a PDF that holds nothing of when and by which browser process it was printed.

    What is put in place is as long as what stood there: the offsets of the file stay right.

    Examples
    --------
    >>> _same_bytes(b"/ID (node00000034) /Headers [(node00000031)] /ModDate (D:20240102)")
    b'/ID (node00000002) /Headers [(node00000001)]                      '
    """
    order = {node: k for k, node in enumerate(sorted(set(_PDF_NODES.findall(content))), start=1)}
    numbered = _PDF_NODES.sub(lambda node: b"(node%08d)" % order[node[1]], content)
    return _PDF_DATES.sub(lambda date: b" " * len(date[0]), numbered)


def _workbook(path: Path, html: str) -> Path:
    """Write each table of a page as a sheet, named by the heading above it."""
    from lxml.html import document_fromstring
    from openpyxl import Workbook
    from openpyxl.styles import Font

    book, taken = Workbook(), set[str]()
    book.remove(book.active)
    page = document_fromstring(html)
    for table in page.iter("table"):
        headings = table.xpath("preceding::*[self::h2 or self::h3][1]")
        heading = headings[0].text_content() if headings else "table"
        sheet = book.create_sheet(_sheet_name(heading, taken))
        for row in table.iter("tr"):
            cells = [cell for cell in row if cell.tag in {"th", "td"}]
            sheet.append([None] * len(cells))
            for cell, written in zip(cells, sheet[sheet.max_row], strict=True):
                _write_cell(written, " ".join(cell.text_content().split()))
                written.font = Font(bold=cell.tag == "th")
        sheet.freeze_panes = "A2"
    if not book.worksheets:
        raise InputError(f"{path}: the page holds no table; allowed: .html, .pdf")
    from fmus.archive.content import write_archive

    written = io.BytesIO()
    book.save(written)
    with zipfile.ZipFile(written) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    files["docProps/core.xml"] = _BOOK_DATES.sub(b"", files["docProps/core.xml"])
    return write_archive(path, files)


def _sheet_name(heading: str, taken: set[str]) -> str:
    plain = NOT_IN_SHEETS.sub(" ", heading).strip() or "table"
    names = [plain[:SHEET], *(f"{plain[: SHEET - 4]} {k}" for k in range(2, 1000))]
    name = next(n for n in names if n.casefold() not in taken)
    taken.add(name.casefold())
    return name


def _write_cell(cell: Any, text: str) -> None:
    """Write a number where the text is one; a text that begins like a formula stays a text."""
    try:
        number = float(text.replace("\u2212", "-"))
    except ValueError:
        number = math.nan
    if math.isfinite(number):
        cell.value = number
    else:
        cell.value = _CONTROLS.sub("\ufffd", text)  # a test may be called so; XML holds no such characters
        cell.data_type = "s"


_WRITERS: dict[str, Callable[[Path, str], Path]] = {
    ".html": write_text,
    ".htm": write_text,
    ".pdf": _pdf,
    ".xlsx": _workbook,
}
