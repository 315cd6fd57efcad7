"""`compare`: friction models against tribometer tests, against press curves, and in one system against each other."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from friction_models.common import InputError, unknown_name

from ..common.console import keeping, progress, say, write_page, write_result
from ..common.files_named import Commands, Reads, Writes
from ..common.options import Isolate, Jobs, Json, Names, Report, Tests, fitted_model, given_names, read_data

if TYPE_CHECKING:
    from fmus.runtime.foreign_friction import GivenNames
    from fmus.runtime.friction_names import FrictionNames

    from ...comparison.in_one_system import RunsComparison
    from ...comparison.on_press import ForcesComparison
    from ...comparison.on_tests import TestsComparison
    from ...comparison.press_study import PressResults, PressStudy

app = Commands(rich_markup_mode="rich")


@app.command(
    epilog="Examples: tribofmu compare --models models/linear models/ffnn 0.08 --data data; with an FMU of others, formed at every "
    "level of a press: tribofmu compare --models models/linear supplier.fmu --names names.yaml --press press; in one forming run, "
    "without measurements: tribofmu compare --system fre.yaml --models supplier.fmu models/linear 0.08 --report runs.html"
)
def compare(
    models: Annotated[
        list[str],
        typer.Option(
            "--models", help="Model folders, .fmu or .onnx files or numbers (constant mu), one or more."
        ),
        Reads(),
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
    system: Annotated[
        Path | None,
        typer.Option(
            "--system",
            help="System (YAML or .ssp) that runs with every model: the runs are laid over each other.",
        ),
    ] = None,
    names: Names = None,
    isolate: Isolate = None,
    runs: Annotated[
        Path | None,
        typer.Option(help="For press curves or a system: keep the run folders here."),
        Writes("STUDY"),
    ] = None,
    mode: Annotated[
        str, typer.Option(help="For a system: gauss_seidel, jacobi or iterated.")
    ] = "gauss_seidel",
    jobs: Jobs = None,
    json: Json = None,
    report: Report = None,
    seed: Annotated[int, typer.Option(help="Seed of the bootstrap.", min=0)] = 0,
) -> None:
    """Compare friction models: on tribometer tests, on press curves, or by runs of one system laid over each other."""
    if data is not None and press is None and (data / "levels.csv").is_file():
        data, press = None, data
    if data is None and press is None and system is None:
        raise InputError(
            "compare: neither --data nor --press nor --system is given; allowed: one of them, or several"
        )
    if data is None and tests is not None:
        what = "runs of a system" if press is None else "press curves"
        raise InputError(f"--tests {tests}: there are {what} only; allowed: with a data set of points")
    if press is None and system is None and runs is not None:
        raise InputError(
            f"--runs {runs}: there are no press curves and no system; allowed: with --press or --system"
        )
    if press is not None and system is not None and runs is not None:
        raise InputError(
            f"--runs {runs}: both --press and --system are given; allowed: one of them with --runs"
        )
    named, given = _labels(models), given_names(models, names)
    study = on_tests = on_press = ran = in_system = None
    if press is not None:
        from ...comparison.press_study import PressStudy

        study = PressStudy.open(press)
    found: dict[str, dict[str, object]] = {}
    if data is not None:
        on_tests = _compare_tests(named, given, data, tests, seed)
        found["tests"] = {"synthetic": on_tests.synthetic, **on_tests.to_dict()}
    if study is not None:
        called = {label: foreign.to_dict() for label, foreign in _foreign(named, given).items()}
        with progress("runs", says_time=True) as tick:
            ran = study.compare(named, runs, jobs, progress=tick, names=called)
        on_press = _compare_forces(study, ran, seed)
        failed = [asdict(f) for f in ran.failed]
        found["press"] = {"synthetic": study.synthetic, "models": [], "failed": failed}
        found["press"] |= {} if on_press is None else on_press.to_dict()
    if system is not None:
        in_system = _run_system(system, named, given, runs, mode, jobs)
        found["system"] = dict(in_system.to_dict())
    if json is not None:
        # The first comparison is the file itself, the others stand in it by name.
        (_, first), *others = found.items()
        write_result(json, {**first, **dict(others)})
    if on_tests is not None or on_press is not None or in_system is not None:
        write_page(report, "comparison", on_tests, on_press, in_system)
    if ran is not None:
        ran.check(runs)
    if in_system is not None and in_system.failed:
        from fmus.runtime.errors import SimulationError

        label, error = next(iter(in_system.failed.items()))
        raise SimulationError(f"{len(in_system.failed)} of the runs failed: {label}: {error[:300]}")


def _labels(models: list[str]) -> dict[str, str]:
    """Return the models by their short names; by the whole path where two would be called the same."""
    short = [Path(name).stem if Path(name).suffix == ".fmu" else Path(name).name for name in models]
    return {mine if short.count(mine) == 1 else name: name for mine, name in zip(short, models)}


def _foreign(named: dict[str, str], names: GivenNames) -> dict[str, FrictionNames]:
    """Return the variables of the FMUs that others made, by label."""
    found = {n: names.foreign(model) for n, model in named.items() if Path(model).suffix == ".fmu"}
    return {label: foreign for label, foreign in found.items() if foreign is not None}


def _run_system(
    system: Path, named: dict[str, str], names: GivenNames, runs: Path | None, mode: str, jobs: int | None
) -> RunsComparison:
    from ...comparison.in_one_system import compare_in_system
    from ...cosim.master import MODES
    from ...cosim.system import System

    if mode not in MODES:
        raise unknown_name("mode", mode, MODES, "--mode")
    kept = "what is finished is kept" if runs is not None else "nothing is kept without --runs FOLDER"
    with keeping(lambda: kept), progress("runs", says_time=True) as tick:
        result = compare_in_system(
            System.load(system), named, runs, _foreign(named, names), mode, jobs, progress=tick
        )
    if result.synthetic:
        say("synthetic data involved")
    say(result.report())
    return result


def _compare_tests(
    named: dict[str, str], names: GivenNames, data: Path, tests: Path | None, seed: int
) -> TestsComparison:
    from ...comparison.on_tests import compare_on_tests

    models = {label: fitted_model(name, names) for label, name in named.items()}
    result = compare_on_tests(models, read_data(data, tests, models.values()), seed)
    say(result.report())
    return result


def _compare_forces(study: PressStudy, ran: PressResults, seed: int) -> ForcesComparison | None:
    """Return the comparison of the models that formed every level, and print it; None where there is none."""
    from ...comparison.on_press import ForcesComparison

    if not ran.models:
        return None
    levels = [Path(level.file).stem for level in study.press.levels]
    lubricants = sorted({level.lubricant for level in study.press.levels})
    result = ForcesComparison.of(ran.models, levels, study.synthetic, seed, ran.failed, lubricants)
    if study.synthetic:
        say("synthetic press curves")
    say(result.report())
    return result
