"""The test table of a data set or campaign: cells are changed in place, or many at once; the command line is shown."""

from __future__ import annotations

import asyncio
import re
from functools import partial

from nicegui import events, ui

from friction_models.common import InputError
from friction_models.loads.tests_table import TableOfTests

from ... import commands
from ...commands import Command
from ..elements import button, choice, line, say, text_field
from ..frame import page_head
from ..view import View
from . import taken_in

#: Columns that are often wanted, with what stands in them.
_USUAL = {
    "role": ["train", "test"],
    "batch": [],
    "lubricant": [],
    "tool_id": [],
    "Ra": [],
    "T_tool": [],
    "bore": [],
}
#: Largest number of single changes in one command line.
MOST_CHANGES = 400


async def show(view: View, place: str) -> None:
    """Show the page."""
    folder = view.project.inside(place)
    if place.split("/")[0] not in {"data", "campaigns", "raw"}:
        raise InputError(f"{place}: no place of a test table; allowed: a folder in data, campaigns or raw")
    if folder.is_file():
        raise InputError(
            f"{place}: a single file has no test table; allowed: a data set that is a folder, as the page Measurements makes"
        )
    found = await asyncio.to_thread(TableOfTests.load, folder)
    page_head(
        f"Test table of {place}",
        "What is known of each test. role says which tests a model may learn from (train) and which are held out (test).",
    )
    ui.link("All measurements", "/measurements")
    _Editor(view, place, found).build()


