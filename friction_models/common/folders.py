"""The kinds of folders that are written here: what is in each, and which folder may be written to.

A command replaces what a command of the same kind made, and nothing else; `earlier` keeps what would be lost.
"""

from __future__ import annotations

import contextlib
import csv
import json
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from .errors import InputError, shown

#: What a desktop leaves in every folder that it shows.
_DESKTOP = {".DS_Store", "Thumbs.db", "desktop.ini"}
#: A folder that grows, run by run, says with this file what it is, from its beginning.
MARK = ".tribofmu"


#: Whether a folder lists a file, by its path in the folder.
Lists = Callable[[str], bool]


def _nothing_more(folder: Path) -> Lists:
    return lambda name: False


@dataclass(frozen=True)
class FolderKind:
    """What is in a folder that is written as a whole, and replaced as a whole.

    Examples
    --------
    >>> kind = FolderKind("a study of wear", marks=("wear.json",), others=("runs/*.csv",))
    >>> owns = kind.owner(Path("."))
    >>> owns("wear.json"), owns("runs/one.csv"), owns("thesis.tex")
    (True, True, False)
    """

    #: What it holds, for messages.
    what: str
    #: Files that every such folder has.
    marks: tuple[str, ...]
    #: Files that it may have, by their path in it; ``*`` stands for any characters.
    others: tuple[str, ...] = ()
    #: Returns for a folder which further files it lists itself.
    listed: Callable[[Path], Lists] = _nothing_more
    #: A file of JSON among the marks, and a key that it holds when it was written here.
    says: tuple[str, str] | None = None
    #: Files that say when it was made, and the keys of their JSON that do; they differ where nothing else does.
    dated: tuple[str, ...] = ()
    times: tuple[str, ...] = ()

    def foreign(self, folder: Path) -> str:
        """Return why the folder is none of this kind, as a part of a sentence; empty when it is one, or is empty."""
        names = {p.name for p in folder.iterdir()} - _DESKTOP
        lacking = [m for m in self.marks if m not in names]
        if not names:
            return ""
        if lacking:
            return f"holds other files and no {lacking[0]}"
        if self.says is not None and self.says[1] not in json_object(folder / self.says[0]):
            return f"holds {self.says[0]!r}, which was not written here"
        more = self._more(folder)
        return f"holds {more!r}, too, which is no part of {self.what}" if more else ""

    def _more(self, folder: Path) -> str:
        """Return a file or an empty folder in a folder that is no part of this kind, empty without one."""
        owns = self.owner(folder)
        for place, folders, files in os.walk(folder):
            inside = Path(place).relative_to(folder)
            links = [n for n in folders if (Path(place) / n).is_symlink()]
            for name in sorted({*files, *links} - _DESKTOP):
                if not owns((inside / name).as_posix()):
                    return (inside / name).as_posix()
            if not (folders or files) and not any(p.startswith(f"{inside}/") for p in (*self.others, "raw/")):
                return inside.as_posix()
        return ""

    def owner(self, folder: Path) -> Lists:
        """Return what tells whether a file, by its path in a folder of this kind, is part of it."""
        listed = self.listed(folder)
        patterns = (*self.marks, *self.others)
        return lambda name: any(fnmatchcase(name, pattern) for pattern in patterns) or listed(name)


@dataclass(frozen=True)
class GrowingKind:
    """What is in a folder that one run after another writes into; files that it does not know stay.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> kind = GrowingKind("a study of wear", signs=("wear.json",))
    >>> with TemporaryDirectory() as place:
    ...     print(kind.foreign(Path(place)) == "")
    ...     (Path(place) / "thesis.tex").touch()
    ...     print(kind.foreign(Path(place)) == "")
    True
    False
    """

    #: What it holds, for messages; it stands in its mark file.
    what: str
    #: Patterns; a folder with one of them is of this kind, even without a mark file.
    signs: tuple[str, ...]

    def foreign(self, folder: Path) -> str:
        """Return why the folder is none of this kind, as a part of a sentence; empty when it is one, or is empty."""
        if not {p.name for p in folder.iterdir()} - _DESKTOP:
            return ""
        mark = folder / MARK
        if mark.is_symlink() or (mark.exists() and not mark.is_file()):
            return f"holds {MARK!r}, which is no plain file"
        if mark.is_file():
            try:
                said = mark.read_text(encoding="utf-8")[:100].strip()
            except (OSError, ValueError):
                said = "something else"
            return "" if said == self.what else f"holds {said}"
        known = any(next(folder.glob(sign), None) is not None for sign in self.signs)
        return "" if known else f"holds other files and nothing of {self.what}"


