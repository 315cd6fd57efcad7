"""A set of measurement files: what was recognised, the columns mapped with a live picture, and the way to a data set."""

from __future__ import annotations

import asyncio
import csv
from collections.abc import Callable
from functools import partial
from typing import Any

from nicegui import ui

from friction_models.common import InputError
from friction_models.common.files import read_json
from friction_models.common.markup import bullets, table
from sct_twin.ingest.channel_map import ChannelMap
from sct_twin.ingest.point_map import PointMap
from sct_twin.ingest.point_tables import read_point_tables

from .. import history, measuring_commands
from ..commands import Command
from ..map_form import TEST_TABLE, ColumnForm, MapForm, choices, looks_like_records, units_of
from ..raw_figures import columns_figure, loads_figure, preview_row
from ..raw_files import RawSet, free_name, map_text, raw_set, save_map, saved_map
from ..worker import DONE, FAILED
from .bring import bring
from .frame import page_head
from .parts import action, button, choice, empty, gone, heading, line, picture, say, words
from .view import View

#: How long the page waits for the next letter before it looks at the map again [s].
PAUSE = 0.35
#: What is shown of the quality table, of how many tests.
_QUALITY = ("test_id", "sampling_rate_Hz", "duration_s", "speed_mm_s", "sliding_mm", "F_n_sliding_N", "F_n_zero_N", "F_r_zero_N", "mu_mean", "mu_std", "notes")  # fmt: skip
_SHOWN = 30


async def show(view: View, name: str) -> None:
    """Show the page."""
    found = await asyncio.to_thread(raw_set, view.project, name)
    page_head(f"Measurements: {name}")
    ui.link("All measurements", "/measurements")
    if found.first is None:
        empty("Nothing here can be read", found.problem)
        bring(view, "Add files", name)
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
            f"{_count(len(found.files), 'file')} ({found.kinds}), {_count(len(first.frame), 'row')} in the first.",
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
    with ui.expansion("Add files to this set").classes("other"):
        bring(view, "More files", name)


