"""What came of a set of measurement files: the campaign with its quality table, the data set and the way on."""

from __future__ import annotations

import csv
from functools import partial
from pathlib import Path

from nicegui import ui

from friction_models.common.files import read_json
from friction_models.common.markup import bullets, table

from ... import commands
from ...project.project import changed
from ..elements import action, button, heading, panel, say, words
from ..view import View

#: What is shown of the quality table, of how many tests.
_QUALITY = ("test_id", "sampling_rate_Hz", "duration_s", "speed_mm_s", "sliding_mm", "F_n_sliding_N", "F_n_zero_N", "F_r_zero_N", "mu_mean", "mu_std", "notes")  # fmt: skip
_SHOWN = 30


def data_set(view: View, name: str) -> None:
    """Show the way on where a data set came of the files."""
    place = f"data/{name}"
    if place not in view.data_sets():
        return
    with panel(f"Data set {place}"):
        say(
            "Made of these files. Ask at once, or first say in the test table which tests are held out (column role).",
            "soft",
        )
        with ui.element("div").classes("buttons"):
            button("Ask what is missing", partial(ask, view, place), "first")
            ui.link("Explore", f"/explore?data={place}").classes("button")
            ui.link("Edit the test table", f"/measurements?tests={place}").classes("button")


def came_of(view: View, name: str) -> list[float]:
    """Return when each file was written that tells of what came of a set."""
    files = (view.project.root / f for f in (f"campaigns/{name}/quality.csv", f"data/{name}/points.csv"))
    return [changed(f) for f in files if f.is_file()]


def ask(view: View, place: str) -> None:
    """Take a data set in hand, and ask what the model in hand is missing there."""
    use(view, place)
    view.run(commands.models.diagnose(place, view.story().model))


def use(view: View, place: str) -> None:
    """Take a data set in hand, and go to the question."""
    view.take_in_hand(place)
    ui.navigate.to("/")


def campaign(view: View, name: str) -> None:
    """Show the quality table of the campaign that came of the set, and the twin."""
    place = f"campaigns/{name}"
    folder = view.project.inside(place)
    if not (folder / "quality.csv").is_file():
        return
    with panel("What was taken in"):
        rows = _rows(folder / "quality.csv")
        columns = [c for c in _QUALITY if rows and any(row.get(c) for row in rows)]
        say(f"{len(rows)} tests; {place}/quality.csv holds all columns.", "soft")
        cells = [[_short(row.get(c, "")) for c in columns] for row in rows[:_SHOWN]]
        if columns:
            words(f'<div class="scroll">{table(columns, cells)}</div>')
        left_out = read_json(folder / "campaign.json").get("left_out", [])
        if isinstance(left_out, list) and left_out:
            heading("Left out", 3)
            words(bullets(str(e.get("reason", e) if isinstance(e, dict) else e) for e in left_out[:_SHOWN]))
        ui.link("Edit the test table", f"/measurements?tests={place}").classes("button")
        action(view, commands.measuring.twin(place, name), "Run the digital twin", first=True)
        if (view.project.root / "data" / name / "points.csv").is_file():
            ui.link("The data set", "/measurements").classes("button")


def _rows(file: Path) -> list[dict[str, str]]:
    try:
        with file.open(encoding="utf-8", newline="") as stream:
            return [dict(row) for _, row in zip(range(5000), csv.DictReader(stream), strict=False)]
    except (OSError, UnicodeError, csv.Error):
        return []


def _short(cell: str | None) -> str:
    try:
        return rounded(float(cell or ""))
    except ValueError:
        return (cell or "")[:120]


def rounded(value: float) -> str:
    """Return four digits, and large numbers in full.

    Examples
    --------
    >>> rounded(90012.6), rounded(0.079442), rounded(1e-14)
    ('90013', '0.07944', '1e-14')
    """
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e9 else f"{value:.4g}"
