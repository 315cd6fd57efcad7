"""Where models miss, as a part of the page Compare: residuals over one load and two; a cell opens its tests, a test its curve."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial

from nicegui import events, ui

from friction_models.common.errors import shown
from friction_models.common.wording import counted
from friction_models.discovery.answer.figures_data import varied
from friction_models.loads.contract import with_unit

from ..figures.residuals import Cell, between, cell_map, cells, curves, models_of, over_loads, points_of
from .elements import button, choice, heading, panel, say
from .report_sections import picture
from .view import View

#: Most cells of the table and most tests of a cell that are shown.
ROWS, TESTS = 8, 40


async def show_residuals(view: View, path: str) -> None:
    """Show where the models of a comparison miss; nothing without the table of points."""
    file = view.project.inside(path)
    if not file.is_file():
        return
    frame = await asyncio.to_thread(points_of, file)
    models, loads = models_of(frame), varied(frame)
    if not loads:
        return
    with ui.element("section"):
        heading("Where the models miss")
        picture(await asyncio.to_thread(over_loads, frame, models))
    kept = view.kept.setdefault("residuals", {})
    chosen: dict[str, str] = {
        "model": kept.get("model", "") if kept.get("model") in models else models[0],
        "first": kept.get("first", "") if kept.get("first") in loads else loads[0],
        "second": kept.get("second", "") if kept.get("second") in loads else loads[min(2, len(loads) - 1)],
    }
    # What is open: a cell by its place, a test by its name.
    opened: dict[str, Cell | str] = {}

    def changed(name: str, value: str) -> None:
        chosen[name] = kept[name] = value
        opened.clear()
        drawn.refresh()

    @ui.refreshable
    def drawn() -> None:
        found = cells(frame, chosen["model"], chosen["first"], chosen["second"])
        figure = cell_map(found, chosen["first"], chosen["second"])

        def pressed(event: events.GenericEventArguments) -> None:
            points = event.args.get("points") if isinstance(event.args, dict) else None
            at = points[0] if isinstance(points, list) and points else {}
            place = (at.get("x"), at.get("y")) if isinstance(at, dict) else None
            cell = next((c for c in found if c.place == place), None)
            if cell is not None:
                open_cell(cell)

        picture(figure, pressed=pressed)
        _table(found, chosen, open_cell)
        inside()

    def open_cell(cell: Cell) -> None:
        opened.clear()
        opened["cell"] = cell
        inside.refresh()

    def open_test(test: str) -> None:
        opened["test"] = test
        inside.refresh()

    @ui.refreshable
    def inside() -> None:
        cell, test = opened.get("cell"), opened.get("test")
        if not isinstance(cell, Cell):
            return
        with panel(f"{counted(len(cell.tests), 'test')}: {_where(cell, chosen)}", 3):
            with ui.element("div").classes("buttons"):
                for name in cell.tests[:TESTS]:
                    button(shown(name, 60), partial(open_test, name), "plain" if name != test else "")
            if len(cell.tests) > TESTS:
                say(f"The first {TESTS} of {len(cell.tests)}.", "soft")
            if isinstance(test, str):
                picture(curves(frame, test, models))
            else:
                say("Press a test to see its curve.", "soft")

    with ui.element("section"):
        heading("Over two loads")
        names = {name: with_unit(name) for name in loads}
        with ui.element("div").classes("choices"):
            choice("Model that is looked at", models, chosen["model"], partial(changed, "model"))
            choice("Across", names, chosen["first"], partial(changed, "first"))
            choice("Up", names, chosen["second"], partial(changed, "second"))
        drawn()


def _where(cell: Cell, chosen: dict[str, str]) -> str:
    sides = zip((chosen["first"], chosen["second"]), cell.bounds, strict=True)
    return ", ".join(dict.fromkeys(f"{with_unit(name)} {between(bounds)}" for name, bounds in sides))


def _table(found: list[Cell], chosen: dict[str, str], open_cell: Callable[[Cell], None]) -> None:
    """Show the cells that are surely off, the worst first; each opens its tests."""
    worst = sorted(found, key=lambda cell: -cell.apart)[:ROWS]
    with ui.element("div").classes("scroll"), ui.element("table").classes("cells"):
        with ui.element("caption"):
            ui.label("Cells that are surely off come first; 95 % intervals over tests.")
        with ui.element("thead"), ui.element("tr"):
            for text in ("cell", "measured − model", "interval", "tests"):
                with ui.element("th").props('scope="col"'):
                    ui.label(text)
        with ui.element("tbody"):
            for cell in worst:
                half = "-" if cell.half != cell.half else f"{cell.mean - cell.half:+.4f} to {cell.mean + cell.half:+.4f}"  # fmt: skip
                with ui.element("tr"):
                    with ui.element("th").props('scope="row"'):
                        button(_where(cell, chosen), partial(open_cell, cell), "plain")
                    for text in (f"{cell.mean:+.4f}", half, str(len(cell.tests))):
                        with ui.element("td"):
                            ui.label(text)
