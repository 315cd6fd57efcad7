"""A project: a folder of what the command line reads and writes, with a history of the commands."""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

from friction_models.common import InputError, write_text
from friction_models.common.errors import shown
from friction_models.common.files import read_json, write_json
from friction_models.common.yaml_files import read_yaml

FOLDERS = ("raw", "campaigns", "data", "models", "fmus", "press", "runs", "reports")
SETTINGS, HISTORY, WORK = "project.yaml", "history.jsonl", ".workbench"
#: Largest project.yaml [byte].
_LARGEST = 100_000
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,79}")


@dataclass(frozen=True)
class Project:
    """A project folder; `root` is absolute and without links, `title` is what the pages call it.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     project = Project.open(Path(place) / "mine", example=True)
    ...     project.title, [p.name for p in project.data_sets()]
    ('Example: a hidden effect', ['sct'])
    """

    root: Path
    title: str

    @classmethod
    def open(cls, folder: Path, example: bool = False) -> Project:
        """Open a folder, make it where it is missing, and fill a new or empty one with the `example` on request.

        Raises InputError: a file, a folder that holds something else, a project.yaml that cannot be read.
        """
        if folder.exists() and not folder.is_dir():
            raise InputError(f"{folder}: is a file; allowed: a project folder, or a new one")
        root = folder.resolve()
        names = {p.name for p in root.iterdir()} if root.is_dir() else set()
        if names and SETTINGS not in names and not names & {*FOLDERS, HISTORY}:
            raise InputError(
                f"{folder}: holds other files and none of {SETTINGS}, {', '.join(f'{n}/' for n in FOLDERS)}; "
                "allowed: a project folder, or a new or empty one"
            )
        if not names and example:
            with as_file(files("orchestrator.app") / "example") as source:
                shutil.copytree(
                    source, root, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__")
                )
        for name in FOLDERS:
            (root / name).mkdir(parents=True, exist_ok=True)
        (root / WORK).mkdir(mode=0o700, exist_ok=True)
        if not (root / SETTINGS).exists():
            write_text(root / SETTINGS, f"format: 1\ntitle: {_plain_title(root.name)}\n")
        return cls(root, _title(root / SETTINGS))

    def inside(self, name: str) -> Path:
        """Return the file or folder of that path in the project.

        Raises InputError: the path leads out of the project, also through a link, or into its working files.
        """
        refused = InputError(f"{shown(name, 80)!r}: leads out of the project; allowed: a path inside it")
        parts = name.split("/")
        if (
            not name
            or name.startswith("/")
            or "\\" in name
            or not name.isprintable()
            or any(part in {"", ".", ".."} or part.startswith(".") for part in parts)
            or len(name) > 500
        ):
            raise refused
        path = self.root.joinpath(*parts)
        real = _real(path)
        if real is None or not real.is_relative_to(self.root) or (self.root / WORK) in (real, *real.parents):
            raise refused
        return path

    def relative(self, path: Path) -> str:
        """Return the path of a file in the project as commands name it."""
        return path.relative_to(self.root).as_posix()

    def bare(self, text: str) -> str:
        """Return a sentence with paths as the project names them.

        Examples
        --------
        >>> Project(Path("/home/me/oil"), "oil").bare("No room: '/home/me/oil/raw/a.csv', in /home/me/oil")
        "No room: 'raw/a.csv', in the project folder"
        """
        return re.sub(
            rf"{re.escape(str(self.root))}(?![\w.-])/?",
            lambda m: "" if m[0].endswith("/") else "the project folder",
            text,
        )

    def kept(self, form: str) -> dict[str, Any]:
        """Return what a form held when it was left; empty where nothing was kept."""
        try:
            return read_json(self.root / WORK / f"{form}.json")
        except InputError:
            return {}

    def keep(self, form: str, content: Mapping[str, object]) -> None:
        """Keep what a form holds."""
        write_json(self.root / WORK / f"{form}.json", content)

    def data_sets(self) -> list[Path]:
        """Return what may be given to ``--data``: folders with points.csv and files of points, sorted."""
        place = self.root / "data"
        own = [place] if (place / "points.csv").is_file() else []
        below = [p for p in self._entries("data") if (p / "points.csv").is_file()]
        single = [
            p for p in self._entries("data") if p.suffix in {".csv", ".parquet"} and p.is_file() and not own
        ]
        return own + below + single

    def raw_sets(self) -> list[Path]:
        """Return the folders of measurement files, sorted."""
        return [p for p in self._entries("raw") if p.is_dir()]

    def models(self) -> list[Path]:
        """Return the model folders, sorted."""
        return [p for p in self._entries("models") if (p / "card.json").is_file()]

    def fmus(self) -> list[Path]:
        """Return the FMUs, sorted."""
        return [p for p in self._entries("fmus") if p.suffix == ".fmu" and p.is_file()]

    def systems(self) -> list[Path]:
        """Return the SSP archives, sorted."""
        return [p for p in self._entries("fmus") if p.suffix == ".ssp" and p.is_file()]

    def onnx_models(self) -> list[Path]:
        """Return the ONNX files beside the model folders, sorted."""
        return [p for p in self._entries("models") if p.suffix == ".onnx" and p.is_file()]

    def press_folders(self) -> list[Path]:
        """Return the folders of press curves, sorted."""
        return [p for p in self._entries("press") if (p / "levels.csv").is_file()]

    def run_folders(self) -> list[Path]:
        """Return the folders of forming runs, sorted."""
        return [p for p in self._entries("runs") if p.is_dir()]

    def reports(self) -> list[Path]:
        """Return the pages, newest first."""
        found = [p for p in self._entries("reports") if p.suffix == ".html" and p.is_file()]
        return sorted(found, key=changed, reverse=True)

    def _entries(self, folder: str) -> list[Path]:
        """Return what a folder holds and commands may be given: names of plain letters, no links out."""
        top = self.root / folder
        listed = sorted(top.iterdir()) if top.is_dir() else []
        return [
            p for p in listed if is_name(p.name) and (real := _real(p)) and real.is_relative_to(self.root)
        ]


