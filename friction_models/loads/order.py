"""Order of points: the points of a test stand together, sorted by time."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..common.errors import InputError
from ..common.wording import first_names

#: A distance that falls back by more than this share of what a test slides is out of order, not noise.
FALL = 0.01

Rows = npt.NDArray[np.intp]
Names = npt.NDArray[np.str_]
Numbers = npt.NDArray[np.float64]


def order_of_tests(
    test_id: npt.ArrayLike | None,
    t: npt.ArrayLike | None,
    sd: npt.ArrayLike | None,
    where: str = "loads",
    memory: bool = False,
    row_numbers: npt.ArrayLike | None = None,
) -> Rows | None:
    """Return the rows in the order of their tests, None where they stand in it.

    The points of a test come together where the test begins; where their time runs backwards they are sorted by it.

    `test_id`, `t` [s] and `sd` [mm], each of shape (n,), are test, time and sliding distance of each point; without
    `test_id` all are of one test. `memory` says whether what follows depends on the order: without `t` the distance
    must then not fall within a test. `row_numbers` are the rows of the points in their file, for messages.

    Raises InputError: times that run backwards and do not order a test: the same one twice, or a distance
    that falls along them; for `memory` no time and a distance that falls, or a time that stands still.

    Examples
    --------
    >>> order_of_tests(["a", "b", "a"], t=[0.0, 0.0, 0.1], sd=[0.0, 0.0, 5.0]).tolist()
    [0, 2, 1]
    >>> order_of_tests(["a", "a"], t=[0.0, 0.1], sd=[0.0, 5.0]) is None
    True
    """
    # A distance that was not measured says nothing against any order.
    way = np.zeros(np.shape(np.asarray(test_id))) if sd is None else np.asarray(sd, dtype=np.float64)
    shown = np.arange(len(way)) if row_numbers is None else np.asarray(row_numbers)
    names = np.full(len(way), "") if test_id is None else np.asarray(test_id).astype(str)
    number, whole = _numbered(names)
    together = None if whole else np.argsort(number, kind="stable")
    rows = np.arange(len(way)) if together is None else together
    if t is None:
        if memory:
            fall = _falls(way[rows], names[rows])
            if fall is not None:
                raise InputError(
                    f"{where}: {_named(names, rows[fall])}column 'sd', row {shown[rows[fall]]}: {way[rows[fall]]:g} mm comes after "
                    f"{way[rows[fall - 1]]:g} mm and there is no time 't'; allowed: points in order, or 't' to sort them by"
                )
        return together
    time = np.asarray(t, dtype=np.float64)
    if memory:
        _refuse_no_time(names[rows], time[rows], way[rows], shown[rows], where)
    same = names[rows][1:] == names[rows][:-1]
    back = (np.diff(time[rows]) < 0.0) & same
    if not back.any():
        return together
    by_time = np.lexsort((time, number))
    times, of = time[by_time], names[by_time]
    disordered = np.isin(of, np.unique(names[rows][1:][back]))
    twice = (np.diff(times) == 0.0) & (of[1:] == of[:-1]) & disordered[1:]
    fall = None if twice.any() else _falls(way[by_time][disordered], of[disordered])
    if twice.any() or fall is not None:
        at = int(np.argmax(back)) + 1
        if fall is None:
            first = int(np.argmax(twice))
            at = int(np.argmax(back & (names[rows][1:] == of[first]))) + 1
            why = f"{float(times[first])!r} s stands there twice"
        else:
            row = by_time[disordered][fall]
            why = f"in the order of 't' the distance falls to {float(way[row])!r} mm in row {shown[row]}"
        raise InputError(
            f"{where}: {_named(names, rows[at])}column 't', row {shown[rows[at]]}: time {float(time[rows[at]])!r} s comes after "
            f"{float(time[rows[at - 1]])!r} s and {why}; time must not run backwards within a test, or must sort its points"
        )
    return by_time


def _refuse_no_time(names: Names, time: Numbers, way: Numbers, shown: Rows, where: str) -> None:
    """Refuse a test that slides while its time stands still."""
    import pandas as pd

    tests = pd.DataFrame({"t": time, "sd": way}).groupby(names)
    span = tests.max() - tests.min()
    still = span.index[(span["t"] == 0.0) & (span["sd"] > 0.0)]
    if len(still):
        at = int(np.argmax(names == still[0]))
        raise InputError(
            f"{where}: {_named(names, at)}column 't', row {shown[at]}: {float(time[at])!r} s at every point of the test; "
            "allowed: times that increase, or no column 't'"
        )


def _numbered(names: Names) -> tuple[Rows, bool]:
    """Return the number of each point's test in the order of appearance, and whether every test is in one piece."""
    starts = np.r_[True, names[1:] != names[:-1]] if len(names) else np.zeros(0, dtype=bool)
    piece = np.cumsum(starts) - 1
    runs = names[starts]
    if len(np.unique(runs)) == len(runs):
        return piece, True
    import pandas as pd

    return np.asarray(pd.factorize(runs)[0][piece], dtype=np.intp), False


def about_falls(test_id: npt.ArrayLike, sd: npt.ArrayLike) -> list[str]:
    """Return what to say of tests within which the distance [mm] falls: points out of order; both of shape (n,).

    Examples
    --------
    >>> about_falls(["a", "a", "b", "b"], [0.0, 5.0, 5.0, 0.0])
    ['sd falls within one test (b): are its points out of order? they are taken in the order of the table']
    """
    names = np.asarray(test_id).astype(str)
    tests = list(dict.fromkeys(names[_fallen(np.asarray(sd, dtype=np.float64), names)]))
    if not tests:
        return []
    where = "one test" if len(tests) == 1 else f"{len(tests)} tests"
    whose = "its" if len(tests) == 1 else "their"
    return [
        f"sd falls within {where} ({first_names(tests)}): are {whose} points out of order? they are taken in the order of the table"
    ]


def _falls(way: Numbers, names: Names) -> int | None:
    """Return where the distance first falls within a test, None where it does not."""
    fallen = _fallen(way, names)
    return int(np.argmax(fallen)) if fallen.any() else None


def _fallen(way: Numbers, names: Names) -> npt.NDArray[np.bool_]:
    """Return which points lie behind an earlier one of their test, shape (n,)."""
    if len(way) < 2:
        return np.zeros(len(way), dtype=bool)
    import pandas as pd

    number = np.cumsum(np.r_[True, names[1:] != names[:-1]])
    tests = pd.Series(way).groupby(number)
    highest = tests.cummax().to_numpy()
    span = tests.transform("max").to_numpy() - tests.transform("min").to_numpy()
    return np.asarray(highest - way > FALL * span)


def _named(names: Names, row: int) -> str:
    return f"test {str(names[row])!r}, " if names[row] else ""
