"""`study`: the paper's studies, resumable, on all cores or on a cluster."""

from __future__ import annotations

import importlib
import importlib.util

import typer

#: Modules with `add_commands`, in the order of the help.
_STUDIES = ("study_learning", "study_forming", "study_coupling")


def add_commands(app: typer.Typer) -> None:
    """Register the commands of this file."""
    studies = typer.Typer(
        name="study",
        help="The paper's studies: resumable, on all cores or on a cluster.",
        no_args_is_help=True,
        rich_markup_mode="rich",
    )
    for name in _STUDIES:
        if importlib.util.find_spec(f"{__package__}.{name}") is not None:
            importlib.import_module(f".{name}", __package__).add_commands(studies)
    if studies.registered_commands:
        app.add_typer(studies)
