"""`TriboLoads`: equal-length arrays of the five loads, checked once, used everywhere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pandas as pd

from .contract import LOAD_NAMES, LOADS, POINT_UNITS, QUANTITIES, Quantity
from .errors import InputError, unknown_name

FloatArray = npt.NDArray[np.float64]


def check_column(values: npt.ArrayLike, quantity: Quantity, where: str = "loads") -> FloatArray:
    """Return `values` as a contiguous float64 vector, or say which row breaks which limit.

    Parameters
    ----------
    values : array_like, shape (n,)
        Values in the unit of `quantity`.
    quantity : Quantity
        Name, unit and physical limits.
    where : str
        File or place, for the message.

    Raises
    ------
    InputError
        Not numeric, not one-dimensional, not finite or outside the physical limits; the message
        names column, row (counted from 0), value and allowed range.
    """
    try:
        array = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        cells = np.ravel(np.asarray(values, dtype=object))
        row = int(np.argmax(pd.isna(pd.to_numeric(pd.Series(cells), errors="coerce"))))
        raise InputError(
            f"{where}: column {quantity.name!r}, row {row}: value {cells[row]!r} is not a number [{quantity.unit}]"
        ) from None
    if array.ndim != 1:
        raise InputError(f"{where}: column {quantity.name!r} has shape {array.shape}, allowed: (n,)")
    good = np.isfinite(array) & (array >= quantity.lower) & (array <= quantity.upper)
    if not good.all():
        row = int(np.argmin(good))
        raise InputError(
            f"{where}: column {quantity.name!r}, row {row}: value {float(array[row])!r} is outside the allowed "
            f"range {quantity.lower:g} to {quantity.upper:g} {quantity.unit}"
        )
    return array


@dataclass(frozen=True, eq=False)
class TriboLoads:
    """The loads of n contact points, in the order and units of the contract.

    Parameters
    ----------
    v_rel, T, sigma_n, sd, psi : array_like, shape (n,)
        Loads in mm/s, degC, MPa, mm, 1.
    t : array_like, shape (n,), optional
        Time [s]; needed by effects with memory. Must not run backwards within a test.
    test_id : array_like, shape (n,), optional
        The test each point belongs to; points of one test are consecutive and ordered in time.
    context : pandas.DataFrame, optional
        Metadata by test, index `test_id` (tool roughness, lubricant batch, order, ...).

    Raises
    ------
    InputError
        Unequal lengths, values that are not finite or outside the physical limits, time running
        backwards within a test.
    """

    v_rel: FloatArray
    T: FloatArray
    sigma_n: FloatArray
    sd: FloatArray
    psi: FloatArray
    t: FloatArray | None = None
    test_id: npt.NDArray[np.str_] | None = None
    context: pd.DataFrame | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        for quantity in LOADS:
            object.__setattr__(self, quantity.name, check_column(getattr(self, quantity.name), quantity))
        if self.t is not None:
            object.__setattr__(self, "t", check_column(self.t, QUANTITIES["t"]))
        if self.test_id is not None:
            object.__setattr__(self, "test_id", np.asarray(self.test_id).astype(str))
        for name in (*LOAD_NAMES[1:], "t", "test_id"):
            column = getattr(self, name)
            if column is not None and len(column) != len(self.v_rel):
                raise InputError(
                    f"loads: column {name!r} has {len(column)} rows, 'v_rel' has {len(self.v_rel)}; "
                    "all columns must have the same length"
                )
        if self.context is not None and "test_id" in self.context.columns:
            table = self.context.assign(test_id=self.context["test_id"].astype(str)).set_index("test_id")
            twice = table.index[table.index.duplicated()]
            if len(twice):
                raise InputError(
                    f"tests: test_id {str(twice[0])!r} stands in {int((table.index == twice[0]).sum())} rows; allowed: one row a test"
                )
            object.__setattr__(self, "context", table)
        if self.t is not None and len(self) > 1:
            backwards = np.diff(self.t) < 0
            if self.test_id is not None:
                backwards &= self.test_id[1:] == self.test_id[:-1]
            if backwards.any():
                row = int(np.argmax(backwards)) + 1
                raise InputError(
                    f"loads: column 't', row {row}: time {float(self.t[row])!r} s comes after "
                    f"{float(self.t[row - 1])!r} s; time must not run backwards within a test"
                )

    @classmethod
    def from_array(cls, array: npt.ArrayLike) -> TriboLoads:
        """Build from an array of shape (n, 5) or (5,) in the order of the contract.

        Raises
        ------
        InputError
            Wrong shape, or values outside the physical limits.
        """
        matrix = np.atleast_2d(np.asarray(array, dtype=np.float64))
        if matrix.ndim != 2 or matrix.shape[1] != len(LOADS):
            raise InputError(
                f"loads: array has shape {matrix.shape}, allowed: (n, {len(LOADS)}) = {LOAD_NAMES}"
            )
        v_rel, T, sigma_n, sd, psi = matrix.T
        return cls(v_rel, T, sigma_n, sd, psi)

    @classmethod
    def from_frame(cls, data: pd.DataFrame, tests: pd.DataFrame | None = None) -> TriboLoads:
        """Build from a table with the columns of the contract; `t` and `test_id` are taken when there.

        Raises
        ------
        InputError
            A load column is missing, or a value is outside the physical limits.
        """
        for name in LOAD_NAMES:
            if name not in data.columns:
                raise missing_column(name, data.columns)
        v_rel, T, sigma_n, sd, psi = (data[n].to_numpy() for n in LOAD_NAMES)
        t = data["t"].to_numpy() if "t" in data.columns else None
        test_id = data["test_id"].to_numpy() if "test_id" in data.columns else None
        return cls(v_rel, T, sigma_n, sd, psi, t=t, test_id=test_id, context=tests)

    def __len__(self) -> int:
        return len(self.v_rel)

    def as_array(self) -> FloatArray:
        """Return the five loads as an array of shape (n, 5), in the order of the contract."""
        return np.column_stack([getattr(self, n) for n in LOAD_NAMES])

    def take(self, rows: npt.ArrayLike) -> TriboLoads:
        """Return the points selected by an index or Boolean array, with time, tests and context."""
        index = np.asarray(rows)
        return TriboLoads(
            self.v_rel[index],
            self.T[index],
            self.sigma_n[index],
            self.sd[index],
            self.psi[index],
            t=None if self.t is None else self.t[index],
            test_id=None if self.test_id is None else self.test_id[index],
            context=self.context,
        )

    def segments(self) -> list[slice]:
        """Return one slice per run of equal `test_id` (the whole range when there are no tests)."""
        if self.test_id is None or len(self) == 0:
            return [slice(0, len(self))]
        edges = np.flatnonzero(self.test_id[1:] != self.test_id[:-1]) + 1
        bounds = [0, *edges.tolist(), len(self)]
        return [slice(a, b) for a, b in pairwise(bounds)]

    def context_column(self, name: str) -> FloatArray | npt.NDArray[np.object_] | None:
        """Return the metadata `name` of each point's test, shape (n,), or None where it is not recorded."""
        if self.context is None or self.test_id is None or name not in self.context.columns:
            return None
        return self.context[name].reindex(self.test_id).to_numpy()

    def tests_table(self) -> pd.DataFrame | None:
        """Return the metadata with their column `test_id`, as they were given; None without them."""
        if self.context is None or self.context.index.name != "test_id":
            return self.context
        return self.context.reset_index()

    def to_frame(self) -> pd.DataFrame:
        """Return a table with the columns of the contract that are present."""
        columns: dict[str, object] = {}
        if self.test_id is not None:
            columns["test_id"] = self.test_id
        if self.t is not None:
            columns["t"] = self.t
        columns |= {n: getattr(self, n) for n in LOAD_NAMES}
        return pd.DataFrame(columns)


def missing_column(name: str, present: Sequence[str] | pd.Index, where: str = "data") -> InputError:
    """Build the error for a column that is not there, with the nearest column that is."""
    hint = unknown_name("column", name, [str(p) for p in present])
    near = str(hint).rpartition("; did you mean ")[2] if "did you mean" in str(hint) else ""
    unit = POINT_UNITS.get(name)
    what = f"{name!r}" + (f" [{unit}]" if unit else "")
    guess = f"; is it {near}" if near else ""
    return InputError(f"{where}: column {what} is missing; present: {', '.join(map(str, present))}{guess}")
