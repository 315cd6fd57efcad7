"""`simulate`: co-simulation of a system of FMUs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from friction_models.common import check_outputs

from ..common.console import keeping, note, progress, say, share
from ..common.files_named import Commands, Writes
from ..common.options import Isolate, Names, OutFolder, Swap, swapped

app = Commands(rich_markup_mode="rich")


@app.command(
    epilog="Example: tribofmu simulate fre.yaml --swap friction=friction.fmu --mode jacobi -o runs/fre"
)
def simulate(
    system: Annotated[Path, typer.Argument(help="System description (YAML), or an SSP archive (.ssp).")],
    out: Annotated[OutFolder, Writes("RUN")],
    swap: Swap = None,
    names: Names = None,
    isolate: Isolate = None,
    mode: Annotated[str, typer.Option(help="gauss_seidel, jacobi or iterated.")] = "gauss_seidel",
    csv: Annotated[bool, typer.Option("--csv", help="Also write results.csv.")] = False,
    fields: Annotated[
        float | None,
        typer.Option(
            help="Keep the fields of the forming process each so many mm of stroke, for `report` and ParaView."
        ),
    ] = None,
    local_errors: Annotated[
        bool,
        typer.Option(
            "--local-errors",
            help="Run once more with smaller elements and state how far the loads at the contact points may be off.",
        ),
    ] = False,
    press: Annotated[
        Path | None, typer.Option(help="Compare with this measured force-stroke curve (CSV).")
    ] = None,
) -> None:
    """Run a system of FMUs and write a run folder (results, manifest, log)."""
    from ...cosim.master import Master
    from ...cosim.run_folders import force_labels
    from ...cosim.system import System
    from ...force_curves.forces import compare_force, read_press_curve

    description = swapped(System.load(system), swap, names)
    measured = read_press_curve(press) if press is not None else None
    check_outputs([out], [description.fmu_path(name) for name in description.components])
    master = Master(description, mode=mode)
    if measured is not None:
        force_labels([item.label for item in master.wiring.recorded], description.name)
    if local_errors:  # imported here, like the fields: the solver takes half a second
        from ...cosim.local_errors import forming_with_elements, state_local_errors

        forming_with_elements(master)
    for text in master.warnings:
        note(text)
    snapshots: int | None = None
    with keeping(), progress(description.name) as tick:
        steps = share(tick, description.steps, "steps")
        if fields is None:
            run = master.run(out, progress=steps, csv=csv)
        else:  # imported here: the solver takes half a second
            from ...cosim.run_fields import run_with_fields

            run, snapshots = run_with_fields(master, out, fields, steps, csv)
    timing = run.manifest["timing_s"]
    say(
        f"run written: {out} ({run.manifest['steps']} steps in {timing['total']:.1f} s, "
        f"{1e6 * timing['master'] / max(1, run.manifest['steps']):.0f} us of them in the master each step)"
    )
    if run.message:
        say(run.message)
    for text in [*master.course.remarks(), *run.remarks()]:
        note(text)
    if local_errors and not run.message:
        with keeping(), progress(f"{description.name}, smaller elements") as tick:
            say(state_local_errors(run, master, share(tick, description.steps, "steps")))
    if snapshots is not None:
        say(
            f"{snapshots} snapshots of the fields in {out / 'fields'}"
            if snapshots
            else "no fields: no component is a forming FMU of this version"
        )
    if measured is not None:
        say(compare_force(run.force_curve(), measured, run.name).table())