class _Page:
    """The form and what follows from it."""

    def __init__(self, view: View, found: RawSet, form: MapForm) -> None:
        assert found.first is not None
        self.view, self.found, self.form, self.table = view, found, form, found.first
        self.asked = 0
        self.units: dict[str, ui.input] = {}

    def build(self) -> None:
        """Build form, picture and buttons."""
        with ui.element("section").classes("panel"):
            heading("What each column is")
            for column in self.form.columns:
                self._row(column)
            if len(self.table.frame.columns) > len(self.form.columns):
                say(
                    f"The first {len(self.form.columns)} of {len(self.table.frame.columns)} columns are shown.",
                    "soft",
                )
            self._more()
        self.verdict = ui.element("div").props('role="status"')
        self.buttons = ui.element("section")
        if self.form.records:
            _campaign(self.view, self.found.name)
        _data_set(self.view, self.found.name)
        self.pictures = ui.element("div")

    def _row(self, column: ColumnForm) -> None:
        records = self.form.records
        with ui.element("div").classes("maprow"):
            with ui.element("div").classes("mapname"):
                words(f"<strong>{_escaped(column.name)}</strong>")
                say(_range(self.table, column), "soft")
            chosen = choice(
                "is",
                choices(records),
                column.is_ if column.is_ in choices(records) else "",
                partial(self._is, column),
            )
            chosen.props["aria-label"] = f"What {column.name} is"
            unit = self._text(
                "unit",
                column.unit or column.file_unit,
                partial(self._unit, column),
                units_of(column.is_, records),
            )
            unit.classes("short").set_visibility(column.is_ not in {"", "test_id", TEST_TABLE})
            self.units[column.name] = unit
            if not column.number:
                return
            more = "sign, zero reading, scale" if records else "sign, limits"
            with ui.expansion(more).classes("other mapmore"), ui.element("div").classes("choices"):
                if records:
                    choice(
                        "sign", {"1": "+", "-1": "−"}, str(column.sign), partial(self._sign, column)
                    ).classes("short")
                    self._number(
                        "zero reading (in its unit)", column.offset, partial(self._set, column, "offset")
                    )
                    self._text("scale, such as 5 kN/V", column.scale, partial(self._set, column, "scale"))
                    self._number("uncertainty of the cell [N]", column.std, partial(self._set, column, "std"))
                else:
                    choice(
                        "sign", {"1": "+", "-1": "−"}, str(column.sign), partial(self._sign, column)
                    ).classes("short")
                    self._number("only rows from", column.low, partial(self._set, column, "low"))
                    self._number("up to", column.high, partial(self._set, column, "high"))

    def _more(self) -> None:
        form = self.form
        with ui.element("div").classes("choices"):
            if form.records:
                self._number("moving mass [kg]", form.mass, partial(self._set, form, "mass"))
                self._text(
                    "test in the file name: *_{test_id}_*", form.name, partial(self._set, form, "name")
                )
            else:
                self._text(
                    "in the file name: {oil}_{T_tool}C_{test_id}", form.name, partial(self._set, form, "name")
                ).classes("long")
            if form.records:
                self._number("T_tool, the tool [degC]", _degrees(form.metadata), self._tool)
            text = "; ".join(
                f"{k}={v}" for k, v in form.metadata.items() if k != "T_tool" or not form.records
            )
            self._text("all tests share: lubricant=MoS2; bore=15.5", text, self._metadata).classes("long")
        if not form.records:
            return
        stated = form.phases if isinstance(form.phases, dict) else {}
        times = {
            k: list(v) if isinstance(v := stated.get(k), list) and len(v) == 2 else [None, None]
            for k in ("upsetting", "sliding")
        }
        with ui.element("div").classes("choices"):
            for phase, pair in times.items():
                for k, word in enumerate(("from", "to")):
                    self._number(f"{phase} {word} [s]", pair[k], partial(self._time, times, phase, k)).props[
                        "placeholder"
                    ] = "detected"
        say(
            "Empty times are detected: upsetting begins when the load rises, sliding when the plate moves.",
            "soft",
        )

    def _text(
        self, label: str, value: str, changed: Callable[[str], Any], options: list[str] | None = None
    ) -> ui.input:
        made = ui.input(
            label,
            value=value,
            on_change=lambda e: changed(str(e.value or "").strip()),
            autocomplete=options or [],
        )
        made.props("outlined dense").classes("choice")
        return made

    def _number(self, label: str, value: float | None, changed: Callable[[float | None], Any]) -> ui.number:
        made = ui.number(label, value=value, on_change=lambda e: changed(e.value))
        made.props("outlined dense step=any").classes("choice short")
        return made

    async def _is(self, column: ColumnForm, value: str) -> None:
        column.is_ = str(value or "")
        self.units[column.name].set_visibility(column.is_ not in {"", "test_id", TEST_TABLE})
        self.units[column.name].set_autocomplete(units_of(column.is_, self.form.records))
        await self._changed()

    async def _unit(self, column: ColumnForm, value: str) -> None:
        column.unit = "" if value == column.file_unit else value
        await self._changed()

    async def _set(self, target: Any, name: str, value: Any) -> None:
        setattr(target, name, value)
        await self._changed()

    async def _sign(self, column: ColumnForm, value: str) -> None:
        await self._set(column, "sign", int(value))

    async def _metadata(self, text: str) -> None:
        pairs = [p.partition("=") for p in text.split(";") if p.strip()]
        tool = {"T_tool": v} if self.form.records and (v := _degrees(self.form.metadata)) is not None else {}
        self.form.metadata = {**tool, **{k.strip(): _value(v.strip()) for k, _, v in pairs if k.strip()}}
        await self._changed()

    async def _tool(self, value: float | None) -> None:
        rest = {k: v for k, v in self.form.metadata.items() if k != "T_tool"}
        self.form.metadata = rest if value is None else {"T_tool": value, **rest}
        await self._changed()

    async def _time(self, times: dict[str, list[Any]], phase: str, k: int, value: float | None) -> None:
        times[phase][k] = value
        full = {name: list(pair) for name, pair in times.items() if None not in pair}
        self.form.phases = full or "detect"
        await self._changed()

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
                hint = (
                    "Sign, zero reading and scale stand beside each column."
                    if self.form.records
                    else "Rows that do not count can be left out: see sign, limits beside a column."
                )
                say(hint, "soft")
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

    def _try(self) -> tuple[dict[str, Any] | None, list[str] | None, str, list[Any]]:
        row, said, problem, figures = None, None, "", []
        try:
            if self.form.records:
                row = preview_row(self.form, self.table)
            else:
                PointMap.load(self.form.content())
                files = [self.view.project.inside(f) for f in self.found.files]
                found = read_point_tables(files if len(files) <= 20 else files[:1], self.form.content())
                where = "" if len(files) <= 20 else " in the first file"
                said = [f"{found.headline()}{where}.", *found.notes]
                figures = [f for f in [loads_figure(found.dataset.points)] if f is not None]
        except InputError as error:
            problem = _bare(str(error), self)
        drawn = columns_figure(self.form, self.table, row)
        return row, said, problem, [*figures, *([drawn] if drawn else [])]

    def _actions(self, complete: bool) -> None:
        command, look_through = _commands(self.view, self.found, self.form)
        with ui.element("div").classes("buttons action"):
            label = "Take in the records" if self.form.records else "Make the data set"
            made = button(label, partial(self._run, command), "first")
            made.set_enabled(complete)
            button("Save the map", self._save)
            button("Look through all files", partial(self._run, look_through)).set_enabled(complete)
        line(command)
        with ui.expansion("The map as a file").classes("other"):
            words(f"<pre>{_escaped(map_text(self.form.content()))}</pre>")
        last = self.view.worker.last(look_through.arguments)
        if last is not None and last.state in {DONE, FAILED}:
            heading("All files", 3)
            words(f"<pre>{_escaped(chr(10).join(last.lines))}</pre>")

    def _save(self) -> None:
        try:
            (ChannelMap if self.form.records else PointMap).load(self.form.content())
            path = save_map(self.view.project, self.found.place, self.form.records, self.form.content())
        except InputError as error:
            ui.notify(f"Not saved: {error}", type="negative")
            return
        self.view.note(history.SAVED, file=path)
        ui.notify(f"{path} is saved.", type="positive")

    def _run(self, command: Command) -> None:
        path = save_map(self.view.project, self.found.place, self.form.records, self.form.content())
        history.add(self.view.project.root / "history.jsonl", history.SAVED, file=path)
        self.view.worker.start(command)
        self.view.started()


