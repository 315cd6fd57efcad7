"""Makes the `Diagnosis` from a verdict and what it rests on: confidence, budget, warnings, tables."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..estimation.base_law import BaseLaw
from ..estimation.binning import FEW_TESTS, Campaign
from ..estimation.importance import weighted_rms
from ..estimation.scan import Fit
from ..estimation.search_round import SearchRound
from ..estimation.significance import stays_first
from ..estimation.structure import StructurePlace
from ..estimation.unseen_loads import EITHER, doubts
from ..loads import LOAD_NAMES, FloatArray
from .diagnosis import Diagnosis
from .findings import FittedEffect, ParameterValue
from .further_tests.next_tests import propose
from .identifiability import limits
from .level_offset import LevelOffset, level_of
from .summaries import averages, base_residual, binned_bias, unrecorded_factor, worst_tests
from .verdict import LEVEL, Evidence
from .wording import sentence

#: A noise floor above this share of mu hides everything else.
BLURRED = 0.5
#: Verdicts that name effects.
NAMED = ("explained", "ambiguous", "data_problem")


@dataclass
class Judged:
    """A verdict and what it rests on."""

    found: SearchRound
    evidence: Evidence
    verdict: str
    chosen: list[Fit]
    notes: list[str]


def _confidence(campaign: Campaign, judged: Judged, level: LevelOffset) -> float:
    """Return how sure the verdict is, 0 to 1."""
    found, evidence, verdict = judged.found, judged.evidence, judged.verdict
    if verdict == "nothing_missing":
        sure = float(np.clip(0.5 + evidence.p_value, 0.5, 0.95))
    elif verdict in NAMED and judged.chosen:
        sure = (1.0 - evidence.p_value) * stays_first(found.ranking, found.simulated)
        sure /= len(evidence.confusion_set) if verdict == "ambiguous" else 1.0
    elif verdict == "unknown_structure":
        structure = evidence.structure.p_value if evidence.unexplained else 1.0
        sure = float(np.clip(1.0 - min(structure, level.p_value if level.off else 1.0), 0.0, 0.99))
    else:
        sure = 0.9
    few = verdict == "nothing_missing" and len(campaign.tests) < FEW_TESTS
    blurred = verdict == "nothing_missing" and _blurred(campaign, found)
    return min(sure, 0.5) if few or blurred or not found.floor.known else sure


def _blurred(campaign: Campaign, found: SearchRound) -> bool:
    """Return whether the noise hides everything."""
    return found.floor.total > BLURRED * float(np.mean(campaign.mu))


def assemble(campaign: Campaign, base: BaseLaw, judged: Judged, mu: FloatArray) -> Diagnosis:
    """Return the diagnosis."""
    found, evidence, verdict, chosen = judged.found, judged.evidence, judged.verdict, judged.chosen
    floor = found.floor
    residual = base_residual(campaign, found)
    named = verdict in NAMED
    names = [f.name for f in chosen] if named else []
    moved = np.sum([found.change(f) for f in chosen], axis=0) if names else np.zeros(len(residual))
    # a linear shift of the model, fitted beside it, contains its level
    level = (
        level_of(found, chosen if named else [])
        if base.fixed and found.columns.shape[1] == 1
        else LevelOffset()
    )
    if level.off and verdict == "nothing_missing":
        judged.verdict = verdict = "unknown_structure"
    # residual of the model as users have it: refitted by ordinary least squares, or fixed
    usual = found.y if base.fixed else found.beyond_base(found.y)
    left = np.hypot(
        evidence.structure.rms if evidence.unexplained else 0.0, level.value if level.off else 0.0
    )
    most, doubted = doubts(campaign, verdict, chosen if named else [])
    confidence = min(_confidence(campaign, judged, level), most)
    factor = unrecorded_factor(campaign, residual - moved)
    if factor is not None and verdict == "nothing_missing":
        confidence = min(confidence, EITHER)  # what sets the two groups apart is missing
    where = _places(campaign, evidence) if verdict == "unknown_structure" else []
    warnings = [*campaign.warnings, *limits(campaign, base, evidence), *judged.notes, *doubted]
    if level.off:
        where += [level.entry(campaign)] if verdict == "unknown_structure" else []
        warnings.append(level.text(f"the {base.name} model"))
    if _blurred(campaign, found):
        warnings.append(
            f"the noise floor ({floor.total:.3g}) is more than half of mu itself ({np.mean(campaign.mu):.3g}): look for outliers "
            "and faulty tests first, little else can be seen in such data"
        )
    rivals = [f for n in evidence.confusion_set for f in found.ranking if f.name == n]
    if not rivals and chosen:
        rivals = chosen[:1]
    if len(rivals) == 1:
        rivals += [f for f in found.ranking if f.name != rivals[0].name and f.gain > 0][:1]
    proposals, inseparable = propose(campaign, found, rivals, mu, base)
    if named and (len(evidence.confusion_set) > 1 or not proposals):
        warnings += inseparable
    return Diagnosis(
        verdict=verdict,
        sentence=sentence(verdict, base, evidence, chosen, confidence, campaign, where, factor),
        effects=names,
        confidence=round(float(confidence), 3),
        confusion_set=evidence.confusion_set if names else [],
        ranking=[
            {
                "effect": f.name,
                "evidence": float(f.evidence),
                "gain": float(f.gain),
                "p_value": found.p_value(f),
            }
            for f in found.ranking
        ],
        noise_floor=floor.to_dict(),
        error_budget={
            "floor": floor.total,
            "explained": weighted_rms(moved, campaign.count),
            "missing": float(left),
        },
        where=where,
        worst_tests=worst_tests(campaign, usual),
        unrecorded_factor=factor,
        next_tests=proposals,
        warnings=warnings,
        model=base.name,
        bias=binned_bias(campaign, usual, usual - moved if names else None),
        parameters={f.name: _parameters(f) for f in chosen} if named else {},
        named={f.name: f.prepared.candidate.effect for f in chosen} if named else {},
        threshold=float(np.quantile(found.null, 1.0 - LEVEL)),
        averages=averages(campaign, usual, usual - moved, chosen if names else ()),
    )


def _places(campaign: Campaign, evidence: Evidence) -> list[StructurePlace]:
    """Return where structure is left: significant blocks, else the loads of the winner if its form does not fit."""
    if not evidence.unexplained:
        return []
    if evidence.structure.where or evidence.winner is None or not evidence.misfit.excess > 0.0:
        return list(evidence.structure.where)
    winner, excess = evidence.winner, evidence.misfit.excess
    region = {}
    for name in winner.prepared.candidate.effect.driver:
        if name in LOAD_NAMES and campaign.varies(name):
            values = getattr(campaign.loads, name)
            region[name] = [float(values.min()), float(values.max())]
    return [
        {
            "variables": list(region),
            "region": region,
            "shape": f"another form than {winner.name}",
            "share": float(excess / (winner.gain + excess)),
        }
    ]


def _parameters(fit: Fit) -> FittedEffect:
    effect = fit.prepared.candidate.effect
    values: dict[str, ParameterValue] = {
        a.name: {"value": float(v), "unit": a.unit}
        for a, v in zip(effect.amplitudes, fit.amplitudes, strict=True)
    }
    shape = fit.shape
    values |= {s.name: {"value": shape[s.name], "unit": s.unit} for s in effect.shapes}
    return {"equation": effect.equation, "values": values}
