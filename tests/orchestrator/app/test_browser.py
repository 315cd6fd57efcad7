"""The whole loop in a real browser, from the example to the FMU, with nothing but the page."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from friction_models.loads import DataSet
from orchestrator.app.project import HISTORY, history
from orchestrator.cli.main import run

from .chromium import CHROMIUM, Watched, something_happens
from .conftest import NETWORK_OFF, Served, shorter_example

pytest.importorskip("nicegui", reason="the extra [app] is not installed")
pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium (Debian package chromium)")
#: Between them they have every kind of field, a chart, a grid and tables.
DAILY = ("", "explore")
NIGHTLY = (
    "measurements?raw=oil",
    "measurements?tests=data/sct",
    "compare",
    "forming",
    "fmu",
    "measurements",
    "reports",
    "measurements?raw=rig",
)


@pytest.mark.slow
@pytest.mark.parametrize("again", [False, pytest.param(True, id="and in a shell", marks=pytest.mark.nightly)])
def test_from_the_example_to_the_fmu_in_six_clicks(
    browser: Any, server: Served, tmp_path: Path, again: bool
) -> None:
    tab = Watched(browser, server)
    tab.press("button", "Ask what is missing")
    tab.see("Cancel")
    # The command goes on without the tab.
    tab.page.close()
    tab.open(tab.own)
    tab.see("linear: Stribeck effect is missing")
    tab.press("button", "Add stribeck")
    tab.see("Before and after: stribeck added")
    assert "fell by" in tab.page.locator(".panel .card .fell").first.inner_text()
    tab.press("button", "Accept")
    tab.see("The rounds so far")
    tab.page.locator(".panel .textpoint").first.wait_for()
    steps = tab.page.locator(".panel .textpoint").all_text_contents()
    assert len(steps) == 2 and float(steps[1]) < 0.75 * float(steps[0])
    tab.press("link", "Take it away as an FMU")
    tab.press("button", "Pack as FMU")
    tab.see("linear-stribeck.fmu")
    with tab.page.expect_download() as kept:
        tab.press("link", "Download")
    assert tab.clicks <= 6
    fmu = tmp_path / "kept.fmu"
    kept.value.save_as(fmu)
    with zipfile.ZipFile(fmu) as archive:
        assert "modelDescription.xml" in archive.namelist()
    assert tab.wrong == []
    if again:
        _same_in_a_shell(server.root, fmu, tmp_path)


def _same_in_a_shell(root: Path, fmu: Path, place: Path) -> None:
    """Run the lines of the history again elsewhere, and compare all files that they name."""
    again = shorter_example(place / "again").root
    lines = [e["command"] for e in history.read(root / HISTORY) if e["event"] == "ended"]
    assert [line.split()[1] for line in lines] == ["diagnose", "refine", "pack"]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(again)
        for line in lines:
            assert run(shlex.split(line)[1:]) == 0
    folders = ("reports", "models", "fmus")
    made = {p.relative_to(root) for f in folders for p in (root / f).rglob("*") if p.is_file()}
    assert len(made) > 7
    assert {p.relative_to(again) for f in folders for p in (again / f).rglob("*") if p.is_file()} == made
    assert [p for p in sorted(made) if (root / p).read_bytes() != (again / p).read_bytes()] == []
    assert fmu.read_bytes() == (again / "fmus/linear-stribeck.fmu").read_bytes()


_BRIGHT = """
[...document.querySelectorAll('.js-plotly-plot .scatterlayer, .js-plotly-plot .barlayer, .js-plotly-plot .legend .traces')]
  .filter((e) => e.childElementCount).map((e) => getComputedStyle(e).filter)
