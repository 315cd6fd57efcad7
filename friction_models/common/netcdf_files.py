"""netCDF files: packed when written, and no traceback beside the error when a damaged one is read."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import xarray

#: How values are packed; `shuffle` is what the reference library does unasked.
PACKED = {"zlib": True, "complevel": 4, "shuffle": True}
_ENGINE: Literal["h5netcdf"] = "h5netcdf"


def library() -> ModuleType:
    """Return h5netcdf, made such that it lets go of a file that it could not open without an error of its own."""
    import h5netcdf

    # Its files set this while they open, and ask for it when they are thrown away, opened or not.
    h5netcdf.File._writable = False
    module: ModuleType = h5netcdf
    return module


def write_dataset(data: xarray.Dataset, path: Path) -> None:
    """Write a data set, its variables packed."""
    data.to_netcdf(path, engine=_ENGINE, encoding={str(name): PACKED for name in data.data_vars})


@contextmanager
def open_dataset(path: Path) -> Iterator[xarray.Dataset]:
    """Read a data set; times stay numbers. Raises OSError, ValueError, KeyError or RuntimeError: the file is damaged."""
    import xarray

    library()
    with xarray.open_dataset(path, engine=_ENGINE, decode_times=False) as data:
        yield data
