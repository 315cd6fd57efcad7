"""Versions of the project, of Python and of the packages that results depend on."""

from __future__ import annotations

import platform
from collections.abc import Iterable

from friction_models.models.model_card import package_version

PACKAGES = ("fmpy", "h5netcdf", "numpy", "onnx", "onnxruntime", "pandas", "pythonfmu", "scipy")


def versions(packages: Iterable[str] = PACKAGES) -> dict[str, str]:
    """Return the versions of tribofmu, Python and the packages that results depend on.

    Examples
    --------
    >>> list(versions(["numpy"]))
    ['python', 'tribofmu', 'numpy']
    """
    return {"python": platform.python_version()} | {
        name: package_version(name) or "not installed" for name in ("tribofmu", *packages)
    }
