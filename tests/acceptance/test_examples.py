"""Examples are run, so that what the reader copies works."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_whole_loop_through_python(tmp_path: Path, capsys) -> None:
    spec = importlib.util.spec_from_file_location("whole_loop", EXAMPLES / "whole_loop.py")
    assert spec is not None and spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    before, after = example.main(tmp_path, plan="tiny-6+3", stroke=1.0)
    said = capsys.readouterr().out
    assert "synthetic" in said.lower() and before.synthetic
    for run in (before, after):
        stroke, force = run["forming.stroke"], run["forming.force"]
        assert np.isclose(stroke[-1], 1.0) and np.all(np.diff(stroke) > 0)
        assert 20.0 < force.max() < 400.0
    assert not np.array_equal(before["forming.force"], after["forming.force"])
