"""`compare`: friction models against tribometer tests and, through co-simulation, against press curves."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .console import progress, say, write_result
from .options import Json, Names, Tests, fitted_model, given_names, read_data

if TYPE_CHECKING:
    from ..comparison import TestsComparison
    from ..comparison_forces import ForcesComparison
    from ..foreign_friction import GivenNames
    from ..press_study import PressResults, PressStudy


def compare(
    models: Annotated[
        list[str],
        typer.Option(
            "--models", help="Model folders, .fmu or .onnx files or numbers (constant mu), one or more."
        ),
    ],
    data: Annotated[
        Path | None,
        typer.Option("--data", help="Data set (folder or file of points), or a folder of press curves."),
    ] = None,
    tests: Tests = None,
    press: Annotated[
        Path | None,
        typer.Option("--press", help="Folder of press curves: every model forms every level."),
    ] = None,
    names: Names = None,
    runs: Annotated[Path | None, typer.Option(help="For press curves: keep the run folders here.")] = None,
    json: Json = None,
    report: Annotated[Path | None, typer.Option(help="Also write an HTML report.")] = None,
    seed: Annotated[int, typer.Option(help="Seed of the bootstrap.", min=0)] = 0,
) -> None:
    """Compare friction models, on tribometer tests or, through co-simulation, on press curves."""
    from friction_models.loads import InputError

    if data is not None and press is None and (data / "levels.csv").is_file():
        data, press = None, data
    if data is None and press is None:
        raise InputError("compare: neither --data nor --press is given; allowed: one of them, or both")
    if data is None and tests is not None:
        raise InputError(f"--tests {tests}: there are press curves only; allowed: with a data set of points")
    if press is None and runs is not None:
        raise InputError(f"--runs {runs}: there are no press curves; allowed: with --press")
    given = given_names(models, names)
    study = None if press is None else _opened(press)
    on_tests = None if data is None else _compare_tests(models, given, data, tests, seed)
    ran = None if study is None else _form(study, models, given, runs)
    on_press = None if study is None or ran is None else _compare_forces(study, ran, seed)
    if json is not None:
        content: dict[str, Any] = {}
        if on_tests is not None:
            content = {"synthetic": on_tests.synthetic, **on_tests.to_dict()}
        if study is not None and ran is not None:
            forces = {"synthetic": study.synthetic, "models": [], "failed": [f.to_dict() for f in ran.failed]}
            forces |= {} if on_press is None else on_press.to_dict()
            content = {**content, "press": forces} if content else forces
        write_result(json, content)
    if report is not None and (on_tests is not None or on_press is not None):
        from friction_models.loads import write_text

        from ..report.comparison_page import comparison_page

        write_text(report, comparison_page(on_tests, on_press))
        say(f"report written: {report}")
    if ran is not None:
        ran.check(runs)


def _opened(press: Path) -> PressStudy:
    from ..press_study import PressStudy

    return PressStudy.open(press)


def _compare_tests(
    models: list[str], names: GivenNames, data: Path, tests: Path | None, seed: int
) -> TestsComparison:
    from ..comparison import compare_on_tests

    named = {_label(name, models): fitted_model(name, names) for name in models}
    result = compare_on_tests(named, read_data(data, tests), seed)
    say(result.report())
    return result


def _form(study: PressStudy, models: list[str], names: GivenNames, runs: Path | None) -> PressResults:
    named = {_label(name, models): name for name in models}
    called = {}
    for label, name in named.items():
        foreign = names.foreign(name) if Path(name).suffix == ".fmu" else None
        if foreign is not None:
            called[label] = foreign.to_dict()
    with progress("runs", says_time=True) as tick:
        return study.compare(named, runs, progress=tick, names=called)


def _compare_forces(study: PressStudy, ran: PressResults, seed: int) -> ForcesComparison | None:
    """Return the comparison of the models that formed every level, and print it; None where there is none."""
    from ..comparison_forces import ForcesComparison

    if not ran.models:
        return None
    levels = [Path(level.file).stem for level in study.press.levels]
    lubricants = sorted({level.lubricant for level in study.press.levels})
    result = ForcesComparison.of(ran.models, levels, study.synthetic, seed, ran.failed, lubricants)
    if study.synthetic:
        say("synthetic press curves")
    say(result.report())
    return result


def _label(name: str, names: list[str]) -> str:
    """Short name of a model; the whole path where two would be called the same."""
    short = [Path(n).stem if Path(n).suffix == ".fmu" else Path(n).name for n in names]
    mine = short[names.index(name)]
    return mine if short.count(mine) == 1 else name


def add_commands(app: typer.Typer) -> None:
    """Register the command of this file."""
    app.command(
        epilog="Examples: tribofmu compare --models models/linear models/ffnn 0.08 --data data; with an FMU of others, formed at every "
        "level of a press: tribofmu compare --models models/linear supplier.fmu --names names.yaml --press press"
    )(compare)
