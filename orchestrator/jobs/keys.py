"""Keys of kept results: hashes of everything that decides a result - inputs, file contents, versions and sources.

Nobody has to list the sources. They follow from the imports: `deciding_code` reads which folders of this package a function
needs. The packages below count as a whole.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import json
import os
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, TypedDict

from friction_models.common import InputError
from friction_models.common.kept import path_digest

from .versions import versions

#: Distributions whose version may change a number.
DISTRIBUTIONS = (
    "fmpy", "netCDF4", "numba", "numpy", "onnx", "onnxruntime", "pandas", "pythonfmu",
    "scikit-learn", "scipy", "torch", "xarray",
)  # fmt: skip
#: The packages below this one; their sources count in every key.
PACKAGES = ("friction_models", "forming", "sct_twin", "fmus")
#: Files of a package that are sources of its results.
_SOURCES = (".py", ".yaml", ".c", ".h")


class Stamp(TypedDict):
    """What counts in every key beside the inputs: versions of packages, and the hash of the sources."""

    versions: dict[str, str]
    code: str


def digest(content: Any) -> str:
    """Return the hash of JSON-able content.

    Raises
    ------
    TypeError, ValueError
        Content that JSON does not hold, NaN among it.
    """
    text = json.dumps(content, sort_keys=True, allow_nan=False, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


class ResultKeys:
    """Keys of the results that the functions of a module compute, with the sources as they are now.

    Parameters
    ----------
    module : str
        Name of the module, or of a folder of modules.
    """

    def __init__(self, module: str) -> None:
        self._stamp = stamp(deciding_code(module))

    def of(self, content: Any) -> str:
        """Return the key of what is computed from JSON-able content: all that enters it, files as their hashes."""
        text = json.dumps(content, sort_keys=True, default=os.fspath)  # start values may be NaN
        return digest({"content": text, **self._stamp})


def stamp(code: Iterable[str]) -> Stamp:
    """Return the versions, and the hash of the sources of packages and modules as they are now."""
    return {"versions": versions(DISTRIBUTIONS), "code": code_digest(code)}


def deciding_code(module: str, root: str = __package__.partition(".")[0]) -> tuple[str, ...]:
    """Return the packages whose sources decide what the functions of a module return.

    Of `root` these are the folder of the module and all that it imports, also in functions, followed through; and the
    packages below. A module of another package stands for itself: `Campaign` takes what else counts.

    Raises
    ------
    InputError
        A folder without sources.
    """
    if module.partition(".")[0] != root:
        return (module,)
    found: set[str] = set()
    waiting = {_folder_of(module)}
    while waiting:
        folder = waiting.pop()
        found.add(folder)
        names = {_folder_of(name) for file in _files(folder) for name in _imported(file, folder)}
        waiting |= {n for n in names - found if n.startswith(f"{root}.") and _place(n) is not None}
    return (*PACKAGES, *sorted(found))


def _folder_of(module: str) -> str:
    """Return the folder in the package that holds a module: ``orchestrator.cosim``."""
    return ".".join(module.split(".")[:2])


def _imported(file: Path, folder: str) -> Iterator[str]:
    """Return what a file of a folder imports, with the names that it takes from it: ``orchestrator.cosim.system.System``."""
    place = _place(folder)
    if file.suffix != ".py" or place is None:
        return
    package = folder.split(".")
    package = [*package, *file.parent.relative_to(place).parts] if place.is_dir() else package[:-1]
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            start = package[: len(package) - node.level + 1] if node.level else []
            base = [*start, node.module] if node.module else start
            yield from (".".join([*base, alias.name]) for alias in node.names)


def code_digest(names: Iterable[str]) -> str:
    """Return the hash of the sources of packages and modules, as they lie on the disk now.

    Raises
    ------
    InputError
        No such package.
    """
    return digest({name: _sources(name) for name in sorted(set(names))})


def _sources(name: str) -> list[list[str]]:
    """Return file names and content hashes of one package or module."""
    files = _files(name)
    top = _place(name)
    return [[(p.name if p == top else p.relative_to(top or p).as_posix()), path_digest(p)] for p in files]


def _files(name: str) -> list[Path]:
    """Return the sources of a package or module."""
    place = _place(name)
    if place is None:
        raise InputError(f"campaign: code {name!r}; allowed: an importable package or module with sources")
    if place.is_file():
        return [place]
    return sorted(p for p in place.rglob("*") if p.suffix in _SOURCES and p.is_file())


@cache
def _place(name: str) -> Path | None:
    try:
        spec = importlib.util.find_spec(name)
    except (ImportError, ValueError):
        return None
    if spec is None or spec.origin is None:
        return None
    file = Path(spec.origin)
    return file.parent if file.name == "__init__.py" else file
