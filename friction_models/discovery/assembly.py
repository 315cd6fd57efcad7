"""Makes the `Diagnosis` from a verdict and what it rests on: confidence, budget, warnings, tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from ..effects import Batch
from ..effects.metadata.factor import numbered
from ..estimation.campaign.binned_tests import BinnedTests
from ..estimation.campaign.factors import labels_of
from ..estimation.campaign.gaps import Gap, gaps_between_tests, gaps_text
from ..estimation.fit.open_gaps import OpenGap, open_gaps
from ..estimation.fit.parameters import FittedTerm, fit_terms
from ..estimation.search.base_law import BaseLaw
from ..estimation.search.structure import StructurePlace
from ..estimation.search.zero_reading import ZERO, zero_is_known
from ..loads import FloatArray
from .answer.budget_numbers import budget_numbers
from .answer.diagnosis import Diagnosis
from .answer.findings import FittedEffect, ParameterValue
from .answer.fit_warnings import about_the_fit
from .answer.not_first import comes_closest, why_not_first
from .answer.reservations import about_the_noise, could_hide, held, reservations, stands_out
from .answer.sentence import Sentence
from .answer.summaries import averages, base_residual, binned_bias, worst_tests
from .answer.uncertain_loads import floor_from_loads, uncertain_drivers
from .causes.codes import about_codes, codes_along
from .causes.other_causes import OtherCauses
from .further_tests.asked import answer_of, questions_of
from .further_tests.next_tests import NextTest, propose
from .how_sure import HowSure
from .judge.closest import Closest, closest_of
from .judge.confirmation import EXPLAINED
from .judge.doubts import BLURRED, LIKELY, blurred
from .judge.hidden_effects import unseen_sizes
from .judge.identifiability import limits, same_columns
from .judge.judged import Judged
from .judge.level_offset import LevelOffset, level_of
from .judge.verdict import LEVEL


def assemble(
    campaign: BinnedTests, base: BaseLaw, judged: Judged, mu: FloatArray, whole: tuple[BinnedTests, BaseLaw]
) -> Diagnosis:
    """Return the diagnosis; `whole` holds the points as measured, and the base there."""
    return _Assembly(campaign, base, judged, mu, whole).diagnosis()


class _Assembly:
    """The parts of an answer; the level of a model that is taken as it is may change its verdict, which comes first."""

    def __init__(
        self,
        campaign: BinnedTests,
        base: BaseLaw,
        judged: Judged,
        mu: FloatArray,
        whole: tuple[BinnedTests, BaseLaw],
    ) -> None:
        self.campaign, self.base, self.judged, self.mu, self.whole = campaign, base, judged, mu, whole
        self.found, self.evidence, self.chosen = judged.found, judged.evidence, judged.chosen
        self.named = bool(judged.named)
        self.effects = [f.effect for f in judged.named]
        unseen = judged.unseen
        self.fitted = fit_terms(*whole, self.effects) if unseen is None else unseen.fitted(self.effects)
        self.names, self.confusion = [term.name for term in self.fitted.terms], judged.confusion
        self.usual_mu = float(np.mean(np.abs(campaign.mu)))
        self.level = self._level()
        if self.level.off and judged.verdict == "nothing_missing":
            self._turn("unknown_structure")
        # residual of the model as users have it: refitted by ordinary least squares, or fixed
        self.usual = self.found.y if base.fixed else self.found.beyond_base(self.found.y)
        alone = self.evidence.structure.rms if self.evidence.unexplained else 0.0
        self.floor, self.budget = budget_numbers(
            campaign, self.found, judged.confirmed, self.level, self.usual, alone
        )
        from_loads = floor_from_loads(*whole, self.fitted.terms, mu)
        if from_loads is not None:
            self.floor["from_loads"] = from_loads
        if self.level.off and judged.verdict in {"explained", "ambiguous"} and self._level_matters():
            self._turn("partly_explained")
        self.verdict, self.confirmed = judged.verdict, judged.confirmed

    def diagnosis(self) -> Diagnosis:
        """Return the answer."""
        campaign, found, fitted = self.campaign, self.found, self.fitted
        # the table after the names is that of the model as it is: its level stays wrong
        after = fitted.residual + (self.level.left if self.level.off else 0.0) if self.named else None
        proposals, inseparable = self._further_tests()
        told = inseparable if self.named and (len(self.confusion) > 1 or not proposals) else []
        return Diagnosis(
            verdict=self.verdict,
            sentence=self._sentence(),
            effects=self.names,
            confidence=self.sure.value,
            grounds=self.sure.grounds,
            confusion_set=self.confusion,
            ranking=[
                {
                    "effect": f.name,
                    "evidence": float(f.evidence),
                    "gain": float(f.gain),
                    "p_value": found.p_value(f),
                }
                for f in found.ranking
            ],
            noise_floor=self.floor,
            error_budget=self.budget,
            where=self.where,
            worst_tests=worst_tests(campaign, self.usual),
            unrecorded_factor=self.causes.factor,
            next_tests=proposals,
            warnings=[*self._warnings(), *told],
            model=self.base.name,
            bias=binned_bias(campaign, self.usual, after),
            parameters={term.name: _parameters(campaign, term) for term in fitted.terms},
            named={term.name: term.effect for term in fitted.terms},
            threshold=found.significance.needed(LEVEL),
            averages=averages(campaign, self.usual, self.usual if after is None else after, fitted.terms),
            not_first=_not_first(self.judged, self.confusion) if self.named else "",
        )

    def _turn(self, verdict: str) -> None:
        self.judged.confirmed = replace(self.judged.confirmed, verdict=verdict)

    def _level(self) -> LevelOffset:
        """Return the level of a model as it is; a linear shift of the model, fitted beside it, contains its level."""
        if self.base.fixed and (self.base.scaled or self.base.columns.shape[1] == 1):
            return level_of(self.found, self.judged.named, self.base.scaled)
        return LevelOffset()

    def _level_matters(self) -> bool:
        """Return whether more is missing than an answer that explains may leave."""
        missing, explained = self.budget["missing"] ** 2, self.budget["explained"] ** 2
        return missing > EXPLAINED * (missing + explained)

    @cached_property
    def left(self) -> FloatArray:
        """What a fit to all tests leaves in the bins, shape (m,)."""
        return self.fitted.residual if self.named else base_residual(self.campaign, self.found)

    @cached_property
    def causes(self) -> OtherCauses:
        """What else may have made what is named or left."""
        left = self.left
        # what loads and metadata say of unseen tests is no group that nobody recorded
        beyond = self.confirmed.beyond
        unknown = left if beyond is None else left - beyond
        named = self.judged.named
        return OtherCauses.of(self.campaign, self.found, named, self.fitted, unknown, self.confirmed.sharper)

    @cached_property
    def unread(self) -> bool:
        """Whether an offset of the force is named beside other effects, and no reading without load says that it is there."""
        named = [f.name for f in self.chosen]
        several = ZERO in named and len(named) > 1
        return several and not zero_is_known(self.campaign, self.found.floor.sensor)

    @cached_property
    def closest(self) -> Closest | None:
        """What would help most where no effect is named."""
        return closest_of(self.judged)

    @cached_property
    def hidden(self) -> dict[str, tuple[float, float]]:
        """Sizes of effects that would not have been seen, where nothing is missing."""
        nothing = self.verdict == "nothing_missing" and self.found.floor.known
        return unseen_sizes(self.found) if nothing and not self.confirmed.within_resolution else {}

    @cached_property
    def sure(self) -> HowSure:
        """How sure the answer is."""
        return HowSure.of(
            self.campaign,
            self.base,
            self.judged,
            self.causes,
            self.level,
            self.closest,
            unread=self.unread,
            codes=bool(self.codes),
        )

    @cached_property
    def codes(self) -> dict[str, list[int]]:
        """Columns of the test table whose numbers may be names."""
        return codes_along(self.campaign, self.where, self.left)

    @cached_property
    def where(self) -> list[StructurePlace]:
        """The structure that is left."""
        if self.verdict in {"unknown_structure", "partly_explained"} or self.confirmed.leaves_much:
            level = [self.level.entry(self.campaign)] if self.level.off else []
            return [*_places(self.campaign, self.judged), *level]
        return []

    @cached_property
    def untested(self) -> dict[str, list[Gap]]:
        """Gaps between the levels of the plan, where nothing is missing: the model alone says what friction does there."""
        return gaps_between_tests(self.campaign) if self.verdict == "nothing_missing" else {}

    def _warnings(self) -> list[str]:
        campaign, found, level = self.campaign, self.found, self.level
        sure = self.sure
        unsure = sure.value <= LIKELY and not sure.held_by_loads and self.causes.factor is None
        # of a mu that is nothing everywhere there are no outliers
        blurs = blurred(campaign, self.judged) and self.floor["total"] >= BLURRED * self.usual_mu
        hides = self.floor["total"] if blurs and np.any(campaign.mu) else None
        gaps = [
            f"no test measured between the levels of the plan ({gaps_text(self.untested)}): what friction does there, none of them says"
        ]
        return [
            *campaign.warnings,
            *limits(campaign, self.base, self.evidence),
            *self.judged.notes,
            *(doubt.reason for doubt in sure.of_loads),
            *([] if sure.held_by_loads else held(sure.beside_loads)),
            *same_columns(campaign, self.effects, [f.effect for f in found.ranking]),
            *self.causes.warnings(),
            *uncertain_drivers(self.whole[0], self.fitted.terms),
            *reservations(campaign, found, self.confirmed, self.judged.knows_noise, unsure),
            *([comes_closest(self.closest)] if self.closest is not None else []),
            *(gaps if self.untested else []),
            *could_hide(self.hidden, self.usual_mu),
            *about_codes(self.codes),
            *([level.text(f"the {self.base.name} model")] if level.off else []),
            *about_the_noise(campaign, hides),
            *about_the_fit(campaign, self.fitted),
        ]

    def _further_tests(self) -> tuple[list[NextTest], list[str]]:
        """Return tests to run next, and what no test tells apart."""
        questions = questions_of(self.judged, self.confusion, self.unread)
        gaps = [OpenGap("", gap, 0.0) for own in self.untested.values() for gap in own]
        gaps += open_gaps(self.campaign, self.fitted)
        answer = answer_of(self.verdict, self.sure.value)
        return propose(self.campaign, questions, self.mu, self.base, answer, gaps, self.unread)

    def _sentence(self) -> str:
        confirmed, close = self.confirmed, None
        if confirmed.within_resolution and confirmed.shares is not None:
            close = float(np.sqrt(confirmed.shares.base)) / self.usual_mu
        blind = any(most >= self.usual_mu for _, most in self.hidden.values())
        return Sentence(
            verdict=self.verdict,
            base=self.base.name,
            evidence=self.evidence,
            chosen=self.chosen,
            confusion=self.confusion,
            confidence=self.sure.value,
            campaign=self.campaign,
            where=self.where,
            by_factor=self.level.factor is not None,
            factor=self.causes.factor,
            close=close,
            unread=self.unread,
            hidden=blind or stands_out(self.found, confirmed) is not None,
            by_settings=confirmed.by_repeats and not self.where,
            jump=self.causes.jumps.get(self.names[0]) if self.names else None,
        ).text()


def _not_first(judged: Judged, confusion: Sequence[str]) -> str:
    """Return why the first name is not the first of the ranking; empty where it is, or no tests can be left out."""
    unseen = judged.unseen
    if unseen is None or not unseen.possible:
        return ""
    return why_not_first(
        judged.chosen, judged.found.ranking, confusion, lambda effects: unseen.errors(effects).rms
    )


def _places(campaign: BinnedTests, judged: Judged) -> list[StructurePlace]:
    """Return where structure is left: what the reference predicts beyond the model, else blocks that stand out, or the loads of a
    winner whose form does not fit."""
    evidence, places = judged.evidence, judged.confirmed.where
    if places or judged.verdict != "unknown_structure" or not evidence.unexplained:
        return places
    if evidence.structure.where:
        return list(evidence.structure.where)
    if evidence.winner is None or evidence.misfit.excess <= 0.0:
        return places
    winner, excess = evidence.winner, evidence.misfit.excess
    region = campaign.ranges(winner.effect.driver)
    return [
        {
            "variables": list(region),
            "region": region,
            "shape": f"another form than {winner.name}",
            "share": float(excess / (winner.gain + excess)),
        }
    ]


def _parameters(campaign: BinnedTests, term: FittedTerm) -> FittedEffect:
    effect, values = term.effect, {**term.amplitudes, **term.shape}
    found: dict[str, ParameterValue] = {}
    units = {p.name: p.unit for p in effect.amplitudes} | {p.name: p.unit for p in effect.shapes}
    for name, unit in units.items():
        found[name] = {"value": values[name], "unit": unit}
        if name in term.intervals:
            found[name]["interval"] = list(term.intervals[name])
        if name in term.not_known:
            found[name]["not_known"] = True
    # a factor says its labels itself, and so do pooled levels
    batches = labels_of(campaign, Batch.name) if effect.name == Batch.name else []
    said = f" ({numbered(batches)})" if batches and not effect.pooled else ""
    return {"equation": effect.equation + said, "values": found}