def _commands(view: View, found: RawSet, form: MapForm) -> tuple[Command, Command]:
    """Return the command that takes the files in, and the one that only looks."""
    if form.records:
        return measuring_commands.ingest(found.place, found.name), measuring_commands.ingest(
            found.place, found.name, dry_run=True
        )
    target = found.name
    # A data set whose test table was changed by hand is not replaced.
    if (view.project.root / "data" / target / "earlier").is_dir():
        target = free_name(view.project, "data", target)
    files = [found.place] if len(found.files) > 12 else found.files
    return measuring_commands.points(files, found.place, target), measuring_commands.points(
        files, found.place, target, dry_run=True
    )


def _data_set(view: View, name: str) -> None:
    """Show the way on where a data set came of the files."""
    sets = [s for s in map(view.project.relative, view.project.data_sets()) if s == f"data/{name}"]
    for place in sets:
        with ui.element("section").classes("panel"):
            heading(f"Data set {place}")
            say(
                "Made of these files. Split it into tests to learn from and tests held out, or ask at once.",
                "soft",
            )
            with ui.element("div").classes("buttons"):
                button("Ask what is missing", partial(use, view, place), "first")
                ui.link("Explore", f"/explore?data={place}").classes("button")
                ui.link("Edit the test table", f"/measurements?tests={place}").classes("button")


