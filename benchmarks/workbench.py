"""``python -m benchmarks.workbench``: time to open a million points in the workbench: in Chromium, and step by step without it."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pandas as pd

from friction_models.loads import DataSet
from orchestrator.app.figures.explore import cloud, sample
from orchestrator.app.figures.raw import columns_figure, loads_figure
from orchestrator.app.project import Project
from orchestrator.app.raw.files import raw_set, read_once
from orchestrator.app.raw.map_form import MapForm
from sct_twin.ingest.point_tables import read_point_tables

from .common import Table

T = TypeVar("T")
POINTS, TESTS = 1_000_000, 200


def table_of_points(seed: int = 1) -> pd.DataFrame:
    """Return made-up points of many tests."""
    draw, each = np.random.default_rng(seed), POINTS // TESTS
    return pd.DataFrame(
        {
            "test_id": np.repeat([f"t{k:03d}" for k in range(TESTS)], each),
            "v_rel": np.repeat(draw.uniform(5.0, 500.0, TESTS), each).round(3),
            "T": draw.uniform(20.0, 200.0, POINTS).round(2),
            "sigma_n": draw.uniform(100.0, 900.0, POINTS).round(2),
            "sd": np.tile(np.linspace(0.0, 80.0, each), TESTS).round(4),
            "psi": np.repeat(draw.uniform(0.5, 2.0, TESTS), each).round(3),
            "mu": draw.uniform(0.03, 0.12, POINTS).round(5),
        }
    )


def project_with_points(folder: Path) -> Project:
    """Make a project with a million points as a data set, and as a file that was brought."""
    project = Project.open(folder)
    points = table_of_points()
    for place in ("data/big/points.csv", "raw/big/big.csv"):
        (project.root / place).parent.mkdir()
        points.to_csv(project.root / place, index=False)
    return project


def on_the_server(project: Project) -> Table:
    """Time the steps of the pages Explore and Measurements [s of the processor]."""
    found = Table(["step", "processor time [s]"])

    def step(name: str, work: Callable[[], T]) -> T:
        began = time.process_time()
        result = work()
        found.rows.append((name, f"{time.process_time() - began:.2f}"))
        return result

    data = step("Explore: read the data set", lambda: DataSet.load(project.root / "data/big", need_mu=False))
    drawn = step("Explore: thin", lambda: sample(data))
    step("Explore: draw", lambda: cloud(drawn, "sd", "mu", "v_rel", lines=True))
    raw = step("Map: read the file", lambda: raw_set(project, "big"))
    assert raw.first is not None
    table = raw.first
    form = MapForm.of(table, False, {})
    files = [project.inside(f) for f in raw.files]
    tables = step("Map: make the points", lambda: read_point_tables(files, form.content(), read=read_once))
    step("Map: draw the points", lambda: loads_figure(tables.dataset.points))
    step("Map: draw the columns", lambda: columns_figure(form, table, None))
    return found


def processor_time_below() -> float:
    """Return the processor time of all living processes that this one started, and those that they started [s]; Linux only."""
    parents, used = {}, {}
    for file in Path("/proc").glob("[0-9]*/stat"):
        try:
            words = file.read_text().rpartition(")")[2].split()
        except OSError:  # it has just ended
            continue
        parents[int(file.parent.name)] = int(words[1])
        used[int(file.parent.name)] = (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")

    def is_below(process: int) -> bool:
        while process in parents:
            process = parents[process]
            if process == os.getpid():
                return True
        return False

    return sum(seconds for process, seconds in used.items() if is_below(process))


#: Longest time between two pictures that the browser shows while something is done [ms].
_LONGEST_FRAME = """
async (milliseconds) => {
  let last = performance.now(), longest = 0;
  const end = last + milliseconds;
  while (last < end) {
    const now = await new Promise(requestAnimationFrame);
    longest = Math.max(longest, now - last); last = now;
  }
  return longest;
}
"""


@contextmanager
def opened(project: Project) -> Iterator[Any]:
    """Serve a project, and open it in a new Chromium."""
    from playwright.sync_api import sync_playwright

    from tests.orchestrator.app.chromium import CHROMIUM, Watched
    from tests.orchestrator.app.conftest import served

    serving = served(project.root)
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        tab = Watched(browser, next(serving))
        yield tab
        assert tab.wrong == [], tab.wrong
        browser.close()
    next(serving, None)


def in_chromium(project: Project) -> Table:
    """Time pages from the call of their address until all charts are drawn [s]; each by a server that has read nothing yet.

    The processor time is that of server and browser together, all their threads: about the longest that it takes on a quiet machine.
    """
    found = Table(["in Chromium, until all is drawn", "time [s]", "processor time [s]"])

    def step(name: str, work: Callable[[], object]) -> None:
        began, before = time.perf_counter(), processor_time_below()
        work()
        taken, used = time.perf_counter() - began, processor_time_below() - before
        found.rows.append((name, f"{taken:.2f}", f"{used:.2f}"))

    with opened(project) as tab:
        step("first page (data sets are there, none is read)", lambda: tab.visit(""))
    with opened(project) as tab:
        step("Explore", lambda: tab.visit("explore?data=data/big"))
        step("Explore again", lambda: tab.visit("explore?data=data/big"))
        step("another colour", lambda: _recolour(tab))
        pictures = tab.page.locator(".js-plotly-plot .nsewdrag")
        longest = _while_drawing(tab, pictures.first.bounding_box())
        found.rows.append(
            ("longest standstill while a frame is drawn around points", f"{longest / 1000:.2f}")
        )
        step("points of that frame picked in both pictures", lambda: tab.see("Picked: "))
    with opened(project) as tab:
        step("Measurements", lambda: tab.visit("measurements"))
    with opened(project) as tab:
        step(
            "Measurements, map of the file",
            lambda: (tab.visit("measurements?raw=big"), tab.see(f"{POINTS} points")),
        )
    return found


def _recolour(tab: Any) -> None:
    """Choose another colour, and wait for pictures in it."""
    tab.page.get_by_role("combobox", name="Colour").click()
    tab.page.get_by_role("option", name="psi", exact=True).click()
    tab.page.locator(".js-plotly-plot .cbtitle", has_text="psi").first.wait_for()
    tab.settle()


def _while_drawing(tab: Any, box: dict[str, float]) -> float:
    """Draw a frame around points, and return the longest time between two pictures [ms]."""
    x, y, width, height = (box[k] for k in ("x", "y", "width", "height"))
    tab.page.evaluate(f"window.standstill = ({_LONGEST_FRAME})(2000)")
    tab.page.mouse.move(x + 0.2 * width, y + 0.3 * height)
    tab.page.mouse.down()
    tab.page.mouse.move(x + 0.5 * width, y + 0.7 * height, steps=20)
    tab.page.mouse.up()
    return float(tab.page.evaluate("window.standstill"))


def main() -> None:
    """Measure and print."""
    with tempfile.TemporaryDirectory() as folder:
        project = project_with_points(Path(folder) / "project")
        for table in (in_chromium(project), on_the_server(project)):
            print("\n".join([*table.lines(), ""]), flush=True)


if __name__ == "__main__":
    main()
