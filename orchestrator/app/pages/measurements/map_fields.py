"""The form of a map: what each column of a file is, its unit and sign, and what all tests share."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from nicegui import ui

from friction_models.common.markup import escape
from friction_models.loads.contract import POINT_UNITS
from sct_twin.readers import RawTable

from ...raw.map_form import TEST_TABLE, ColumnForm, MapForm, choices, number, units_of
from ..elements import choice, fold, heading, number_field, say, text_field, words
from ..view import View

#: From so many columns on, those that are not used are folded away.
_MANY = 4


class MapFields:
    """The fields; `changed` is called when one of them has another value."""

    def __init__(
        self, view: View, form: MapForm, table: RawTable, changed: Callable[[], Awaitable[None]]
    ) -> None:
        self.view = view
        self.form, self.table, self._changed = form, table, changed
        self.units: dict[str, ui.input] = {}
        self.limits: dict[str, tuple[ui.number, ui.number]] = {}

    def build(self) -> None:
        """Build a row for each column, and below them what concerns the files."""
        heading("What each column is")
        spare = [c for c in self.form.columns if not c.is_]
        folded = len(spare) >= _MANY and not self.form.records
        for column in self.form.columns:
            if not (folded and column in spare):
                self._row(column)
        if folded:
            names = ", ".join(c.name for c in spare)
            title = f"{len(spare)} columns are not used: {names}"
            with fold(self.view, title, "spare columns", "other spare"):
                for column in spare:
                    self._row(column)
        if len(self.table.frame.columns) > len(self.form.columns):
            say(
                f"The first {len(self.form.columns)} of {len(self.table.frame.columns)} columns are shown.",
                "soft",
            )
        self._more()

    def limit(self, column: str, low: float | None, high: float | None) -> None:
        """Fill in the limits of a column; None leaves one as it is."""
        for field, value in zip(self.limits[column], (low, high), strict=True):
            if value is not None:
                field.set_value(value)

    def _row(self, column: ColumnForm) -> None:
        records = self.form.records
        with ui.element("div").classes("maprow"):
            with ui.element("div").classes("mapname"):
                words(f"<strong>{escape(column.name)}</strong>")
                say(_range(self.table, column), "soft")
            # The framework reads out the label of a choice, so it names the column.
            known = choices(records)
            choice(
                f"{column.name} is",
                known,
                column.is_ if column.is_ in known else "",
                partial(self._is, column),
            )
            stated, units = column.unit or column.file_unit, units_of(column.is_, records)
            unit = self._text("unit", stated, partial(self._unit, column), units)
            unit.props["aria-label"] = f"unit of {column.name}"
            self._assumed(unit, column)
            unit.classes("short").set_visibility(column.is_ not in {"", "test_id", TEST_TABLE})
            self.units[column.name] = unit
            if not column.number:
                return
            more = "sign, zero reading, scale" if records else "sign, limits"
            folded = fold(self.view, more, f"more of {column.name}", "other mapmore")
            with folded, ui.element("div").classes("choices"):
                choice("sign", {"1": "+", "-1": "−"}, str(column.sign), partial(self._sign, column)).classes(
                    "short"
                )
                if records:
                    self._number(
                        "zero reading (in its unit)", column.offset, partial(self._set, column, "offset")
                    )
                    self._text("scale, such as 5 kN/V", column.scale, partial(self._set, column, "scale"))
                    self._number("uncertainty of the cell [N]", column.std, partial(self._set, column, "std"))
                else:
                    self.limits[column.name] = (
                        self._number("rows from", column.low, partial(self._set, column, "low")),
                        self._number("up to", column.high, partial(self._set, column, "high")),
                    )

    def _assumed(self, unit: ui.input, column: ColumnForm) -> None:
        """Show the unit that holds where none is stated; records must state theirs."""
        if not self.form.records:
            unit.props("stack-label").props["placeholder"] = POINT_UNITS.get(column.is_, "")

    def _more(self) -> None:
        form = self.form
        with ui.element("div").classes("choices").style("align-items: flex-start"):
            if form.records:
                self._number("moving mass [kg]", form.mass, partial(self._set, form, "mass"))
                label, example = "test in the file name", "*_{test_id}_*"
            else:
                label, example = "what stands in the file name", "{oil}_{T_tool}C_{test_id}"
            self._example(label, example, form.name, partial(self._set, form, "name"))
            if form.records:
                self._number("T_tool of all tests [degC]", _degrees(form.metadata), self._tool)
            text = "; ".join(
                f"{k}={v}" for k, v in form.metadata.items() if k != "T_tool" or not form.records
            )
            self._example("what all tests share", "lubricant=MoS2; bore=15.5", text, self._metadata)
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
                    self._number(
                        f"{phase} {word} [s]", number(pair[k]), partial(self._time, times, phase, k)
                    ).props["placeholder"] = "detected"
        say(
            "Empty times are detected: upsetting begins when the load rises, sliding when the plate moves.",
            "soft",
        )

    def _text(
        self, label: str, value: str, changed: Callable[[str], Any], options: list[str] | None = None
    ) -> ui.input:
        return text_field(label, value, lambda v: changed(v.strip()), autocomplete=options or [])

    def _example(self, label: str, example: str, value: str, changed: Callable[[str], Any]) -> None:
        """Build a field whose example stands below: inside of it one would take it for what was filled in."""
        text_field(label, value, lambda v: changed(v.strip()), f"such as {example}").classes("long")

    def _number(self, label: str, value: float | None, changed: Callable[[float | None], Any]) -> ui.number:
        return number_field(label, value, changed).props("step=any").classes("short")

    async def _is(self, column: ColumnForm, value: str) -> None:
        column.is_ = str(value or "")
        self.units[column.name].set_visibility(column.is_ not in {"", "test_id", TEST_TABLE})
        self.units[column.name].set_autocomplete(units_of(column.is_, self.form.records))
        self._assumed(self.units[column.name], column)
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


def _range(table: RawTable, column: ColumnForm) -> str:
    unit = f" {column.file_unit}" if column.file_unit else ""
    if not column.number:
        # A column of names is known by its first cells.
        first = table.frame[column.name].dropna().head(1000)
        if len(first) and pd.to_numeric(first, errors="coerce").isna().all():
            return f"text, such as {str(first.iloc[0])[:40]}"
    values, _ = table.numbers(column.name)
    if np.isnan(values).all():
        names = table.frame[column.name].dropna()
        return f"text, such as {str(names.iloc[0])[:40]}" if len(names) else "empty"
    return f"{np.nanmin(values):.4g} to {np.nanmax(values):.4g}{unit}"


def _degrees(metadata: Mapping[str, object]) -> float | None:
    return number(metadata.get("T_tool"))


def _value(text: str) -> Any:
    try:
        return float(text) if "." in text or "e" in text.lower() else int(text)
    except ValueError:
        return text
