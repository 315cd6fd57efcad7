"""Checked points of a table: rows that lack a number are left out, and each test is sorted by time."""

from __future__ import annotations

import os
from dataclasses import dataclass
from hashlib import sha256

import numpy as np
import numpy.typing as npt
import pandas as pd

from ..common.errors import InputError
from .columns import measured_loads, missing_column
from .contract import MEASURED_MU, POINT_COLUMNS, QUANTITIES, TIME
from .order import about_falls, order_of_tests
from .table import read_table
from .tribo_loads import check_column

#: Largest share of the points that may lack a number.
MOST_LACKING = 0.1
#: From this share of negative values on, the sign of mu is wrong and not the zero of the force cell.
MOST_NEGATIVE = 0.5
#: With fewer points two tests may hold the same rounded numbers by chance.
FEW_POINTS = 6


@dataclass(frozen=True)
class Points:
    """Points that can be used."""

    #: The contract's columns first, others behind; the points of a test stand together, ordered by time.
    frame: pd.DataFrame
    #: Row of each point in the table.
    rows: npt.NDArray[np.intp]
    #: What was left out, moved or accepted, one sentence each.
    notes: tuple[str, ...] = ()


def load_points(path: str | os.PathLike[str], need_mu: bool = True) -> pd.DataFrame:
    """Read and check a file of points (CSV or Parquet); see `read_table` and `check_points`."""
    return check_points(read_table(path), str(path), need_mu).frame


def check_points(frame: pd.DataFrame, where: str = "data", need_mu: bool = True) -> Points:
    """Check the columns of the contract; leave out points that lack a number, and put the tests in order.

    Raises InputError: `mu`, `test_id` or all loads are missing, a value is outside its physical limits, many
    numbers are missing, or the times do not order a test; the message names column, row and value.

    Examples
    --------
    >>> table = pd.DataFrame({"test_id": ["a"] * 2, "t": [0.1, 0.0], "sigma_n": [800, 700], "mu": [0.07, 0.08]})
    >>> points = check_points(table)
    >>> points.frame["sigma_n"].tolist()
    [700.0, 800.0]
    >>> points.notes
    ('data: the points of a test are not in order: each test is taken as one, by time',)
    """
    frame = frame.copy(deep=False)  # columns are replaced whole
    if "test_id" not in frame.columns:
        raise missing_column("test_id", frame.columns, where)
    blank = (frame["test_id"].isna() | (frame["test_id"].astype(str).str.strip() == "")).to_numpy()
    if blank.any():
        raise InputError(
            f"{where}: column 'test_id', row {int(np.argmax(blank))}: no value; allowed: any name"
        )
    frame["test_id"] = frame["test_id"].astype(str)
    lacking: dict[str, npt.NDArray[np.bool_]] = {}
    measured = [QUANTITIES[name] for name in measured_loads(frame.columns, where)]
    for quantity in (*measured, *((MEASURED_MU,) if need_mu else ())):
        if quantity.name not in frame.columns:
            raise missing_column(quantity.name, frame.columns, where)
        values = check_column(frame[quantity.name].to_numpy(), quantity, where, may_lack=True)
        frame[quantity.name], lacking[quantity.name] = values, np.isnan(values)
    kept, notes = _with_numbers(frame["test_id"].to_numpy(), lacking, where)
    if TIME.name in frame.columns:
        times = check_column(frame[TIME.name].to_numpy(), TIME, where, may_lack=True)
        frame[TIME.name] = times
        if np.isnan(times).all():
            frame = frame.drop(columns=TIME.name)
        elif np.isnan(times[kept]).any():
            row = int(kept[np.argmax(np.isnan(times[kept]))])
            test = frame["test_id"].iloc[row]
            raise InputError(
                f"{where}: test {test!r}, column 't', row {row}: value nan; allowed: a time for every point, or no column 't'"
            )
    if need_mu:
        notes += about_negative(frame["mu"].to_numpy()[kept], where)
    frame = frame.iloc[kept]
    if need_mu and (twice := repeated_rows(frame)).any():
        notes.append(f"{where}: {repeated_text(twice)}")
        frame, kept = frame[~twice], kept[~twice]
    order = order_of_tests(frame["test_id"], frame.get(TIME.name), frame.get("sd"), where, row_numbers=kept)
    if order is not None:
        moved = frame["test_id"].to_numpy()[order] != frame["test_id"].to_numpy()
        how = "by time" if TIME.name in frame.columns else "in the order of their rows"
        notes.append(
            f"{where}: the points of {'tests are mixed' if moved.any() else 'a test are not in order'}: each test is "
            f"taken as one, {how}"
        )
        frame, kept = frame.iloc[order], kept[order]
    if "sd" in frame.columns:
        notes += [f"{where}: {text}" for text in about_falls(frame["test_id"], frame["sd"])]
    if need_mu:
        notes += about_copies(frame, where)
    front = [c for c in POINT_COLUMNS if c in frame.columns]
    frame = frame[front + [c for c in frame.columns if c not in front]].reset_index(drop=True)
    return Points(frame, kept, tuple(notes))


