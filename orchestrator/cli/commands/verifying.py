"""`verify`: the verification table of the forming simulation and the twin."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from friction_models.common import InputError, unknown_name, write_text

from ..common.console import progress, say, write_result
from ..common.files_named import Commands, Writes

if TYPE_CHECKING:
    from forming.verification import Case

app = Commands(rich_markup_mode="rich")


@app.command(epilog="Example: tribofmu verify --only ring --json rows.json")
def verify(
    only: Annotated[
        list[str] | None, typer.Option(help="Run these cases only: a name, or the start of names.")
    ] = None,
    fast: Annotated[bool, typer.Option("--fast", help="Leave out the cases that take long.")] = False,
    json: Annotated[
        Path | None, typer.Option("--json", help="Also write the rows to this file."), Writes()
    ] = None,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="Also write a Markdown page to this file."), Writes()
    ] = None,
) -> int:
    """Compare the simulations with closed forms and with CalculiX: case, reference, ours, deviation, tolerance.

    Ends with exit code 1 when a row fails. CalculiX (`ccx`, Debian package calculix-ccx) is run beside where
    it is installed; otherwise its rows say that they are skipped.
    """
    from forming.verification.table import markdown_page, text_table

    cases = chosen(only or [], fast)
    results = []
    with progress("verify") as tick:
        for k, case in enumerate(cases):
            tick(k, len(cases), case.name)
            results.append(case.run())
        tick(len(cases), len(cases), "")
    say(text_table(results))
    write_result(json, {"rows": [row.to_dict() for r in results for row in r.rows]})
    if out is not None:
        write_text(out, markdown_page(results))
        say(f"written: {out}")
    return int(any(result.failed for result in results))


def chosen(names: list[str], fast: bool) -> list[Case]:
    """Return the cases whose names start with one of `names`; all without names."""
    from forming.verification import CASES as FORMING
    from sct_twin.twin.heat.verification import CASES as TWIN

    cases = [*FORMING, *TWIN]
    for name in names:
        if not any(case.name.startswith(name) for case in cases):
            raise unknown_name("case", name, [case.name for case in cases], "verify")
    named = [case for case in cases if not names or case.name.startswith(tuple(names))]
    wanted = [case for case in named if case.fast or not fast]
    if not wanted:
        raise InputError("verify: all cases named take long; allowed with --fast: those that do not")
    return wanted
