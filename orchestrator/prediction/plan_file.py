"""A test plan as a file: the proposed tests of a diagnosis or of a coverage map, one row a test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from friction_models.common import write_text


def write_plan(path: str | Path, rows: Sequence[Mapping[str, Any]], prefix: str = "next") -> Path:
    """Write rows of a test plan as CSV, as ``lab --plan`` and a rig read them; return the path.

    Parameters
    ----------
    path : path-like
        File to write.
    rows : sequence of mapping
        Settings of each test; see `sct_twin.virtual_lab.protocols`. Cells that a row lacks stay empty.
    prefix : str
        Of the ``test_id`` of rows without one: names of their own keep new tests apart from the old ones.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     plan = write_plan(Path(place) / "next.csv", [{"sigma_set": 600.0, "v_set": 20.0}, {"sigma_set": 900.0}])
    ...     print(plan.read_text())
    test_id,sigma_set,v_set
    next001,600.0,20.0
    next002,900.0,
    """
    named = [{"test_id": f"{prefix}{k + 1:03d}", **row} for k, row in enumerate(rows)]
    return write_text(path, pd.DataFrame(named).to_csv(index=False, lineterminator="\n"))


def missing_settings(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return which settings the rows do not know, because the data behind them lack that load.

    Examples
    --------
    >>> missing_settings([{"sigma_set": 600.0, "v_set": 20.0, "T_tool": 20.0}, {"sigma_set": 600.0, "v_set": 20.0}])
    ['T_tool']
    """
    needed = ("sigma_set", "v_set", "T_tool")
    return [name for name in needed if any(name not in row and not _replaced(name, row) for row in rows)]


def _replaced(name: str, row: Mapping[str, Any]) -> bool:
    return name == "v_set" and "v_levels" in row
