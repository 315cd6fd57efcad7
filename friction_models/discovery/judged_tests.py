"""The tests that `diagnose` and `refine` judge: all but those that lie far off what all others say."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..common import InputError
from ..estimation.campaign.binned_tests import BinnedTests
from ..estimation.campaign.metadata import NOT_METADATA
from ..estimation.campaign.own_heat import without_own_heat
from ..estimation.noise.beyond_level import beyond_level_text
from ..estimation.noise.noise_floor import NoiseFloor, independent_columns
from ..estimation.noise.odd_tests import left_out_text, odd_tests, too_many_text, without_tests
from ..estimation.search.base_law import BaseLaw, base_law
from ..estimation.search.search_round import distrust_outliers
from ..estimation.search.zero_reading import corrected_alone, corrected_text
from ..families.registry import make_model
from ..loads import LOAD_NAMES, require_loads
from ..models.base import FrictionModel

#: Averages that must be left beside the numbers of the base.
SPARE = 3


@dataclass(frozen=True)
class JudgedTests:
    """Tests beside a model."""

    measured: BinnedTests  #: Without odd tests, with all loads as they are.
    campaign: (
        BinnedTests  #: The same tests for the search of effects, without the heat of their own friction.
    )
    base: BaseLaw
    floor: NoiseFloor | None  #: A first noise floor, where there are enough averages.
    odd: tuple[str, ...] = ()  #: Names of the tests that were left out.
    odd_kept: bool = False  #: Whether more lie off, too many to be left out.
    odd_region: bool = False  #: Whether all that were left out lie in one corner of the loads, to one side.


def tests_beside(measured: BinnedTests, model: Any, seed: int) -> JudgedTests:
    """Return the tests of a campaign beside a model, odd ones included.

    Raises InputError: no load varies, or hardly more averages than the model has numbers.
    """
    campaign = without_own_heat(measured)
    campaign.warnings = list(measured.warnings)
    if isinstance(model, FrictionModel) and model.is_fitted:
        require_loads(campaign.loads, model.needed_loads, f"the {model.name} model")
    if len(campaign.tests) > 1:
        campaign.loads.in_order(memory=True)  # effects with memory are among those that are looked for
    base = base_law(make_model(model) if isinstance(model, str) else model, campaign, seed)
    _check_enough(campaign, base)
    return JudgedTests(measured, campaign, base, distrust_outliers(campaign, base))


def without_odd(found: JudgedTests, model: Any, seed: int) -> JudgedTests:
    """Return the tests without odd ones, and those that only a reading of the friction cell sets apart; warnings of the campaign name them."""
    if found.base.fixed:
        return found
    if names := corrected_alone(found.measured):
        left = without_tests(found.measured, names, corrected_text(names))
        found = replace(tests_beside(left, model, seed), odd=tuple(names))
    odd = odd_tests(found.campaign, found.campaign.average(found.base.columns), found.floor)
    judged = found
    if odd.few:
        why = left_out_text(odd.few, odd.region) + beyond_level_text(found.measured, odd.few)
        left = without_tests(found.measured, odd.few, why)
        judged = replace(
            tests_beside(left, model, seed), odd=(*found.odd, *odd.few), odd_region=bool(odd.region)
        )
    if odd.too_many:
        judged.campaign.warnings = [*judged.campaign.warnings, too_many_text(odd.too_many)]
        judged = replace(judged, odd_kept=True)
    return judged


def _check_enough(campaign: BinnedTests, base: BaseLaw) -> None:
    """Refuse data that the base alone can fit exactly.

    Raises InputError: no load varies, or hardly more averages than the base has numbers.
    """
    if not any(campaign.varies(n) for n in LOAD_NAMES):
        names = [n for n, c in sorted(campaign.system.items()) if n not in NOT_METADATA and np.ptp(c) > 0.0]
        alone = f", nor about columns of the test table ({', '.join(names[:6])}) alone" if names else ""
        raise InputError(
            f"data: none of the loads ({', '.join(LOAD_NAMES)}) varies, so nothing can be said about their effects{alone}; "
            "allowed: tests along which, or between which, at least one of them varies"
        )
    averages, spare = len(campaign.starts), spare_averages(campaign, base)
    if spare < SPARE:
        numbers = averages - spare
        raise InputError(
            f"data: {averages} averages of mu from {len(campaign.tests)} tests, and the {base.name} model alone has "
            f"{numbers} numbers; allowed: at least {numbers + SPARE}, by more tests or by time series instead of averages"
        )


def spare_averages(campaign: BinnedTests, base: BaseLaw) -> int:
    """Return how many averages are left beside the numbers of the base."""
    averages = campaign.average(base.columns)
    return len(averages) - independent_columns(averages).shape[1]
