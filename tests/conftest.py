"""What holds for all tests: no property test judges the speed of the machine it runs on; interrupts arrive; garbage is looked for among what tests leave."""

from __future__ import annotations

import gc
import signal
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, settings

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


def pytest_collection_finish() -> None:
    """Take modules and tests out of the sight of the garbage collector, and let it come less often: it took a tenth of all time."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)
