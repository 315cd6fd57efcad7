"""Virtual press curves: labelled, scattered, deterministic."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from forming.press import PressCurves
from friction_models.common import InputError
from sct_twin.virtual_lab import press_curves
from sct_twin.virtual_lab.law import TrueLaw
from sct_twin.virtual_lab.press import NINE_LEVELS, VirtualPress

COARSE = VirtualPress(mesh_size=0.9, cup_mesh_size=0.7)


def test_press_curves_of_the_true_law(tmp_path: Path) -> None:
    law = TrueLaw.draw("stribeck", 1)
    seen: list[str] = []
    made = press_curves(
        law,
        levels=[(20.0, 5.0)],
        out=tmp_path / "press",
        stroke=2.0,
        repeats=4,
        press=COARSE,
        jobs=1,
        progress=lambda done, total, what: seen.append(f"{done}/{total} {what}"),
    )
    assert seen[-1] == "2/2 virtual press at 20 degC, 5 mm/s"
    read = PressCurves.read(tmp_path / "press")
    assert read.synthetic and read.levels[0].synthetic and "synthetic" in read.info["notice"]
    level = read.levels[0]
    assert (level.T_tool, level.speed, len(level.repeats)) == (20.0, 5.0, 4)
    forces = level.max_forces()
    assert np.array_equal(forces, made.levels[0].max_forces())
    # Four billets, each with its own lubricant and material: a per cent apart, not the same curve.
    assert 0.001 < np.std(forces) / np.mean(forces) < 0.05
    assert 50.0 < forces.mean() < 500.0
    spacing = np.diff(level.repeats[0]["stroke"])
    assert (spacing >= 0).all() and spacing.mean() == pytest.approx(0.005, rel=0.05)


def test_cups_of_two_lubricants(tmp_path: Path) -> None:
    laws = [TrueLaw.draw(None, 1, name) for name in ("polymer", "mos2")]
    press_curves(
        laws, [(50.0, 5.0)], tmp_path / "p", processes=["bce"], stroke=1.0, repeats=3, press=COARSE, jobs=1
    )
    read = PressCurves.read(tmp_path / "p")
    assert [level.lubricant for level in read.levels] == ["polymer", "mos2"]
    assert [level.file for level in read.levels] == ["bce_polymer_5mms_50C.csv", "bce_mos2_5mms_50C.csv"]
    assert {level.process for level in read.levels} == {"bce"}
    means = [level.max_forces().mean() for level in read.levels]
    assert means[0] != means[1] and all(100.0 < force < 400.0 for force in means)
    # What the press really is stands beside the curves, and it is not what a user would simulate.
    reality = read.info["reality"]
    assert reality["flow_stress"] != 1.0 and reality["htc"] != 35.0 and reality["cup_mesh_size"] == 0.7


def test_nine_levels() -> None:
    assert len(set(NINE_LEVELS)) == 9
    assert len({T for T, _ in NINE_LEVELS}) == len({speed for _, speed in NINE_LEVELS}) == 3


def test_what_cannot_be_pressed(tmp_path: Path) -> None:
    law = TrueLaw.draw(None, 0)
    with pytest.raises(InputError, match="no levels"):
        press_curves(law, levels=[])
    with pytest.raises(InputError, match="repeats = 0; allowed: 1 to 100"):
        press_curves(law, repeats=0)
    with pytest.raises(InputError, match=r"no truth.json and truth.npz"):
        press_curves(tmp_path)
    with pytest.raises(InputError, match="unknown process 'cup'"):
        press_curves(law, processes=["cup"])
    with pytest.raises(InputError, match="lubricants virtual, virtual; allowed: each of them once"):
        press_curves([law, law])
    with pytest.raises(InputError, match="T_tool = 5000"):
        press_curves(law, levels=[(5000.0, 5.0)], jobs=1)