"""


@pytest.mark.slow
@pytest.mark.parametrize("paths", [DAILY, pytest.param(NIGHTLY, marks=pytest.mark.nightly)], ids=len)
def test_no_page_is_hard_to_read_or_to_reach(browser: Any, server: Served, paths: Sequence[str]) -> None:
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed").Axe()
    tab = Watched(browser, server)
    tab.page.emulate_media(reduced_motion="reduce")

    def serious(charts: bool = False, **options: Any) -> list[Any]:
        # The inside of a chart costs axe many times as long as all the rest, and says nothing: to a reader a chart is one picture.
        context = None if charts else {"exclude": [[".js-plotly-plot"]]}
        options["resultTypes"] = ["violations"]  # what passes is not described
        if tab.page.evaluate("window.axe === undefined"):
            found = axe.run(tab.page, context=context, options=options).response["violations"]
        else:
            run_ = "async ([context, options]) => (await axe.run(context ?? document, options)).violations"
            found = tab.page.evaluate(run_, [context, options])
        return [(v["id"], v["nodes"][0]["html"]) for v in found if v["impact"] in {"serious", "critical"}]

    (server.root / "raw/oil").mkdir(exist_ok=True)
    (server.root / "raw/oil/oil.csv").write_text(
        "test,v_mm_s,mu\n" + "".join(f"t{k},{k},0.{50 - k}\n" for k in range(9))
    )
    (server.root / "raw/rig").mkdir(exist_ok=True)
    (server.root / "raw/rig/rig1.csv").write_text(
        "t [s],F_n [kN],F_r [kN]\n" + "".join(f"{k},{9 * k},{k}\n" for k in range(9))
    )
    for path in paths:
        tab.context.add_cookies([{"name": "tribofmu-look", "value": "light", "url": tab.own}])
        tab.visit(path)
        _walk(tab)
        if path == "explore":
            # Thousands of points more would be looked at one by one.
            tab.page.get_by_label("Part of a test name").fill("sct00")
            tab.see("of 4 tests")
            tab.settle()
        assert serious(charts=path == "explore") == [], path
        tab.press("button", "Look: light")
        tab.page.locator("body.body--dark").wait_for()
        assert serious(runOnly=["color-contrast"]) == [], ("dark", path)
        # Curves have the colours of the legend.
        assert set(tab.page.evaluate(_BRIGHT)) <= {"brightness(1.3)"}, path
        tab.page.evaluate(
            "document.querySelectorAll('.q-expansion-item--collapsed > * > .q-item').forEach(e => e.click())"
        )
        # Nothing sticks out at the side, also on a phone, and of what was folded.
        for width in (1366, 390):
            tab.page.set_viewport_size({"width": width, "height": 768})
            assert tab.page.evaluate("document.documentElement.scrollWidth") <= width, path
            assert tab.page.evaluate(_STICKS_OUT) == [], (path, width)
        tab.page.set_viewport_size({"width": 1366, "height": 768})
    assert tab.wrong == []


def _walk(tab: Watched) -> None:
    """Go through a page by Tab: first past the names of the pages, then to all that can be pressed or filled in."""
    assert tab.page.evaluate("document.activeElement === document.body")
    tab.page.evaluate(_NOTES)
    tab.page.keyboard.press("Tab")
    assert tab.page.evaluate("document.activeElement.className") == "skip"
    left = f"[...document.querySelectorAll('{_REACHABLE}')].filter(lacks)"
    # Where all is reached with as many stops as there are, no place holds the focus. What the page builds anew meanwhile
    # is met on another round.
    for _ in range(3):
        for _ in range(tab.page.evaluate(f"{left}.length") + 3):
            tab.page.keyboard.press("Tab")
        if tab.page.evaluate(f"{left}.length") == 0:
            break
    assert tab.page.evaluate("stops.unseen") == [], tab.page.url
    assert tab.page.evaluate(f"{left}.map(e => e.outerHTML.slice(0, 200))") == [], tab.page.url


#: Buttons and command lines that are wider than what they stand in.
_STICKS_OUT = """
[...document.querySelectorAll('.action, .line, .maprow')].filter(
  (e) => e.getBoundingClientRect().right > e.parentElement.getBoundingClientRect().right + 1
).map((e) => e.innerText)
"""
#: What Tab must reach; a grid is one stop, in which arrows go from cell to cell.
_REACHABLE = 'button, a[href], input, [tabindex="0"]'
#: Notes each stop, and those whose focus nobody sees: neither outlined nor a field that is marked.
_NOTES = """
window.stops = {reached: new Set(), unseen: []};
window.lacks = (e) => {
  const place = e.getBoundingClientRect();
  const shown = place.width && place.height && getComputedStyle(e).visibility !== 'hidden';
  // The crosses of chips can be reached while their field has the focus: they stand before it, for Shift and Tab.
  const beside = e.closest('.ag-root-wrapper') || e.matches('.q-chip__icon--remove');
  return shown && !e.disabled && !beside && !stops.reached.has(e);
};
document.addEventListener('focusin', (event) => {
  const e = event.target, place = e.getBoundingClientRect(), style = getComputedStyle(e);
  stops.reached.add(e);
  const field = e.closest('.q-field'), grid = e.closest('.ag-root-wrapper');
  const outlined = style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) > 0;
  const inside = place.width && place.height && place.bottom > 0 && place.top < innerHeight;
  if (!grid && !(inside && (outlined || field))) stops.unseen.push(e.outerHTML.slice(0, 200));
});
"""


@pytest.mark.nightly  # by day `test_measuring_pages` in the simulated browser
def test_a_file_is_brought_and_mapped_through_the_page(browser: Any, server: Served, tmp_path: Path) -> None:
    file = tmp_path / "own tests.csv"
    file.write_text("run,v_m_s,COF\n" + "".join(f"t{k},{10 + k},0.0{5 + k % 4}\n" for k in range(12)))
    tab = Watched(browser, server)
    tab.visit("measurements")
    with tab.page.expect_file_chooser() as chooser:
        tab.press("button", "Choose files")
    chooser.value.set_files(file)
    tab.see("What each column is")
    assert (server.root / "raw/own-tests/own-tests.csv").read_bytes() == file.read_bytes()
    tab.see("12 tests, 12 points")
    # Who pressed far below is led to what came of it.
    tab.page.set_viewport_size({"width": 1366, "height": 400})
    tab.press("button", "Make the data set")
    assert tab.page.evaluate("scrollY") > 100
    tab.page.get_by_role("heading", name="Data set data/own-tests").wait_for()
    tab.page.wait_for_function("scrollY === 0")
    points = DataSet.load(server.root / "data/own-tests").points
    assert points["v_rel"].tolist() == [1000.0 * (10 + k) for k in range(12)]
    assert tab.wrong == []


@pytest.mark.nightly  # by day `test_measuring_pages` in the simulated browser
def test_what_is_picked_in_one_picture_is_picked_in_all(browser: Any, server: Served) -> None:
    tab = Watched(browser, server)
    tab.page.goto(f"{tab.own}/explore?data=data/sct")
    tab.page.locator(".js-plotly-plot .points").nth(1).wait_for(state="attached")
    box = tab.page.locator(".js-plotly-plot .nsewdrag").first.bounding_box()
    tab.page.mouse.move(box["x"] + 0.2 * box["width"], box["y"] + 0.3 * box["height"])
    tab.page.mouse.down()
    tab.page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.6 * box["height"], steps=4)
    tab.page.mouse.up()
    tab.see("Picked: ")
    # Both pictures mark the same points: all those of the tests with a point in the frame.
    marked = tab.page.evaluate(
        "[...document.querySelectorAll('.js-plotly-plot')].map(p => p._fullData.filter(t => t.customdata)"
        ".map(t => [...new Set(t.selectedpoints.map(k => t.customdata[k]))].sort().join()))"
    )
    assert marked[0] == marked[1] and marked[0][0]
    counts = tab.page.evaluate(
        "[...document.querySelectorAll('.js-plotly-plot')].map(p => p._fullData.find(t => t.customdata).selectedpoints.length)"
    )
    tests = len(marked[0][0].split(","))
    assert counts == [24 * tests] * 2 and 0 < tests < 55
    assert tab.wrong == []


def test_a_request_that_leaves_the_machine_fails_and_is_noted(
    browser: Any, server: Served, tmp_path: Path
) -> None:
    """Says that the other tests would see one: all of them run with the network off, and none is tried."""
    from playwright.sync_api import Error

    tab = Watched(browser, server)
    fetched = "fetch('http://example.org/').then(() => 'came', () => 'failed')"
    assert tab.page.evaluate(fetched) == "failed" and "http://example.org/" in tab.wrong[0]
    with pytest.raises(Error, match="ERR_NAME_NOT_RESOLVED"):
        tab.page.goto("http://example.net/")
    assert any(text == "asked for http://example.net/" for text in tab.wrong)
    assert tab.context.request.get(f"{tab.own}/files/project.yaml").ok
    tried = tmp_path / "tried"
    script = "import socket; socket.create_connection(('192.0.2.1', 80), 1)"
    off = {"PYTHONPATH": str(NETWORK_OFF), "TRIBOFMU_TRIED": str(tried)}
    said = subprocess.run(
        [sys.executable, "-c", script], env={**os.environ, **off}, capture_output=True, text=True
    )
    assert "the network is off: 192.0.2.1" in said.stderr and "192.0.2.1" in tried.read_text()


def test_a_report_opened_as_a_page_draws_and_reaches_nothing(browser: Any, server: Served) -> None:
    (server.root / "reports/curious.html").write_text(
        "<p id=said>nothing</p><script>let said = document.getElementById('said');"
        "try { said.textContent = document.cookie || 'empty' } catch (e) { said.textContent = 'no cookie' }"
        "fetch('/files/project.yaml').then(() => said.textContent += ', but files').catch(() => said.textContent += ', no files')"
        "</script>"
    )
    tab = Watched(browser, server)
    tab.page.goto(f"{tab.own}/page/reports/curious.html")
    tab.page.get_by_text(re.compile("files")).wait_for()
    assert tab.page.locator("#said").inner_text() == "no cookie, no files"


@pytest.mark.nightly
def test_what_was_unfolded_stays_unfolded(browser: Any, server: Served) -> None:
    tab = Watched(browser, server)
    tab.visit("forming")
    unfolded = tab.page.locator(".nicegui-expansion-content table").first
    tab.page.get_by_text("What the parameters mean").click()
    unfolded.wait_for()
    tab.page.evaluate("document.querySelector('.content h1').id = 'old'")
    something_happens(server)
    tab.page.wait_for_function("!document.getElementById('old')")
    tab.settle()
    unfolded.wait_for()
    assert tab.wrong == []
