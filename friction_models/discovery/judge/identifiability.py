"""Warnings about what limits a verdict: loads constant within tests, flexible bases, effects hidden by the base."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, permutations

import numpy as np
from scipy.stats import rankdata

from ...common.wording import listed
from ...effects.base import Effect
from ...effects.metadata.factor import PREFIX
from ...estimation.campaign.binned_tests import BinnedTests
from ...estimation.campaign.curves import transformed
from ...estimation.campaign.factors import factors_like, same_levels
from ...estimation.campaign.metadata import levels_text
from ...estimation.campaign.settings import in_units
from ...estimation.noise.noise_floor import sensor_noise
from ...estimation.search.base_law import BaseLaw
from ...estimation.search.scan import Fit
from ...estimation.search.search_round import SearchRound
from ...estimation.search.unseen_loads import WITHIN, within_share
from ...loads import LOAD_NAMES, FloatArray
from .verdict import Evidence

#: Families that can follow part of an effect.
FLEXIBLE = ("polynomial", "gradient_boosting", "ffnn")
#: Below this share of its own variation beside the base, an amplitude is poorly known.
WEAK = 0.02
#: A model that leaves less of the sensor's noise than this share was fitted to these very points.
NOISE_LEFT = 0.75
#: With fewer points the noise itself is too poorly known to say so.
LEAST_POINTS = 200
#: Loads that agree more than this over the tests cannot be told apart by their levels; fewer tests do not show it.
TOGETHER, LEAST_LEVELS = 0.9, 4
#: Agreeing more than this, also along the tests, they are one load for these data.
ONE_LOAD = 0.98
#: Effects whose changes of mu agree more than this may stand for the form of one another.
STAND_IN = 0.7
#: No tribometer resolves friction better than this share of mu.
RESOLUTION = 0.002


def knows_the_noise(measured: BinnedTests, model: BaseLaw) -> bool:
    """Return whether a model that is taken as it is follows the noise of the records: it was fitted to these points."""
    if not model.fixed or len(measured.mu) < LEAST_POINTS:
        return False
    noise = sensor_noise(measured, measured.mu)
    left = sensor_noise(measured, measured.mu - model.offset)
    return noise > RESOLUTION * float(np.mean(np.abs(measured.mu))) and left < NOISE_LEFT * noise


def limits(campaign: BinnedTests, base: BaseLaw, evidence: Evidence) -> list[str]:
    """Return warnings that a reader of the verdict should know."""
    notes = []
    if len(campaign.tests) > 1 and not campaign.averaged:
        flat = [n for n in LOAD_NAMES if campaign.varies(n) and within_share(campaign, n) < WITHIN]
        if flat:
            notes.append(
                f"{listed(flat)} hardly {'varies' if len(flat) == 1 else 'vary'} within tests: what is said of effects of "
                f"{'it' if len(flat) == 1 else 'them'} rests on the levels of the tests alone"
            )
    if base.name.split("+")[0] in FLEXIBLE:
        notes.append(
            f"a {base.name} base absorbs part of an effect: 'nothing missing' would speak of the error, not of the physics"
        )
    winner = evidence.winner
    if winner is not None and evidence.present:
        notes += _tied_loads(campaign, winner.effect.driver)
        whole = evidence.found.whiten(winner.binned - winner.binned.mean())
        share = float(winner.signal @ winner.signal) / max(float(whole @ whole), 1e-300)
        if share < WEAK:
            notes.append(
                f"only {100 * share:.1f} % of the variation of {winner.name} shows beside the base: "
                "its form is seen, its amplitude is poorly known"
            )
    return notes


def same_columns(campaign: BinnedTests, named: Sequence[Effect], others: Sequence[Effect]) -> list[str]:
    """Return a warning for each effect of a column of the test table with which further columns change, beside those of `others`."""
    notes = []
    for effect in named:
        further = [n.removeprefix(PREFIX) for n in factors_like(campaign, effect, others)]
        if further:
            told = listed(levels_text(campaign.loads, name) for name in [*effect.metadata, *further])
            notes.append(
                f"{told} change together from test to test, so little or nothing tells which of them it is; run the same loads again with "
                "each value of the one with each of the other"
            )
    return notes


def _tied_loads(campaign: BinnedTests, drivers: Sequence[str]) -> list[str]:
    """Return a warning where a load that drives an effect moves with another one from test to test, or along each of them."""
    apart = [n for n in campaign.varied if campaign.sets_apart(n)]
    levels = {n: campaign.of_tests(transformed(campaign, n)) for n in apart}
    tied = [
        (a, f"{b} (correlation {value:+.2f})")
        for a, b in permutations(levels, 2)
        if a in drivers
        and (b not in drivers or a < b)
        and abs(value := _correlation(levels[a], levels[b])) > TOGETHER
    ]
    along = [b for b in one_load(campaign, drivers) if b not in levels]
    if along:
        together = dict.fromkeys([*(n for n in drivers if n in campaign.varied), *along])
        return [
            f"along the tests {listed(together)} move together, in all of them alike: what looks like an effect of the one may be one of "
            "the other; let them go apart in further tests"
        ]
    if not tied:
        return []
    movers = dict.fromkeys(a for a, _ in tied)
    return [
        f"from test to test {listed(movers)} {'moves' if len(movers) == 1 else 'move'} with {listed(dict.fromkeys(b for _, b in tied))}: what looks "
        "like an effect of the one may be one of the other; cross their levels in further tests"
    ]


def one_load(campaign: BinnedTests, drivers: Sequence[str]) -> list[str]:
    """Return the loads with which one that drives an effect rises or falls, between and along tests; another driver, too."""
    own = [n for n in campaign.varied if n in drivers]
    return [
        b
        for b in campaign.varied
        if _changes(campaign, b) and any(a != b and _are_one(campaign, a, b) for a in own)
    ]


def _changes(campaign: BinnedTests, name: str) -> bool:
    """Return whether a load changes by more than counts as the same setting: less of it sets nothing apart."""
    values = campaign.average(getattr(campaign.loads, name))
    return float(np.ptp(in_units(name, values, 0.0))) > 1.0


def one_cause(campaign: BinnedTests, drivers: Sequence[str], others: Sequence[str]) -> bool:
    """Return whether each driver of one effect is, for these tests, the same as one of another effect, whatever their formulas."""
    if {*drivers} == {*others} or not {*drivers, *others} <= {*campaign.varied, *campaign.system}:
        return False
    return all(
        any(a == b or _are_one(campaign, a, b) for b in some)
        for own, some in ((drivers, others), (others, drivers))
        for a in own
    )


def standing_in(found: SearchRound, chosen: Sequence[Fit]) -> list[tuple[str, str]]:
    """Return pairs of names that each alone change mu, beyond what the model follows, much where the other does.

    Friction work, surface expansion and distance grow together in tests of one length: where the form of one name is somewhat wrong,
    the other one mends it.
    """
    names = [f.name for f in chosen]
    alone = {f.name: found.change(f) for f in found.ranking if f.name in names and f.gain > 0.0}
    pairs = combinations([name for name in names if name in alone], 2)
    return [(a, b) for a, b in pairs if _correlation(alone[a], alone[b]) > STAND_IN]


def _are_one(campaign: BinnedTests, a: str, b: str) -> bool:
    """Return whether two loads rise or fall together, between and along tests; or whether columns of metadata have the same levels."""
    loads = len({a, b} & {*LOAD_NAMES})
    if not loads:
        return same_levels(*(campaign.system[n][campaign.point_starts, 0] for n in (a, b)))
    if loads < 2:
        return False
    values = [rankdata(campaign.average(getattr(campaign.loads, n))) for n in (a, b)]
    agree = [abs(_correlation(*values))]
    # loads that every test goes through alike differ along the tests only
    if campaign.sets_apart(a) or campaign.sets_apart(b):
        agree.append(abs(_correlation(*map(campaign.of_tests, values))))
    return min(agree) > ONE_LOAD


def _correlation(a: FloatArray, b: FloatArray) -> float:
    if len(a) < LEAST_LEVELS or min(np.ptp(a), np.ptp(b)) <= 0.0:
        return 0.0
    return float(np.corrcoef(a, b)[0, 1])
