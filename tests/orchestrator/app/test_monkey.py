"""A monkey at the pages: random actions from a seed; nothing may be logged as an error, here or in the browser's console.

``make monkey`` does 1000 in the simulated browser and 300 in Chromium.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("nicegui", reason="the extra [app] is not installed")

from nicegui import ui
from nicegui.elements.upload_files import SmallFileUpload
from nicegui.testing import User

from orchestrator.app.pages.frame import PAGES
from orchestrator.app.project import HISTORY, Project, history
from orchestrator.app.work.worker import Worker

from .chromium import CHROMIUM, Watched
from .conftest import Served, served
from .seen import look
from .test_pages import HOSTILE, storage

assert storage  # a fixture that holds here, too

ACTIONS = int(os.environ.get("TRIBOFMU_MONKEY", "25"))
CLICKS = int(os.environ.get("TRIBOFMU_MONKEY_CLICKS", "0"))
SEED = int(os.environ.get("TRIBOFMU_MONKEY_SEED", "4"))
TEXTS = ("", "0", "-1", "1e309", "nan", "mu", "K", "MPa", "*", "../..", HOSTILE, "'; drop", ":js", "\x00", "x" * 600, "{test_id}", "a=b; c", "ä µ ²")  # fmt: skip
TABLE = "test,v_mm_s,sigma_n_MPa,mu\n" + "".join(f"t{k},{1 + k % 3},{1 + k},0.{50 - k}\n" for k in range(12))


def furnished(root: Path) -> Project:
    """The example with a set of raw files, and addresses that are not as they should be."""
    project = Project.open(root, example=True)
    (project.root / "raw/oil").mkdir()
    (project.root / "raw/oil/oil.csv").write_text(TABLE)
    (project.root / "raw/oil/points.yaml").write_text("columns: [no, map]\n")
    return project


def addresses() -> list[str]:
    more = ("/measurements?raw=oil", "/measurements?raw=oil&as=records", "/measurements?tests=data/sct", "/measurements?raw=../x", "/explore?data=%00", "/no")  # fmt: skip
    return [*(path for path, _, _ in PAGES), *more]


async def act(user: User, draw: random.Random) -> str:
    """Do something at random; return what it was."""
    assert user.client is not None
    kinds: tuple[type[Any], ...] = (ui.button, ui.select, ui.number, ui.input, ui.switch, ui.upload)
    found = [e for e in user.client.elements.values() if isinstance(e, kinds) and e.visible]
    if not found or draw.random() < 0.12:
        address = draw.choice(addresses())
        await user.open(address)
        return f"open {address}"
    element = draw.choice(found)
    if isinstance(element, ui.upload):
        name, text = (
            draw.choice(TEXTS) + draw.choice((".csv", ".tdms", "", ".exe")),
            draw.choice((TABLE, "", "\x00\x01")),
        )
        await element.handle_uploads([SmallFileUpload(name, "text/csv", text.encode())])
        return f"upload {name!r}"
    if isinstance(element, ui.button):
        for listener in list(element._event_listeners.values()):
            if listener.type == "click" and listener.handler is not None:
                element._handle_event({"listener_id": listener.id, "args": {}})
        return f"press {element.text!r}"
    if isinstance(element, ui.select):
        element.set_value(draw.choice(list(element.options)))
    elif isinstance(element, ui.number):
        element.set_value(draw.choice((None, 0.0, -1.0, 1e300, 0.5, 3)))
    elif isinstance(element, ui.switch):
        element.set_value(not element.value)
    else:
        element.set_value(draw.choice(TEXTS))
    return f"{type(element).__name__} {element.props.get('label')!r} = {element.value!r}"


def test_random_actions_leave_no_exception(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    project = furnished(tmp_path / "project")
    draw = random.Random(SEED)
    done: list[str] = []

    async def test(user: User, worker: Worker) -> None:
        await user.open("/measurements")
        for _ in range(ACTIONS):
            with contextlib.suppress(AssertionError):  # a page that is just being built has no such element
                done.append(await act(user, draw))
            await asyncio.sleep(draw.choice((0.0, 0.0, 0.01, 0.1)))
            wrong = [r.getMessage() + str(r.exc_info) for r in caplog.records if r.levelno >= logging.ERROR]
            assert wrong == [], done[-8:]

    look(project, test)
    assert len(done) > ACTIONS / 2
    assert sorted(p.name for p in project.root.parent.iterdir()) == ["project"]
    assert all("event" in line for line in history.read(project.root / HISTORY))


@pytest.fixture(scope="module")
def furnished_server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """The furnished example, served; what it logs is looked at when it ends."""
    yield from served(furnished(tmp_path_factory.mktemp("monkey") / "project").root)


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None or not CLICKS, reason="make monkey lets it into Chromium")
def test_random_clicks_leave_the_console_empty(browser: Any, furnished_server: Served) -> None:
    from playwright.sync_api import Error

    draw = random.Random(SEED)
    tab = Watched(browser, furnished_server)
    for number in range(CLICKS):
        if number % 12 == 0:
            # A click before may have been on a link whose page comes only now, and wins: it does not matter which page comes, but
            # one must.
            with contextlib.suppress(Error):
                tab.page.goto(f"{tab.own}{draw.choice(addresses())}", wait_until="commit", timeout=2000)
            tab.settle()
        found = tab.page.locator(
            "button:visible, a:visible, input:visible, .q-select:visible, .js-plotly-plot:visible"
        )
        count = found.count()
        if not count:
            continue
        one = found.nth(draw.randrange(count))
        with contextlib.suppress(Error):  # covered, gone, or just moving
            if draw.random() < 0.3:
                one.fill(draw.choice([t for t in TEXTS if t.isprintable()]), timeout=300)
            else:
                one.click(timeout=300, no_wait_after=True)
        if draw.random() < 0.2:
            tab.page.keyboard.press(draw.choice(("Escape", "Tab", "Enter", "ArrowDown")))
        for more in tab.context.pages:
            if more is not tab.page:
                more.close()
        wrong = [w for w in tab.wrong if "status of 404" not in w]
        assert wrong == [], (number, tab.page.url)
    tab.settle()
