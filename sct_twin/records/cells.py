"""Cells of test tables and entries of channel maps: empty or not, number or not."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from friction_models.common import InputError, unknown_name
from friction_models.common.wording import kind_of
from friction_models.common.yaml_files import read_yaml

#: Largest file of a map of columns.
MAX_MAP_BYTES = 1_000_000
#: What a cell of a test table holds.
Cell = str | float | None


def is_given(value: Any) -> bool:
    """Whether a cell of a test table holds something.

    >>> [is_given(cell) for cell in (0.0, "A", "", None, float("nan"))]
    [True, True, False, False, False]
    """
    return value is not None and value != "" and not (isinstance(value, float) and math.isnan(value))


def check_keys(content: Iterable[Any], allowed: Sequence[str], where: str) -> None:
    """Refuse keys of a channel map that it does not know.

    Raises InputError: names the key and the nearest one that is allowed.
    """
    for key in content:
        if key not in allowed:
            raise unknown_name("key", key, allowed, where)


def column_entry(entry: Any, keys: Sequence[str], here: str) -> Mapping[str, Any]:
    """Return what a map says of a column, by known keys; a text alone is its quantity."""
    if isinstance(entry, str):
        entry = {"quantity": entry}
    if not isinstance(entry, Mapping):
        raise InputError(f"{here}: {entry!r}; allowed: {', '.join(keys)}")
    check_keys(entry, keys, here)
    return entry


def map_content(
    source: str | os.PathLike[str] | Mapping[str, Any], what: str, keys: Sequence[str]
) -> tuple[Mapping[str, Any], str]:
    """Return the content of a map of columns (a YAML file, or what such a file holds), and how messages name it.

    Raises InputError: no such file, too large, unreadable YAML, no keys, or unknown ones.
    """
    where = what
    content: Any = source
    if not isinstance(source, Mapping):
        where, path = str(source), Path(source)
        content = read_yaml(path, MAX_MAP_BYTES, f"a YAML file with a {what}")
    if not isinstance(content, Mapping):
        raise InputError(f"{where}: holds {kind_of(content)}; allowed: keys {', '.join(keys)}")
    check_keys(content, keys, where)
    return content, where
