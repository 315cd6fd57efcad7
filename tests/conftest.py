"""What holds for all tests: no property test judges the speed of the machine it runs on; interrupts arrive; garbage is looked for among what tests leave."""

from __future__ import annotations

import gc
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from fmus.native import compile as compiling
from tests.builds import KeptBuilds

settings.register_profile("any machine", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("any machine")


@pytest.fixture(scope="session", autouse=True)
def interruptible() -> None:
    """A shell starts what runs in its background with interrupts ignored; tests send them."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session", autouse=True)
def one_process() -> Iterator[None]:
    """Let what is not told how many processes to use run in this one: each other would import everything anew.

    The tests keep the cores busy; those of pools of processes say how many they want.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("friction_models.common.processes.pool.default_jobs", lambda: 1)
        yield


@pytest.fixture(scope="session")
def run_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that all processes of a run of the tests share."""
    own = tmp_path_factory.getbasetemp()
    return own.parent if os.environ.get("PYTEST_XDIST_WORKER") else own


@pytest.fixture(scope="session", autouse=True)
def builds_kept(run_folder: Path) -> Iterator[KeptBuilds]:
    """Let all processes of the tests compile each C source once."""
    kept = KeptBuilds(compiling.build, run_folder / "kept-builds")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiling, "build", kept)
        yield kept


@pytest.fixture
def built_anew(builds_kept: KeptBuilds, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a test that judges what is compiled compile it itself."""
    monkeypatch.setattr(compiling, "build", builds_kept.build)


@pytest.fixture
def uncompiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the compiler out where only the description of an FMU is looked at."""
    monkeypatch.setattr(compiling, "build", lambda *_: {})


def pytest_collection_finish() -> None:
    """Take modules and tests out of the sight of the garbage collector, and let it come less often: it took a tenth of all time."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)
