"""The order in which tests were run, where a table of tests tells it by dates, or by numbers that begin anywhere."""

from __future__ import annotations

import pandas as pd

from .contract import ORDER

#: How dates are written, beside ISO 8601.
_DATES = ("%d.%m.%Y", "%d.%m.%Y %H:%M", "%d.%m.%Y %H:%M:%S")


def with_places(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table of tests with dates in the column ``order`` as places 1, 2, 3 ...; tests of one date share the place between.

    Numbers that begin above 1, as those of a laboratory do, are counted from the first test: a drift is none of the tests before.
    Other numbers, and other texts, stay as they are.

    Examples
    --------
    >>> with_places(pd.DataFrame({"order": ["2024-02-01", "2024-01-31", "2024-02-01"]}))["order"].tolist()
    [2.5, 1.0, 2.5]
    >>> with_places(pd.DataFrame({"order": ["1.2.2024", "31.1.2024"]}))["order"].tolist()
    [2.0, 1.0]
    >>> with_places(pd.DataFrame({"order": ["run 2", "run 10"]}))["order"].tolist()
    ['run 2', 'run 10']
    >>> with_places(pd.DataFrame({"order": [1003, 1001, 1002]}))["order"].tolist()
    [3, 1, 2]
    """
    if ORDER not in table.columns:
        return table
    values = table[ORDER]
    if (
        not pd.api.types.is_datetime64_any_dtype(values)
        and pd.to_numeric(values, errors="coerce").notna().any()
    ):
        numbers = values if pd.api.types.is_numeric_dtype(values) else pd.to_numeric(values, errors="coerce")
        first = numbers.min()
        counts = numbers.notna().equals(values.notna()) and 1 < first < float("inf")
        return table.assign(**{ORDER: numbers - first + 1}) if counts else table
    for form in ("ISO8601", *_DATES):
        dates = pd.to_datetime(values, format=form, errors="coerce", utc=True)
        if dates.notna().any() and (dates.notna() == values.notna()).all():
            return table.assign(**{ORDER: dates.rank()})
    return table
