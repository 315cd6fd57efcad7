"""Friction models on press curves of both processes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from forming.press import PressCurves, PressLevel
from orchestrator import Run, System
from orchestrator.comparison.press_study import PressStudy


def level(process: str) -> PressLevel:
    stroke = np.linspace(0.0, 0.45, 46)
    curves = pd.DataFrame({"stroke": stroke, "force": 100.0 * stroke, "repeat": 1})
    return PressLevel(process, 20.0, 5.0, "made up", f"{process}.csv", curves, synthetic=True)


def test_rods_and_cups_in_one_folder(tmp_path: Path) -> None:
    info = {"process": {"mesh_size": 0.9}, "T_billet_degC": 20.0}
    PressCurves((level("fre"), level("bce")), info).save(tmp_path / "press")
    study = PressStudy.open(tmp_path / "press")
    seen: list[str] = []
    compared = study.compare(
        {"low": "0.04"}, tmp_path / "runs", 1, lambda done, total, what: seen.append(f"{done}/{total}")
    )
    assert seen[-1] == "2/2" and [c.label for c in compared.models] == ["low"] and not compared.failed
    rod, cup = compared.models[0].levels
    # A cup needs its force at once, a rod is only just in the cone; both FMUs got friction at their own markers.
    assert cup.max_force.simulated > 2.0 * rod.max_force.simulated > 0.0
    assert cup.stroke[-1] == pytest.approx(0.4, abs=0.051)
    found = json.loads((tmp_path / "runs" / "runs.json").read_text(encoding="utf-8"))
    run = Run.load(tmp_path / "runs" / found["bce, low"])
    assert run.synthetic and run.name == "bce_5mms_20C, low"
    # The run can be simulated again from where it lies.
    system = System.load(tmp_path / "runs" / found["bce, low"] / "system.yaml")
    assert {system.fmu_path(name).resolve().name for name in system.components} == {
        "friction-1.fmu",
        "bce.fmu",
    }
    assert all(system.fmu_path(name).is_file() for name in system.components)
    assert run.force_curve().force.max() == pytest.approx(run["forming.force"].max())
