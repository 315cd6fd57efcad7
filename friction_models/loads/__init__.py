"""The loads contract and the data sets that keep it; imports no other part of the project."""

from ..common.errors import InputError
from .columns import STAND_IN, missing_column, not_measured, require_every_load
from .contract import (
    LOAD_NAMES,
    LOADS,
    MEASURED_MU,
    MU,
    POINT_COLUMNS,
    POINT_UNITS,
    QUANTITIES,
    TIME,
    UNCERTAINTY_COLUMNS,
    Quantity,
)
from .dataset import DataSet
from .points import about_negative, load_points
from .tribo_loads import FloatArray, TriboLoads, check_column, require_loads

__all__ = [
    "LOADS",
    "LOAD_NAMES",
    "MEASURED_MU",
    "MU",
    "POINT_COLUMNS",
    "POINT_UNITS",
    "QUANTITIES",
    "STAND_IN",
    "TIME",
    "UNCERTAINTY_COLUMNS",
    "DataSet",
    "FloatArray",
    "InputError",
    "Quantity",
    "TriboLoads",
    "about_negative",
    "check_column",
    "load_points",
    "missing_column",
    "not_measured",
    "require_every_load",
    "require_loads",
]
