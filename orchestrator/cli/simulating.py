"""`simulate`: co-simulation of a system of FMUs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .console import progress, say, share
from .options import OutFolder, Swap, swapped


def simulate(
    system: Annotated[Path, typer.Argument(help="System description (YAML), or an SSP archive (.ssp).")],
    out: OutFolder,
    swap: Swap = None,
    mode: Annotated[str, typer.Option(help="gauss_seidel, jacobi or iterated.")] = "gauss_seidel",
    csv: Annotated[bool, typer.Option("--csv", help="Also write results.csv.")] = False,
    press: Annotated[
        Path | None, typer.Option(help="Compare with this measured force-stroke curve (CSV).")
    ] = None,
) -> None:
    """Run a system of FMUs and write a run folder (results, manifest, log)."""
    from ..forces import compare_force, read_press_curve
    from ..master import Master
    from ..system import System

    description = swapped(System.load(system), swap)
    measured = read_press_curve(press) if press is not None else None
    master = Master(description, mode=mode)
    with progress(description.name) as tick:
        run = master.run(out, progress=share(tick, description.steps, "steps"), csv=csv)
    timing = run.manifest["timing_s"]
    say(
        f"run written: {out} ({description.steps} steps in {timing['total']:.1f} s, "
        f"{1e6 * timing['master'] / description.steps:.0f} us of them in the master each step)"
    )
    if measured is not None:
        say(compare_force(run.force_curve(), measured, run.name).table())


def add_commands(app: typer.Typer) -> None:
    """Register the commands of this file."""
    app.command(
        epilog="Example: tribofmu simulate fre.yaml --swap friction=friction.fmu --mode jacobi -o runs/fre"
    )(simulate)
