"""Virtual press curves: labelled, scattered, deterministic."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from forming.press import PressCurves
from friction_models.loads import InputError
from sct_twin.virtual_lab import press_curves
from sct_twin.virtual_lab.law import TrueLaw
from sct_twin.virtual_lab.press import VirtualPress

COARSE = VirtualPress(mesh_size=0.9)


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


def test_what_cannot_be_pressed(tmp_path: Path) -> None:
    law = TrueLaw.draw(None, 0)
    with pytest.raises(InputError, match="no levels"):
        press_curves(law, levels=[])
    with pytest.raises(InputError, match="repeats = 0; allowed: 1 to 100"):
        press_curves(law, repeats=0)
    with pytest.raises(InputError, match=r"no truth.json and truth.npz"):
        press_curves(tmp_path)
    with pytest.raises(InputError, match="T_tool = 5000"):
        press_curves(law, levels=[(5000.0, 5.0)], jobs=1)
