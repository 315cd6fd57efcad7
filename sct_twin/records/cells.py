"""Cells of test tables and entries of channel maps: empty or not, number or not."""

from __future__ import annotations

import math
import sys
from typing import Any


def is_given(value: Any) -> bool:
    """Whether a cell of a test table holds something."""
    return value is not None and value != "" and not (isinstance(value, float) and math.isnan(value))


def is_number(value: Any) -> bool:
    """Whether an entry is a finite number that fits into a float; Booleans are none."""
    largest = sys.float_info.max
    return isinstance(value, int | float) and not isinstance(value, bool) and -largest <= value <= largest