def use(view: View, place: str) -> None:
    """Take a data set in hand, and go to the question."""
    story = view.story()
    if story.data != place:
        view.choose(place, story.rounds[0].model)
    ui.navigate.to("/")


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _campaign(view: View, name: str) -> None:
    """Show the quality table of the campaign that came of the set, and the twin."""
    place = f"campaigns/{name}"
    folder = view.project.inside(place)
    if not (folder / "quality.csv").is_file():
        return
    with ui.element("section").classes("panel"):
        heading("What was taken in")
        rows = _rows(folder / "quality.csv")
        columns = [c for c in _QUALITY if rows and any(row.get(c) for row in rows)]
        say(f"{len(rows)} tests; {place}/quality.csv holds all columns.", "soft")
        words(
            f'<div class="scroll">{table(columns, [[_short(row.get(c, "")) for c in columns] for row in rows[:_SHOWN]])}</div>'
        )
        left_out = read_json(folder / "campaign.json").get("left_out", [])
        if isinstance(left_out, list) and left_out:
            heading("Left out", 3)
            words(
                bullets(
                    [str(e.get("reason", e)) if isinstance(e, dict) else str(e) for e in left_out[:_SHOWN]]
                )
            )
        ui.link("Edit the test table", f"/measurements?tests={place}").classes("button")
        action(view, measuring_commands.twin(place, name), "Run the digital twin", first=True)
        if (view.project.root / "data" / name / "points.csv").is_file():
            ui.link("The data set", "/measurements").classes("button")


def _rows(file: Any) -> list[dict[str, str]]:
    try:
        with file.open(encoding="utf-8", newline="") as stream:
            return [dict(row) for _, row in zip(range(5000), csv.DictReader(stream), strict=False)]
    except (OSError, UnicodeError, csv.Error):
        return []


def _first(row: dict[str, Any]) -> list[tuple[str, str]]:
    known = {
        "sampling rate [Hz]": "sampling_rate_Hz", "length [s]": "duration_s", "upsetting begins [s]": "upsetting_s",
        "sliding begins [s]": "sliding_s", "sliding ends [s]": "end_s", "sliding distance [mm]": "sliding_mm",
        "speed [mm/s]": "speed_mm_s", "F_n without load, before the test [N]": "F_n_zero_N",
        "F_r without load, before the test [N]": "F_r_zero_N", "F_n while sliding [N]": "F_n_sliding_N", "mean mu": "mu_mean",
        "uncertainty of mu at one point": "mu_std",
    }  # fmt: skip
    found = [(label, row.get(key)) for label, key in known.items()]
    return [
        (label, _shown(value)) for label, value in found if isinstance(value, int | float) and value == value
    ]


def _short(cell: str | None) -> str:
    try:
        return _shown(float(cell or ""))
    except ValueError:
        return (cell or "")[:120]


def _shown(value: float) -> str:
    """Return four digits, and large numbers in full.

    Examples
    --------
    >>> _shown(90012.6), _shown(0.079442), _shown(1e-14)
    ('90013', '0.07944', '1e-14')
    """
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e9 else f"{value:.4g}"


def _range(table: Any, column: ColumnForm) -> str:
    import numpy as np

    unit = f" {column.file_unit}" if column.file_unit else ""
    values, _ = table.numbers(column.name)
    if np.isnan(values).all():
        names = table.frame[column.name].dropna()
        return f"text, such as {str(names.iloc[0])[:40]}" if len(names) else "empty"
    return f"{np.nanmin(values):.4g} to {np.nanmax(values):.4g}{unit}"


def _bare(text: str, page: _Page) -> str:
    """Return a sentence without the paths of this machine, and without the file where it is the one that is shown."""
    source = page.table.source
    return (
        text.removeprefix(f"{source}: ")
        .replace(source, "the first file")
        .replace(f"{page.view.project.root}/", "")
    )


def _escaped(text: str) -> str:
    from friction_models.common.markup import escape

    return escape(text)


def _degrees(metadata: dict[str, Any]) -> float | None:
    value = metadata.get("T_tool")
    return float(value) if isinstance(value, int | float) else None


def _value(text: str) -> Any:
    try:
        return float(text) if "." in text or "e" in text.lower() else int(text)
    except ValueError:
        return text
