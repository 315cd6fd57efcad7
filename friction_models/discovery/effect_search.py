"""Searches for effects beside one base: the best one, further ones, and the evidence that a verdict is drawn from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..estimation.campaign.binned_tests import BinnedTests
from ..estimation.campaign.curves import spline_columns
from ..estimation.campaign.factors import level_columns
from ..estimation.noise.noise_floor import NoiseFloor
from ..estimation.search.base_law import BaseLaw
from ..estimation.search.between_tests import metadata_that_sets_tests_apart
from ..estimation.search.candidates import Candidate
from ..estimation.search.importance import LEAST_SHARE, error_share, weighted_rms
from ..estimation.search.scan import Fit
from ..estimation.search.search_round import SearchRound, search
from ..estimation.search.significance import stays_first
from ..estimation.search.structure import Misfit, find_structure, own_misfit
from ..estimation.search.unseen_loads import AS_GOOD, constant, own_load
from ..estimation.search.zero_reading import credible, judge_zero
from .judge.naming.names import MOST_NAMED
from .judge.verdict import LEVEL, SECOND_LEVEL, Evidence

#: If the winner comes first again less often than this, the second effect counts as a rival.
SURE = 0.5
#: Knots of the curves along the loads of the first effect while a second one is sought.
FREED = 8
#: A second effect must carry this share of the squared contribution of both.
SECOND_SHARE = 0.05
#: The same where unseen tests have to confirm it.
SMALL_SHARE = 0.01


class EffectSearch:
    """The search beside one base, with what it found; `notes` say what a reading without load had to do with it."""

    def __init__(
        self,
        campaign: BinnedTests,
        base: BaseLaw,
        candidates: list[Candidate],
        seed: int,
        floor: NoiseFloor | None,
    ) -> None:
        self.campaign, self.base, self.seed = campaign, base, seed
        self.found = self._search_twice(candidates, floor)
        self.candidates, self.notes = judge_zero(campaign, self.found, candidates)
        self._asked: dict[tuple[tuple[str, int], ...], list[tuple[float, float, Fit]]] = {}

    def _search_twice(self, candidates: list[Candidate], floor: NoiseFloor | None) -> SearchRound:
        """Search, then once more with a floor that knows the winner: a sharp effect inflates the first floor."""
        campaign, base, seed = self.campaign, self.base, self.seed
        apart = metadata_that_sets_tests_apart(campaign, base, candidates)
        found = search(campaign, base, None, candidates, seed, floor, also_in_mean=apart)
        winner = found.winner
        if winner is None or found.p_value(winner) >= 0.2:
            return found
        beside = np.column_stack([apart, winner.columns])
        again = search(campaign, base, None, candidates, seed, found.floor, also_in_mean=beside)
        again.least_p = found.p_value(winner)
        return again

    def weigh(self, outside: float) -> tuple[Evidence, list[Fit]]:
        """Collect the evidence; return it with the effects that belong to the answer.

        The share `outside` of the points lies beyond the domain of the model.
        """
        campaign, found = self.campaign, self.found
        self._large_ones_first()
        winner = found.winner
        p = found.p_value(winner) if winner else 1.0
        share = self._share(found, winner) if winner else 0.0
        present = winner is not None and p < LEVEL and share > LEAST_SHARE
        if winner is None or not present:
            structure = find_structure(campaign, found, np.empty((len(found.y), 0)), self.seed)
            part = error_share(structure.rms, found.floor.total)
            return Evidence(found, winner, p, share, [], Misfit(), structure, part, outside), []
        confusion = found.confusion_set()
        if (
            len(confusion) == 1
            and len(found.ranking) > 1
            and stays_first(found.ranking, found.simulated) < SURE
        ):
            confusion.append(found.ranking[1].name)
        chosen: list[Fit] = [winner]
        while True:
            signal = np.column_stack([found.whiten(f.columns) for f in chosen])
            structure = find_structure(campaign, found, signal, self.seed)
            misfit = own_misfit(campaign, found, winner, signal, self.seed)
            part = error_share(structure.rms, found.floor.total)
            evidence = Evidence(found, winner, p, share, confusion, misfit, structure, part, outside)
            if len(chosen) == MOST_NAMED or (len(chosen) > 1 and not evidence.unexplained):
                return evidence, chosen
            more = self.further(chosen, SECOND_LEVEL, SECOND_SHARE)
            if not more:
                return evidence, chosen
            chosen.append(more[0])

    def further(self, known: Sequence[Fit], level: float = LEVEL, share: float = SMALL_SHARE) -> list[Fit]:
        """Return effects beside known ones, the best first, also small ones: unseen tests have to confirm them.

        Each is significant at `level`, and carries more than `share` of the squared contribution of all.
        """
        key = tuple((f.name, f.index) for f in known)
        if key not in self._asked:  # the judge asks again when it looks for rivals
            self._asked[key] = self._further(known)
        return [fit for p, part, fit in self._asked[key] if p < level and part > share]

    def beside(self, known: Sequence[Fit]) -> SearchRound:
        """Search all other effects beside known ones, as they are: what could stand in the place of a further name."""
        names = {f.name for f in known}
        others = [c for c in self.candidates if c.effect.name not in names]
        columns = np.column_stack([f.columns for f in known])
        return search(self.campaign, self.base, columns, others, self.seed, self.found.floor)

    def _further(self, known: Sequence[Fit]) -> list[tuple[float, float, Fit]]:
        """Return effects of other loads, judged with the own loads of the known ones freed as curves, their texts as levels, the best first.

        Before each stand its p-value and its share of the squared contribution of all. No offset of the force that is too large for
        one stands beside another name.
        """
        campaign, base, found = self.campaign, self.base, self.found
        sensor = found.floor.sensor
        if not all(credible(campaign, sensor, f) for f in known):
            return []
        own = tuple(dict.fromkeys(load for f in known for load in own_load(f.effect)))
        names = {f.name for f in known}
        others = [
            c for c in self.candidates if {*own}.isdisjoint(own_load(c.effect)) and c.effect.name not in names
        ]
        if not others:
            return []
        freed = np.column_stack(
            [*(f.columns for f in known), spline_columns(campaign, own, FREED), level_columns(campaign, own)]
        )
        apart = metadata_that_sets_tests_apart(campaign, base, others, freed)
        again = search(campaign, base, freed, others, self.seed, found.floor, also_in_mean=apart)
        # the gain counts what varies within tests many times over: the sizes are compared in mu
        size = sum(weighted_rms(found.change(f), campaign.count) ** 2 for f in known)
        kept = []
        for more in again.ranking:
            # curves along its loads show as much, or a load that it needs stays the same: the plan does not excite what it is about
            if more.name in again.by_parts or constant(more.effect, campaign):
                continue
            part = weighted_rms(again.change(more), campaign.count) ** 2
            if self._share(again, more) > LEAST_SHARE and credible(campaign, sensor, more):
                kept.append((again.p_value(more), part / (size + part), more))
        return kept

    def _share(self, found: SearchRound, fit: Fit) -> float:
        """Return the share of the squared error that a fit carries, the floor included."""
        rms = weighted_rms(found.change(fit), self.campaign.count)
        return error_share(rms, found.floor.total)

    def _large_ones_first(self) -> None:
        """If the first effect is too small to matter, let a significant larger one lead.

        An effect that varies along tests is seen in many averages. Even traces of it, as errors of a twin leave them, may gain
        more than an effect that sets the level of tests.
        """
        found = self.found
        for fit in found.ranking[:4]:
            if fit.gain < AS_GOOD * found.ranking[0].gain or found.p_value(fit) >= LEVEL:
                return
            if self._share(found, fit) > LEAST_SHARE:
                rest = [f for f in found.ranking if f is not fit]
                large = [f for f in rest if f.gain < fit.gain or self._share(found, f) > LEAST_SHARE]
                found.ranking = [fit, *large, *(f for f in rest if not any(f is x for x in large))]
                return
