"""`study`: the paper's studies, resumable, on all cores or on a cluster."""

from __future__ import annotations

import typer

from ..common.files_named import Commands
from . import study_coupling, study_forming, study_learning


def add_commands(app: typer.Typer) -> None:
    """Register the commands of this file."""
    studies = Commands(
        name="study",
        help="The paper's studies: resumable, on all cores or on a cluster.",
        no_args_is_help=True,
        rich_markup_mode="rich",
        epilog="Example: tribofmu study learning-curve --quick -o studies/learning-curve",
    )
    for module in (study_learning, study_forming, study_coupling):
        module.add_commands(studies)
    app.add_typer(studies)
