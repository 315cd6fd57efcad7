"""Projects of the workbench for the tests, and a served one."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import pytest

from orchestrator.app.project import Project

#: Makes the network fail for a process and all that it starts, and notes what was tried.
NETWORK_OFF = Path(__file__).parent / "network_off"


class Served(NamedTuple):
    """A workbench that listens, and its project."""

    port: int
    token: str
    root: Path


@pytest.fixture
def example(tmp_path: Path) -> Project:
    """A fresh copy of the example."""
    return Project.open(tmp_path / "project", example=True)


def shorter_example(folder: Path) -> Project:
    """A copy of the example with every other test: an answer takes half of the time."""
    project = Project.open(folder, example=True)
    for file in (project.root / "data/sct/points.csv", project.root / "data/sct/tests.csv"):
        table = pd.read_csv(file, dtype=str, keep_default_na=False)
        table[table["test_id"].str[-1].isin([*"02468"])].to_csv(file, index=False)
    return project


def served(folder: Path, *options: str, **environment: str) -> Iterator[Served]:
    """Serve a copy of the example in a process of its own, on a free port; to it and its commands the network is off."""
    pytest.importorskip("nicegui", reason="the extra [app] is not installed")
    command = [sys.executable, "-c", "from orchestrator.cli import main; main()", "app", str(folder)]
    log, tried = (folder.parent / f"{folder.name}.{kind}" for kind in ("log", "tried"))
    off = {"PYTHONPATH": str(NETWORK_OFF), "TRIBOFMU_TRIED": str(tried)}
    with (
        log.open("wb") as errors,
        subprocess.Popen(
            [*command, "--example", "--no-browser", *options],
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
            env={**os.environ, "OMP_NUM_THREADS": "1", **off, **environment},
        ) as process,
    ):
        try:
            assert process.stdout is not None
            lines = [process.stdout.readline() for _ in range(3)]
            found = re.search(r"http://[^:]+:(\d+)/(?:\?token=(\S+))?", "".join(lines))
            assert found is not None, (lines, log.read_text())
            yield Served(int(found[1]), found[2] or "", folder.resolve())
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(20)
    assert "Traceback" not in log.read_text(), log.read_text()[-4000:]
    assert not tried.exists(), tried.read_text()


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """The shorter example, served on this machine only."""
    yield from served(shorter_example(tmp_path_factory.mktemp("served") / "project").root)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Headless Chromium; not for a whole session, as it holds the event loop of its thread."""
    from playwright.sync_api import sync_playwright

    from .chromium import CHROMIUM, OFFLINE

    with sync_playwright() as play:
        made = play.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", *OFFLINE])
        yield made
        made.close()
