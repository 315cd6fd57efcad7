"""Pages in NiceGUI's simulated browser, for the tests of single pages; nobody types there, so the pages need not wait for the next letter."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import logging
from collections.abc import Awaitable, Callable, Iterator
from typing import Any

import pytest
from nicegui import ui
from nicegui.testing import User
from nicegui.testing.user_simulation import user_simulation

from orchestrator.app.pages import frame
from orchestrator.app.pages.frame import Workbench
from orchestrator.app.pages.measurements import raw_set
from orchestrator.app.project import Project
from orchestrator.app.work.worker import Worker


class Idle(Worker):
    """A worker whose commands wait for ever: what is asked is tested by what it writes."""

    def _work(self, quick: bool) -> None:
        return


@contextlib.contextmanager
def no_errors() -> Iterator[None]:
    """Fail where an error is logged meanwhile."""
    told: list[str] = []
    handler = logging.Handler(logging.ERROR)
    handler.emit = lambda record: told.append(handler.format(record))  # type: ignore[method-assign]
    logging.getLogger().addHandler(handler)
    try:
        yield
    finally:
        logging.getLogger().removeHandler(handler)
    assert told == [], told  # only the modules of tests show what they compare


def look(project: Project, test: Callable[[User, Worker], Awaitable[None]]) -> None:
    """Run a test in a browser tab; nothing that the pages do may log an error.

    What the simulation says when it ends does not count: on a machine that stands still for two seconds it says that tasks, which
    are done, could not be cancelled in time.
    """

    async def whole() -> None:
        worker = Idle(project)
        async with user_simulation(root=Workbench(project, worker).root) as user:
            with no_errors():
                await test(user, worker)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(frame, "TICK", 0.03)
        patch.setattr(frame, "AT_ONCE", 2.0)  # pages come whole where they can
        patch.setattr(raw_set, "PAUSE", 0.01)
        # The simulated browser looks for garbage twice: only among what this page leaves, not among all modules and tests.
        gc.collect()
        gc.freeze()
        asyncio.run(whole())


def shown(user: User) -> str:
    """Return all texts of the page, also those of HTML."""
    assert user.client is not None
    elements = user.client.elements.values()
    return "\n".join(str(getattr(e, "content", "") or getattr(e, "text", "") or "") for e in elements)


def labelled(user: User, kind: type[Any], label: str) -> Any:
    """Return the field of that label."""
    return next(e for e in user.find(kind).elements if str(e.props.get("label", "")).startswith(label))


def figures(user: User) -> list[Any]:
    """Return the figures of the page."""
    assert user.client is not None
    return [e.figure for e in user.client.elements.values() if isinstance(e, ui.plotly)]


async def built(user: User) -> None:
    """Wait until nothing more comes to the page by itself."""
    client = user.client
    assert client is not None
    await until(lambda: not any("aria-busy" in e.props for e in list(client.elements.values())))


async def until(true: Callable[[], bool], seconds: float = 8.0) -> None:
    """Wait until something is so."""
    for _ in range(int(seconds / 0.01)):
        # A page that is being built lacks what is looked for.
        with contextlib.suppress(AssertionError, StopIteration):
            if true():
                return
        await asyncio.sleep(0.01)
    raise AssertionError("it did not come")


def waiting(worker: Worker) -> list[str]:
    """Return the command lines that were asked for."""
    return [job.command.line for job in worker.current()]
