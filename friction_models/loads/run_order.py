"""The order in which tests were run, where a table of tests tells it by dates."""

from __future__ import annotations

import pandas as pd

from .contract import ORDER

#: How dates are written, beside ISO 8601.
_DATES = ("%d.%m.%Y", "%d.%m.%Y %H:%M", "%d.%m.%Y %H:%M:%S")


def with_numbered_dates(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table of tests with dates in the column ``order`` as places 1, 2, 3 ...; tests of one date share the place between.

    Numbers and other texts stay as they are.

    Examples
    --------
    >>> with_numbered_dates(pd.DataFrame({"order": ["2024-02-01", "2024-01-31", "2024-02-01"]}))["order"].tolist()
    [2.5, 1.0, 2.5]
    >>> with_numbered_dates(pd.DataFrame({"order": ["1.2.2024", "31.1.2024"]}))["order"].tolist()
    [2.0, 1.0]
    >>> with_numbered_dates(pd.DataFrame({"order": ["run 2", "run 10"]}))["order"].tolist()
    ['run 2', 'run 10']
    """
    if ORDER not in table.columns:
        return table
    values = table[ORDER]
    if (
        not pd.api.types.is_datetime64_any_dtype(values)
        and pd.to_numeric(values, errors="coerce").notna().any()
    ):
        return table
    for form in ("ISO8601", *_DATES):
        dates = pd.to_datetime(values, format=form, errors="coerce", utc=True)
        if dates.notna().any() and (dates.notna() == values.notna()).all():
            return table.assign(**{ORDER: dates.rank()})
    return table