class _Editor:
    """The table and the changes that are not saved yet."""

    def __init__(self, view: View, place: str, found: TableOfTests) -> None:
        self.view, self.place, self.found = view, place, found
        key = f"changes of {place}"
        kept: tuple[TableOfTests, dict[tuple[str, str], str]] = view.kept.get(key, (found, {}))
        # What was typed holds for the table that was there, and not for one that was saved since.
        self.changes = kept[1] if kept[0].rows == found.rows else {}
        view.kept[key] = found, self.changes
        self.column, self.value, self.which = "role", "", "*"

    def build(self) -> None:
        """Build grid, fields and buttons."""
        # Every table gets a column to hold tests out, even one that has none yet.
        names = list(dict.fromkeys([*self.found.columns, "role"]))
        # Fields of the grid have names of our own: a heading of a file is shown and never evaluated.
        self.fields = {f"c{k}": name for k, name in enumerate(names)}
        rows = self._rows(self.found)
        with ui.element("section"):
            say("Click twice into a cell, or press Enter there, to change it; or change many below.", "soft")
            self.grid = ui.aggrid(
                {
                    "columnDefs": [_column(field, name) for field, name in self.fields.items()],
                    "rowData": rows,
                    "stopEditingWhenCellsLoseFocus": True,
                    "singleClickEdit": False,
                    # One stop for Tab: arrows go from cell to cell. In a cell that is being changed Tab goes to the next.
                    ":tabToNextCell": "(e) => e.editing ? e.nextCellPosition : false",
                    ":tabToNextHeader": "() => false",
                },
                auto_size_columns=False,
            )
            self.grid.classes("grid").style(f"height: {min(460, 60 + 43 * len(rows))}px")
            self.grid.on("cellValueChanged", self._cell, args=["data", "colId", "newValue", "value"])
        with ui.element("div").classes("choices"):
            known = list(dict.fromkeys([*_USUAL, *(n for n in names if n != "test_id")]))
            choice(
                "Column, or a new one",
                known,
                "role",
                self._choose,
                with_input=True,
                new_value_mode="add-unique",
            )
            self.field = text_field(
                "Value; empty clears", "", partial(self._set, "value"), autocomplete=_USUAL["role"]
            )
            text_field("Tests: * is any text", "*", partial(self._set, "which"))
            button("Set", self._many)
        self.status = ui.element("div").props('role="status"')
        self.foot = ui.element("div")
        self._refresh()

    def _rows(self, table: TableOfTests) -> list[dict[str, str]]:
        return [{f: cells.get(n, "") for f, n in self.fields.items()} for cells in table.cells()]

    def _set(self, name: str, value: str) -> None:
        setattr(self, name, value.strip())

    def _choose(self, value: object) -> None:
        self.column = str(value or "").strip()
        self.field.set_autocomplete(_USUAL.get(self.column, []))

    def _cell(self, event: events.GenericEventArguments) -> None:
        """Note a cell that was changed in the grid."""
        said = event.args if isinstance(event.args, dict) else {}
        data = said.get("data")
        test = (data if isinstance(data, dict) else {}).get(
            next(f for f, n in self.fields.items() if n == "test_id")
        )
        column = self.fields.get(str(said.get("colId")))
        if isinstance(test, str) and column:
            value = said.get("newValue")
            self._note([(test, column, "" if value is None else str(value))])

    def _many(self) -> None:
        form = re.compile(".*".join(map(re.escape, (self.which or "*").split("*"))))
        hits = [test for test in self.found.tests if form.fullmatch(test)]
        if not hits:
            ui.notify(f"No test is called {self.which!r}.", type="negative")
            return
        self._note([(self.which or "*", self.column, self.value)])

    def _note(self, changes: list[tuple[str, str, str]]) -> None:
        wanted = {**self.changes}
        for test, column, value in changes:
            # A later change of the same cells counts, and stands behind what it changes.
            wanted.pop((test, column), None)
            wanted[test, column] = value
        try:
            self.found.changed([(t, c, v) for (t, c), v in wanted.items()])
        except InputError as error:
            ui.notify(self.view.bare(str(error)), type="negative")
            return
        if len(wanted) > MOST_CHANGES:
            ui.notify(f"Save first: at most {MOST_CHANGES} changes at once.", type="negative")
            return
        self.changes.clear()
        self.changes.update(wanted)
        self._refresh()

    def _refresh(self) -> None:
        self.status.clear()
        self.foot.clear()
        if not self.changes:
            if self.place.startswith("data/"):
                with self.foot, ui.element("div").classes("buttons action"):
                    button("Ask what is missing", partial(taken_in.ask, self.view, self.place), "first")
                    ui.link("Explore", f"/explore?data={self.place}").classes("button")
            return
        triples = [(t, c, v) for (t, c), v in self.changes.items()]
        changed = self.found.changed(triples)
        command = commands.measuring.edit_tests(self.place, triples)
        with self.status:
            say(f"Not saved yet: {self.found.difference(changed)}.")
            if {cells.get("role", "").strip() for cells in changed.cells()} == {"test"}:
                say("All tests are held out: models have nothing to learn from.", "problem")
        with self.foot:
            with ui.element("div").classes("buttons action"):
                button("Save the table", partial(self._save, command), "first")
                button("Forget the changes", ui.navigate.reload)
            line(command)
            say("The table before is kept in the folder earlier beside it.", "soft")
        self._draw(changed)

    def _save(self, command: Command) -> None:
        self.view.worker.start(command)
        self.view.started()

    def _draw(self, changed: TableOfTests) -> None:
        """Show the changed cells in the grid, with columns that are new."""
        for name in changed.columns:
            if name not in self.fields.values():
                field = f"c{len(self.fields)}"
                self.fields[field] = name
                self.grid.options["columnDefs"].append(_column(field, name))
        rows = self._rows(changed)
        if rows != self.grid.options["rowData"]:
            self.grid.options["rowData"] = rows
            self.grid.update()


def _column(field: str, name: str) -> dict[str, object]:
    """Return a column of the grid; the names of the tests stay in sight and as they are."""
    is_name = name == "test_id"
    return {
        "field": field, "headerName": name, "editable": not is_name, "sortable": True, "filter": True, "resizable": True,
        "minWidth": 110, **({"pinned": "left"} if is_name else {}),
    }  # fmt: skip
