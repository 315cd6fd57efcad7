"""Steps that are done once: a finished step with the same inputs is not repeated."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypedDict

from friction_models.common import InputError, write_json
from friction_models.common.files import read_json

from ..jobs.keys import ResultKeys


class _Step(TypedDict):
    """A finished step: the key of its inputs, and how long it took [s]."""

    key: str
    seconds: float


class StepBook:
    """Remembers in ``steps.json`` which steps of a folder are finished, with which inputs and how long they took."""

    def __init__(self, folder: Path) -> None:
        self._file = folder / "steps.json"
        self._folder = folder
        self._keys = ResultKeys(__package__)
        self._steps: dict[str, _Step] = {}
        if self._file.is_file():
            with contextlib.suppress(InputError):  # unreadable: everything is done again
                self._steps = read_json(self._file)

    def do(self, name: str, inputs: str, outputs: list[str], work: Callable[[], object]) -> bool:
        """Do a step unless it is done; return whether it was worked on.

        `inputs` say what decides the result, versions and sources are added; `outputs` are files or folders, relative
        to the folder, that the step leaves behind; `work` does it.
        """
        key = self._keys.of({"chain": inputs})
        found = self._steps.get(name)
        if found and found["key"] == key and all((self._folder / o).exists() for o in outputs):
            return False
        began = time.perf_counter()
        work()
        self._steps[name] = {"key": key, "seconds": round(time.perf_counter() - began, 3)}
        write_json(self._file, self._steps)
        return True

    @property
    def seconds(self) -> dict[str, float]:
        """Computing time of each finished step [s]."""
        return {name: float(step["seconds"]) for name, step in self._steps.items()}
