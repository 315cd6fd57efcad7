"""FMUs with memory on other machines, in a host without Python."""

from __future__ import annotations

from pathlib import Path

import pytest

from .machines import MACHINES, CannotRun, Machine
from .subjects import KINDS, Subjects


@pytest.mark.parametrize("machine", MACHINES, ids=lambda machine: machine.name)
def test_machine(machine: Machine, subjects: Subjects, tmp_path: Path) -> None:
    try:
        values = machine.play(subjects, KINDS[1], tmp_path / "host")
    except CannotRun as reason:
        pytest.skip(f"{machine.label}: {reason}")
    assert machine.deviation(subjects, KINDS[1], values) <= 1e-12
