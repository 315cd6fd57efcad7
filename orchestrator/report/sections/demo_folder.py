"""A finished demo folder, read once for its page."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from friction_models.common import InputError
from friction_models.loads import DataSet, FloatArray

from ...cosim.run_folders import Run
from ...force_curves.forces import ForceComparison, compare_force, read_press_curve
from ..charts.force import ForceLine

#: Folder of the tests that were predicted in a closed loop.
PREDICTED = "predicted"


@dataclass
class DemoFolder:
    """The demo's data, models, forces and diagnosis.

    Attributes
    ----------
    folder : Path
    summary : dict
        Content of ``demo.json``.
    held_out : DataSet
        Tests that no model was trained on.
    models : dict of str to FrictionModel
        By part: ``before`` and ``after`` (missing where nothing was added), ``other``.
    predicted : dict of str to ndarray
        mu at the held-out points by ``before`` and ``after``.
    lines : list of ForceLine
        Forces of every friction model on every level.
    """

    folder: Path
    summary: dict[str, Any]
    held_out: DataSet
    models: dict[str, Any]
    predicted: dict[str, FloatArray]
    lines: list[ForceLine]

    @classmethod
    def read(cls, folder: Path) -> DemoFolder:
        """Read a finished demo folder.

        Raises
        ------
        InputError
            A file is missing or damaged.
        """
        from friction_models import load_model

        try:
            summary = json.loads((folder / "demo.json").read_text(encoding="utf-8"))
            held_out = DataSet.load(folder / summary["data"]).select("test")
            models = {
                entry["part"]: load_model(folder / entry["folder"])
                for entry in summary["frictions"]
                if "folder" in entry
            }
            predicted = {
                part: models[part].predict_frame(held_out.points, held_out.tests)
                for part in ("before", "after")
                if part in models
            }
            lines = [_line(folder, summary, entry) for entry in summary["frictions"]]
        except (KeyError, TypeError, json.JSONDecodeError, OSError) as error:
            raise InputError(
                f"{folder}: not a complete demo folder ({type(error).__name__}: {error}); run the demo again"
            ) from None
        return cls(folder, summary, held_out, models, predicted, lines)

    def label(self, part: str) -> str:
        """Return the name of the friction model with a part."""
        return next(str(e["label"]) for e in self.summary["frictions"] if e["part"] == part)

    @property
    def diagnosis(self) -> dict[str, Any]:
        """The diagnosis as `diagnose --json` writes it."""
        found: dict[str, Any] = self.summary["diagnosis"]
        return found


def _line(folder: Path, summary: dict[str, Any], entry: dict[str, Any]) -> ForceLine:
    levels: dict[str, ForceComparison] = {}
    for level in summary["levels"]:
        run = Run.load(folder / entry["runs"][level["name"]])
        press = read_press_curve(folder / level["press"])
        levels[level["name"]] = compare_force(run.force_curve(), press, entry["label"])
    return ForceLine(entry["label"], entry["part"], levels)
