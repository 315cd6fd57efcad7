"""Names of a package that are imported at first use: what a program does not need costs it nothing."""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any


def lazily(package: str, file: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Return `__getattr__`, `__dir__` and `__all__` of a package that imports its names in `file` under ``if TYPE_CHECKING``.

    ``from .module import name as name`` there hands a name on, for type checkers and here: each name stands once.
    ``from . import module as module`` hands on a module itself.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     file = Path(place) / "__init__.py"
    ...     _ = file.write_text("if TYPE_CHECKING: from .decoder import JSONDecoder as JSONDecoder")
    ...     get, _, names = lazily("json", str(file))
    >>> names, get("JSONDecoder").__name__
    (['JSONDecoder'], 'JSONDecoder')
    """
    blocks = [node for node in ast.parse(Path(file).read_bytes()).body if isinstance(node, ast.If)]
    imports = [node for block in blocks for node in block.body if isinstance(node, ast.ImportFrom)]
    module_of = {
        alias.name: "." * node.level + (node.module or "")
        for node in imports
        for alias in node.names
        if alias.asname == alias.name
    }

    def get(name: str) -> Any:
        if name not in module_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        if module_of[name] == ".":
            return importlib.import_module(f".{name}", package)
        return getattr(importlib.import_module(module_of[name], package), name)

    def known() -> list[str]:
        return sorted({*vars(sys.modules[package]), *module_of})

    return get, known, sorted(module_of)
