"""`compare`: friction models against tribometer tests, against press curves, and in one system against each other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from friction_models.common import InputError, unknown_name
from friction_models.common.wording import listed

from ..common.console import Tick, keeping, progress, say, write_page, write_result
from ..common.files_named import Commands, Reads, Writes
from ..common.options import (
    Isolate,
    Jobs,
    Json,
    Names,
    Report,
    Tests,
    fitted_model,
    given_names,
    key_values,
    read_data,
)

if TYPE_CHECKING:
    from fmus.runtime.foreign_friction import GivenNames
    from fmus.runtime.friction_names import FrictionNames

    from ...comparison.in_one_system import RunsComparison
    from ...comparison.in_process import LevelsOfProcess
    from ...comparison.on_press import ForcesComparison
    from ...comparison.on_tests import TestsComparison
    from ...comparison.press_study import PressResults, PressStudy
    from ...force_curves.forces import ForceCurve

app = Commands(rich_markup_mode="rich")

Formed = TypeVar("Formed", "RunsComparison", "LevelsOfProcess")


@app.command(
    epilog="Examples: tribofmu compare --models models/linear models/ffnn 0.08 --data data; with an FMU of others, formed at every "
    "level of a press: tribofmu compare --models models/linear supplier.fmu --names names.yaml --press press; in one forming run, "
    "without measurements: tribofmu compare --system fre.yaml --models supplier.fmu models/linear 0.08 --report runs.html; in a "
    "process of ours at two levels: tribofmu compare --process fre --set half_angle=30 --level speed=5 --level speed=50,T_tool=100 "
    "--models models/linear 0.08 --runs runs/fre --report rods.html"
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
        typer.Option(
            "--press",
            help="Folder of press curves: every model forms every level. With --system or --process also the curve of one "
            "level (CSV), under which the runs are laid.",
        ),
    ] = None,
    system: Annotated[
        Path | None,
        typer.Option(
            "--system",
            help="System (YAML or .ssp) that runs with every model: the runs are laid over each other.",
        ),
    ] = None,
    process: Annotated[
        str | None,
        typer.Option(
            "--process",
            help="Forming process that runs with every model: fre, bce, upsetting or ring; its numbers with --set.",
        ),
    ] = None,
    parameters: Annotated[
        list[str] | None,
        typer.Option("--set", help="Parameter of the process: half_angle=45, material=16MnCr5. Repeatable."),
        Reads(),
    ] = None,
    level: Annotated[
        list[str] | None,
        typer.Option(
            "--level",
            help="Level at which the process runs: speed=50,T_tool=100. Repeatable; each is formed.",
        ),
    ] = None,
    stroke: Annotated[
        float | None,
        typer.Option(help="Punch travel of the process [mm]; 20 mm, or what it allows, by default."),
    ] = None,
    local_errors: Annotated[
        bool,
        typer.Option(
            "--local-errors",
            help="For a system or process: run each model once more with smaller elements and state how far the loads at the "
            "contact points may be off.",
        ),
    ] = False,
    names: Names = None,
    isolate: Isolate = None,
    runs: Annotated[
        Path | None,
        typer.Option(help="For press curves, a system or a process: keep the run folders here."),
        Writes("STUDY"),
    ] = None,
    mode: Annotated[
        str, typer.Option(help="For a system or process: gauss_seidel, jacobi or iterated.")
    ] = "gauss_seidel",
    jobs: Jobs = None,
    json: Json = None,
    report: Report = None,
    points: Annotated[
        Path | None,
        typer.Option(
            "--points",
            help="For a data set: also write its points with mu of every model (.csv or .parquet).",
        ),
        Writes(),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the bootstrap.", min=0)] = 0,
) -> None:
    """Compare friction models: on tribometer tests, on press curves, or by forming runs laid over each other."""
    if data is not None and press is None and (data / "levels.csv").is_file():
        data, press = None, data
    curve = None
    if press is not None and press.is_file() and (system is not None or process is not None):
        curve, press = press, None
    _check_options(data, tests, press, system, process, runs)
    if points is not None and data is None:
        raise InputError(f"--points {points}: there is no data set; allowed: with --data")
    if points is not None and points.suffix not in {".csv", ".parquet"}:
        raise InputError(f"{points}: suffix {points.suffix!r}, allowed: .csv, .parquet")
    formed = {"--set": bool(parameters), "--level": bool(level), "--stroke": stroke is not None}
    for option, given_here in formed.items():
        if given_here and process is None:
            raise InputError(f"{option}: belongs to a forming process; allowed: with --process")
    if local_errors and system is None and process is None:
        raise InputError("--local-errors: there is no forming run; allowed: with --system or --process")
    if curve is not None and len(level or []) > 1:
        raise InputError(f"--press {curve}: the curve of one level; allowed: with one --level")
    named, given = _labels(models), given_names(models, names)
    study = on_tests = on_press = ran = in_system = in_process = None
    measured = None
    if curve is not None:
        from ...force_curves.forces import read_press_curve

        measured = read_press_curve(curve)
    if press is not None:
        from ...comparison.press_study import PressStudy

        study = PressStudy.open(press)
    found: dict[str, dict[str, object]] = {}
    if data is not None:
        on_tests = _compare_tests(named, given, data, tests, seed)
        if points is not None:
            from friction_models.loads.table import write_table

            write_table(points, on_tests.points())
            say(f"written: {points}")
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
        from ...comparison.in_one_system import compare_in_system
        from ...cosim.system import System

        described, foreign = System.load(system), _foreign(named, given)
        in_system = _formed(
            lambda tick: compare_in_system(described, named, runs, foreign, mode, jobs, tick, local_errors),
            runs,
            mode,
            measured,
        )
        found["system"] = dict(in_system.to_dict())
    if process is not None:
        from ...comparison.in_process import FormingPlan, compare_in_process

        levels = [key_values(text.split(",")) for text in level or []]
        values = key_values(parameters or [], ("material", "tool_material"))
        plan, foreign = FormingPlan(process, values, levels or [{}], stroke), _foreign(named, given)
        in_process = _formed(
            lambda tick: compare_in_process(plan, named, runs, foreign, mode, jobs, tick, local_errors),
            runs,
            mode,
            measured,
        )
        found["process"] = dict(in_process.to_dict())
    if json is not None:
        # The first comparison is the file itself, the others stand in it by name.
        (_, first), *others = found.items()
        write_result(json, {**first, **dict(others)})
    formed_runs = [*([in_system] if in_system else []), *(in_process.levels.values() if in_process else [])]
    if on_tests is not None or on_press is not None or formed_runs:
        write_page(report, "comparison", on_tests, on_press, formed_runs)
    if ran is not None:
        ran.check(runs)
    failures = {**(in_system.failed if in_system else {}), **(in_process.failures if in_process else {})}
    if failures:
        from fmus.runtime.errors import SimulationError

        label, error = next(iter(failures.items()))
        raise SimulationError(f"{len(failures)} of the runs failed: {label}: {error[:300]}")


def _check_options(
    data: Path | None,
    tests: Path | None,
    press: Path | None,
    system: Path | None,
    process: str | None,
    runs: Path | None,
) -> None:
    """Refuse options that do not belong together."""
    forming = {"--press": press, "--system": system, "--process": process}
    given = [name for name, value in forming.items() if value is not None]
    if data is None and not given:
        raise InputError(
            "compare: neither --data nor --press nor --system nor --process is given; allowed: one of them, or several"
        )
    if data is None and tests is not None:
        what = "press curves" if press is not None else "runs of a system"
        raise InputError(f"--tests {tests}: there are {what} only; allowed: with a data set of points")
    if runs is not None and not given:
        raise InputError(
            f"--runs {runs}: there are no press curves, no system and no process; allowed: with --press, --system or --process"
        )
    if runs is not None and len(given) > 1:
        both = "both " if len(given) == 2 else ""
        raise InputError(f"--runs {runs}: {both}{listed(given)} are given; allowed: one of them with --runs")


def _formed(
    work: Callable[[Tick], Formed], runs: Path | None, mode: str, measured: Sequence[ForceCurve] | None
) -> Formed:
    """Let `work` run the models, hold the runs against a measured curve where there is one, and print what came out."""
    from ...cosim.master import MODES

    if mode not in MODES:
        raise unknown_name("mode", mode, MODES, "--mode")
    kept = "what is finished is kept" if runs is not None else "nothing is kept without --runs FOLDER"
    with keeping(lambda: kept), progress("runs", says_time=True) as tick:
        result = work(tick)
    if measured is not None:
        result = result.against(measured)
    if result.synthetic:
        say("synthetic data involved")
    say(result.report())
    return result


def _labels(models: list[str]) -> dict[str, str]:
    """Return the models by their short names; by the whole path where two would be called the same."""
    twice = sorted({name for name in models if models.count(name) > 1})
    if twice:
        raise InputError(
            f"--models: {twice[0]} stands {models.count(twice[0])} times; allowed: each model once"
        )
    short = [Path(name).stem if Path(name).suffix == ".fmu" else Path(name).name for name in models]
    return {mine if short.count(mine) == 1 else name: name for mine, name in zip(short, models)}


def _foreign(named: dict[str, str], names: GivenNames) -> dict[str, FrictionNames]:
    """Return the variables of the FMUs that others made, by label."""
    found = {n: names.foreign(model) for n, model in named.items() if Path(model).suffix == ".fmu"}
    return {label: foreign for label, foreign in found.items() if foreign is not None}


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
