"""The time that files state as theirs: of the environment, so that the same input gives the same bytes."""

from __future__ import annotations

import datetime
import os

from .errors import InputError

VARIABLE = "SOURCE_DATE_EPOCH"


def build_time() -> datetime.datetime | None:
    """Return the time that the variable ``SOURCE_DATE_EPOCH`` gives, or None without it.

    Raises InputError: it is no number of seconds.

    Examples
    --------
    >>> os.environ["SOURCE_DATE_EPOCH"] = "86400"
    >>> build_time().isoformat()
    '1970-01-02T00:00:00+00:00'
    >>> del os.environ["SOURCE_DATE_EPOCH"]
    """
    given = os.environ.get(VARIABLE, "")
    if not given:
        return None
    try:
        return datetime.datetime.fromtimestamp(int(given), tz=datetime.UTC)
    except (ValueError, OverflowError, OSError):
        raise InputError(f"{VARIABLE}: {given[:40]!r}; allowed: seconds since 1970, a whole number") from None
