"""In Chromium: names of the pages on a phone, and what is there at once when something takes long."""

from __future__ import annotations

from typing import Any

import pytest

from orchestrator.report.charts.diagnosis import budget_chart
from orchestrator.report.parts.page import Page

from .chromium import CHROMIUM, Watched
from .conftest import Served

pytest.importorskip("nicegui", reason="the extra [app] is not installed")
pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
pytestmark = [
    pytest.mark.nightly,  # by day Chromium starts for `test_browser` alone
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium (Debian package chromium)"),
]


def test_on_a_phone_the_names_of_the_pages_are_one_line(browser: Any, server: Served) -> None:
    tab = Watched(browser, server)
    tab.page.set_viewport_size({"width": 390, "height": 844})
    for path in ("measurements", "compare", "reports"):
        tab.visit(path)
        names = tab.page.locator("nav a")
        tops = {round(names.nth(k).bounding_box()["y"]) for k in range(names.count())}
        assert len(tops) == 1 and names.count() == 7
        # That of this page is in sight.
        here = tab.page.locator("nav .here").bounding_box()
        assert here["x"] >= 0 and here["x"] + here["width"] <= 390, path
        assert tab.page.evaluate("document.documentElement.scrollWidth") <= 390
    assert tab.wrong == []


@pytest.fixture
def report(server: Served) -> str:
    """The path of a report with a chart."""
    page = Page("Stribeck effect is missing", "tribofmu diagnosis", "What was found.")
    page.plot("budget", "Error budget", budget_chart(0.004, 0.005, 0.0, True), "Words below.", "Bars.")
    (server.root / "reports/diagnosis-sct-linear.html").write_text(page.render())
    return "reports/diagnosis-sct-linear.html"


def test_what_opens_a_new_tab_says_so_at_once(browser: Any, server: Served, report: str) -> None:
    tab = Watched(browser, server)
    tab.visit("reports")
    link = tab.page.get_by_role("link", name="diagnosis sct linear")
    with tab.context.expect_page() as opened:
        link.click()
    tab.page.get_by_text("Opening in a new tab ...").wait_for()
    opened.value.get_by_text("What was found.").wait_for()
    opened.value.close()
    # Who is back finds the link as it was.
    tab.page.evaluate("document.dispatchEvent(new Event('visibilitychange'))")
    link.wait_for()
    assert tab.wrong == []


def test_the_words_of_a_report_do_not_wait_for_its_pictures(
    browser: Any, server: Served, report: str
) -> None:
    tab = Watched(browser, server)
    tab.page.add_init_script(
        "const next = requestAnimationFrame; requestAnimationFrame = (f) => { window.go = () => next(f) }"
    )
    tab.page.goto(f"{tab.own}/page/{report}")
    tab.see("What was found.")
    tab.see("Words below.")
    assert tab.page.locator(".main-svg").count() == 0
    tab.page.evaluate("go()")
    tab.page.locator(".main-svg").first.wait_for()
    # Bars from 0 to 100 %: both ends are named.
    names = tab.page.locator(".xtick text").evaluate_all(
        "all => all.filter(e => e.checkVisibility({opacityProperty: true})).map(e => e.textContent)"
    )
    assert (names[0], names[-1]) == ("0 %", "100 %")
    assert tab.wrong == []
