"""A page in Chromium that is built anew, as when a command ends: nobody loses what was begun, nor the place."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from orchestrator.app.project import HISTORY

from .chromium import CHROMIUM, Watched, something_happens
from .conftest import Served

pytest.importorskip("nicegui", reason="the extra [app] is not installed")
pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
pytestmark = [
    pytest.mark.nightly,  # by day `test_browser` builds a page anew under an unfolded part
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium (Debian package chromium)"),
]

#: How fast the browser sends [byte/s], and how large the file is [byte].
SPEED, LARGE = 3_000_000, 20_000_000


def large_table(path: Path) -> Path:
    """Write a table of points of the size of a long record."""
    row = b"a,1.0000000,0.1000000,%07d\n"
    with path.open("wb") as file:
        file.write(b"test_id,v_rel,mu,note\n")
        block = b"".join(row % n for n in range(10_000))
        while file.tell() < LARGE:
            file.write(block)
    return path


def slow(tab: Watched) -> None:
    """Let the browser send slowly."""
    line = tab.context.new_cdp_session(tab.page)
    line.send("Network.enable")
    conditions = {"offline": False, "latency": 0, "downloadThroughput": -1, "uploadThroughput": SPEED}
    line.send("Network.emulateNetworkConditions", conditions)


def choose(tab: Watched, name: str = "Choose files") -> Any:
    """Open the dialog for files."""
    with tab.page.expect_file_chooser() as found:
        tab.press("button", name)
    # The dialog opens at once, and the server hears of it on its way; nobody is faster.
    tab.page.wait_for_timeout(1000)
    return found.value


def test_an_upload_outlives_what_happens_meanwhile(browser: Any, server: Served, tmp_path: Path) -> None:
    tab = Watched(browser, server)
    tab.visit("measurements")
    large = large_table(tmp_path / "large.csv")
    slow(tab)
    dialog = choose(tab)
    # While somebody looks for the file, too.
    something_happens(server)
    tab.page.wait_for_timeout(1000)
    dialog.set_files([large])
    tab.page.wait_for_timeout(2000)
    something_happens(server)
    tab.page.wait_for_timeout(1000)
    assert not list(server.root.glob("raw/large/*"))  # it is still on its way
    tab.see("Measurements: large")
    assert (server.root / "raw/large/large.csv").read_bytes() == large.read_bytes()
    assert tab.wrong == []


def test_who_chooses_no_file_sees_what_is_new(browser: Any, server: Served) -> None:
    tab = Watched(browser, server)
    tab.visit("measurements")
    choose(tab)
    (server.root / "raw/newcomer").mkdir()
    something_happens(server)
    tab.page.wait_for_timeout(1000)
    new = tab.page.get_by_text("newcomer: 0 files")
    assert not new.count()
    tab.page.locator("input[type=file]").dispatch_event("cancel", {"bubbles": True})
    new.wait_for()
    assert tab.wrong == []


def test_a_page_that_is_built_anew_stays_where_one_reads(browser: Any, server: Served) -> None:
    (server.root / "reports").mkdir(exist_ok=True)
    lines = [json.dumps({"event": "saved", "time": "now", "file": f"raw/{k}"}) for k in range(200)]
    with (server.root / HISTORY).open("a") as file:
        file.write("\n".join(lines) + "\n")
    tab = Watched(browser, server)
    tab.visit("reports")
    tab.page.evaluate("scrollTo(0, 2000)")
    tab.page.wait_for_timeout(300)
    before = tab.page.get_by_text("raw/other/points.yaml").count()
    something_happens(server)
    tab.page.wait_for_function(
        f"[...document.querySelectorAll('td')].filter(c => c.innerText.includes('raw/other/points.yaml')).length > {before}"
    )
    tab.page.wait_for_timeout(1000)
    assert tab.page.evaluate("scrollY") == 2000
    assert tab.page.evaluate("document.getElementById('content').style.minHeight") == ""
    assert tab.wrong == []
