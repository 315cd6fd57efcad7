"""`lab`, `ingest`, `twin`: from raw records to a data set."""

from __future__ import annotations

import shutil
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from friction_models.common import InputError, unknown_name
from friction_models.common.wording import counted

from ..common.console import keeping, note, progress, say
from ..common.files_named import Commands, Reads, Writes
from ..common.options import Jobs, OutFolder, key_values

if TYPE_CHECKING:
    import pandas as pd

app = Commands(rich_markup_mode="rich")

DryRun = Annotated[bool, typer.Option("--dry-run", help="Only show what was found, write nothing.")]

_KEPT_BY_LAB = "what is finished is kept beside the campaign folder; the same command goes on from there"


@app.command(epilog="Example: tribofmu lab --plan factorial-81+30 --hidden stribeck --seed 7 -o campaign")
def lab(
    out: Annotated[OutFolder, Writes("CAMPAIGN")],
    plan: Annotated[
        str, typer.Option(help="Test plan by name, or a CSV file with a row a test."), Reads()
    ] = "factorial-81+30",
    hidden: Annotated[
        str | None, typer.Option(help="Effect hidden in the truth; without it nothing is hidden.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed; the same seed gives the same files.")] = 0,
    lubricant: Annotated[
        str | None,
        typer.Option(
            help="Lubricant: polymer or mos2, on a rig with the flaws of a real one; without it a linear law on "
            "a plain rig."
        ),
    ] = None,
    repeats: Annotated[int, typer.Option(help="How often each training test of a named plan is run.")] = 1,
    file_format: Annotated[
        str,
        typer.Option(
            "--format",
            help="Files as a data logger writes them: canonical, csv, ascii, catman, mdf, tdms, mat, parquet, xlsx.",
        ),
    ] = "canonical",
    jobs: Jobs = None,
) -> None:
    """Make a synthetic SCT campaign: raw records, labelled synthetic.

    The truth goes to a file of its own that no training or diagnosis reads.
    """
    from sct_twin import virtual_lab

    campaign = virtual_lab.Campaign(plan=plan, hidden=hidden, seed=seed, lubricant=lubricant, repeats=repeats)
    with progress("virtual laboratory") as tick, keeping(lambda: _KEPT_BY_LAB):
        campaign.write(out, file_format, jobs=jobs, progress=tick)
    say(f"synthetic campaign written: {out}")
    if file_format != "canonical":
        say(f"channel map for ingest: {out / 'channels.yaml'}")


@app.command(epilog="Example: tribofmu ingest rig/*.csv --map channels.yaml -o campaign")
def ingest(
    files: Annotated[list[Path], typer.Argument(help="Measurement files, or a folder of them.")],
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="Folder to write; not needed with --dry-run."),
        Writes("CAMPAIGN"),
    ] = None,
    channels: Annotated[
        Path | None, typer.Option("--map", help="YAML: which column is which channel, units, signs, offsets.")
    ] = None,
    tests: Annotated[
        Path | None,
        typer.Option("--tests", help="Test table with a column test_id; comma, semicolon or tab."),
    ] = None,
    test_id: Annotated[
        str | None,
        typer.Option(
            help="Which part of a file's name is the test's: '*_SCT{test_id}_raw'; * is any text, ? any character. "
            "Without it the map's test_id, or the whole name."
        ),
    ] = None,
    dry_run: DryRun = False,
) -> None:
    """Turn measurement files of any layout into a campaign folder with canonical channels and units.

    Reads CSV and ASCII, catman, MDF, TDMS, MATLAB, Parquet and Excel. Shows columns, phases and quality of every
    test, then writes.
    """
    from sct_twin.ingest.campaign_files import ingest as read
    from sct_twin.ingest.preview import describe, preview

    if out is None and not dry_run:
        raise InputError("ingest: -o is missing; allowed: the folder to write, or --dry-run")
    source = files[0] if len(files) == 1 else files
    width = min(max(shutil.get_terminal_size((80, 24)).columns, 60), 160)
    if dry_run:
        with progress("reading") as tick:
            text = preview(source, channels, tests, tick, width, test_id)
        say(text)
        return
    with progress("reading") as tick, keeping(lambda: f"{out} was not written"):
        report = read(
            source, channels, out, tests, tick, lambda found: say(describe(found, channels, width)), test_id
        )
    say(report.headline())