def repeated_rows(frame: pd.DataFrame) -> npt.NDArray[np.bool_]:
    """Return which points stand twice: the same test, time, loads and mu as an earlier one; none where no time is recorded.

    Examples
    --------
    >>> repeated_rows(pd.DataFrame({"test_id": ["a", "a"], "t": [0.1, 0.1], "mu": [0.07, 0.07]})).tolist()
    [False, True]
    """
    if TIME.name not in frame.columns:
        return np.zeros(len(frame), dtype=bool)
    return np.asarray(frame.duplicated([c for c in POINT_COLUMNS if c in frame.columns]))


def repeated_text(twice: npt.NDArray[np.bool_]) -> str:
    """Return what is said of points that stand twice, as `repeated_rows` finds them."""
    return f"{int(twice.sum())} of {len(twice)} points stand twice in their test, with the same time, loads and mu: they are taken once"


def _with_numbers(
    test_id: npt.NDArray[np.object_], lacking: dict[str, npt.NDArray[np.bool_]], where: str
) -> tuple[npt.NDArray[np.intp], list[str]]:
    """Return the rows with a number in every column, and what to say of the others.

    Raises InputError: more than `MOST_LACKING` of the points lack a number, or all points of a test.
    """
    bad = np.any(list(lacking.values()), axis=0)
    if not bad.any():
        return np.arange(len(bad)), []
    per_test = pd.Series(bad).groupby(test_id).transform("all").to_numpy()
    if bad.mean() > MOST_LACKING or per_test.any():
        row = int(np.argmax(per_test if per_test.any() else bad))
        name = next(n for n, lacks in lacking.items() if lacks[row])
        much = f"no point of test {test_id[row]!r} is whole" if per_test.any() else "too many lack a number"
        raise InputError(
            f"{where}: column {name!r}, row {row}: value nan; {int(bad.sum())} of {len(bad)} points lack a number, {much}; "
            f"allowed: at most {MOST_LACKING:.0%} of the points, and no whole test"
        )
    counts = {name: int(lacks.sum()) for name, lacks in lacking.items() if lacks.any()}
    if len(counts) == 1:
        why = f"{next(iter(counts))} is not a number"
    else:
        why = "not a number: " + ", ".join(f"{name} in {count}" for name, count in counts.items())
    first = f"first: row {int(np.argmax(bad))}"
    return np.flatnonzero(~bad), [f"{where}: {int(bad.sum())} of {len(bad)} points left out: {why} ({first})"]


def about_copies(frame: pd.DataFrame, where: str) -> list[str]:
    """Return what to say of tests that hold the same loads and the same friction, point by point.

    Of a few points, and of friction that never changes, the same numbers say little: they are passed over.

    Examples
    --------
    >>> one = pd.DataFrame({"test_id": "a", "sd": range(6), "mu": [0.08, 0.09, 0.07, 0.08, 0.06, 0.07]})
    >>> about_copies(pd.concat([one, one.assign(test_id="b")]), "points.csv")
    ["points.csv: tests 'a' and 'b' hold the same numbers: are they copies?"]
    """
    numbers = frame[[*measured_loads(frame.columns, where), "mu"]].to_numpy(np.float64)
    known: dict[bytes, list[str]] = {}
    for test, rows in frame.groupby("test_id", sort=False).indices.items():
        if len(rows) >= FEW_POINTS and np.ptp(numbers[rows, -1]) > 0.0:
            known.setdefault(sha256(numbers[rows].tobytes()).digest(), []).append(str(test))
    same = [" and ".join(map(repr, tests)) for tests in known.values() if len(tests) > 1]
    if not same:
        return []
    more = f", and {len(same) - 3} more sets" if len(same) > 3 else ""
    shown = "; ".join(f"tests {names}" for names in same[:3]) + more
    return [f"{where}: {shown} hold the same numbers: are they copies?"]


def about_negative(mu: npt.NDArray[np.float64], where: str) -> list[str]:
    """Return what to say of slightly negative friction.

    Raises InputError: so many values are negative that no zero error explains them.

    Examples
    --------
    >>> about_negative(np.array([0.05, -0.001, 0.06]), "points.csv")[0][:52]
    'points.csv: 1 of 3 values of mu are below 0, the low'
    """
    negative = int((mu < 0.0).sum())
    if not negative:
        return []
    lowest = f"the lowest {float(mu.min()):.4g}"
    if negative > MOST_NEGATIVE * len(mu):
        raise InputError(
            f"{where}: column 'mu': {negative} of {len(mu)} values are below 0, {lowest}; allowed: friction against the "
            "sliding as a positive number (is the sign of the force wrong?)"
        )
    return [
        f"{where}: {negative} of {len(mu)} values of mu are below 0, {lowest}: taken as they are (a zero error of the force "
        f"cell; allowed: down to {MEASURED_MU.lower:g})"
    ]
