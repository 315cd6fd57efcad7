"""The Typer application: every command, in the order of the loop."""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any

import typer

from .commands import (
    attributing,
    cards,
    comparing,
    covering,
    discovering,
    fmus,
    measuring,
    modelling,
    predicting_sct,
    showing,
    simulating,
    studying,
    verifying,
    workbench,
)
from .common.files_named import Commands

app = Commands(
    name="tribofmu",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(wanted: bool) -> None:
    if wanted:
        import importlib.metadata

        print(f"tribofmu {importlib.metadata.version('tribofmu')}")
        raise typer.Exit()


@app.callback()
def _start(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Friction models from tribometer measurements, as FMUs, in co-simulated cold forging.

    The loop: lab or ingest, twin, train, evaluate, pack, simulate, compare, diagnose, refine - and again.

    An output that is there already makes way: if anything of it would be lost it is kept as NAME.1, NAME.2 and so on
    (not with TRIBOFMU_KEEP_EARLIER=no in the environment).
    """


for module in (
    showing,
    measuring,
    modelling,
    cards,
    fmus,
    simulating,
    predicting_sct,
    comparing,
    discovering,
    covering,
    attributing,
    verifying,
    studying,
    workbench,
):
    app.add_typer(module.app)


@cache
def command() -> Any:
    """Return the command that all of them form; a Typer application would read every signature again at each call."""
    return typer.main.get_command(app)
