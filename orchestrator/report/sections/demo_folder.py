"""A finished demo folder, read once for its page."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NotRequired, TypedDict, cast

import numpy as np

from friction_models.common import InputError
from friction_models.loads import DataSet, FloatArray

from ...cosim.run_folders import Run
from ...force_curves.forces import ForceComparison, LevelsNumbers, compare_force, read_press_curve
from ..charts.force import ForceLine

if TYPE_CHECKING:
    from friction_models import FrictionModel

    from .evidence import DiagnosisNumbers

#: Folder of the tests that were predicted in a closed loop.
PREDICTED = "predicted"


class PressLevelEntry(TypedDict):
    """A level of the press; `press` is the file of its curves."""

    name: str
    heading: str
    press: str


class FrictionEntry(TypedDict):
    """A friction model of the demo; `runs` are folders by level, `folder` is missing for a constant."""

    part: str
    label: str
    fmu: str
    runs: dict[str, str]
    outside_domain: dict[str, float]
    folder: NotRequired[str]


class RunFacts(TypedDict):
    """What a run took and reached."""

    steps: int
    seconds: float
    share_friction: float
    master_us_per_step: float
    max_tau_over_k: float
    friction_sha256: str


class SettlingRound(TypedDict):
    """A proposal that was run because the answer was ambiguous, the names before and after it, and what changed in words."""

    protocol: str
    setpoints: dict[str, float | list[float]]
    separates: list[str]
    expected_t: float
    entropy_reduction: float
    tests: int
    before: list[str]
    after: list[str]
    changed: str


class DemoSummary(TypedDict):
    """Content of ``demo.json``; `held_out`, `forces` and `predicted` are by the part of a friction model.

    `diagnosis` is the last one, after the further tests of `rounds`; the first is in ``diagnosis.json``.
    """

    synthetic: bool
    hidden: str | None
    seed: int
    plan: str
    base: str
    data: str
    tests: dict[str, int]
    levels: list[PressLevelEntry]
    frictions: list[FrictionEntry]
    held_out: Mapping[str, Any]
    forces: dict[str, LevelsNumbers]
    diagnosis: Mapping[str, Any]
    rounds: list[SettlingRound]
    run_facts: dict[str, RunFacts]
    seconds: dict[str, float]
    versions: dict[str, str]
    predicted: Mapping[str, Any]


@dataclass
class DemoFolder:
    """The demo's data, models, forces and diagnosis.

    `held_out` are the tests that no model was trained on; `models` by part (``before``, ``other``, ``after``, which is
    missing where nothing was added), `predicted` their mu at the held-out points, `lines` their forces on every level.
    """

    folder: Path
    summary: DemoSummary
    held_out: DataSet
    models: dict[str, FrictionModel]
    predicted: dict[str, FloatArray]
    lines: list[ForceLine]

    @classmethod
    def read(cls, folder: Path) -> DemoFolder:
        """Read a finished demo folder.

        Raises InputError: a file is missing or damaged.
        """
        from friction_models import load_model

        try:
            summary: DemoSummary = json.loads((folder / "demo.json").read_text(encoding="utf-8"))
            held_out = DataSet.load(folder / summary["data"]).select("test")
            models = {
                entry["part"]: load_model(folder / entry["folder"])
                for entry in summary["frictions"]
                if "folder" in entry
            }
            predicted: dict[str, FloatArray] = {
                part: np.asarray(
                    models[part].predict_frame(held_out.points, held_out.tests), dtype=np.float64
                )
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
    def diagnosis(self) -> DiagnosisNumbers:
        """The diagnosis as `diagnose --json` writes it."""
        return cast("DiagnosisNumbers", self.summary["diagnosis"])


def _line(folder: Path, summary: DemoSummary, entry: FrictionEntry) -> ForceLine:
    levels: dict[str, ForceComparison] = {}
    for level in summary["levels"]:
        run = Run.load(folder / entry["runs"][level["name"]])
        press = read_press_curve(folder / level["press"])
        levels[level["name"]] = compare_force(run.force_curve(), press, entry["label"])
    return ForceLine(entry["label"], entry["part"], levels)
