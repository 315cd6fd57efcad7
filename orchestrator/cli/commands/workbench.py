"""`app`: the workbench in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..common.files_named import Commands

app = Commands(rich_markup_mode="rich")


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
