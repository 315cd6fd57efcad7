"""Names of a package that are imported at first use: what a program does not need costs it nothing."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any


def lazily(package: str, places: Mapping[str, Sequence[str]]) -> tuple[Callable[[str], Any], list[str]]:
    """Return `__getattr__` and `__all__` of a package from the names that each of its modules holds.

    Names under ``"."`` are the modules themselves.

    Examples
    --------
    >>> get, names = lazily("json", {".decoder": ["JSONDecoder"]})
    >>> names, get("JSONDecoder").__name__
    (['JSONDecoder'], 'JSONDecoder')
    """
    module_of = {name: module for module, names in places.items() for name in names}

    def get(name: str) -> Any:
        if name not in module_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        if module_of[name] == ".":
            return importlib.import_module(f".{name}", package)
        return getattr(importlib.import_module(module_of[name], package), name)

    return get, sorted(module_of)
