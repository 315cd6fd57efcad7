from __future__ import annotations

from collections.abc import Callable

import pytest

from orchestrator.cli.main import run

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