@app.command(epilog="Example: tribofmu twin campaign --set material=steel.yaml --check 3 -o data")
def twin(
    campaign: Annotated[Path, typer.Argument(help="Campaign folder (from lab or ingest).")],
    out: Annotated[OutFolder, Writes("TWIN")],
    jobs: Jobs = None,
    check: Annotated[
        int,
        typer.Option(
            help="Compute so many tests at other fidelity and assumptions too, and report the differences."
        ),
    ] = 0,
    parameters: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            help="Setting of the twin: material=steel.yaml, mesh_size=0.5, upsetting_mu=0.05. Repeatable.",
        ),
        Reads(),
    ] = None,
) -> None:
    """Run the digital twin of every test: adds contact pressure, surface expansion and contact temperature."""
    from sct_twin import SctTwin

    settings = key_values(parameters or [], ("material",))  # the name of a steel may look like a number
    known = {field.name for field in fields(SctTwin)} - {"thermal", "uncertainty"}
    for name in settings:
        if name not in known:
            raise unknown_name("setting of the twin", name, known)
    evaluation = SctTwin(**settings)
    with progress("twin") as tick, keeping(lambda: _kept(out)):
        result = evaluation.run(campaign, out=out, jobs=jobs, progress=tick, check=check)
    data = result.dataset()
    label = "synthetic " if data.synthetic else ""
    say(
        f"{label}data set written: {out} ({counted(data.points['test_id'].nunique(), 'test')}, {counted(len(data.points), 'point')})"
    )
    if (out / "averages").is_dir():
        say(f"means over each test: {out / 'averages'}")
    if not result.left_out.empty:
        say(f"{counted(len(result.left_out), 'test')} left out, reasons in {out / 'left_out.csv'}")
    for remark in result.remarks:
        say(f"{remark['test_id']}: {remark['remark']}")
    if result.put_aside is not None:
        note(f"{out / 'errors.csv'}: of other points than there are now, kept as {result.put_aside}")
    if check:
        say(result.error_table())


@app.command(epilog="Example: tribofmu points tables/ --map points.yaml -o data")
def points(
    files: Annotated[list[Path], typer.Argument(help="Tables of points, or a folder of them.")],
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="Data set to write; not needed with --dry-run."),
        Writes("DATASET"),
    ] = None,
    columns: Annotated[
        Path | None,
        typer.Option("--map", help="YAML: which column is which load, units, limits, parts of file names."),
    ] = None,
    synthetic: Annotated[
        bool, typer.Option("--synthetic", help="The values were computed and not measured.")
    ] = False,
    dry_run: DryRun = False,
) -> None:
    """Turn tables of points of any laboratory into a data set: names and units of the contract, and a test table.

    Reads what `ingest` reads; a tests.csv beside the files adds its columns. Of a data set that is written anew the test tables before are kept in the folder `earlier`, and columns that
    only they have (role, batch) stay. Without --map the columns must be called as in a data set; --dry-run drafts a map.
    """
    from friction_models.loads.dataset import read_tests
    from friction_models.loads.earlier_tables import with_columns_of
    from sct_twin.ingest.point_guess import describe_points
    from sct_twin.ingest.point_tables import read_point_tables

    if out is None and not dry_run:
        raise InputError("points: -o is missing; allowed: the folder to write, or --dry-run")
    source = files[0] if len(files) == 1 else files
    with progress("reading") as tick:
        if dry_run:
            describe_points(source, columns, tick, say)
            return
        found = read_point_tables(source, columns, tick, synthetic)
    assert out is not None
    for text in found.notes:
        note(text)
    dataset = found.dataset
    if dataset.tests is not None and (out / "dataset.json").is_file() and (out / "tests.csv").is_file():
        table, more = with_columns_of(dataset.tests, read_tests(out / "tests.csv"))
        dataset = replace(dataset, tests=table)
        if more:
            note(f"{', '.join(more)}: taken from the test table before, for tests of the same name")
    dataset.save(out)
    say(f"data set written: {out} ({found.headline()})")
    say(f"in it: {_ranges(dataset.points)}")


@app.command(epilog="Example: tribofmu tests data --set t01:role=test --set 't0*:batch=A'")
def tests(
    data: Annotated[
        Path,
        typer.Argument(help="Folder with a test table (data set, campaign, measurements), or the table."),
    ],
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="TEST:COLUMN=VALUE",
            help="Value of a column for a test, or for all that a name with * fits; the empty text clears it.",
        ),
    ] = None,
) -> None:
    """Show the test table of a folder, or change what it says: role, batch, lubricant, any column.

    The table before is kept in the folder `earlier` beside it. A column that is not there is added.
    """
    from friction_models.loads.tests_table import TableOfTests, change_tests, read_change

    if not changes:
        say(TableOfTests.load(data).text())
        return
    table, changed, kept = change_tests(data, [read_change(c) for c in changes])
    say(f"test table written: {changed.file} ({table.difference(changed)})")
    if kept is not None:
        say(f"the table before: {kept}")


def _ranges(points: pd.DataFrame) -> str:
    """Return the range of each load and of mu in its unit: a wrong unit shows there, and nowhere else."""
    from friction_models.loads import LOADS, MU

    return ", ".join(
        f"{q.name} {points[q.name].min():.4g} to {points[q.name].max():.4g}{f' {q.unit}' if q.unit != '1' else ''}"
        for q in (*LOADS, MU)
        if q.name in points and points[q.name].notna().any()
    )


def _kept(folder: Path) -> str:
    count = len(list((folder / "twin").glob("*.nc")))
    if not count:
        return "nothing was finished yet"
    return f"{count} finished tests are kept in {folder}; the same command goes on from there"
