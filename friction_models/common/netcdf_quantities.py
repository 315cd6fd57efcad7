"""Variables of netCDF files as quantities: in the units that the project computes with, over the same steps and points."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np

from .errors import InputError
from .netcdf_files import FloatArray, Numbers
from .units import conversion, differs


def in_units(
    found: Numbers, wanted: Mapping[str, str], where: Path, differences: Collection[str] = ()
) -> dict[str, FloatArray]:
    """Return all values, those of `wanted` in the units given there; where the file names no unit, they are taken for that.

    `differences` are values that have no zero of their own, as errors of a temperature.
    Raises InputError: a unit that is not known, or measures something else.

    Examples
    --------
    >>> found = Numbers({"sigma_n": np.array([0.5, 1.0])}, {"sigma_n": "GPa"}, {}, ())
    >>> in_units(found, {"sigma_n": "MPa"}, Path("contact.nc"))["sigma_n"].tolist()
    [500.0, 1000.0]
    >>> in_units(found, {"sigma_n": "kN"}, Path("contact.nc"))
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: contact.nc: unknown unit of column 'sigma_n' 'GPa'; allowed: MN, N, kN
    """
    values = dict(found.values)
    for name in values:
        if differs(name, found.units[name], wanted):
            factor, offset = conversion(wanted[name], found.units[name], name, str(where))
            values[name] = factor * values[name] + (0.0 if name in differences else offset)
    return values


def check_shapes(
    values: Mapping[str, FloatArray], names: Collection[str], steps: FloatArray, where: Path
) -> None:
    """Check that all of these variables run over the given steps, and over the same points.

    Raises InputError, which names the first that does not.
    """
    if steps.ndim != 1 or not np.isfinite(steps).all():
        raise InputError(f"{where}: steps of shape {steps.shape}; allowed: one finite number a step")
    shape = next(
        (v.shape for n in names if (v := values[n]).shape[:1] == steps.shape), (steps.size, "points")
    )
    for name in names:
        if values[name].shape != shape:
            allowed = f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''}), as the steps and the other variables"
            raise InputError(
                f"{where}: variable {name!r} has the shape {values[name].shape}; allowed: {allowed}"
            )
