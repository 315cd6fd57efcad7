from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from orchestrator.cli.main import run
from sct_twin.virtual_lab.plans import make_plan

Tribofmu = Callable[..., str]


@pytest.fixture
def tribofmu(capsys: pytest.CaptureFixture[str]) -> Tribofmu:
    """Run a command that must succeed; return what it printed."""

    def command(*arguments: object) -> str:
        code = run([str(a) for a in arguments])
        shown = capsys.readouterr()
        assert code == 0, shown.err
        return shown.out

    return command


def short_plan(path: Path, name: str, seed: int, held_out: int, sliding: float, every: int = 2) -> Path:
    """Write every so many training tests of a named plan and some of its held-out ones as a plan of shorter tests."""
    table = make_plan(name, seed)
    held = table["role"] == "test"
    rows = pd.concat([table[~held].iloc[::every], table[held].iloc[:held_out]]).assign(sd_set=sliding)
    rows.drop(columns=["bore", "tip", "F_set", "synthetic"]).to_csv(path, index=False)
    return path
