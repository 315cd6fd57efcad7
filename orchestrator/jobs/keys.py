"""What decides the result of a job, as hashes: inputs, file contents, versions and sources."""

from __future__ import annotations

import hashlib
import importlib.util
import json
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from friction_models.common import InputError
from friction_models.common.kept import path_digest

#: Distributions whose version may change a number.
DISTRIBUTIONS = (
    "fmpy", "netCDF4", "numba", "numpy", "onnx", "onnxruntime", "pandas", "pythonfmu",
    "scikit-learn", "scipy", "torch", "xarray",
)  # fmt: skip
#: Files of a package that are sources of its results.
_SOURCES = (".py", ".yaml", ".c", ".h")


def digest(content: Any) -> str:
    """Return the hash of JSON-able content.

    Raises
    ------
    TypeError, ValueError
        Content that JSON does not hold, NaN among it.
    """
    text = json.dumps(content, sort_keys=True, allow_nan=False, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


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
    place = _place(name)
    if place is None:
        raise InputError(f"campaign: code {name!r}; allowed: an importable package or module with sources")
    if place.is_file():
        return [[place.name, path_digest(place)]]
    files = sorted(p for p in place.rglob("*") if p.suffix in _SOURCES and p.is_file())
    return [[p.relative_to(place).as_posix(), path_digest(p)] for p in files]


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
