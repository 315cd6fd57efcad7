"""`attribute`: which cause the difference between measured and simulated force-stroke curves points to."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from friction_models.common import check_outputs

from ..common.console import keeping, progress, say, write_page, write_result
from ..common.files_named import Commands, Writes
from ..common.options import Jobs, Json, Report

app = Commands(rich_markup_mode="rich")


@app.command(
    epilog="Example: tribofmu attribute --press press --system fre.yaml --system bce.yaml --report cause.html"
)
def attribute(
    press: Annotated[Path, typer.Option("--press", help="Folder of measured press curves (levels.csv).")],
    system: Annotated[
        list[Path],
        typer.Option(
            "--system", help="System description of the forming process (YAML or SSP); one for each process."
        ),
    ],
    causes: Annotated[
        list[str] | None,
        typer.Option("--causes", help="Only these causes (names as in the report); all by default."),
    ] = None,
    runs: Annotated[
        Path | None,
        typer.Option(
            help="Folder in which runs are kept and found again (default: the user's cache folder)."
        ),
        Writes("SENSITIVITIES"),
    ] = None,
    jobs: Jobs = None,
    json: Json = None,
    report: Report = None,
) -> None:
    """Say which cause force-stroke curves point to: friction effects, flow stress, heat, the press. Not a proof."""
    from ...attribution.attribute import attribute as find
    from ...cosim.system import System

    systems = [System.load(path) for path in system]
    fmus = [s.fmu_path(name) for s in systems for name in s.components]
    check_outputs([p for p in (runs, json, *(report or [])) if p is not None], fmus)
    kept = f"finished runs are kept in {runs or 'the cache folder'}; the same command goes on from there"
    with keeping(lambda: kept), progress("sensitivities") as tick:
        result = find(press, systems, causes, runs, jobs, tick)
    say(result.report())
    write_result(json, result.to_dict())
    write_page(report, "attribution", result, press.name)
