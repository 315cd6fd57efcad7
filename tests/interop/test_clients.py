"""Each client gives the model's own mu, or is known not to offer that kind of FMU."""

from __future__ import annotations

from pathlib import Path

import pytest

from .cases import CASES, Case
from .running import missing
from .subjects import Subjects


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.label)
def test_client(case: Case, subjects: Subjects, tmp_path: Path) -> None:
    if case.version is None:
        pytest.skip(f"not here: {'; '.join(map(missing, case.needs))}")
    result = case.run(case, subjects, tmp_path / "run")
    print(case.label, result)
    if case.supported:
        assert result.outcome == "agrees", result
    else:
        assert result.outcome != "agrees", "the client can do this now: say so in the table"
