"""The workbench in Chromium: a tab that notes every complaint and every request that leaves the server."""

from __future__ import annotations

import shutil
from typing import Any

from orchestrator.app.project import HISTORY, history

from .conftest import Served

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
#: Options that turn the network off: no name but those of this machine leads anywhere.
OFFLINE = ("--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1", "--disable-background-networking")
#: Longest wait for anything [ms]: far longer than it takes.
PATIENCE = 60_000


def something_happens(server: Served) -> None:
    """Write a line into the history, as a command that ends does; every page is built anew."""
    history.add(server.root / HISTORY, history.SAVED, file="raw/other/points.yaml")


class Watched:
    """A page in Chromium that counts clicks and notes every complaint and every request that leaves the server."""

    def __init__(self, browser: Any, server: Served) -> None:
        self.own = f"http://127.0.0.1:{server.port}"
        self.context = browser.new_context(viewport={"width": 1366, "height": 768})
        self.context.set_default_timeout(PATIENCE)
        self.clicks = 0
        self.wrong: list[str] = []
        self.open(f"{self.own}/?token={server.token}")
        self.page.locator(".content h1").wait_for()  # the page that gives the cookie leads on by itself

    def open(self, address: str) -> None:
        """Open an address in a new tab."""
        self.page = self.context.new_page()
        self.page.on(
            "console", lambda m: self.wrong.append(m.text) if m.type in {"error", "warning"} else None
        )
        self.page.on("pageerror", lambda error: self.wrong.append(str(error)))
        self.page.on("request", lambda request: self._asked(request.url))
        self.page.on("websocket", lambda line: self._asked(line.url))
        self.page.goto(address)

    def _asked(self, url: str) -> None:
        own = (f"{self.own}/", f"{self.own.replace('http', 'ws')}/", "data:", f"blob:{self.own}/")
        if not url.startswith(own):
            self.wrong.append(f"asked for {url}")

    def visit(self, path: str) -> None:
        """Go to a page and wait until it is built and its charts are drawn."""
        self.page.goto(f"{self.own}/{path}")
        self.settle()

    def settle(self) -> None:
        """Wait until the page is built and its charts are drawn."""
        self.page.locator(".content:not([aria-busy]) h1").wait_for()
        self.page.wait_for_function(
            "[...document.querySelectorAll('.plot')].every(p => p.querySelector('.main-svg'))"
        )

    def press(self, role: str, name: str) -> None:
        """Click on what has that name."""
        self.page.get_by_role(role, name=name, exact=True).first.click()
        self.clicks += 1

    def see(self, text: str) -> None:
        """Wait for a text."""
        self.page.get_by_text(text).first.wait_for()
