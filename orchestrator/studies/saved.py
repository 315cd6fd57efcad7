"""Studies whose results are kept in a folder: read again without computing anything."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from friction_models.common import InputError, unknown_name
from friction_models.common.files import read_json

from ..jobs.store import JobResult, Store

NAMES = ("learning-curve", "forming-error", "lag", "extrapolation")
#: Larger files are not read: the numbers of the full size take less than 20 MB.
MAX_BYTES = 200_000_000
_KEY = re.compile(r"[0-9a-f]{40}")


@dataclass(frozen=True)
class SavedStudy:
    """The folder of a study."""

    folder: Path
    name: str  # of the study
    manifest: dict[str, Any]  # content of ``manifest.json``

    @classmethod
    def read(cls, folder: Path) -> SavedStudy | None:
        """Read the manifest of a folder; None where it is not that of a study."""
        manifest = read_json(folder / "manifest.json", MAX_BYTES)
        settings = manifest.get("settings")
        if not isinstance(settings, dict) or "study" not in settings:
            return None
        name = str(settings["study"])
        if name not in NAMES:
            raise unknown_name("study", name, NAMES, str(folder / "manifest.json"))
        return cls(folder, name, manifest)

    @property
    def settings(self) -> dict[str, Any]:
        """What the manifest says of the study."""
        return dict(self.manifest["settings"])

    @property
    def names(self) -> list[str]:
        """Names of all jobs, with results and without."""
        return [*map(str, self.manifest["jobs"]), *map(str, self.manifest["failed"])]

    def numbers(self) -> dict[str, Any]:
        """Return the content of ``NAME.json``."""
        return read_json(self.folder / f"{self.name}.json", MAX_BYTES)

    def results(self, names: Iterable[str], *heads: str) -> dict[str, JobResult]:
        """Return the results that are there, of the jobs whose names begin with one of `heads`.

        They are those that the manifest names, whatever sources they were computed with; a folder without any is
        refused. A key is a name in ``jobs``, never a path out of it.
        """
        store, found = Store(self.folder / "jobs"), {}
        for name in (n for n in map(str, names) if n.startswith(heads)):
            key = str(self.manifest["jobs"].get(name, {}).get("job", ""))
            result = store.load(key, name) if _KEY.fullmatch(key) else None
            if result is not None:
                found[name] = result
        if not found:
            raise InputError(
                f"{self.folder / 'jobs'}: holds none of the results; allowed: the folder of the study as a whole"
            )
        return found
