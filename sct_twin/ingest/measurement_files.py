"""Search for measurement files and the test table in a folder."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from friction_models.common import InputError

from ..readers.formats import SUFFIXES, no_reader

#: A folder of measurement files, one file, or several.
Source = str | os.PathLike[str] | Iterable[str | os.PathLike[str]]

#: What a test table beside the files is called.
_TESTS = ("tests.csv", "tests.tsv", "tests.txt", "tests.parquet")
#: Files of a campaign folder that hold no test, and companions of measurement files.
_OTHER = {*_TESTS, "quality.csv", "points.csv", "channels.yaml", "channels.yml"}
_COMPANIONS = {".yaml", ".yml", ".json", ".md", ".pdf", ".png", ".jpg", ".npz", ".tdms_index"}


def _listing(folder: Path) -> list[Path]:
    return sorted(
        file
        for file in folder.iterdir()
        if file.is_file() and file.name not in _OTHER and not file.name.startswith((".", "~$"))
    )


class LeftOut(NamedTuple):
    """A file that is not used ('' for a test without a file), and why."""

    file: str
    reason: str


def passed_over(source: Source) -> list[LeftOut]:
    """Return the files of a folder that no reader reads, so that the user hears of each of them."""
    if not isinstance(source, str | os.PathLike) or not Path(source).is_dir():
        return []
    folder = Path(source) / "raw" if (Path(source) / "raw").is_dir() else Path(source)
    return [
        LeftOut(str(file), no_reader(file))
        for file in _listing(folder)
        if file.suffix.lower() not in SUFFIXES and file.suffix.lower() not in _COMPANIONS
    ]


def tests_beside(folder: Path) -> Path | None:
    """Return the test table of a folder, None without one. Raises InputError: there are two."""
    found = [folder / name for name in _TESTS if (folder / name).is_file()]
    if len(found) > 1:
        names = " and ".join(file.name for file in found)
        raise InputError(
            f"{folder}: holds {names}; allowed: one test table, or --tests with the one that counts"
        )
    return found[0] if found else None


def measurement_files(source: Source) -> tuple[list[Path], Path | None]:
    """Return the measurement files and the folder that may hold a test table.

    Raises InputError: no such file or folder, or no measurement files in it.
    """
    if isinstance(source, str | os.PathLike):
        path = Path(source)
        if path.is_file():
            return [path], path.parent
        if not path.is_dir():
            raise InputError(
                f"{path}: no such file or folder; allowed: measurement files or a folder of them"
            )
        folder = path / "raw" if (path / "raw").is_dir() else path
        files = [file for file in _listing(folder) if file.suffix.lower() in SUFFIXES]
        if not files and (path / "points.csv").is_file():
            raise InputError(
                f"{path}: holds points of friction (points.csv) and no measurement files; allowed: ingest reads "
                "measurements, points go to train, compare and diagnose as they are (--data)"
            )
        if not files:
            raise InputError(
                f"{folder}: no measurement files; allowed suffixes: {', '.join(sorted(SUFFIXES))}"
            )
        return files, path
    files = [Path(item) for item in source]
    if not files:
        raise InputError("ingest: the list of files is empty; allowed: at least one measurement file")
    for file in files:
        if not file.exists():
            raise InputError(f"{file}: no such file")
    homes = {f.parent.parent if f.parent.name == "raw" else f.parent for f in files}
    return files, homes.pop() if len(homes) == 1 else None
