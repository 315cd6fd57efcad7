"""Readers of measurement files: each returns a table of channels with their units."""

from __future__ import annotations

import os
from pathlib import Path

from friction_models.common import InputError

from .catman import read_catman
from .csv import read_csv
from .formats import SUFFIXES, kind_of
from .guarded import read_guarded
from .table import RawTable

__all__ = ["SUFFIXES", "RawTable", "read_catman", "read_csv", "read_file"]


def read_file(path: str | os.PathLike[str]) -> RawTable:
    """Read a measurement file of any format: CSV/ASCII, catman, MDF, TDMS, MATLAB, Parquet, Excel.

    Raises
    ------
    InputError
        No such file, no reader for it, or its content is damaged or not what the suffix says.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "test.csv"
    ...     with file.open("w") as stream:
    ...         for row in ["t,F_n", "s,kN", "0.0,1.5", "0.5,2.5", "1.0,3.5"]:
    ...             print(row, file=stream)
    ...     table = read_file(file)
    >>> table.units
    {'t': 's', 'F_n': 'kN'}
    >>> table.frame["F_n"].tolist()
    [1.5, 2.5, 3.5]
    """
    file = Path(path)
    try:
        kind = kind_of(file)
        if kind == "CSV":
            return read_csv(file)
        if kind == "catman":
            return read_catman(file)
        return read_guarded(file.resolve(), kind)
    except OSError as error:
        raise InputError(f"{file}: cannot be read ({error.strerror or error})") from None
