"""Keys of kept results: hashes of everything that decides a result - inputs, file contents, versions and sources.

Nobody has to list the sources. They follow from the imports: `deciding_code` reads which folders of this package a function
needs. The packages below count as a whole.
"""

from __future__ import annotations

import ast
import json
import os
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, TypedDict

from friction_models.common.cached_results import code_digest, digest, source_files, source_place

from .versions import versions

#: Distributions whose version may change a number.
DISTRIBUTIONS = (
    "fmpy", "h5netcdf", "h5py", "numba", "numpy", "onnx", "onnxruntime", "pandas", "pythonfmu",
    "scikit-learn", "scipy", "torch",
)  # fmt: skip
#: The packages below this one; their sources count in every key.
PACKAGES = ("friction_models", "forming", "sct_twin", "fmus")


class Stamp(TypedDict):
    """What counts in every key beside the inputs: versions of packages, and the hash of the sources."""

    versions: dict[str, str]
    code: str


class ResultKeys:
    """Keys of the results that the functions of a module, or a folder of modules, compute with the sources as they are now.

    Examples
    --------
    >>> keys = ResultKeys("json")
    >>> keys.of({"mu": 0.1}) == keys.of({"mu": 0.1}), keys.of({"mu": 0.1}) == keys.of({"mu": 0.2})
    (True, False)
    """

    def __init__(self, module: str) -> None:
        self._stamp = stamp(deciding_code(module))

    def of(self, content: Any) -> str:
        """Return the key of what is computed from JSON-able content: all that enters it, files as their hashes."""
        text = json.dumps(content, sort_keys=True, default=os.fspath)  # start values may be NaN
        return digest({"content": text, **self._stamp})


@cache
def running_code(module: str) -> str:
    """Return the hash of the sources that decide what the functions of a module return, as this process first found them."""
    return code_digest(deciding_code(module))


def stamp(code: Iterable[str]) -> Stamp:
    """Return the versions, and the hash of the sources of packages and modules as they are now."""
    return {"versions": versions(DISTRIBUTIONS), "code": code_digest(code)}


def deciding_code(module: str, root: str = __package__.partition(".")[0]) -> tuple[str, ...]:
    """Return the packages whose sources decide what the functions of a module return.

    Of `root` these are the folder of the module and all that it imports, also in functions, followed through; and the
    packages below. A module of another package stands for itself: `JobGraph` takes what else counts.

    Examples
    --------
    >>> deciding_code("json")
    ('json',)
    """
    if module.partition(".")[0] != root:
        return (module,)
    found: set[str] = set()
    waiting = {_folder_of(module)}
    while waiting:
        folder = waiting.pop()
        found.add(folder)
        names = {_folder_of(name) for file in source_files(folder) for name in _imported(file, folder)}
        waiting |= {n for n in names - found if n.startswith(f"{root}.") and source_place(n) is not None}
    return (*PACKAGES, *sorted(found))


def _folder_of(module: str) -> str:
    """Return the folder in the package that holds a module: ``orchestrator.cosim``."""
    return ".".join(module.split(".")[:2])


def _imported(file: Path, folder: str) -> Iterator[str]:
    """Return what a file of a folder imports, with the names that it takes from it: ``orchestrator.cosim.system.System``."""
    place = source_place(folder)
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
