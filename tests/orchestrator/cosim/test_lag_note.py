"""The master points out communication steps in which the tools of a forming FMU travel far."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from fmus import pack, pack_forming
from friction_models import ConstantFriction
from orchestrator import Master, System

STEP = 0.02


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("lag")
    return {
        "friction": pack(ConstantFriction(mu=0.08), folder / "friction.fmu", nodes=12),
        "forming": pack_forming(folder / "forming.fmu", n_points=12, mesh_size=0.9),
    }


def system(fmu: dict[str, Path], speed: float) -> System:
    loads = [f"forming.{name} -> friction.{name}" for name in ("v_rel", "T", "sigma_n", "sd", "psi")]
    return System.from_dict(
        {
            "communication_step": STEP,
            "stop_time": STEP,
            "components": {
                "friction": {"fmu": str(fmu["friction"])},
                "press": {"fmu": str(fmu["forming"]), "start": {"speed": speed}},
            },
            "connections": [
                "friction.mu -> press.mu",
                *(text.replace("forming", "press") for text in loads),
            ],
            "record": ["press.force"],
        }
    )


def test_far_travel_is_told_and_written(fmu: dict[str, Path], tmp_path: Path) -> None:
    master = Master(system(fmu, 0.5 / STEP))
    (note,) = master.warnings
    assert note.startswith("component 'press': the tools travel 0.5 mm in a communication step")
    master.run(tmp_path / "run")
    assert json.loads((tmp_path / "run" / "manifest.json").read_text())["warnings"] == [note]


def test_short_steps_and_steps_without_lag_need_no_word(fmu: dict[str, Path]) -> None:
    assert Master(system(fmu, 0.2 / STEP)).warnings == []
    assert Master(system(fmu, 0.5 / STEP), "iterated").warnings == []
