"""Columns of the test table whose numbers may be names."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...common.wording import listed
from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.campaign.metadata import is_text
from ...estimation.noise.noise_floor import independent_columns
from ...estimation.search.between_tests import chance_beside
from ...estimation.search.structure import StructurePlace
from ...loads import FloatArray
from ...loads.contract import ORDER

#: Whole numbers in a column of the test table that may be names, if there are no more.
MOST_CODES = 8
#: Chance below which levels of their own count, over all such columns.
BY_CHANCE = 0.01


def codes_along(
    campaign: BinnedTests, where: Sequence[StructurePlace], residual: FloatArray
) -> dict[str, list[int]]:
    """Return the columns of the test table whose few whole numbers may be names, with these.

    Most is left along them, or levels of their own describe what is left of the tests, by `residual`, shape (m,), in the bins, for
    certain better than a straight line in the numbers does (F test).
    """
    found = {}
    for name in sorted(campaign.system):
        levels = np.unique(campaign.system[name])
        whole = len(levels) <= MOST_CODES and np.array_equal(levels, np.rint(levels))
        if name != ORDER and whole and not is_text(campaign.loads, name):
            found[name] = [int(v) for v in levels]
    most = {n for place in where[:1] for n in place["variables"]}
    limit = BY_CHANCE / max(len(found), 1)
    return {n: v for n, v in found.items() if n in most or _no_line(campaign, n, residual) < limit}


def _no_line(campaign: BinnedTests, name: str, residual: FloatArray) -> float:
    """Return the chance that means of levels describe the tests so much better than a line in their numbers."""
    number, left = (campaign.of_tests(v) for v in (campaign.metadata(name), residual))
    line = independent_columns(np.column_stack([np.ones(len(number)), number]))
    return chance_beside(left, line, (number[:, None] == np.unique(number)).astype(float), spare=1)


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
