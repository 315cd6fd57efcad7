"""A test plan as a file: the proposed tests of a diagnosis or of a coverage map, one row a test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from friction_models.common import write_text

#: Settings of a test; see `sct_twin.virtual_lab.protocols`.
PlanRow = Mapping[str, float | str]


def write_plan(path: str | Path, rows: Sequence[PlanRow], prefix: str = "next") -> Path:
    """Write rows of a test plan as CSV, as ``lab --plan`` and a rig read them; return the path.

    Cells that a row lacks stay empty. `prefix` is that of the ``test_id`` of rows without one: names of their own
    keep new tests apart from the old ones.

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


def missing_settings(rows: Sequence[PlanRow]) -> list[str]:
    """Return which settings the rows do not know, because the data behind them lack that load.

    Examples
    --------
    >>> missing_settings([{"sigma_set": 600.0, "v_set": 20.0, "T_tool": 20.0}, {"sigma_set": 600.0, "v_set": 20.0}])
    ['T_tool']
    """
    needed = {"sigma_set": "sigma_set", "v_set": "v_levels", "T_tool": "T_tool"}
    return [name for name, instead in needed.items() if any(name not in r and instead not in r for r in rows)]
