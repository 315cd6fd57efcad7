"""CSV files of the studies; every row says whether it comes from synthetic measurements."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from pathlib import Path

from friction_models.common import atomic_path, write_json, write_text
from friction_models.common.json_values import plain


def write_rows(target: Path, rows: Iterable[Mapping[str, object]], synthetic: bool) -> None:
    """Write rows that all have the same columns.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     write_rows(Path(place) / "runs.csv", [{"model": "a", "error": 0.01}], synthetic=True)
    ...     print((Path(place) / "runs.csv").read_text())
    model,error,synthetic
    a,0.01,True
    """
    table = [{**row, "synthetic": synthetic} for row in rows]
    with atomic_path(target) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(table[0]) if table else ["synthetic"], lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)


def write_study(
    folder: Path, name: str, numbers: object, rows: Iterable[Mapping[str, object]], synthetic: bool, page: str
) -> None:
    """Write numbers as ``NAME.json``, rows as ``NAME.csv`` and the page as ``report.html``.

    Numbers inside numbers of a row become columns ``lag.work_pct``; what a row lacks stays empty.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     write_study(Path(place), "lag", {}, [{"model": "a", "lag": {"work_pct": 2.0}}], synthetic=False, page="")
    ...     print((Path(place) / "lag.csv").read_text())
    model,lag.work_pct,synthetic
    a,2.0,False
    """
    import pandas as pd

    table = pd.DataFrame([_flat(row) for row in rows]).assign(synthetic=synthetic)
    write_json(folder / f"{name}.json", plain(numbers))
    write_text(folder / f"{name}.csv", table.to_csv(index=False, lineterminator="\n"))
    write_text(folder / "report.html", page)


def _flat(row: Mapping[str, object], prefix: str = "") -> dict[str, object]:
    flat: dict[str, object] = {}
    for key, value in row.items():
        flat |= _flat(value, f"{prefix}{key}.") if isinstance(value, dict) else {f"{prefix}{key}": value}
    return flat
