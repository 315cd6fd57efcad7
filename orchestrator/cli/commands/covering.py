"""`coverage`: which loads of a forming process were never tested, and which tests would cover them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from friction_models.common import InputError

from ..common.console import say, write_page, write_result
from ..common.files_named import Commands
from ..common.options import Data, Json, NextTests, Report, Tests, read_data, split_pair

app = Commands(rich_markup_mode="rich")


@app.command(
    epilog="Example: tribofmu coverage --data data --history forge.csv --column sigma_n='Contact pressure [GPa]' "
    "--report coverage.html"
)
def coverage(
    data: Data,
    run: Annotated[
        Path | None, typer.Option("--run", help="Run folder of a co-simulation (`simulate -o`).")
    ] = None,
    history: Annotated[
        Path | None,
        typer.Option(
            "--history", help="Contact history from another code: CSV, one row a contact point and time."
        ),
    ] = None,
    column: Annotated[
        list[str] | None,
        typer.Option(
            "--column",
            help="Column of the history: sigma_n='Contact pressure [GPa]'; also mu, area, t, point. Repeatable.",
        ),
    ] = None,
    rig: Annotated[
        list[str] | None,
        typer.Option("--rig", help="Limit of the tribometer: v_set=0.5:800, psi_set=1.07,5,20. Repeatable."),
    ] = None,
    tests: Tests = None,
    json: Json = None,
    report: Report = None,
    plan: NextTests = None,
) -> None:
    """Say where a forming process leaves the tested loads, and which further tests would cover it."""
    from ...cosim.run_folders import Run
    from ...coverage.contact_states import ContactStates
    from ...coverage.proposals import Rig, propose_tests
    from ...coverage.tested_loads import coverage as compare
    from ...prediction.plan_file import write_plan

    if (run is None) == (history is None):
        raise InputError("coverage: allowed: either --run FOLDER or --history FILE.csv")
    if column and history is None:
        raise InputError("coverage: --column names columns of --history; allowed: only with it")
    limits = Rig.read(rig or [])
    pairs = [split_pair("--column ", text, "sigma_n=NAME or sigma_n='NAME [unit]'") for text in column or []]
    columns = {name.strip(): rest.strip() for name, rest in pairs}
    states = (
        ContactStates.of_run(Run.load(run)) if run is not None else ContactStates.read(history or "", columns)
    )
    dataset = read_data(data, tests, every_load=True, need_mu=False)
    found = compare(dataset.points, states, dataset.synthetic)
    propose_tests(found, dataset.points, dataset.tests, limits)
    say(found.report())
    write_result(json, found.to_dict())
    if plan is not None:
        if not found.proposals:
            say("no plan written: no test is proposed")
        else:
            write_plan(plan, [row for p in found.proposals for row in p["plan"]], "cover")
            lab = f" (in the virtual laboratory: tribofmu lab --plan {plan} ...)" if dataset.synthetic else ""
            say(f"written: {plan}{lab}")
    write_page(report, "coverage", found, Path(states.source).name)
