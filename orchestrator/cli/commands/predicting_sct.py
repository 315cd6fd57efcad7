"""`predict-sct`: compression tests that were not run, by friction FMU and twin FMU in a closed loop."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from friction_models.common import InputError, grown, shown

from ..common.console import keeping, progress, say, write_result
from ..common.files_named import Commands, Reads, Writes
from ..common.options import (
    FittedModel,
    Isolate,
    Jobs,
    Json,
    Names,
    OutFolder,
    Tests,
    as_number,
    given_names,
    key_values,
    read_data,
)

if TYPE_CHECKING:
    from ...prediction.schedule import SctSchedule

app = Commands(rich_markup_mode="rich")


@app.command(
    "predict-sct",
    epilog="Examples: tribofmu predict-sct models/better --data data -o predicted;  "
    "tribofmu predict-sct friction.fmu --plan plan.csv -o predicted;  "
    "tribofmu predict-sct friction.fmu --inputs test.csv --set bore=20 --set T_tool=100 -o predicted",
)
def predict_sct(
    friction: FittedModel,
    out: Annotated[OutFolder, Writes("PREDICTION")],
    data: Annotated[
        Path | None,
        typer.Option(
            help="Data set whose held-out tests are predicted and compared: folder, CSV or Parquet file."
        ),
    ] = None,
    tests: Tests = None,
    only: Annotated[
        list[str] | None, typer.Option("--only", help="Predict these tests of the data set, held out or not.")
    ] = None,
    plan: Annotated[
        Path | None,
        typer.Option(
            help="Table of tests that nobody ran: test_id, F_set (N), v_set (mm/s), sd_set (mm), T_tool (degC), bore, tip ..."
        ),
    ] = None,
    inputs: Annotated[
        Path | None,
        typer.Option(help="Table of one test over time: t (s), F_n (N), v_slide (mm/s), T_tool (degC)."),
    ] = None,
    parameters: Annotated[
        list[str] | None,
        typer.Option(
            "--set", help="Parameter of the twin: bore=20, tip=9, upsetting_mu=0.07, material=16MnCr5."
        ),
        Reads(),
    ] = None,
    jobs: Jobs = None,
    json: Json = None,
    names: Names = None,
    isolate: Isolate = None,
) -> None:
    """Predict compression tests that were not run: the friction FMU and the twin FMU in a closed loop.

    Only normal force, motion and tool temperature go in; friction and the heat it makes come out, and are
    compared with the measurement where the test was run after all.
    """
    from friction_models.common.folders import PREDICTION

    from ...cosim.swapping import friction_fmu
    from ...prediction.predict_sct import predict_sct as predict

    twin = key_values(parameters or [], ("material",))  # the name of a steel may look like a number
    schedules = _schedules(data, tests, only, plan, inputs, twin)
    label = Path(friction).stem if as_number(friction) is None else f"constant {friction}"
    called = given_names([friction], names).foreign(friction) if Path(friction).suffix == ".fmu" else None
    grown(out, PREDICTION)
    fmu = friction_fmu(friction, out / "fmus" / "friction.fmu", nodes=1)
    with progress("closed loop") as tick, keeping(lambda: f"finished tests are kept in {out}"):
        found = predict(fmu, schedules, out, twin=twin, label=label, names=called, jobs=jobs, progress=tick)
    say(found.table())
    say(f"written: {out} (predicted.csv, prediction.json, runs/ with a folder a test)")
    earlier = {p.name for p in (out / "runs").iterdir()} - {test.run.folder.name for test in found.tests}
    if earlier:
        say(
            f"note: {out / 'runs'} also holds runs that are not of this prediction: {shown(', '.join(sorted(earlier)))}"
        )
    write_result(json, found.to_dict())


def _schedules(
    data: Path | None,
    tests: Path | None,
    only: list[str] | None,
    plan: Path | None,
    inputs: Path | None,
    twin: dict[str, float | str | None],
) -> list[SctSchedule]:
    """Return the tests that one of the three options names."""
    from ...prediction.schedule import SctSchedule, held_out_schedules, planned_schedules

    given = [option for option in (data, plan, inputs) if option is not None]
    if len(given) != 1:
        raise InputError(f"{len(given)} of --data, --plan and --inputs given; allowed: exactly one")
    if data is None and (only or tests):
        raise InputError("--only and --tests name tests of a data set; allowed with --data")
    if data is not None:
        return held_out_schedules(read_data(data, tests, need_mu=False), only)
    if plan is not None:
        return planned_schedules(plan)
    assert inputs is not None
    T_tool = twin.pop("T_tool", None)
    return [SctSchedule.from_file(inputs, {"test_id": inputs.stem, "T_tool": T_tool})]
