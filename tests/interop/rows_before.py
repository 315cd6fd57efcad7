"""Rows of the page before: what cannot be run on this machine keeps what an earlier run found."""

from __future__ import annotations

from pathlib import Path

from .comparing import Case

Row = tuple[str, ...]


def rows_before(page: Path) -> list[Row]:
    """Return the rows of all tables of a page; none where there is no page."""
    if not page.is_file():
        return []
    lines = [line for line in page.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    return [tuple(cell.strip() for cell in line.strip().strip("|").split("|")) for line in lines]


def of_case(before: list[Row], case: Case) -> Row | None:
    """Return the row of a case."""
    wanted = (case.client, case.fmi, case.form, case.shape, case.model)
    return next((r for r in before if len(r) == 9 and (r[0], *r[2:6]) == wanted), None)


def of_machine(before: list[Row], row: Row) -> Row | None:
    """Return the row of the machine of `row`, where it was run."""
    return next(
        (r for r in before if len(r) == len(row) and r[0] == row[0] and not r[3].startswith("not run")), None
    )