def json_object(file: Path) -> dict[str, object]:
    """Return a JSON object, empty where there is none."""
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


def _column(file: Path, name: str) -> set[str]:
    """Return the texts in a column of a table, without empty ones."""
    try:
        with file.open(encoding="utf-8", newline="") as stream:
            return {str(row.get(name) or "") for row in csv.DictReader(stream)} - {""}
    except (OSError, ValueError, csv.Error):
        return set()


def _of_run(folder: Path) -> Lists:
    parts = json_object(folder / "manifest.json").get("components")
    names = (
        {p.get("fmu") for p in parts.values() if isinstance(p, dict)} if isinstance(parts, dict) else set()
    )
    return lambda name: name.startswith("fmus/") and name[5:] in names


def _of_campaign(folder: Path) -> Lists:
    """Records are called as their tests, with more behind the name where a test has several files."""
    tests = _column(folder / "tests.csv", "test_id")

    def listed(name: str) -> bool:
        top, _, file = name.partition("/")
        return top == "raw" and any(file[:k] in tests for k in range(len(file), 0, -1))

    return listed


def _of_export(folder: Path) -> Lists:
    files = json_object(folder / "export.json").get("files")
    return (
        {str(name) for name in files}.__contains__
        if isinstance(files, list | dict)
        else _nothing_more(folder)
    )


def _of_press(folder: Path) -> Lists:
    return _column(folder / "levels.csv", "file").__contains__


_FIELDS = ("fields.pvd", "*.vtu", "fields.npz")
_FIELDS_BELOW = tuple(f"fields/*{name.lstrip('*')}" for name in _FIELDS)
RUN = FolderKind(
    "a run",
    ("manifest.json", "results.nc"),
    ("results.csv", "local_errors.nc", "system.yaml", "log.txt", "report.html", *_FIELDS_BELOW),
    _of_run,
    ("manifest.json", "components"),
    dated=("manifest.json", "log.txt"),
    times=("written", "timing_s"),
)
MODEL = FolderKind(
    "a model", ("card.json", "model.onnx"), ("card.md", "parameters.npz"), says=("card.json", "format")
)
DATASET = FolderKind(
    "a data set",
    ("points.csv", "dataset.json"),
    ("tests.csv", "earlier/tests-*.csv"),
    says=("dataset.json", "units"),
)
CAMPAIGN = FolderKind(
    "a campaign",
    ("campaign.json", "raw", "tests.csv"),
    ("quality.csv", "channels.yaml", "truth.json", "truth.npz", "earlier/tests-*.csv"),
    _of_campaign,
    ("campaign.json", "format"),
)
UNFINISHED = FolderKind("an unfinished campaign", (".lock",), ("key", "raw/*", "truth/*"))
PRESS = FolderKind("press curves", ("levels.csv", "press.json"), listed=_of_press)
EXPORT = FolderKind("an export", ("export.json",), (), _of_export, ("export.json", "files"))
FORMING = FolderKind(
    "a forming result",
    ("forming.json", "force.csv"),
    ("contact.nc", "ejection.csv", "ejection.json", "ejection_contact.nc", "report.html", *_FIELDS_BELOW),
)
FIELDS = FolderKind("fields", ("fields.pvd",), _FIELDS)

TWIN = GrowingKind("a data set of the twin", ("twin/*.nc",))
STUDY = GrowingKind("results of a study", ("jobs/.lock",))
PREDICTION = GrowingKind("predicted tests", ("prediction.json", "runs/*/manifest.json"))
DEMO = GrowingKind("the demo", ("steps.json", "demo.json", ".campaign.partial"))
SENSITIVITIES = GrowingKind("runs of an attribution", ("probe-*.fmu",))

#: All kinds that are replaced as a whole.
KINDS = (RUN, MODEL, DATASET, CAMPAIGN, PRESS, EXPORT, FORMING, FIELDS)


