"""Few tests at one level of a load that all lie far off the others: a law that nothing else shows, or a fault that they share."""

from __future__ import annotations

import numpy as np

from ...common.wording import first_names
from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.campaign.settings import in_units
from ...estimation.noise.odd_tests import LEAST_TESTS, most_by_chance
from ...loads import POINT_UNITS, FloatArray
from ...loads.contract import behind
from ..judge.identifiability import RESOLUTION

#: Of more than this share of the tests curves say what they do.
FEW = 0.2
#: Each of them lies off by so many times the scatter of the others: one that does by chance says nothing of its level.
EACH = 3.0


def about_lone_levels(campaign: BinnedTests, residual: FloatArray) -> list[str]:
    """Return a warning for each level of a load at which few tests, two at least, all lie off to one side, by more than chance does.

    `residual`, shape (m,), is what is left of mu in the bins. The others say what is usual, by median and median deviation.
    """
    left, tests = campaign.of_tests(residual), len(campaign.tests)
    if tests < LEAST_TESTS:
        return []
    said = {}
    # what no tribometer resolves lies off by nothing
    least = RESOLUTION * max(float(np.mean(np.abs(campaign.mu))), 1e-300)
    limit = most_by_chance(tests)
    for name, level in campaign.levels.items():
        units = in_units(name, level)
        for own in sorted({tuple(np.flatnonzero(np.abs(units - unit) <= 0.5)) for unit in units}):
            if not 2 <= len(own) <= FEW * tests:
                continue
            others = np.delete(left, own)
            usual = float(np.median(others))
            scatter = max(1.4826 * float(np.median(np.abs(others - usual))), least)
            off = (left[list(own)] - usual) / scatter
            one_side = abs(float(np.sign(off).sum())) == len(own) and float(np.abs(off).min()) > EACH
            if one_side and abs(float(off.mean())) * np.sqrt(len(own)) > limit:
                names = [campaign.tests[k] for k in own]
                said[own] = (
                    f"all tests at {name} {np.mean(level[list(own)]):.3g}{behind(POINT_UNITS[name])} ({first_names(names)}) lie off by "
                    f"{scatter * off.mean():+.2g}, where the others scatter by {scatter:.2g}: repeat them, and measure at levels beside theirs"
                )
    return list(said.values())
