"""Each client gives the model's own mu, or is known not to offer that kind of FMU."""

from __future__ import annotations

from pathlib import Path

import pytest

from .cases import CASES, Case
from .running import missing
from .subjects import MAP, Subjects


def by_day() -> set[Case]:
    """Return one case of each client, version and form, and the map: the hardest, with memory and many points."""
    chosen: dict[tuple[object, ...], Case] = {}
    for case in sorted(CASES, key=lambda c: (c.model == "memory", c.points)):
        if case.supported:
            chosen[case.client, case.fmi, case.form, case.model == MAP] = case
    return {*chosen.values()}


DAILY = by_day()


@pytest.mark.parametrize(
    "case", [pytest.param(c, id=c.label, marks=() if c in DAILY else pytest.mark.nightly) for c in CASES]
)
def test_client(case: Case, subjects: Subjects, tmp_path: Path) -> None:
    if case.version is None:
        pytest.skip(f"not here: {'; '.join(map(missing, case.needs))}")
    result = case.run(case, subjects, tmp_path / "run")
    print(case.label, result)
    if case.supported:
        assert result.outcome == "agrees", result
    else:
        assert result.outcome != "agrees", "the client can do this now: say so in the table"
