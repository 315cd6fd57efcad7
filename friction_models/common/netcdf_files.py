"""netCDF files: packed when written, and no traceback beside the error when a damaged one is read.

h5netcdf writes and reads them at once. xarray would load pandas first, and all of dask where it is installed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .errors import InputError

if TYPE_CHECKING:
    import h5netcdf

#: How values are packed; `shuffle` is what the reference library does unasked.
PACKED: dict[str, Any] = {"compression": "gzip", "compression_opts": 4, "shuffle": True}
#: What a damaged file raises while it is read.
DAMAGED_NETCDF = (OSError, ValueError, KeyError, RuntimeError, TypeError, AttributeError)


class Variable(NamedTuple):
    """Values over named dimensions, with their unit and meaning."""

    dimensions: tuple[str, ...]
    values: npt.NDArray[Any]
    attributes: Mapping[str, str]


class Dataset(NamedTuple):
    """What a netCDF file holds; ``xarray.Dataset(*data)`` is the same data set."""

    variables: Mapping[str, Variable]
    #: One that does not run along the dimension of its own name is named in the attribute `coordinates` of the variables.
    coordinates: Mapping[str, Variable]
    attributes: Mapping[str, str | int | float]


def library() -> ModuleType:
    """Return h5netcdf, made such that it lets go of a file that it could not open without an error of its own."""
    import h5netcdf

    # Its files set this while they open, and ask for it when they are thrown away, opened or not.
    h5netcdf.File._writable = False
    module: ModuleType = h5netcdf
    return module


def write_dataset(data: Dataset, path: Path) -> None:
    """Write a data set, its variables packed.

    Raises InputError: a name with a slash, which would be a group of netCDF.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> mu = Variable(("time",), np.array([0.08, 0.07]), {"units": "1"})
    >>> time = Variable(("time",), np.array([0.0, 0.1]), {"units": "s"})
    >>> with TemporaryDirectory() as place:
    ...     write_dataset(Dataset({"mu": mu}, {"time": time}, {"name": "run"}), Path(place) / "run.nc")
    ...     with open_dataset(Path(place) / "run.nc") as file:
    ...         file.variables["mu"][...].tolist(), file.attrs["name"]
    ([0.08, 0.07], 'run')
    """
    every = {**data.variables, **data.coordinates}
    if slashed := [name for name in every if "/" in name]:
        raise InputError(f"{path.name}: variable {slashed[0]!r}; allowed: names without '/'")
    elsewhere = {name: set(c.dimensions) for name, c in data.coordinates.items() if c.dimensions != (name,)}
    with library().File(path, "w") as file:
        file.attrs.update(data.attributes)
        file.dimensions = {
            name: size for v in every.values() for name, size in zip(v.dimensions, v.values.shape)
        }
        for name, (dimensions, values, attributes) in every.items():
            fill = np.nan if np.issubdtype(values.dtype, np.floating) else None
            packed = PACKED if name in data.variables else {}
            variable = file.create_variable(
                name, dimensions, values.dtype, data=values, fillvalue=fill, **packed
            )
            variable.attrs.update(attributes)
            own = [n for n, along in elsewhere.items() if along <= set(dimensions)]
            if own and name in data.variables:
                variable.attrs["coordinates"] = " ".join(own)


@contextmanager
def open_dataset(path: Path) -> Iterator[h5netcdf.File]:
    """Open a netCDF file for reading; a damaged one raises `DAMAGED_NETCDF`, here or where its values are read.

    So does one whose values mean something else than their numbers: what was packed anew, or marks gaps by a number.
    """
    with library().File(path, "r") as file:
        for name, variable in file.variables.items():
            if changed := _changed_meaning(variable.attrs):
                raise ValueError(
                    f"variable {name!r} has the attribute {changed!r}; allowed: values as they are, gaps as NaN"
                )
        yield file


def _changed_meaning(attributes: Mapping[str, Any]) -> str:
    """Return the attribute by which values are to be scaled or left out; empty where they stand for themselves."""
    for name in ("scale_factor", "add_offset"):
        if name in attributes:
            return name
    for name in ("_FillValue", "missing_value"):
        fill = np.ravel(attributes[name]) if name in attributes else np.empty(0)
        if not all(isinstance(x, np.floating | float) and np.isnan(x) for x in fill):
            return name
    return ""
