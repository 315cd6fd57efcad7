"""The loads contract and the data sets that keep it; imports no other part of the project.

Attributes are imported on first use: the names of the contract cost no pandas.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..common.imports.lazy_names import lazily

if TYPE_CHECKING:
    from ..common.errors import InputError as InputError
    from .columns import STAND_IN as STAND_IN
    from .columns import missing_column as missing_column
    from .columns import not_measured as not_measured
    from .columns import require_every_load as require_every_load
    from .contract import LOAD_NAMES as LOAD_NAMES
    from .contract import LOADS as LOADS
    from .contract import MEASURED_MU as MEASURED_MU
    from .contract import MU as MU
    from .contract import POINT_COLUMNS as POINT_COLUMNS
    from .contract import POINT_UNITS as POINT_UNITS
    from .contract import QUANTITIES as QUANTITIES
    from .contract import TIME as TIME
    from .contract import UNCERTAINTY_COLUMNS as UNCERTAINTY_COLUMNS
    from .contract import FloatArray as FloatArray
    from .contract import Quantity as Quantity
    from .dataset import DataSet as DataSet
    from .points import about_negative as about_negative
    from .points import load_points as load_points
    from .tribo_loads import TriboLoads as TriboLoads
    from .tribo_loads import check_column as check_column
    from .tribo_loads import require_loads as require_loads

__getattr__, __dir__, __all__ = lazily(__name__, __file__)
