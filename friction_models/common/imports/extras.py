"""Libraries that only some installations have: the extras of the package."""

from __future__ import annotations

from importlib.util import find_spec

from ..errors import InputError


def need(library: str, extra: str, what: str) -> None:
    """Raise InputError where a library of an extra that something needs is not installed; the sentence names the extra.

    Examples
    --------
    >>> need("json", "reports", "this example")
    >>> need("no_such_library", "reports", "this example")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: this example needs no_such_library, which is not installed; pip install 'tribofmu[reports]' brings it
    """
    if find_spec(library) is None:
        raise InputError(
            f"{what} needs {library}, which is not installed; pip install 'tribofmu[{extra}]' brings it"
        )
