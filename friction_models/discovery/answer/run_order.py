"""Whether tests that were run one after the other lie alike: something changed with time that nobody recorded."""

from __future__ import annotations

import numpy as np

from ...estimation.campaign.binning import BinnedTests
from ...loads import FloatArray
from ...loads.contract import ORDER

#: Fewest tests of which that is said.
LEAST_TESTS = 12
#: Standard deviations from what the correlation is by chance (one such case of 2000).
BEYOND_CHANCE = 3.3


def alike_in_order(campaign: BinnedTests, residual: FloatArray) -> list[str]:
    """Return a warning where what is left of a test, by `residual` in the bins, is alike in the tests run before and after it.

    The correlation of neighbours, the first of lag one, has under chance the mean -1/(n - 1) and about the variance 1/n
    (Anderson, Ann. Math. Stat. 13 (1942) 1).
    """
    tests = len(campaign.tests)
    if ORDER not in campaign.system or tests < LEAST_TESTS:
        return []
    order = campaign.of_tests(campaign.metadata(ORDER))
    level = campaign.of_tests(residual)[np.argsort(order, kind="stable")]
    level = level - level.mean()
    square = float(level @ level)
    if len(np.unique(order)) < tests or square <= 0.0:
        return []
    correlation = float(level[1:] @ level[:-1]) / square
    if (correlation + 1.0 / (tests - 1.0)) * np.sqrt(tests) < BEYOND_CHANCE:
        return []
    return [
        f"what is left of a test is alike in the tests run before and after it (correlation {correlation:+.2f}): something changes with "
        "time that is not recorded, so look for it (lubricant, surface of the tool, warm-up, operator)"
    ]
