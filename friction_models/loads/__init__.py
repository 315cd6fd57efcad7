"""The loads contract and the data sets that keep it; imports no other part of the project."""

from .contract import (
    LOAD_NAMES,
    LOADS,
    MU,
    POINT_COLUMNS,
    POINT_UNITS,
    QUANTITIES,
    TIME,
    Quantity,
    check_units,
)
from .dataset import DataSet, header_units, read_points
from .errors import InputError, nearest, unknown_name
from .files import atomic_folder, atomic_path, write_json, write_text
from .tribo_loads import FloatArray, TriboLoads, check_column, missing_column

__all__ = [
    "LOADS",
    "LOAD_NAMES",
    "MU",
    "POINT_COLUMNS",
    "POINT_UNITS",
    "QUANTITIES",
    "TIME",
    "DataSet",
    "FloatArray",
    "InputError",
    "Quantity",
    "TriboLoads",
    "atomic_folder",
    "atomic_path",
    "check_column",
    "check_units",
    "header_units",
    "missing_column",
    "nearest",
    "read_points",
    "unknown_name",
    "write_json",
    "write_text",
]
