"""`story`: what was done in a project and what came of it, on one page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from friction_models.common import InputError

from ..common.console import note, write_page
from ..common.files_named import Commands, Writes

app = Commands(rich_markup_mode="rich")


@app.command(epilog="Example: tribofmu story my-project -o my-project/reports/story.html")
def story(
    # A text and no path: the page may lie in the project that it tells about.
    project: Annotated[str, typer.Argument(help="Project folder of the workbench.")] = ".",
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--out",
            help="File to write: .html, .pdf or .xlsx (default: reports/story.html in the project).",
        ),
        Writes(),
    ] = None,
) -> None:
    """Write the story of a project as one self-contained page: measurements, models, rounds, FMUs, forming runs."""
    from ...app.story import story_of
    from ...report.writing import check_page_file

    folder = Path(project)
    if not folder.is_dir():
        raise InputError(f"{project}: no such folder; allowed: a project of the workbench (tribofmu app)")
    target = folder / "reports" / "story.html" if out is None else out
    check_page_file(target)
    told = story_of(folder)
    for text in told.problems:
        note(text)
    write_page([target], "story", told)
