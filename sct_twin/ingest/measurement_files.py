"""Search for measurement files and the test table in a folder; templates that take the name of a test out of a file name."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Any, NamedTuple

from friction_models.common import InputError
from friction_models.common.wording import listed

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


def is_test_table(file: Path) -> bool:
    """Whether a file is called as a test table beside measurement files."""
    return file.name in _TESTS


def tests_beside(folder: Path) -> Path | None:
    """Return the test table of a folder, None without one. Raises InputError: there are two."""
    found = [folder / name for name in _TESTS if (folder / name).is_file()]
    if len(found) > 1:
        names = listed(file.name for file in found)
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


MARK = "{test_id}"
#: More of them would take long to match.
_MAX_STARS = 3
_ALLOWED = (
    f"a file name with {MARK} where the name of the test stands, * for any text and ? for any character"
)


@dataclass(frozen=True)
class NameTemplate:
    """A file name with ``{test_id}`` where the name of the test stands: ``*_SCT{test_id}_raw``.

    >>> NameTemplate("*_SCT{test_id}_raw").test_of("lab7_SCT042_raw")
    '042'
    """

    text: str

    @classmethod
    def load(cls, content: Any, where: str) -> NameTemplate | None:
        """Read a template; None stands for the whole name of the file.

        Raises InputError: not a text with ``{test_id}`` once, or too many stars.
        """
        if content is None:
            return None
        if not isinstance(content, str) or content.count(MARK) != 1 or len(content) > 255:
            raise InputError(
                f"{where}: test_id is {content!r}; allowed: {_ALLOWED}, such as '*_SCT{MARK}_raw'"
            )
        if content.count("*") > _MAX_STARS:
            raise InputError(f"{where}: test_id is {content!r}; allowed: at most {_MAX_STARS} *")
        return cls(content)

    def test_of(self, name: str, where: str = "") -> str:
        """Return the name of the test in a file name (without suffix). Raises InputError: the name does not fit."""
        form = re.escape(self.text).replace(re.escape(MARK), "(.+?)")
        found = re.fullmatch(form.replace(r"\*", ".*?").replace(r"\?", "."), name)
        if found is None:
            raise InputError(
                f"{where}the name {name!r} does not fit test_id {self.text!r}; allowed: {_ALLOWED}"
            )
        return found[1]


def proposed(tests: Iterable[str], files: Iterable[Path]) -> str | None:
    """Return a template by which files get the names of a test table; None where their names do not hold them.

    >>> proposed(["042", "043"], [Path("lab_SCT042_raw.csv"), Path("lab_SCT043_raw.csv")])
    'lab_SCT{test_id}_raw'
    """
    names, stems = list(tests), [file.stem for file in files]
    # A name of its own first; then also a number behind letters, or letters behind a number.
    return _template(names, stems, glued=False) or _template(names, stems, glued=True)


def _template(tests: list[str], stems: list[str], glued: bool) -> str | None:
    pairs: dict[str, tuple[str, str, str]] = {}
    for test in tests:
        before, after = (_more(test[end], glued) for end in (0, -1))
        part = re.compile(rf"(?<!{before}){re.escape(test)}(?!{after})")
        for stem in stems:
            found = part.search(stem)
            if found is not None:
                pairs.setdefault(stem, (test, stem[: found.start()], stem[found.end() :]))
                break
    if not pairs:
        return None
    head, tail = ({pair[k] for pair in pairs.values()} for k in (1, 2))
    left = _common([text[::-1] for text in head])[::-1]
    right = _common(tail)
    text = f"{'*' if len(head) > 1 else ''}{left}{MARK}{right}{'*' if len(tail) > 1 else ''}"
    try:
        fits = all(NameTemplate(text).test_of(stem) == pair[0] for stem, pair in pairs.items())
    except InputError:
        return None
    return text if fits else None


def _more(char: str, glued: bool) -> str:
    """Return the characters, as a class of a regular expression, that would make a name which ends in `char` longer."""
    if not glued:
        return r"[^\W_]"
    return r"\d" if char.isdigit() else r"[^\W\d_]"


def _common(texts: Iterable[str]) -> str:
    """Return the beginning that texts share; where they differ in a word or number, without the part of it."""
    several = list(texts)
    same = "".join(chars[0] for chars in takewhile(lambda chars: len(set(chars)) == 1, zip(*several)))
    return same if all(text == same for text in several) else re.sub(r"[^\W_]+$", "", same)
