"""Errors that a user can act on: one sentence with the name, the value, what is allowed, the nearest name."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class InputError(ValueError):
    """Bad input from a user: a file, a name, a value or a unit that cannot be used.

    The message is one sentence that names the file or name, the value, what is allowed and, for
    a misspelt name, the nearest valid one. The command line prints it and exits with code 2.

    Examples
    --------
    >>> from friction_models import InputError, make_model
    >>> try:
    ...     make_model("constant", muu=0.1)
    ... except InputError as error:
    ...     print(error)
    unknown parameter of constant 'muu'; allowed: mu; did you mean 'mu'?
    """


def nearest(name: str, allowed: Iterable[str]) -> str | None:
    """Return the allowed name closest to `name`, or None when nothing resembles it.

    Examples
    --------
    >>> nearest("linar", ["constant", "linear", "ffnn"])
    'linear'
    >>> nearest("xyz", ["constant", "linear", "ffnn"]) is None
    True
    """
    pool = {str(a).casefold(): str(a) for a in allowed}
    hits = difflib.get_close_matches(str(name).casefold(), list(pool), n=1, cutoff=0.5)
    return pool[hits[0]] if hits else None


def unknown_name(kind: str, name: object, allowed: Iterable[str], where: str = "") -> InputError:
    """Build the error for a name outside a closed set.

    Parameters
    ----------
    kind : str
        What the name stands for, for example ``"effect"``.
    name : object
        The name that was given.
    allowed : iterable of str
        The closed set.
    where : str
        File or place where the name stood, or empty.

    Returns
    -------
    InputError
        To be raised by the caller.

    Examples
    --------
    >>> print(unknown_name("effect", "stribek", ["stribeck", "viscous"]))
    unknown effect 'stribek'; allowed: stribeck, viscous; did you mean 'stribeck'?
    """
    names = sorted(str(a) for a in allowed)
    hint = nearest(str(name), names)
    place = f"{where}: " if where else ""
    guess = f"; did you mean {hint!r}?" if hint else ""
    return InputError(f"{place}unknown {kind} {str(name)!r}; allowed: {', '.join(names)}{guess}")


def shown(text: object, most: int = 300) -> str:
    """Return a text from elsewhere on one line, without what a terminal would obey, and not longer than `most`.

    Examples
    --------
    >>> shown("two   words"), shown("x" * 20, most=10)
    ('two words', 'xxxxxx ...')
    """
    # No more of it is looked at than could be shown: it may be of any size.
    line = " ".join(str(text)[: 20 * most].split())
    line = "".join(c for c in line if c.isprintable())
    return line if len(line) <= most else f"{line[: most - 4]} ..."
