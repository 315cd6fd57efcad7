"""`TriboLoads`: equal-length arrays of the five loads, checked once, used everywhere."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from datetime import date, timedelta
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ..common.errors import InputError, unknown_name
from ..common.wording import listed
from .columns import STAND_IN, measured_loads, stated_uncertainty
from .contract import LOAD_NAMES, LOADS, QUANTITIES, UNCERTAINTY_COLUMNS, FloatArray, Quantity, behind
from .order import order_of_tests

if TYPE_CHECKING:  # arrays of loads need no pandas, which takes long to import
    import pandas as pd


def check_column(
    values: npt.ArrayLike, quantity: Quantity, where: str = "loads", may_lack: bool = False
) -> FloatArray:
    """Return `values`, shape (n,), in the unit of a quantity as a contiguous float64 vector, or say which row breaks which limit.

    `where` is the file or place, for the message; `may_lack` says whether NaN may stand for a value that is missing.

    Raises InputError: not numeric, not one-dimensional, not finite or outside the physical limits; the
    message names column, row (counted from 0), value and allowed range.

    Examples
    --------
    >>> from friction_models.loads import MU, check_column
    >>> check_column([0.05, 0.1], MU).tolist()
    [0.05, 0.1]
    >>> check_column([0.05, 50], MU, "points.csv")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: points.csv: column 'mu', row 1: value 50.0 is outside the allowed range 0 to 10
    """
    try:
        given = np.asarray(values)
        # a cast would drop the imaginary part, or the unit of a duration; of a date it makes ticks of a clock, of True a 1
        if given.dtype.kind in "cmMb":
            raise TypeError
        array = np.ascontiguousarray(given, dtype=np.float64)
        # what Python reads as a number, and nobody else: 5_0
        if given.dtype.kind in "OU" and any(map(_no_number, given.flat)):
            raise ValueError
    except (TypeError, ValueError):
        import pandas as pd

        # of numpy's durations pandas makes readable ones
        cells = pd.Series(values.ravel() if isinstance(values, np.ndarray) else values).astype(object)
        text = pd.isna(pd.to_numeric(cells, errors="coerce")).to_numpy() & cells.notna().to_numpy()
        text |= np.array([_no_number(cell) for cell in cells])
        row = int(np.argmax(text))
        unit = "" if quantity.unit == "1" else f" in {quantity.unit}"
        raise InputError(
            f"{where}: column {quantity.name!r}, row {row}: value {cells.iloc[row]!r} is not a number; allowed: numbers{unit}, or nothing"
        ) from None
    if array.ndim != 1:
        raise InputError(f"{where}: column {quantity.name!r} has shape {array.shape}, allowed: (n,)")
    good = np.isfinite(array) & (array >= quantity.lower) & (array <= quantity.upper)
    if may_lack:
        good |= np.isnan(array)
    if not good.all():
        row = int(np.argmin(good))
        raise InputError(
            f"{where}: column {quantity.name!r}, row {row}: value {float(array[row])!r} is outside the allowed "
            f"range {quantity.lower:g} to {quantity.upper:g}{behind(quantity.unit)}"
        )
    return array


def _no_number(cell: object) -> bool:
    """Return whether a cell is none of a measured number, though a cast would make one of it."""
    return isinstance(cell, bool | complex | date | timedelta) or (isinstance(cell, str) and "_" in cell)


@dataclass(frozen=True, eq=False)
class TriboLoads:
    """The loads of n contact points, in the order and units of the contract.

    Parameters
    ----------
    v_rel, T, sigma_n, sd, psi : array_like, shape (n,)
        Loads in mm/s, degC, MPa, mm, 1.
    t : array_like, shape (n,), optional
        Time [s]; needed by effects with memory.
    test_id : array_like, shape (n,), optional
        The test each point belongs to; the points may stand in any order that `t` can sort, see `in_order`.
    context : pandas.DataFrame, optional
        Metadata by test, index `test_id` (tool roughness, lubricant batch, order, ...).
    absent : tuple of str
        Loads that were not measured: their columns hold a constant that says nothing.
    uncertainty : mapping of str to array_like, shape (n,), optional
        Standard uncertainty of some of the loads by their names, in the unit of each (T in K). `stated_uncertainty` checks them:
        only what honours them needs them.

    Raises
    ------
    InputError
        Unequal lengths, values that are not finite or outside the physical limits, time running
        backwards within a test where it does not sort its points.

    Examples
    --------
    >>> from friction_models import TriboLoads
    >>> loads = TriboLoads(v_rel=[50, 100], T=[20, 80], sigma_n=[500, 1000], sd=[0, 5], psi=[1, 1.2])
    >>> len(loads)
    2
    >>> loads.as_array().tolist()
    [[50.0, 20.0, 500.0, 0.0, 1.0], [100.0, 80.0, 1000.0, 5.0, 1.2]]

    A value that cannot be is refused, with column and row:

    >>> TriboLoads.from_array([[50, 20, -1, 0, 1]])
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: loads: column 'sigma_n', row 0: value -1.0 is outside the allowed range 0 to 100000 MPa
    """

    v_rel: FloatArray
    T: FloatArray
    sigma_n: FloatArray
    sd: FloatArray
    psi: FloatArray
    t: FloatArray | None = None
    test_id: npt.NDArray[np.str_] | None = None
    context: pd.DataFrame | None = field(default=None, repr=False)
    absent: tuple[str, ...] = ()
    uncertainty: Mapping[str, FloatArray] | None = field(default=None, repr=False)

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
        for name, values in (self.uncertainty or {}).items():
            if name not in LOAD_NAMES:
                raise unknown_name("load with an uncertainty", name, LOAD_NAMES)
            if np.shape(values) != (len(self.v_rel),):
                raise InputError(
                    f"loads: the uncertainty of {name!r} has shape {np.shape(values)}; allowed: ({len(self.v_rel)},), one a point"
                )
        if self.context is not None and not len(self.context):
            object.__setattr__(self, "context", None)
        if self.context is not None and "test_id" in self.context.columns:
            columns = self.context.columns
            if columns.has_duplicates:
                name = str(columns[columns.duplicated()][0])
                raise InputError(f"tests: column {name!r} stands twice; allowed: each column once")
            table = self.context.assign(test_id=self.context["test_id"].astype(str)).set_index("test_id")
            twice = table.index[table.index.duplicated()]
            if len(twice):
                raise InputError(
                    f"tests: test_id {str(twice[0])!r} stands in {int((table.index == twice[0]).sum())} rows; allowed: one row a test"
                )
            from .plain_cells import with_plain_cells
            from .run_order import with_places
            from .test_numbers import with_numbers

            object.__setattr__(self, "context", with_numbers(with_places(with_plain_cells(table))))
        if self.t is not None:
            order_of_tests(self.test_id, self.t, self.sd)

    @classmethod
    def from_array(cls, array: npt.ArrayLike) -> TriboLoads:
        """Build from an array of shape (n, 5) or (5,) in the order of the contract.

        Raises
        ------
        InputError
            Wrong shape, or values outside the physical limits.
        """
        try:
            matrix = np.atleast_2d(np.asarray(array, dtype=np.float64))
        except (TypeError, ValueError) as error:
            raise InputError(f"loads: {error}; allowed: numbers, of shape (n, {len(LOADS)})") from None
        if matrix.ndim != 2 or matrix.shape[1] != len(LOADS):
            raise InputError(
                f"loads: array has shape {matrix.shape}, allowed: (n, {len(LOADS)}) = {LOAD_NAMES}"
            )
        v_rel, T, sigma_n, sd, psi = matrix.T
        return cls(v_rel, T, sigma_n, sd, psi)

    @classmethod
    def from_frame(cls, data: pd.DataFrame, tests: pd.DataFrame | None = None) -> TriboLoads:
        """Build from a table with the columns of the contract; `t`, `test_id` and uncertainties are taken when there.

        The standard uncertainties stand in the columns `u_sigma_n`, `u_psi`, `u_T`. A load that is not there was not measured: it is `absent`.

        Raises
        ------
        InputError
            No load column, one with nearly the name of a load, or a value outside the physical limits.

        Examples
        --------
        >>> import pandas as pd
        >>> loads = TriboLoads.from_frame(pd.DataFrame({"v_rel": [50.0], "T": [20.0], "sigma_n": [800.0]}))
        >>> loads.absent
        ('sd', 'psi')
        """
        measured = measured_loads(data.columns)
        v_rel, T, sigma_n, sd, psi = (
            data[n].to_numpy() if n in measured else np.full(len(data), STAND_IN[n]) for n in LOAD_NAMES
        )
        t = data["t"].to_numpy() if "t" in data.columns else None
        test_id = data["test_id"].to_numpy() if "test_id" in data.columns else None
        absent = tuple(n for n in LOAD_NAMES if n not in measured)
        stated = {
            load: stated_uncertainty(data[column])
            for load, column in UNCERTAINTY_COLUMNS.items()
            if load in measured and column in data.columns
        }
        return cls(v_rel, T, sigma_n, sd, psi, t, test_id, tests, absent, stated or None)

    def __len__(self) -> int:
        return len(self.v_rel)

    def as_array(self) -> FloatArray:
        """Return the five loads as an array of shape (n, 5), in the order of the contract."""
        return np.column_stack([getattr(self, n) for n in LOAD_NAMES])

    def take(self, rows: npt.ArrayLike) -> TriboLoads:
        """Return the points selected by an index or Boolean array, with time, tests and context.

        Examples
        --------
        >>> loads = TriboLoads.from_array([[50, 20, 500, 0, 1], [50, 40, 500, 5, 1], [50, 60, 500, 10, 1]])
        >>> loads.take([0, 2]).T.tolist()
        [20.0, 60.0]
        >>> loads.take(loads.sd > 1).T.tolist()
        [40.0, 60.0]
        """
        index = np.asarray(rows)
        v_rel, T, sigma_n, sd, psi = self.as_array()[index].T
        t = None if self.t is None else self.t[index]
        test_id = None if self.test_id is None else self.test_id[index]
        stated = None if self.uncertainty is None else {k: u[index] for k, u in self.uncertainty.items()}
        return TriboLoads(v_rel, T, sigma_n, sd, psi, t, test_id, self.context, self.absent, stated)

    def stated_uncertainty(self) -> dict[str, FloatArray]:
        """Return the standard uncertainty of each load that states one above 0 anywhere, by its name, shape (n,).

        Raises
        ------
        InputError
            One that is negative or not finite.

        Examples
        --------
        >>> import pandas as pd
        >>> data = pd.DataFrame({"T": [80.0, 90.0], "u_T": [4.0, 5.0], "psi": [1.2, 1.2], "u_psi": [0.0, 0.0]})
        >>> {load: u.tolist() for load, u in TriboLoads.from_frame(data).stated_uncertainty().items()}
        {'T': [4.0, 5.0]}
        """
        found = {}
        for load, values in (self.uncertainty or {}).items():
            u = np.asarray(values, dtype=np.float64)
            wrong = ~(np.isfinite(u) & (u >= 0.0))
            if wrong.any():
                row, column = int(np.argmax(wrong)), UNCERTAINTY_COLUMNS.get(load, f"u_{load}")
                raise InputError(f"column {column!r}, row {row}: {u[row]}; allowed: finite numbers from 0 on")
            if u.any():
                found[load] = u
        return found

    def without_uncertainty(self) -> TriboLoads:
        """Return the same points without the uncertainties of their loads."""
        return self if self.uncertainty is None else replace(self, uncertainty=None)

    def in_order(self, memory: bool) -> tuple[TriboLoads, npt.NDArray[np.intp]]:
        """Return the points with those of each test together, sorted by time, and the row from which each of them comes.

        `memory` says whether the order matters for what follows: without `t` the distance must then not fall in a test.

        Raises
        ------
        InputError
            See `order_of_tests`.

        Examples
        --------
        >>> one, two = [50, 20, 500, 0, 1], [50, 30, 500, 5, 1]
        >>> loads = TriboLoads(*np.transpose([two, one]), t=[0.1, 0.0], test_id=["a", "a"])
        >>> ordered, rows = loads.in_order(memory=True)
        >>> ordered.t.tolist(), rows.tolist()
        ([0.0, 0.1], [1, 0])
        """
        rows = order_of_tests(self.test_id, self.t, self.sd, memory=memory)
        return (self, np.arange(len(self))) if rows is None else (self.take(rows), rows)

    def segments(self) -> list[slice]:
        """Return one slice a test (the whole range when there are no tests) of points that stand in order.

        Raises
        ------
        ValueError
            The points of a test do not stand together; see `in_order`.

        Examples
        --------
        >>> points = [[50, 20, 500, 0, 1]] * 3
        >>> TriboLoads(*np.transpose(points), test_id=["a", "a", "b"]).segments()
        [slice(0, 2, None), slice(2, 3, None)]
        """
        if self.test_id is None or len(self) == 0:
            return [slice(0, len(self))]
        starts = self.run_starts
        if len(np.unique(self.test_id[starts])) < len(starts):
            raise ValueError("points of a test do not stand together; take in_order() first")
        bounds = [*starts.tolist(), len(self)]
        return [slice(a, b) for a, b in pairwise(bounds)]

    @property
    def run_starts(self) -> npt.NDArray[np.intp]:
        """First point of each run of consecutive points of one test."""
        if self.test_id is None or len(self) == 0:
            return np.arange(min(len(self), 1))
        return np.flatnonzero(np.r_[True, self.test_id[1:] != self.test_id[:-1]])

    def context_column(self, name: str) -> FloatArray | npt.NDArray[np.object_] | None:
        """Return the metadata `name` of each point's test, shape (n,), or None where it is not recorded.

        Examples
        --------
        >>> import pandas as pd
        >>> tests = pd.DataFrame({"test_id": ["a", "b"], "Ra": [0.01, 0.02]})
        >>> points = [[50, 20, 500, 0, 1]] * 3
        >>> loads = TriboLoads(*np.transpose(points), test_id=["a", "a", "b"], context=tests)
        >>> loads.context_column("Ra").tolist()
        [0.01, 0.01, 0.02]
        """
        if self.context is None or self.test_id is None or name not in self.context.columns:
            return None
        starts = self.run_starts  # the table is asked once for each run
        values = self.context[name].reindex(self.test_id[starts]).to_numpy()
        return np.repeat(values, np.diff(starts, append=len(self)))

    def tests_table(self) -> pd.DataFrame | None:
        """Return the metadata with their column `test_id`, as they were given; None without them."""
        if self.context is None or self.context.index.name != "test_id":
            return self.context
        return self.context.reset_index()

    def to_frame(self) -> pd.DataFrame:
        """Return a table with the columns of the contract that are present; loads that were not measured are none."""
        import pandas as pd

        columns: dict[str, object] = {}
        if self.test_id is not None:
            columns["test_id"] = self.test_id
        if self.t is not None:
            columns["t"] = self.t
        columns |= {n: getattr(self, n) for n in LOAD_NAMES if n not in self.absent}
        return pd.DataFrame(columns)


def require_loads(loads: TriboLoads, needed: Iterable[str], model: str) -> None:
    """Raise `InputError` where a load was not measured that a model needs; `model` names it in the message."""
    lacking = [n for n in needed if n in loads.absent]
    if lacking:
        raise InputError(
            f"{model} was given {listed(lacking)} in training, which these data lack; allowed: data with "
            f"{'that column' if len(lacking) == 1 else 'those columns'}, or a model trained without"
        )
