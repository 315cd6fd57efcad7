"""`story`, `app`: what was done in a project on one page, and the workbench in the browser."""

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
    from ...app.project_contents import story_of
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


@app.command(
    name="app", epilog="Example: tribofmu app my-project;  to try it out: tribofmu app try-out --example"
)
def workbench(
    folder: Annotated[
        Path,
        typer.Argument(help="Project folder, or a new one (default: the current folder)."),
    ] = Path("."),
    port: Annotated[
        int | None,
        typer.Option(min=1, max=65535, help="Port to listen on (default: 8420, or the next that is free)."),
    ] = None,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the browser.")] = True,
    example: Annotated[
        bool,
        typer.Option("--example", help="Fill a new or empty folder with a small synthetic example."),
    ] = False,
    host: Annotated[
        str,
        typer.Option(
            help="Address to listen on. Beyond 127.0.0.1 others can use the workbench: that needs a password of at least 12 "
            "characters in TRIBOFMU_APP_PASSWORD, and nothing is encrypted."
        ),
    ] = "127.0.0.1",
) -> None:
    """Open the workbench in the browser: what is missing, comparing, FMUs. Every button is a command line."""
    from ...app.server.listening import serve

    serve(folder, port, host, browser, example)
