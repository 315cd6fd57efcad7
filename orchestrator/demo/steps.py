"""Steps that are done once: a finished step with the same inputs is not repeated."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypedDict

from friction_models.common import write_json

from ..jobs.keys import ResultKeys


class _Step(TypedDict):
    """A finished step: the key of its inputs, and how long it took [s]."""

    key: str
    seconds: float


class StepBook:
    """Remembers in ``steps.json`` which steps of a folder are finished, with which inputs and how long they took.

    Parameters
    ----------
    folder : Path
        The folder whose steps are kept.
    """

    def __init__(self, folder: Path) -> None:
        self._file = folder / "steps.json"
        self._folder = folder
        self._keys = ResultKeys(__package__)
        self._steps: dict[str, _Step] = {}
        if self._file.is_file():
            try:
                content = json.loads(self._file.read_text(encoding="utf-8"))
                self._steps = dict(content) if isinstance(content, dict) else {}
            except ValueError:
                self._steps = {}  # unreadable: everything is done again

    def do(self, name: str, inputs: Mapping[str, Any], outputs: list[str], work: Callable[[], Any]) -> bool:
        """Do a step unless it is done; return whether it was worked on.

        Parameters
        ----------
        name : str
            Name of the step.
        inputs : mapping
            JSON-able values that decide the result; versions and sources are added.
        outputs : list of str
            Files or folders, relative to the folder, that the step leaves behind.
        work : callable
            Does it.
        """
        key = self._keys.of(inputs)
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
