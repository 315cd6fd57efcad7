"""Which of the five loads a table holds. A load that was not measured becomes a constant that no model may use."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..common.errors import InputError, nearest, shown
from .contract import LOAD_NAMES, LOADS, POINT_COLUMNS, POINT_UNITS, FloatArray

if TYPE_CHECKING:  # solver processes of FMUs start without pandas
    import pandas as pd

#: What stands for a load that was not measured; without forming nothing expands.
STAND_IN: dict[str, float] = {q.name: 1.0 if q.name == "psi" else q.nominal for q in LOADS}
#: A column that is so much like the name of a load that is not there is a misspelt one.
ALIKE = 0.8


def missing_column(name: str, present: Sequence[str] | pd.Index, where: str = "data") -> InputError:
    """Build the error for a column that is not there, with the nearest column that is.

    Examples
    --------
    >>> print(missing_column("sigma_n", ["test_id", "sigma", "mu"], "points.csv"))
    points.csv: column 'sigma_n' [MPa] is missing; present: test_id, sigma, mu; is it 'sigma'?
    """
    near = nearest(name, sorted(map(str, present)))
    unit = POINT_UNITS.get(name)
    what = f"{name!r}" + (f" [{unit}]" if unit else "")
    guess = f"; is it {near!r}?" if near else ""
    return InputError(f"{where}: column {what} is missing; present: {', '.join(map(str, present))}{guess}")


def measured_loads(columns: Iterable[object], where: str = "data") -> tuple[str, ...]:
    """Return the loads among the columns of a table, in the order of the contract.

    Raises InputError: none of the loads is there, or one is not and a column has nearly its name.

    Examples
    --------
    >>> measured_loads(["sigma_n", "mu", "v_rel"])
    ('v_rel', 'sigma_n')
    """
    present = [str(c) for c in columns]
    found = tuple(n for n in LOAD_NAMES if n in present)
    others = [c for c in present if c not in POINT_COLUMNS]
    for name in LOAD_NAMES:
        if name not in found and any(_alike(name, c) for c in others):
            raise missing_column(name, present, where)
    if not found:
        loads = ", ".join(f"{q.name!r} [{q.unit}]" for q in LOADS)
        raise InputError(
            f"{where}: the columns of all loads are missing; present: {', '.join(present)}; allowed: at least one of {loads}, "
            "beside which columns of the test table count, but not alone"
        )
    return found


def not_measured(columns: Iterable[object]) -> tuple[str, ...]:
    """Return the loads that are not among the columns of a table.

    Examples
    --------
    >>> from friction_models.loads import not_measured
    >>> not_measured(["test_id", "v_rel", "T", "sigma_n", "mu"])
    ('sd', 'psi')
    """
    present = {str(c) for c in columns}
    return tuple(n for n in LOAD_NAMES if n not in present)


def require_every_load(columns: Iterable[object], where: str) -> None:
    """Raise `InputError` where a load is missing, for what needs all five."""
    present = [str(c) for c in columns]
    for name in not_measured(present):
        raise missing_column(name, present, where)


def _alike(name: str, column: str) -> bool:
    return difflib.SequenceMatcher(None, name.casefold(), column.casefold()).ratio() >= ALIKE


def stated_uncertainty(column: pd.Series[Any]) -> FloatArray:
    """Return stated uncertainties as numbers; raise where a cell holds something else."""
    import pandas as pd

    numbers = pd.to_numeric(column, errors="coerce")
    wrong = (numbers.isna() & column.notna()).to_numpy()
    if wrong.any():
        row = int(np.argmax(wrong))
        text = shown(str(column.iloc[row]), 30)
        raise InputError(
            f"column {str(column.name)!r}, row {row}: {text!r}; allowed: finite numbers from 0 on"
        )
    return numbers.to_numpy(dtype=np.float64)