def check_folder(target: str | os.PathLike[str], kind: FolderKind | GrowingKind) -> Path:
    """Return the folder to be written, absolute, when it may be: a new or empty one, or one of this kind.

    Nothing is changed.

    Raises InputError: a file or a link; a folder that holds something else, or in which this process stands.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> kind = FolderKind("a study of wear", marks=("wear.json",))
    >>> with TemporaryDirectory() as place:
    ...     folder = check_folder(Path(place) / "new", kind)
    ...     folder.name, folder.exists()
    ('new', False)
    """
    given = Path(target)
    replaced = isinstance(kind, FolderKind)
    more = " and nothing else" if replaced else ""
    allowed = f"a new or empty folder, or one that holds {kind.what}{more}"
    folder = absolute(given)
    try:
        if replaced and folder.is_symlink():
            raise InputError(f"{given}: is a link, which is not replaced; allowed: {allowed}")
        if folder.exists() and not folder.is_dir():
            raise InputError(f"{given}: is a file; allowed: {allowed}")
        if not folder.is_dir():
            check_parents(given)
            return folder
        reason = kind.foreign(folder)
    except OSError as error:
        raise InputError(
            f"{shown(given)}: cannot be written ({error.strerror}); allowed: {allowed}"
        ) from None
    if reason:
        raise InputError(f"{given}: {reason}; allowed: {allowed}")
    if replaced and Path.cwd().is_relative_to(folder.resolve()):
        raise InputError(f"{given}: is the current folder or holds it; allowed: {allowed}")
    return folder


def absolute(path: Path) -> Path:
    """Return the absolute path as the system takes it, ``..`` behind links included; a link at its end stays one."""
    if path.name in {"", ".."}:
        return Path(os.path.realpath(path))
    return Path(os.path.realpath(path.parent)) / path.name


def check_parents(target: Path) -> None:
    """Raise InputError for what cannot be made: below a file, where one may not write, with a name too long."""
    place = absolute(target)
    try:
        above = next(p for p in place.parents if p.exists())
        with contextlib.suppress(FileNotFoundError, NotADirectoryError):
            place.lstat()
    except OSError as error:
        raise InputError(f"{shown(target)}: cannot be written ({error.strerror})") from None
    if not above.is_dir():
        raise InputError(f"{target}: {above} is a file; allowed: a place in a folder")
    if not os.access(above, os.W_OK | os.X_OK):
        raise InputError(f"{target}: no permission to write in {above}; allowed: a place of your own")


def grown(target: str | os.PathLike[str], kind: GrowingKind) -> Path:
    """Make or take a folder that one run after another writes into, and mark it; return it as it was given.

    Raises InputError: what `check_folder` refuses.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     folder = grown(Path(place) / "wear", GrowingKind("a study of wear", signs=("wear.json",)))
    ...     [file.name for file in folder.iterdir()] == [MARK]
    True
    """
    check_folder(target, kind)
    folder = Path(target)
    folder.mkdir(parents=True, exist_ok=True)
    mark = folder / MARK
    if not mark.is_file():
        mark.write_text(kind.what + "\n", encoding="utf-8")
    return folder


def check_outputs(
    outputs: Iterable[str | os.PathLike[str]], inputs: Iterable[str | os.PathLike[str]]
) -> None:
    """Refuse an output that would replace an input: one that is it, or holds it, or is a part of its folder.

    Raises InputError, which names the first such output.

    Examples
    --------
    >>> check_outputs(["model"], ["points.csv"])
    >>> check_outputs(["points.csv"], ["points.csv"])
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: ...
    """
    written = [Path(o) for o in outputs]
    for number, output in enumerate(written):
        place = output.resolve()
        if any(place == other.resolve() for other in written[:number]):
            raise InputError(f"{output}: two outputs of one name; allowed: a name for each")
        for given in map(Path, inputs):
            source = given.resolve()
            if place == source:
                raise InputError(
                    f"{output}: is an input of this command; allowed: another name for the output"
                )
            if source.is_relative_to(place):
                raise InputError(
                    f"{output}: holds {given}, an input of this command; allowed: another folder for the output"
                )
            if place.is_relative_to(source) and place.exists() and _is_part(source, place):
                raise InputError(
                    f"{output}: is a part of {given}, an input of this command; allowed: another name for the output"
                )


def _is_part(folder: Path, file: Path) -> bool:
    """Return whether an existing file belongs to what its folder holds; reports do not."""
    name = file.relative_to(folder).as_posix()
    if file.suffix.lower() in {".html", ".htm"}:
        return False
    return name == "points.parquet" or any(kind.owner(folder)(name) for kind in KINDS)
