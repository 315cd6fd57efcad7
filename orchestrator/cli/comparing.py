"""`compare`: friction models against tribometer tests, or through co-simulation against press curves."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .console import progress, say, write_result
from .options import Json, Tests, fitted_model, read_data


def compare(
    models: Annotated[
        list[str],
        typer.Option("--models", help="Model folders, .fmu files or numbers (constant mu), one or more."),
    ],
    data: Annotated[
        Path,
        typer.Option("--data", help="Data set (folder or file of points), or a folder of press curves."),
    ],
    tests: Tests = None,
    runs: Annotated[Path | None, typer.Option(help="For press curves: keep the run folders here.")] = None,
    json: Json = None,
) -> None:
    """Compare friction models, on tribometer tests or, through co-simulation, on press curves."""
    if (data / "levels.csv").is_file():
        _compare_forces(models, data, runs, json)
        return
    from friction_models.discovery import compare as measure

    named = {_label(name, models): fitted_model(name) for name in models}
    dataset = read_data(data, tests)
    held_out = dataset.select("test")
    used = held_out if len(held_out.points) else dataset
    result = measure(named, used.points, used.tests)
    say(result.report())
    if json is not None:
        write_result(json, {"synthetic": dataset.synthetic, **result.to_dict()})


def _compare_forces(models: list[str], press: Path, runs: Path | None, json: Path | None) -> None:
    from ..forces import levels_table
    from ..press_study import PressStudy

    study = PressStudy.open(press)
    named = {_label(name, models): name for name in models}
    with progress("runs") as tick:
        results = study.compare(named, runs, progress=tick)
    if study.synthetic:
        say("synthetic press curves")
    say(levels_table(results))
    if json is not None:
        content = {"synthetic": study.synthetic, "models": [r.to_dict() for r in results]}
        write_result(json, content)


def _label(name: str, names: list[str]) -> str:
    """Short name of a model; the whole path where two would be called the same."""
    short = [Path(n).stem if Path(n).suffix == ".fmu" else Path(n).name for n in names]
    mine = short[names.index(name)]
    return mine if short.count(mine) == 1 else name


def add_commands(app: typer.Typer) -> None:
    """Register the command of this file."""
    app.command(epilog="Example: tribofmu compare --models models/linear models/ffnn 0.08 --data data")(
        compare
    )
