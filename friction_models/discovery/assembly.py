"""Makes the `Diagnosis` from a verdict and what it rests on: confidence, budget, warnings, tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..effects import Batch
from ..effects.metadata.factor import numbered
from ..estimation.campaign.binned_tests import BinnedTests
from ..estimation.campaign.factors import labels_of
from ..estimation.campaign.gaps import gaps_between_tests, gaps_text
from ..estimation.fit.open_gaps import OpenGap, open_gaps
from ..estimation.fit.parameters import FittedTerm, fit_terms
from ..estimation.search.base_law import BaseLaw
from ..estimation.search.structure import StructurePlace
from ..estimation.search.unseen_loads import EITHER, doubts
from ..estimation.search.zero_reading import ZERO, zero_is_known
from ..loads import FloatArray
from .answer.budget_numbers import budget_numbers
from .answer.diagnosis import Diagnosis
from .answer.findings import ErrorBudget, FittedEffect, ParameterValue
from .answer.fit_warnings import about_the_fit
from .answer.not_first import comes_closest, why_not_first
from .answer.other_causes import OtherCauses
from .answer.reservations import about_the_noise, could_hide, reservations, stands_out
from .answer.summaries import averages, base_residual, binned_bias, worst_tests
from .answer.uncertain_loads import floor_from_loads, uncertain_drivers
from .answer.wording import sentence
from .further_tests.asked import answer_of, questions_of
from .further_tests.next_tests import propose
from .judge.confidence import BLURRED, blurred, grounds, sureness
from .judge.confirmation import EXPLAINED, NAMED
from .judge.error_budget import helps
from .judge.hidden_effects import unseen_sizes
from .judge.identifiability import limits, same_columns
from .judge.judged import Judged
from .judge.level_offset import LevelOffset, level_of
from .judge.verdict import LEVEL


def _beside_unread_zero(campaign: BinnedTests, judged: Judged) -> bool:
    """Return whether an offset of the force is named beside other effects, and no reading without load says that it is there."""
    named = [f.name for f in judged.chosen]
    return ZERO in named and len(named) > 1 and not zero_is_known(campaign, judged.found.floor.sensor)


def _level_matters(budget: ErrorBudget) -> bool:
    """Return whether more is missing than an answer that explains may leave."""
    return budget["missing"] ** 2 > EXPLAINED * (budget["missing"] ** 2 + budget["explained"] ** 2)


def assemble(
    campaign: BinnedTests, base: BaseLaw, judged: Judged, mu: FloatArray, whole: tuple[BinnedTests, BaseLaw]
) -> Diagnosis:
    """Return the diagnosis; `whole` holds the points as measured, and the base there."""
    found, evidence, verdict, chosen = judged.found, judged.evidence, judged.verdict, judged.chosen
    named = verdict in NAMED and bool(chosen)
    effects = [f.effect for f in chosen] if named else []
    fitted = fit_terms(*whole, effects) if judged.unseen is None else judged.unseen.fitted(effects)
    names, confusion = [term.name for term in fitted.terms], judged.confusion
    # a linear shift of the model, fitted beside it, contains its level
    level = (
        level_of(found, chosen if named else [])
        if base.fixed and base.columns.shape[1] == 1
        else LevelOffset()
    )
    if level.off and verdict == "nothing_missing":
        judged.confirmed = replace(judged.confirmed, verdict="unknown_structure")
        verdict = "unknown_structure"
    # residual of the model as users have it: refitted by ordinary least squares, or fixed
    usual = found.y if base.fixed else found.beyond_base(found.y)
    alone = evidence.structure.rms if evidence.unexplained else 0.0
    floor, budget = budget_numbers(campaign, found, judged.confirmed, level, usual, alone)
    from_loads = floor_from_loads(*whole, fitted.terms, mu)
    if from_loads is not None:
        floor["from_loads"] = from_loads
    if level.off and verdict in {"explained", "ambiguous"} and _level_matters(budget):
        judged.confirmed = replace(judged.confirmed, verdict="partly_explained")
        verdict = "partly_explained"
    # the table after the names is that of the model as it is: its level stays wrong
    after = fitted.residual + (level.value if level.off else 0.0) if named else None
    most, doubted = doubts(campaign, verdict, chosen if named else [])
    rests_on = grounds(found, evidence, judged.confirmed, len(campaign.tests))
    left = fitted.residual if named else base_residual(campaign, found)
    # what loads and metadata say of unseen tests is no group that nobody recorded
    beyond = judged.confirmed.beyond
    unknown = left if beyond is None else left - beyond
    causes = OtherCauses.of(
        campaign, found, chosen if named else [], fitted, unknown, judged.confirmed.sharper
    )
    unread = _beside_unread_zero(campaign, judged)
    nothing = verdict == "nothing_missing" and found.floor.known and not judged.confirmed.within_resolution
    hidden = unseen_sizes(found) if nothing else {}
    sure = min(
        sureness(
            campaign,
            found,
            judged.confirmed,
            rests_on,
            off=level.p_value if level.off else None,
            grouped=causes.grouped,
            knows_noise=judged.knows_noise,
            odd_kept=judged.odd_kept,
            unread=unread,
            on_one=bool(causes.on_one),
            other_cause=causes.do_as_well,
        ),
        most,
    )
    # as files have it, so that the sentence and a page made of them say the same
    sure = round(float(sure), 3)
    where: list[StructurePlace] = []
    if verdict in {"unknown_structure", "partly_explained"} or judged.confirmed.leaves_much:
        where = [*_places(campaign, judged), *([level.entry(campaign)] if level.off else [])]
    warnings = [*campaign.warnings, *limits(campaign, base, evidence), *judged.notes, *doubted]
    warnings += same_columns(campaign, effects, [f.effect for f in found.ranking])
    warnings += [*causes.warnings(), *uncertain_drivers(whole[0], fitted.terms)]
    unsure = sure <= EITHER < most and causes.factor is None
    warnings += reservations(campaign, found, judged.confirmed, judged.knows_noise, unsure)
    warnings += _closest(judged)
    # between the levels, the model alone says what friction does
    untested = gaps_between_tests(campaign) if verdict == "nothing_missing" else {}
    if untested:
        warnings.append(
            f"no test measured between the levels of the plan ({gaps_text(untested)}): what friction does there, none of them says"
        )
    usual_mu = float(np.mean(np.abs(campaign.mu)))
    warnings += could_hide(hidden, usual_mu)
    may_hide = stands_out(found, judged.confirmed) is not None
    may_hide = may_hide or any(most >= usual_mu for _, most in hidden.values())
    warnings += [level.text(f"the {base.name} model")] if level.off else []
    # of a mu that is nothing everywhere there are no outliers
    hidden_by = blurred(campaign, found, judged.confirmed) and floor["total"] >= BLURRED * usual_mu
    hides = floor["total"] if hidden_by and np.any(campaign.mu) else None
    warnings += [*about_the_noise(campaign, hides), *about_the_fit(campaign, fitted)]
    questions = questions_of(judged, confusion, unread)
    gaps = [OpenGap("", gap, 0.0) for own in untested.values() for gap in own]
    gaps += open_gaps(campaign, fitted)
    proposals, inseparable = propose(campaign, questions, mu, base, answer_of(verdict, sure), gaps, unread)
    if named and (len(confusion) > 1 or not proposals):
        warnings += inseparable
    close = None
    if judged.confirmed.within_resolution and judged.confirmed.shares is not None:
        close = float(np.sqrt(judged.confirmed.shares.base)) / usual_mu
    return Diagnosis(
        verdict=verdict,
        sentence=sentence(
            verdict,
            base,
            evidence,
            chosen,
            confusion,
            sure,
            campaign,
            where,
            causes.factor,
            close,
            unread,
            may_hide,
            causes.jumps.get(names[0]) if names else None,
        ),
        effects=names,
        confidence=sure,
        grounds=rests_on,
        confusion_set=confusion,
        ranking=[
            {
                "effect": f.name,
                "evidence": float(f.evidence),
                "gain": float(f.gain),
                "p_value": found.p_value(f),
            }
            for f in found.ranking
        ],
        noise_floor=floor,
        error_budget=budget,
        where=where,
        worst_tests=worst_tests(campaign, usual),
        unrecorded_factor=causes.factor,
        next_tests=proposals,
        warnings=warnings,
        model=base.name,
        bias=binned_bias(campaign, usual, after),
        parameters={term.name: _parameters(campaign, term) for term in fitted.terms},
        named={term.name: term.effect for term in fitted.terms},
        threshold=found.significance.needed(LEVEL),
        averages=averages(campaign, usual, usual if after is None else after, fitted.terms),
        not_first=_not_first(judged, confusion) if named else "",
    )


def _not_first(judged: Judged, confusion: Sequence[str]) -> str:
    """Return why the first name is not the first of the ranking; empty where it is, or no tests can be left out."""
    unseen = judged.unseen
    if unseen is None or not unseen.possible:
        return ""
    return why_not_first(
        judged.chosen, judged.found.ranking, confusion, lambda effects: unseen.errors(effects).rms
    )


def _closest(judged: Judged) -> list[str]:
    """Return a warning where no effect is named and the first of the ranking that is no fault of the data would help all the same."""
    unseen, shares = judged.unseen, judged.confirmed.shares
    first = next((f for f in judged.found.ranking if f.effect.kind != "fault"), None)
    if judged.verdict != "unknown_structure" or unseen is None or shares is None or first is None:
        return []
    if judged.found.p_value(first) >= LEVEL:
        return []
    before, after = unseen.errors(), unseen.errors([first.effect])
    reachable = float(np.sqrt(min(shares.best, after.rms**2)))
    return [comes_closest(first.name, before.rms, after.rms, reachable)] if helps(before, after) else []


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
