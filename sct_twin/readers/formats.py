"""Selection of the reader of a file by its suffix, checked against its first bytes."""

from __future__ import annotations

import contextlib
import importlib
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

from friction_models.common import InputError
from friction_models.common.imports.extras import need

from .catman import looks_like_catman
from .table import RawTable, check_file

#: Suffix -> kind; the kinds without a reader of our own run guarded.
SUFFIXES: dict[str, str] = {
    ".csv": "CSV",
    ".txt": "CSV",
    ".asc": "CSV",
    ".dat": "CSV",
    ".tsv": "CSV",
    ".bin": "catman",
    ".mf4": "MDF",
    ".mdf": "MDF",
    ".tdms": "TDMS",
    ".mat": "MATLAB",
    ".parquet": "Parquet",
    ".xlsx": "Excel",
    ".xlsm": "Excel",
}
_READERS = {
    "MDF": (".mdf", "read_mdf"),
    "TDMS": (".tdms", "read_tdms"),
    "MATLAB": (".matlab", "read_matlab"),
    "Parquet": (".parquet", "read_parquet"),
    "Excel": (".excel", "read_excel"),
}
#: What takes its time to load, sometimes longer than a file to read.
_LIBRARIES = {
    "MDF": "asammdf",
    "TDMS": "nptdms",
    "MATLAB": "scipy.io.matlab",
    "Parquet": "pyarrow.parquet",
    "Excel": "openpyxl",
}
_PICKLE = (b"\x80\x02", b"\x80\x03", b"\x80\x04", b"\x80\x05")
_HDF5 = b"\x89HDF\r\n\x1a\n"


def kind_of(file: Path) -> str:
    """Return the kind of a file.

    Raises InputError: no such file, empty, too large, a suffix without a reader, or content that is something
    else than the suffix says.
    """
    check_file(file)
    kind = SUFFIXES.get(file.suffix.lower())
    if kind is None:
        raise InputError(no_reader(file))
    with file.open("rb") as stream:
        head = stream.read(512)
    if head[:2] in _PICKLE:
        raise InputError(f"{file}: binary content, a Python pickle; allowed: {_allowed(kind)}")
    if kind == "CSV":
        return kind
    if not _fits(kind, head):
        raise InputError(f"{file}: the content is not that of a {kind} file; allowed: {_allowed(kind)}")
    return kind


def no_reader(file: Path) -> str:
    """Return the sentence about a file whose suffix no reader knows."""
    return f"{file}: suffix {file.suffix!r} has no reader; allowed: {', '.join(sorted(SUFFIXES))}"


def _fits(kind: str, head: bytes) -> bool:
    if kind == "catman":
        return looks_like_catman(head)
    if kind == "MDF":
        return head.startswith((b"MDF     ", b"UnFinMF "))
    if kind == "TDMS":
        return head.startswith(b"TDSm")
    if kind == "Parquet":
        return head.startswith(b"PAR1")
    if kind == "Excel":
        return head.startswith(b"PK\x03\x04")
    # MATLAB: a text of 116 bytes and a byte order mark; version 7.3 is HDF5 behind such a header.
    return head[126:128] in (b"IM", b"MI") or head.startswith(_HDF5)


def _allowed(kind: str) -> str:
    return {
        "CSV": "a text file with a header, a units row and numbers",
        "catman": "a file that catman saved as catman binary",
        "MDF": "MDF 3 or 4",
        "TDMS": "a TDMS file (not its .tdms_index)",
        "Parquet": "a Parquet file",
        "Excel": "an Excel workbook (.xlsx)",
        "MATLAB": "a MATLAB file of version 5 to 7.2 (save with -v7)",
    }[kind]


def library(module: str, package: str, file: Path, kind: str) -> ModuleType:
    """Import a library of an extra. Raises InputError: it is not installed; names the extra."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise InputError(
            f"{file}: {kind} files need {package} ({error}); install it with pip install 'tribofmu[daq]'"
        ) from None


def load_library(kind: str) -> None:
    """Load the library of a kind, so that reading takes the time of reading alone; one that is missing is told there."""
    with contextlib.suppress(ImportError):
        importlib.import_module(_LIBRARIES[kind])


def read_kind(file: Path, kind: str) -> RawTable:
    """Read a file with the library of its kind, in this process."""
    if kind == "Parquet":
        need("pyarrow", "solvers", f"{file}: a Parquet file")
    module, function = _READERS[kind]
    reader: Callable[[Path], RawTable] = getattr(importlib.import_module(module, __package__), function)
    return reader(file)
