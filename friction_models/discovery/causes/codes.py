"""Columns of the test table whose numbers may be names."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...common.wording import listed
from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.campaign.metadata import is_text
from ...estimation.search.structure import StructurePlace

#: Whole numbers in a column of the test table that may be names, if there are no more.
MOST_CODES = 8


def codes_along(campaign: BinnedTests, where: Sequence[StructurePlace]) -> dict[str, list[int]]:
    """Return the columns of the test table along which most is left and whose few whole numbers may be names, with these."""
    found = {}
    for name in [n for place in where[:1] for n in place["variables"]]:
        if name in campaign.system and not is_text(campaign.loads, name):
            levels = np.unique(campaign.system[name])
            if len(levels) <= MOST_CODES and np.array_equal(levels, np.rint(levels)):
                found[name] = [int(v) for v in levels]
    return found


def about_codes(codes: dict[str, list[int]]) -> list[str]:
    """Return what may be wrong with columns of codes.

    Examples
    --------
    >>> about_codes({"coating": [1, 2, 3]})
    ['coating is taken as a quantity of 1, 2 and 3: if these are names, write them as text (c1, c2, ...), and each gets an offset of its own']
    """
    return [
        f"{name} is taken as a quantity of {listed(map(str, levels))}: if these are names, write them as text ({name[0]}{levels[0]}, {name[0]}{levels[1]}, ...), and each "
        "gets an offset of its own"
        for name, levels in codes.items()
    ]
