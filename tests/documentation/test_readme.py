"""The README's loop in Python runs as it is printed; only the number of tests and the strokes are smaller."""

from __future__ import annotations

import re
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from sct_twin.virtual_lab import press_curves

TEXT = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
STROKE = 0.5


def block(language: str) -> str:
    """Return the one block of a language."""
    (found,) = re.findall(rf"```{language}\n(.*?)```", TEXT, re.DOTALL)
    return str(found)


def small_plan() -> pd.DataFrame:
    """Return twelve tests to learn from and two that are held out, with short sliding."""
    settings = [
        *product((5.0, 50.0, 500.0), (20.0, 200.0), (500.0, 2000.0)),
        (20.0, 100.0, 1000.0),
        (200.0, 60.0, 1500.0),
    ]
    plan = pd.DataFrame(settings, columns=["v_set", "T_tool", "sigma_set"]).assign(sd_set=12.0, role="train")
    plan.loc[12:, "role"] = "test"
    return plan


@pytest.mark.nightly  # by day its imports, the tutorials, which make the same calls, and the demo
def test_the_loop_of_the_readme_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    system = yaml.safe_load(block("yaml"))
    speed = 5.0  # mm/s
    system["stop_time"] = STROKE / speed
    Path("fre.yaml").write_text(yaml.safe_dump(system), encoding="utf-8")
    monkeypatch.setattr(
        "sct_twin.virtual_lab.press_curves",
        lambda *a, **k: press_curves(*a, **k, stroke=STROKE, repeats=2, jobs=1),
    )
    code = block("python")
    assert code.count('plan="factorial-81+30"') == 1
    seen: dict[str, object] = {"small": small_plan()}
    exec(compile(code.replace('plan="factorial-81+30"', "plan=small"), "README.md", "exec"), seen)
    said = capsys.readouterr().out
    assert "stribeck" in seen["diagnosis"].confusion_set  # type: ignore[attr-defined]
    assert "synthetic" in said.lower()
    points = seen["test"]
    assert isinstance(points, pd.DataFrame)
    again = seen["same"].predict_frame(points)  # type: ignore[attr-defined]
    assert np.array_equal(again, seen["better"].predict_frame(points))  # type: ignore[attr-defined]
    force = seen["run"]["forming.force"]  # type: ignore[index]
    assert 5.0 < force.max() < 400.0
