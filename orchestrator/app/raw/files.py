"""Sets of files that a laboratory measured: the folders in `raw`, what is in them, and their maps."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from friction_models.common import InputError, write_text
from friction_models.common.yaml_files import read_yaml
from friction_models.loads.earlier_tables import EARLIER, keep
from sct_twin.ingest.measurement_files import is_test_table, measurement_files
from sct_twin.readers import SUFFIXES, RawTable, read_file

from ..commands.measuring import CHANNEL_MAP, POINT_MAP
from ..project import Project, is_name, name_of
from ..project.loaded import kept_while_unchanged

RAW = "raw"
#: Most files of a set.
MOST_FILES = 2000
#: What is taken beside measurement files: maps, and test tables, which are text.
MAPS = (".yaml", ".yml")
_LARGEST_MAP = 1_000_000


@dataclass(frozen=True)
class RawSet:
    """A set of measurement files; its `place` and the paths of its `files` are those in the project."""

    name: str
    place: str
    files: list[str]
    #: What stands in the first file that can be read, or why none can be read.
    first: RawTable | None
    problem: str

    @property
    def kinds(self) -> str:
        """How many files of which format."""
        counts = Counter(SUFFIXES.get(Path(f).suffix.lower(), "other") for f in self.files)
        return ", ".join(f"{count} {kind}" for kind, count in counts.items())


def raw_set(project: Project, name: str) -> RawSet:
    """Return what is in a folder of `raw`.

    Raises InputError: no such folder.
    """
    place = f"{RAW}/{name}"
    folder = project.inside(place)
    if not is_name(name) or not folder.is_dir():
        raise InputError(f"{place}: no such folder of measurement files in the project")
    try:
        # What leads out of the project, or is called as no command takes it, is passed over.
        found = [
            f for f in sorted(folder.iterdir())
            if f.is_file() and is_name(f.name) and f.suffix.lower() in SUFFIXES and f.resolve().is_relative_to(project.root)
        ]  # fmt: skip
        listed = measurement_files(folder)[0] if not all(map(is_test_table, found)) else []
    except InputError:
        # Files that are called as those of a data set.
        listed = [f for f in found if not is_test_table(f)]
    kept = [f for f in listed if f in found] or found
    first, problem = None, "there is no measurement file in it"
    for file in kept[:3]:
        try:
            first = read_once(file)
            break
        except InputError as error:
            problem = str(error).replace(str(file), file.name)
    return RawSet(name, place, [project.relative(f) for f in kept], first, "" if first else problem)


@kept_while_unchanged(4)
def read_once(file: Path) -> RawTable:
    """Return what stands in a file; raises InputError for what `read_file` refuses."""
    return read_file(file)


def saved_map(project: Project, place: str, records: bool) -> dict[str, Any]:
    """Return the map of a set as it was saved; empty without one, or with one that cannot be read."""
    file = project.inside(f"{place}/{CHANNEL_MAP if records else POINT_MAP}")
    try:
        content = read_yaml(file, _LARGEST_MAP)
    except (InputError, OSError):
        return {}
    return content if isinstance(content, dict) else {}


def map_text(content: Mapping[str, object]) -> str:
    """Return a map as the command line takes it."""
    return str(yaml.safe_dump(content, allow_unicode=True, sort_keys=False, width=120))


def save_map(project: Project, place: str, records: bool, content: Mapping[str, object]) -> str:
    """Write a map beside its files, and return its path; the one before is kept in the folder `earlier`."""
    path = f"{place}/{CHANNEL_MAP if records else POINT_MAP}"
    file = project.inside(path)
    text = map_text(content)
    if file.is_file():
        if file.read_bytes() == text.encode():
            return path
        project.inside(f"{place}/{EARLIER}")  # a link that leads out of the project is refused
        keep(file, file.parent)
    write_text(file, text)
    return path


def free_name(project: Project, folder: str, wanted: str) -> str:
    """Return a name of which the project's folder holds nothing yet.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     (Path(place) / "data/oil").mkdir(parents=True)
    ...     free_name(Project(Path(place), ""), "data", "oil")
    'oil-2'
    """
    number, name = 1, wanted
    while os.path.lexists(project.root / folder / name):
        number += 1
        name = f"{wanted[:70]}-{number}"
    return name


def set_name(file: str) -> str:
    """Return what a set is called after its first file.

    Examples
    --------
    >>> set_name("sct001.csv"), set_name("2024-05.tdms"), set_name("..\\\\.csv"), set_name("my rig (3).csv")
    ('sct', '2024-05', 'measurements', 'my-rig')
    """
    stem = name_of(Path(name_of(file)).stem)
    bare = re.sub(r"[-_.]*\d+$", "", stem)
    stem = bare if len(bare) >= 3 and not re.search(r"\d", bare) else stem
    return stem if is_name(stem) and stem != "unnamed" and stem not in {"csv"} else "measurements"
