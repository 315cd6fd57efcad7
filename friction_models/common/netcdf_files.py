"""netCDF files: packed when written; a damaged or foreign one is refused in one sentence when read.

h5netcdf writes them at once. xarray would load pandas first, and all of dask where it is installed.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .errors import InputError, check_readable, unknown_name

if TYPE_CHECKING:
    import h5py

#: How values are packed; `shuffle` is what the reference library does unasked.
PACKED: dict[str, Any] = {"compression": "gzip", "compression_opts": 4, "shuffle": True}
#: What a damaged file raises while it is read.
_DAMAGED = (OSError, ValueError, KeyError, RuntimeError, TypeError, AttributeError)
#: How the NAME of a dimension without a variable begins.
_ONLY_A_LENGTH = "This is a netCDF dimension but not a netCDF variable"
#: How every netCDF-4 file begins.
_SIGNATURE = b"\x89HDF\r\n\x1a\n"

FloatArray = npt.NDArray[np.float64]


class NetcdfVariable(NamedTuple):
    """Values over named dimensions, with their unit and meaning."""

    dimensions: tuple[str, ...]
    values: npt.NDArray[Any]
    attributes: Mapping[str, str]


class Dataset(NamedTuple):
    """What a netCDF file holds; ``xarray.Dataset(*data)`` is the same data set."""

    variables: Mapping[str, NetcdfVariable]
    #: One that does not run along the dimension of its own name is named in the attribute `coordinates` of the variables.
    coordinates: Mapping[str, NetcdfVariable]
    attributes: Mapping[str, str | int | float]


class Numbers(NamedTuple):
    """What was read of a netCDF file."""

    values: Mapping[str, FloatArray]
    units: Mapping[str, str]
    #: Those of the file that are text.
    attributes: Mapping[str, str]
    #: Names of the variables that run along the dimension of their own name.
    scales: Collection[str]


def write_dataset(data: Dataset, path: Path) -> None:
    """Write a data set, its variables packed.

    Raises InputError: a name with a slash, which would be a group of netCDF.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> mu = NetcdfVariable(("time",), np.array([0.08, 0.07]), {"units": "1"})
    >>> time = NetcdfVariable(("time",), np.array([0.0, 0.1]), {"units": "s"})
    >>> with TemporaryDirectory() as place:
    ...     write_dataset(Dataset({"mu": mu}, {"time": time}, {"name": "run"}), Path(place) / "run.nc")
    ...     found = read_numbers(Path(place) / "run.nc", ["mu"])
    >>> found.values["mu"].tolist(), found.units["mu"], found.attributes["name"]
    ([0.08, 0.07], '1', 'run')
    """
    import h5netcdf

    every = {**data.variables, **data.coordinates}
    if slashed := [name for name in every if "/" in name]:
        raise InputError(f"{path.name}: variable {slashed[0]!r}; allowed: names without '/'")
    elsewhere = {name: set(c.dimensions) for name, c in data.coordinates.items() if c.dimensions != (name,)}
    with h5netcdf.File(path, "w") as file:
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


def read_numbers(path: Path, needed: Collection[str] = (), most: float = math.inf) -> Numbers:
    """Read a netCDF file of `most` numbers at most, with the variables that are `needed`.

    Raises InputError: the file is damaged, a variable is missing, holds no numbers or has no named dimensions, or its values mean
    something else than their numbers: they were packed anew, or a number marks gaps.
    """
    import h5py  # h5netcdf takes four times as long

    check_readable(path)
    try:
        with h5py.File(path, "r") as file:
            every = {name: values for name, values in file.items() if _is_variable(values)}
            for name in needed:
                if name not in every:
                    raise unknown_name("variable", name, every, str(path))
            for name, variable in every.items():
                if wrong := _what_is_wrong(variable):
                    raise InputError(f"{path}: variable {name!r} {wrong}")
            if (count := sum(v.size for v in every.values())) > most:
                raise InputError(f"{path}: {count} numbers; allowed: at most {most:.0f}")
            return Numbers(
                {name: np.asarray(v[...], dtype=np.float64) for name, v in every.items()},
                {name: _text(v.attrs.get("units", "")) for name, v in every.items()},
                {name: text for name, value in file.attrs.items() if (text := _text(value))},
                frozenset(name for name, v in every.items() if v.is_scale),
            )
    except InputError:
        raise
    except _DAMAGED:
        with path.open("rb") as stream:
            began = stream.read(len(_SIGNATURE)) == _SIGNATURE
        what = "damaged or cut short" if began else "not a netCDF-4 file"
        raise InputError(
            f"{path}: {what} ({path.stat().st_size} bytes); allowed: the file as it was written"
        ) from None


def _is_variable(item: h5py.Dataset | h5py.Group) -> bool:
    """Return whether this is a variable: no group, and no dimension of which only the length is known."""
    return hasattr(item, "dtype") and not _text(item.attrs.get("NAME", "")).startswith(_ONLY_A_LENGTH)


def _what_is_wrong(variable: h5py.Dataset) -> str:
    """Say why the values of a variable cannot be taken for its numbers; empty if they can."""
    if variable.dtype.kind not in "biuf":
        return f"holds {variable.dtype}; allowed: numbers"
    attributes = variable.attrs
    if variable.ndim and "DIMENSION_LIST" not in attributes and not variable.is_scale:
        return "has no dimensions with a name; allowed: netCDF dimension scales"
    changed = [name for name in ("scale_factor", "add_offset") if name in attributes]
    for name in ("_FillValue", "missing_value"):
        fill = np.ravel(attributes[name]) if name in attributes else np.empty(0)
        if not all(isinstance(x, np.floating | float) and np.isnan(x) for x in fill):
            changed.append(name)
    return f"has the attribute {changed[0]!r}; allowed: values as they are, gaps as NaN" if changed else ""


def _text(attribute: object) -> str:
    """Return an attribute of text; an empty one has no value in the file."""
    if isinstance(attribute, bytes):
        return attribute.decode("utf-8")
    return attribute if isinstance(attribute, str) else ""
