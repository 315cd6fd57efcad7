"""Effects that the data cannot judge, because a load or metadata that they need is missing or constant.

Those that lack something are not tried. One with a constant load does not lead the ranking while another one explains as much.
"""

from __future__ import annotations

import numpy as np

from ...common.wording import listed
from ...effects.base import Effect
from ...loads import LOAD_NAMES, FloatArray
from ..campaign.binned_tests import BinnedTests
from ..campaign.conflicting_loads import distance_by_speed
from ..campaign.metadata import recorded
from .scan import Fit

#: An effect with at least this share of the gain of the first one may lead the ranking in its place.
AS_GOOD = 0.5
#: `v_rel` and distance over time contradict each other when they differ by more than this factor.
SPEED_FACTOR = 2.0
#: A load varies within tests when this share of its variance lies within them.
WITHIN = 1e-3


def own_load(effect: Effect) -> tuple[str, ...]:
    """Return the load along which an effect may have another form than its formula, so that no further effect of it is sought.

    A memory of several loads has none: it bends with what it remembers, in which all of them are summed up.
    """
    return () if effect.needs_state and len(effect.needed_loads) > 1 else effect.driver[:1]


def driven_by_load(effect: Effect) -> bool:
    """Return whether a load drives an effect, and not the test table alone."""
    return bool(set(effect.driver) & set(LOAD_NAMES))


def testable(
    effects: list[Effect], campaign: BinnedTests, taken: tuple[str, ...]
) -> tuple[list[Effect], list[str]]:
    """Return the effects whose metadata the campaign holds, and notes on those that it lacks."""
    usable, notes = [], []
    untested: dict[str, list[str]] = {}
    for effect in effects:
        constant_law = unvaried(effect, campaign) and not effect.needs_state
        if effect.name in taken or effect.driver[0] in campaign.absent or constant_law:
            continue  # a warning about the load is given already
        reason = _not_tested(effect, campaign)
        if reason is not None:
            untested.setdefault(reason, []).append(effect.name)
            continue
        usable.append(effect)
        notes += [f"{effect.name}: {told}" for m in effect.metadata if (told := recorded(campaign.loads, m))]
    for reason, names in untested.items():
        were = "was" if len(names) == 1 else "were"
        notes.append(f"{', '.join(names)} {were} not tested: {reason}")
    return usable, notes


def unvaried(effect: Effect, campaign: BinnedTests) -> bool:
    """Return whether loads alone drive an effect, and none of them varies: a law of the noise of a control is no finding."""
    return set(effect.driver) <= set(LOAD_NAMES) and not any(map(campaign.varies, effect.driver))


def _not_tested(effect: Effect, campaign: BinnedTests) -> str | None:
    """Return why these data cannot say anything about an effect; None where they can."""
    if without := effect.lacking(campaign.absent):
        return f"the data lack {listed(without)}"
    if effect.needs_state and campaign.loads.t is None and "sd" in campaign.absent:
        return "memory needs the time t or the distance sd"
    along = effect.needs_state or (effect.driver[0] == "sd" and len(campaign.tests) > 1)
    if along and campaign.averaged:
        return "what happens along a test does not show in one point a test"
    absent = [m for m in effect.metadata if m not in campaign.system]
    reasons = [recorded(campaign.loads, m) or f"the test table holds no numbers in {m}" for m in absent]
    return "; ".join(reasons) or None


def constant(effect: Effect, campaign: BinnedTests) -> list[str]:
    """Return the loads that an effect needs and that do not vary in the data.

    A memory of the speed shows after changes of it, so `v_rel` has to vary within tests; a rest counts, too.
    """

    def shown(name: str) -> bool:
        if name == "v_rel" and effect.needs_state:
            return bool(campaign.course.pause.any()) or within_share(campaign, name) >= WITHIN
        return campaign.varies(name)

    return [n for n in effect.needed_loads if not shown(n)]


def within_share(campaign: BinnedTests, name: str) -> float:
    """Return the share of the variance of a load that lies within tests, beyond the noise of its sensor."""
    points = getattr(campaign.loads, name)
    values = campaign.average(points)
    means = campaign.of_tests(values)
    around = values - np.average(values, weights=campaign.count)
    whole = float(campaign.count @ around**2)
    inside = float(campaign.count @ (values - means[campaign.test]) ** 2) - _noise_within(campaign, points)
    return max(inside, 0.0) / whole if whole > 0 else 0.0


def _noise_within(campaign: BinnedTests, points: FloatArray) -> float:
    """Return what white noise, known from second differences along each test, adds to the squares within tests."""
    test, tests = campaign.point_test, len(campaign.tests)
    along = test[2:] == test[:-2]
    second = np.bincount(test[2:][along], np.diff(points, 2)[along] ** 2 / 6.0, tests)
    known = np.maximum(np.bincount(test[2:][along], minlength=tests), 1)
    return float((np.bincount(campaign.test, minlength=tests) - 1) @ (second / known))


def varied_first(campaign: BinnedTests, ranking: list[Fit]) -> list[Fit]:
    """Move an effect whose loads all vary to the front, if it explains about as much as the first one.

    An effect with a constant load depends on its other loads only, so these data cannot prefer it to an effect of those
    loads. It stays in the ranking as a rival.
    """
    if not ranking or not constant(ranking[0].effect, campaign):
        return ranking
    first = ranking[0]
    shown = {n for n in first.effect.driver if n not in campaign.absent}
    for fit in ranking[1:]:
        if fit.gain < AS_GOOD * first.gain or fit.gain <= 0.0:
            continue
        if shown & set(fit.effect.driver) and not constant(fit.effect, campaign):
            return [fit, *(f for f in ranking if f is not fit)]
    return ranking


def other_speed(campaign: BinnedTests) -> bool:
    """Return whether distance over time contradicts `v_rel` in most tests."""
    ratio = distance_by_speed(campaign.loads, campaign.point_starts)
    known = ratio[np.isfinite(ratio)]
    return bool(len(known)) and bool(np.mean(np.abs(known) > np.log10(SPEED_FACTOR)) > 0.5)
