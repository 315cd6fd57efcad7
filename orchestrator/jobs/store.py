"""Store of job results: one folder a result, named by its hash, which appears by one renaming."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from friction_models.common import InputError, write_json
from friction_models.common.cached_results import digest, path_digest
from friction_models.common.files import read_json
from friction_models.common.locks import locked

#: Every result folder holds this file, which names all others with their hashes.
RESULT = "result.json"
#: A larger result is none: the largest of the studies here take 4 MB.
MAX_BYTES = 64_000_000


@dataclass(frozen=True)
class JobResult:
    """Result of a job.

    Examples
    --------
    >>> result = JobResult("fre", {"run": "run"}, Path("jobs/0123"), 2.5)
    >>> result.file("run").as_posix()
    'jobs/0123/run'
    """

    name: str
    values: dict[str, Any]  # what its function returned, as JSON holds it
    folder: Path  # of the files it wrote
    seconds: float

    def file(self, value: str) -> Path:
        """Return the file or folder of the result that one of its values names; never one outside of its folder."""
        path = self.folder / str(self.values[value])
        if not path.resolve().is_relative_to(self.folder.resolve()):
            raise InputError(f"{self.folder}: {value} = {self.values[value]!r:.100}; allowed: a place in it")
        return path


class Store:
    """The results in a folder.

    `folder`: ``jobs`` in the folder of a study; need not exist yet.

    Examples
    --------
    >>> with tempfile.TemporaryDirectory() as place:
    ...     store = Store(Path(place))
    ...     work = Path(place) / "work"
    ...     work.mkdir()
    ...     store.keep("0123", work, {"values": {"mu": 0.1}, "seconds": 2.5})
    ...     print(store.load("0123", "fit").values, store.load("4567", "fit"))
    {'mu': 0.1} None
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()

    def load(self, key: str, name: str) -> JobResult | None:
        """Return the kept result of a key under a job's name; None where there is none, or where it was changed."""
        place = self.folder / key
        try:
            content = read_json(place / RESULT, MAX_BYTES)
            checksum = content.pop("sha256", None)
            # Those of a version before, which a report may name, have none.
            if checksum is not None and (content["key"] != key or checksum != digest(content)):
                return None
            values, seconds = dict(content["values"]), float(content["seconds"])
            if not _whole(place, dict(content.get("files", {}))):
                return None
        except (InputError, OSError, ValueError, KeyError, TypeError):
            return None
        return JobResult(name, values, place, seconds)

    def keep(self, key: str, work: Path, content: dict[str, object]) -> None:
        """Put the folder `work` in its place as the result of a key; one that is there already stays."""
        files = {p.relative_to(work).as_posix(): p for p in sorted(work.rglob("*")) if p.is_file()}
        hashes = {name: [p.stat().st_size, path_digest(p)] for name, p in files.items()}
        whole = {**content, "key": key, "files": hashes}
        write_json(work / RESULT, {**whole, "sha256": digest(whole)})
        place = self.folder / key
        if place.exists() and self.load(key, "") is None:
            shutil.rmtree(place)  # damaged
        try:
            work.rename(place)
        except OSError:
            # Another process was first; a result that is not there is an error of the disk.
            if self.load(key, "") is None:
                raise
            shutil.rmtree(work, ignore_errors=True)

    @contextmanager
    def opened(self) -> Iterator[Path]:
        """Make the folder, keep other runs out of it and yield a place for work in hand."""
        self.folder.mkdir(parents=True, exist_ok=True)
        busy = f"{self.folder.parent}: another run of this study is at work here; wait for it, or use another folder"
        with locked(self.folder / ".lock", busy):
            for left in self.folder.glob(".work-*"):  # of a run that was killed
                shutil.rmtree(left, ignore_errors=True)
            work = Path(tempfile.mkdtemp(prefix=".work-", dir=self.folder))
            try:
                yield work
            finally:
                for left in self.folder.glob(f"{work.name}*"):
                    shutil.rmtree(left, ignore_errors=True)


def _whole(place: Path, files: dict[str, list[Any]]) -> bool:
    """Return whether the files of a result are what they were: a power cut, or a full disk, may have cut them short."""
    for name, (size, sha256) in files.items():
        file = (place / name).resolve()
        there = file.is_relative_to(place) and file.is_file() and file.stat().st_size == size
        if not there or path_digest(file) != sha256:
            return False
    return True