def changed(path: Path) -> float:
    """Return when a file was changed; 0 where it was removed since it was listed."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0


def _real(path: Path) -> Path | None:
    """Return a path without links; None where links lead in a circle."""
    try:
        real = path.resolve()
    except (OSError, RuntimeError):
        return None
    # From Python 3.13 on a link that leads in a circle stays in the path, without an error.
    return None if any(p.is_symlink() for p in (real, *real.parents)) else real


def is_name(text: str) -> bool:
    """Whether a text can be the name of a file here: letters, digits, dot, dash and underscore.

    Examples
    --------
    >>> is_name("sct-1.csv"), is_name("../x"), is_name("--data"), is_name("a b")
    (True, False, False, False)
    """
    return _NAME.fullmatch(text) is not None


def name_of(text: str) -> str:
    """Return a name for a file, made of what somebody called it.

    Examples
    --------
    >>> name_of("../Prüfstand 3/mu (2).csv"), name_of("...")
    ('mu-2-.csv', 'unnamed')
    """
    last = re.split(r"[/\\]", text)[-1]
    return re.sub(r"[^A-Za-z0-9._-]+", "-", last)[:80].strip(".-_ ") or "unnamed"


def _plain_title(name: str) -> str:
    return "".join(c if c.isalnum() or c in " -_" else " " for c in name).strip() or "project"


def _title(file: Path) -> str:
    content = read_yaml(file, _LARGEST)
    if not isinstance(content, dict) or content.get("format") != 1:
        raise InputError(f"{file}: no project of this version; allowed: a file with 'format: 1' and 'title'")
    return shown(content.get("title", file.parent.name), 80)
