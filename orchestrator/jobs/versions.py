"""Versions of the project, of Python and of the packages that results depend on."""

from __future__ import annotations

import platform
from collections.abc import Iterable
from importlib import metadata

PACKAGES = ("fmpy", "h5netcdf", "numpy", "onnx", "onnxruntime", "pandas", "pythonfmu", "scipy")


def versions(packages: Iterable[str] = PACKAGES) -> dict[str, str]:
    """Return the versions of tribofmu, Python and the packages that results depend on.

    Examples
    --------
    >>> list(versions(["numpy"]))
    ['python', 'tribofmu', 'numpy']
    """
    return {"python": platform.python_version()} | {name: _version(name) for name in ("tribofmu", *packages)}


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"
