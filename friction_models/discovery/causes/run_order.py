"""What changed from test to test in the order in which they were run, and nobody recorded."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.fit.parameters import FittedTerms
from ...estimation.noise.reference_variances import STRONG
from ...estimation.search.search_round import SearchRound
from ...loads import FloatArray
from ...loads.contract import ORDER

#: What a sentence about tests begins with that do not drift, but jump.
JUMP = "the levels of the tests jump"
#: Fewest tests of which that is said.
LEAST_TESTS = 12
#: Standard deviations from what the correlation is by chance (one such case of 2000).
BEYOND_CHANCE = 3.3
#: Fewest tests before and after a jump.
SIDE = 3
#: What to do about a jump.
LOOK = "look what was changed there (lubricant, tool, batch), and record it as a column of the test table"


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


def jumps_in_order(campaign: BinnedTests, fitted: FittedTerms) -> dict[str, str]:
    """Return by how much and where the levels of the tests jump in their order, for each effect that only follows such a jump."""
    found = {}
    for term in fitted.terms:
        if term.effect.driver != (ORDER,) or len(campaign.tests) < 4 * SIDE:
            continue
        order = campaign.of_tests(campaign.metadata(ORDER))
        sequence = np.argsort(order, kind="stable")
        level = campaign.of_tests(term.binned + fitted.residual)[sequence]
        n, line = len(level), np.column_stack([np.ones(len(level)), order[sequence]])
        drift = float(np.sum((level - line @ np.linalg.lstsq(line, level, rcond=None)[0]) ** 2))
        places = range(SIDE, n - SIDE + 1)
        step = [float(np.var(level[:k]) * k + np.var(level[k:]) * (n - k)) for k in places]
        k = places[int(np.argmin(step))]
        if n * np.log(drift / max(min(step), 1e-300)) > np.log(n) + STRONG:  # its place is one more number
            before, after = (campaign.tests[sequence[j]] for j in (k - 1, k))
            size = float(level[k:].mean() - level[:k].mean())
            found[term.name] = f"by {size:+.2g} between {before} and {after}"
    return found


def about_jumps(jumps: Mapping[str, str], instead: Mapping[str, tuple[str, str]]) -> list[str]:
    """Return warnings about effects that only follow a jump of the levels in the order of the tests, or in whose place one does as well.

    `jumps` and `instead` are what `jumps_in_order` and `jumps_instead` return.
    """
    return [
        *(f"{JUMP} {place}, and do not drift, as {name} says: {LOOK}" for name, place in jumps.items()),
        *(
            f"beside the model, a jump between {before} and {after} in the order of the tests describes them as well as {name} does: {LOOK}, "
            "or run tests of both kinds again in another order"
            for name, (before, after) in instead.items()
            if name not in jumps
        ),
    ]


def jumps_instead(
    campaign: BinnedTests, found: SearchRound, fitted: FittedTerms
) -> dict[str, tuple[str, str]]:
    """Return the tests between which a jump describes them as well as an effect of the loads, or of the order, in its place, by effect.

    As well is by Schwarz's criterion with a test as the unit, at the noise of a search: a jump has a size and a place, an effect
    mostly more parameters.
    """
    tests = len(campaign.tests)
    terms = [t for t in fitted.terms if not t.effect.metadata or t.effect.driver == (ORDER,)]
    if ORDER not in campaign.system or tests < 4 * SIDE or not terms:
        return {}
    order = campaign.of_tests(campaign.metadata(ORDER))
    sequence = np.argsort(order, kind="stable")
    rank = np.argsort(sequence)[campaign.test]
    places = np.arange(SIDE, tests - SIDE + 1)
    base = np.linalg.qr(found.whiten(found.columns))[0]

    def beside(values: FloatArray) -> FloatArray:
        white = found.whiten(values)
        return np.asarray(white - base @ (base.T @ white))

    steps = beside((rank[:, None] >= places).astype(float))
    squares = np.maximum(np.sum(steps**2, axis=0), 1e-300)
    own = float(np.sum(beside(fitted.residual) ** 2))
    instead = {}
    for term in terms:
        rest = beside(term.binned + fitted.residual)
        taken = (steps.T @ rest) ** 2 / squares
        k = int(np.argmax(taken))
        more = len(term.effect.amplitudes) + len(term.effect.free_shapes) - 2
        if float(rest @ rest - taken[k]) - own <= more * np.log(tests):
            instead[term.name] = (
                campaign.tests[sequence[places[k] - 1]],
                campaign.tests[sequence[places[k]]],
            )
    return instead
