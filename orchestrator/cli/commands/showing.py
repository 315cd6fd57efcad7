"""`demo`, `report`: the whole loop on built-in data, and the HTML report of finished runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..common.console import keeping, progress, say
from ..common.files_named import Commands, Writes
from ..common.options import Jobs, OutFolder

app = Commands(rich_markup_mode="rich")


@app.command(epilog="Example: tribofmu demo -o build/demo")
def demo(
    out: Annotated[OutFolder, Writes("DEMO")] = Path("tribofmu-demo"),
    hidden: Annotated[
        str, typer.Option(help="Effect hidden in the virtual laboratory; `none` for nothing.")
    ] = "stribeck",
    seed: Annotated[int, typer.Option(help="Seed of the virtual campaign.")] = 7,
    jobs: Jobs = None,
) -> None:
    """Run the whole loop on synthetic data and write an HTML report.

    Virtual campaign with a hidden effect, twin, two models, FMUs, co-simulated forward rod extrusion,
    virtual press, diagnosis, the effect added, errors before and after as they came out.
    """
    from ...demo import Demo, Scenario, printed_summary

    scenario = Scenario(hidden=None if hidden == "none" else hidden, seed=seed)
    with keeping(lambda: f"finished steps are kept in {out}; the same command goes on from there"):
        result = Demo(out, scenario, jobs, progress).run()
    say(printed_summary(result))


@app.command(epilog="Example: tribofmu report runs/fre -o fre.html")
def report(
    folder: Annotated[
        Path, typer.Argument(help="Run folder, folder of a study, of predicted tests, or of the demo.")
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            "-o", "--out", help="File to write: .html, .pdf or .xlsx (default: report.html in the folder)."
        ),
        Writes(),
    ] = None,
) -> None:
    """Write a self-contained HTML report (works offline) of a run, a study, predicted tests or a demo."""
    from ...report import write_report

    say(f"report written: {write_report(folder, out)}")
