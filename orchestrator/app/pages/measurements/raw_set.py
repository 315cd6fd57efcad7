"""A set of measurement files: what was recognised, the columns mapped with a live picture, and the way to a data set."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Mapping
from functools import partial
from pathlib import PurePosixPath

from nicegui import ui

from friction_models.common import InputError
from friction_models.common.markup import bullets, escape, table
from friction_models.common.wording import counted
from sct_twin.ingest.channel_map import ChannelMap
from sct_twin.ingest.point_map import PointMap
from sct_twin.ingest.point_tables import read_point_tables
from sct_twin.records.channels import CHANNELS

from ....report.reading import ReadFigure
from ... import commands
from ...commands import Command
from ...figures.raw import columns_figure, loads_figure, preview_row
from ...project import history, is_name
from ...raw.files import RAW, RawSet, free_name, map_text, raw_set, read_once, save_map, saved_map
from ...raw.map_form import MapForm, beyond_limits, looks_like_records
from ...raw.moving import moved_to
from ...work.command_run import DONE, FAILED
from ..elements import button, choice, empty, fold, gone, heading, line, refused, say, words
from ..frame import page_head
from ..report_sections import picture
from ..view import View
from .bring import bring
from .map_fields import MapFields
from .moving import into_own_set, rename_or_put_aside
from .taken_in import came_of, campaign, data_set, rounded

#: What the reader of tables says of a test that stands in two files.
_SAME_TESTS = "allowed: each test in one file"
#: How long the page waits for the next letter before it looks at the map again [s].
PAUSE = 0.35


async def show(view: View, name: str) -> None:
    """Show the page."""
    place = f"{RAW}/{name}"
    if is_name(name) and not (view.project.root / place).exists() and (now := moved_to(view.project, place)):
        _moved(name, now)
        return
    found = await asyncio.to_thread(raw_set, view.project, name)
    page_head(f"Measurements: {name}")
    ui.link("All measurements", "/measurements")
    if found.first is None:
        empty("Nothing here can be read", found.problem)
        bring(view, "Add files", name)
        rename_or_put_aside(view, name)
        return
    first = found.first
    records = view.query.get("as", "") == "records" or (
        view.query.get("as") != "points" and await asyncio.to_thread(looks_like_records, first)
    )
    saved = saved_map(view.project, found.place, records)
    key = f"map of {name} {records}"
    form: MapForm = view.kept.setdefault(key, MapForm.of(first, records, saved))
    with ui.element("section"):
        say(
            f"{counted(len(found.files), 'file')} ({found.kinds}), {counted(len(first.frame), 'row')} in the first.",
            "soft",
        )
        if first.notes:
            words(bullets(first.notes))
        kinds = {
            "records": "records of a tribometer: forces over time",
            "points": "tables of points: loads and mu",
        }
        with ui.element("div").classes("choices"):
            choice(
                "What these files are", kinds, "records" if records else "points",
                lambda v: ui.navigate.to(f"/measurements?raw={name}&as={v}"),
            )  # fmt: skip
    page = _Page(view, found, form)
    page.build()
    await page.look()
    with fold(view, "Add files to this set"):
        bring(view, "More files", name)
    rename_or_put_aside(view, name)


def _moved(name: str, now: str) -> None:
    """Say where a set is that has another name now, as one comes by the button Back of the browser."""
    page_head(f"Measurements: {name}")
    top, _, new = now.partition("/")
    if top == RAW:
        empty("This set has another name", f"It is called {new} now.", (new, f"/measurements?raw={new}"))
    else:
        empty("This set was put aside", "It can be brought back.", ("All measurements", "/measurements"))


class _Page:
    """The form and what follows from it."""

    def __init__(self, view: View, found: RawSet, form: MapForm) -> None:
        assert found.first is not None
        self.view, self.found, self.form, self.table = view, found, form, found.first
        self.asked = 0

    def build(self) -> None:
        """Build form, picture and buttons."""
        # What came of the files stands first: it is the way on.
        self.view.first(*came_of(self.view, self.found.name))
        if self.form.records:
            campaign(self.view, self.found.name)
        data_set(self.view, self.found.name)
        self.fields = MapFields(self.view, self.form, self.table, self._changed)
        with ui.element("section").classes("panel"):
            self.fields.build()
        self.verdict = ui.element("div").props('role="status"')
        self.buttons = ui.element("section")
        self.pictures = ui.element("div")

    async def _changed(self) -> None:
        """Look at the map when nobody types any more."""
        self.asked += 1
        mine = self.asked
        await asyncio.sleep(PAUSE)
        if mine == self.asked:
            await self.look()

    async def look(self) -> None:
        """Show what the map makes of the first file, or what it lacks."""
        asked = self.asked
        row, dataset, problem, figures = await asyncio.to_thread(self._try)
        if asked != self.asked or gone(self.verdict):
            return
        self.verdict.clear()
        with self.verdict:
            if problem:
                say(f"Not complete: {problem}", "problem")
                say(_hint(problem, self.form.records), "soft")
                self._mend(problem)
            elif row is not None:
                words(table(["first file", "found"], _first(row), narrow=True))
            elif dataset is not None:
                say(dataset[0])
                words(bullets(dataset[1:]))
        self.pictures.clear()
        with self.pictures:
            for figure in figures:
                picture(figure)
        self.buttons.clear()
        with self.buttons:
            self._actions(not problem)

    def _mend(self, problem: str) -> None:
        """Offer to leave out the rows whose values cannot be."""
        found = None if self.form.records else beyond_limits(self.form, self.table, problem)
        if found is not None:
            said = f"Leave out {counted(found.rows, 'row')} with {found.column} {found.words}"
            button(said, lambda: self.fields.limit(found.column, found.low, found.high))
        with ui.element("div").classes("buttons"):
            for file in _same_tests(problem, self.found.files):
                said = f"Put {PurePosixPath(file).name} into a set of its own"
                button(said, partial(into_own_set, self.view, file))

    def _try(self) -> tuple[dict[str, object] | None, list[str] | None, str, list[ReadFigure]]:
        row, said, problem = None, None, ""
        figures: list[ReadFigure | None] = []
        try:
            if self.form.records:
                row = preview_row(self.form, self.table)
            else:
                PointMap.load(self.form.content())
                files = [self.view.project.inside(f) for f in self.found.files]
                seen = files if len(files) <= 20 else files[:1]
                found = read_point_tables(seen, self.form.content(), read=read_once)
                where = "" if seen == files else " in the first file"
                said = [f"{found.headline()}{where}.", *found.notes]
                figures.append(loads_figure(found.dataset.points))
        except InputError as error:
            # Without the paths of this machine, and without the file where it is the one that is shown.
            source = self.table.source
            plain = str(error).removeprefix(f"{source}: ").replace(source, "the first file")
            problem = self.view.bare(plain)
        figures.append(columns_figure(self.form, self.table, row))
        return row, said, problem, [f for f in figures if f is not None]

    def _actions(self, complete: bool) -> None:
        command, look_through = _commands(self.view, self.found, self.form)
        with ui.element("div").classes("buttons action"):
            label = "Take in the records" if self.form.records else "Make the data set"
            made = button(label, partial(self._run, command), "first")
            made.set_enabled(complete)
            button("Save the map", self._save)
            button("Look through all files", partial(self._run, look_through)).set_enabled(complete)
        line(command)
        with fold(self.view, "The map as a file"):
            words(f"<pre>{escape(map_text(self.form.content()))}</pre>")
        last = self.view.worker.last(look_through.arguments)
        if last is not None and last.state in {DONE, FAILED}:
            heading("All files", 3)
            words(f"<pre>{escape(chr(10).join(last.lines))}</pre>")

    def _save(self) -> None:
        try:
            (ChannelMap if self.form.records else PointMap).load(self.form.content())
            path = self._keep()
        except InputError as error:
            refused(error, "Not saved: ")
            return
        ui.notify(f"{path} is saved.", type="positive")

    def _keep(self) -> str:
        path = save_map(self.view.project, self.found.place, self.form.records, self.form.content())
        self.view.note(history.SAVED, file=path)
        return path

    def _run(self, command: Command) -> None:
        self._keep()
        self.view.worker.start(command)
        self.view.started()


def _commands(view: View, found: RawSet, form: MapForm) -> tuple[Command, Command]:
    """Return the command that takes the files in, and the one that only looks."""
    if form.records:
        take_in = partial(commands.measuring.ingest, found.place, found.name)
        return take_in(), take_in(dry_run=True)
    target = found.name
    # A data set whose test table was changed by hand is not replaced.
    if (view.project.root / "data" / target / "earlier").is_dir():
        target = free_name(view.project, "data", target)
    files = [found.place] if len(found.files) > 12 else found.files
    make = partial(commands.measuring.points, files, found.place, target)
    return make(), make(dry_run=True)


def _same_tests(problem: str, files: list[str]) -> list[str]:
    """Return the two files of a set that hold the same tests, as a summary does; none for another problem.

    Examples
    --------
    >>> said = "raw/oil/all.csv: test 'a' stands in mean.csv, too; allowed: each test in one file"
    >>> _same_tests(said, ["raw/oil/all.csv", "raw/oil/mean.csv", "raw/oil/more.csv"])
    ['raw/oil/all.csv', 'raw/oil/mean.csv']
    """
    told = re.search(rf"test '.*' stands in (.+), too; {_SAME_TESTS}", problem)
    return [f for f in files if told and (problem.startswith(f"{f}: ") or PurePosixPath(f).name == told[1])]


def _hint(problem: str, records: bool) -> str:
    """Return where on the page it can be mended.

    Examples
    --------
    >>> _hint("channel map: quantity 'F_r' is mapped 0 times; allowed: exactly once", True)
    'Say above which column is F_r: force that drives the plate.'
    """
    if _SAME_TESTS in problem:
        return "The files of a set are tables of the same kind, with other tests in each."
    if not records:
        return "Rows that do not count can be left out: see sign, limits beside a column."
    if told := re.search(r"quantity '(\w+)' is mapped (\d+) times", problem):
        name, meaning = told[1], CHANNELS[told[1]].meaning if told[1] in CHANNELS else "a channel"
        if told[2] == "0":
            return f"Say above which column is {name}: {meaning}."
        return f"Leave one column as {name}: {meaning}; set the others to not used."
    if "'T_tool'" in problem:
        return "T_tool stands below the columns: the temperature of the tool in all these tests. A file tests.csv can name one for each."
    return "Sign, zero reading and scale stand beside each column."


def _first(row: Mapping[str, object]) -> list[tuple[str, str]]:
    known = {
        "sampling rate [Hz]": "sampling_rate_Hz", "length [s]": "duration_s", "upsetting begins [s]": "upsetting_s",
        "sliding begins [s]": "sliding_s", "sliding ends [s]": "end_s", "sliding distance [mm]": "sliding_mm",
        "speed [mm/s]": "speed_mm_s", "F_n without load, before the test [N]": "F_n_zero_N",
        "F_r without load, before the test [N]": "F_r_zero_N", "F_n while sliding [N]": "F_n_sliding_N", "mean mu": "mu_mean",
        "uncertainty of mu at one point": "mu_std",
    }  # fmt: skip
    found = [(label, row.get(key)) for label, key in known.items()]
    return [
        (label, rounded(value)) for label, value in found if isinstance(value, int | float) and value == value
    ]
