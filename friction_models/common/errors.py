"""Errors that a user can act on: one sentence with the name, the value, what is allowed, the nearest name."""

from __future__ import annotations

import difflib
import math
import os
import re
from collections.abc import Iterable
from pathlib import Path

_OBEYED = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")


class InputError(ValueError):
    """Bad input from a user: a file, a name, a value or a unit that cannot be used.

    The message is one sentence that names the file or name, the value, what is allowed and, for
    a misspelt name, the nearest valid one. The command line prints it and exits with code 2.

    Examples
    --------
    >>> raise unknown_name("effect", "stribek", ["stribeck", "viscous"])
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: unknown effect 'stribek'; allowed: stribeck, viscous; did you mean 'stribeck'?
    """


def nearest(name: str, allowed: Iterable[str]) -> str | None:
    """Return the allowed name closest to `name`, or else one that begins with it; None when nothing resembles it.

    Examples
    --------
    >>> nearest("vrel", ["v_rel", "sigma_n", "T"])
    'v_rel'
    >>> nearest("process", ["radioss", "native"]) is None
    True
    """
    pool = {str(a).casefold(): str(a) for a in allowed}
    given = str(name).casefold()
    cutoff = 0.6 if len(given) > 3 else 0.5  # of two letters one may be wrong
    hits = difflib.get_close_matches(given, list(pool), n=1, cutoff=cutoff)
    hits = hits or [name for name in pool if given and name.startswith(given)]
    return pool[hits[0]] if hits else None


def unknown_name(kind: str, name: object, allowed: Iterable[str], where: str = "") -> InputError:
    """Build the error for a name that is none of those allowed; the caller raises it.

    `kind` says what the name stands for, for example ``"effect"``, and `where` in which file or place it stood.

    Examples
    --------
    >>> print(unknown_name("mode", "jakobi", ["gauss_seidel", "jacobi"], "system.yaml"))
    system.yaml: unknown mode 'jakobi'; allowed: gauss_seidel, jacobi; did you mean 'jacobi'?
    """
    names = sorted(str(a) for a in allowed)
    hint = nearest(str(name), names)
    place = f"{where}: " if where else ""
    guess = f"; did you mean {hint!r}?" if hint else ""
    return InputError(f"{place}unknown {kind} {str(name)!r}; allowed: {', '.join(names)}{guess}")


def given_path(value: object, allowed: str) -> Path:
    """Return a path that was given as text or as a path; `allowed` says of what.

    Raises InputError: something else.

    Examples
    --------
    >>> given_path(None, "a model folder")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: None is no path; allowed: the path of a model folder
    """
    if not isinstance(value, str | os.PathLike):
        raise InputError(f"{shown(repr(value), 60)} is no path; allowed: the path of {allowed}")
    return Path(value)


def check_readable(file: Path, most: float = math.inf, allowed: str = "a file") -> None:
    """Check that a file is there and not larger than `most` bytes; `allowed` says what it should be.

    Raises InputError: no such file, a folder, a pipe or the like, a link that leads nowhere, or too large.

    Examples
    --------
    >>> check_readable(Path("no.yaml"), 1000, "a YAML file")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: no.yaml: no such file; allowed: a YAML file
    """
    if not file.is_file():
        if file.is_dir():
            found = "is a folder"
        elif file.exists():
            found = "is a pipe or a device"
        else:
            found = "is a link that leads to no file" if file.is_symlink() else "no such file"
        raise InputError(f"{file}: {found}; allowed: {allowed}")
    if (size := file.stat().st_size) > most:
        raise InputError(f"{file}: {size} bytes, allowed: at most {most}")


def inert(text: str) -> str:
    """Return a text without what a terminal would obey: control characters, and those that turn the direction of writing.

    Its lines and blanks stay.

    Examples
    --------
    >>> inert("a\\x1b[31mb\\tc\\u202ed")
    'a[31mb\\tcd'
    """
    return _OBEYED.sub("", text)


def shown(text: object, most: int = 300) -> str:
    """Return a text from elsewhere on one line, without what a terminal would obey, and not longer than `most`.

    Examples
    --------
    >>> shown("two   words ")
    'two words'
    >>> shown("a long text", most=8)
    'a lo ...'
    """
    # No more of it is looked at than could be shown: it may be of any size.
    line = " ".join(str(text)[: 20 * most].split())
    line = "".join(c for c in line if c.isprintable())
    return line if len(line) <= most else f"{line[: most - 4]} ..."
