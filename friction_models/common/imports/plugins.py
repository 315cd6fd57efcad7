"""Classes that installed packages offer under an entry point."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from importlib.metadata import entry_points
from typing import Any


def offered(group: str, what: str, fault: Callable[[Any], str | None]) -> Iterator[Any]:
    """Yield what installed packages offer in a group of entry points.

    One that cannot be imported, or of which `fault` says what is wrong, is left out with a warning that names it.
    """
    for entry in entry_points(group=group):
        try:
            found = entry.load()
            reason = fault(found)
        except Exception as error:
            reason = str(error)
        if reason is None:
            yield found
        else:
            warnings.warn(
                f"{what} plug-in {entry.name!r} ({entry.value}) is left out: {reason}", stacklevel=2
            )
