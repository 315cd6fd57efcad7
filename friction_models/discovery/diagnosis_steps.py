"""`diagnose`: which physical effect is missing.

Steps: bin every test, estimate the noise floor around a flexible mean, whiten, scan all effects over their
shape parameters, take the family-wise p-value from simulated noise, re-estimate the floor with the winner in,
look for rivals, for a second effect, and for structure that no effect explains.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from ..common import InputError
from ..common.errors import shown
from ..common.processes.one_blas_thread import one_blas_thread
from ..common.processes.pool import Progress
from ..common.processes.stages import Stages
from ..effects import CATALOGUE, make_effect
from ..effects.base import Effect
from ..effects.together import check_together
from ..estimation.campaign.binned_tests import BinnedTests
from ..estimation.campaign.binning import prepare
from ..estimation.campaign.factors import factors_of
from ..estimation.campaign.mixed_units import means_of_tests
from ..estimation.noise.noise_floor import NoiseFloor
from ..estimation.search.base_law import BaseLaw, base_law
from ..estimation.search.candidates import Candidate, evaluate_all, spans_of
from ..estimation.search.unseen_loads import testable
from ..expressions.parameters import check_seed
from ..loads import FloatArray
from ..models.base import FrictionModel
from ..models.domain import Domain
from ..models.model_card import LISTED_TESTS, test_digests
from ..models.tangent import polynomial_columns
from .answer.diagnosis import Diagnosis
from .answer.summaries import base_residual
from .assembly import assemble
from .causes.beside_levels import beside_levels
from .effect_search import EffectSearch
from .formulas.beside_names import beside_names
from .formulas.missing import Missing
from .formulas.search import not_offered, offers
from .judge.confirmation import NAMED, Confirmation
from .judge.identifiability import knows_the_noise
from .judge.judged import Judged
from .judge.unseen_tests import UnseenTests, refitted
from .judge.unseen_tests_judge import UnseenTestsJudge
from .judge.verdict import decide, named_verdict
from .judged_tests import SPARE, spare_averages, tests_beside, without_odd

#: Above this share of spikes the records have to be repaired first; the verdict is ``data_problem``.
MOST_SPIKES = 0.04
#: Verdicts that leave structure unexplained, for which empirical terms are sought.
UNEXPLAINED = ("unknown_structure", "partly_explained")
BESIDE_A_SHIFT = (
    "what is named was seen beside a change of the {base} model that is linear in the loads: the model was fitted to data "
    "that hold the effect, or is off by such a change itself"
)
FITTED_TO_THESE = (
    "the {base} model follows the noise of these very points, so it was fitted to them: what it lacks shows only in tests that "
    "it has not seen; hand over its family, or keep tests aside"
)


@one_blas_thread()
def diagnose(
    data: pd.DataFrame,
    tests: pd.DataFrame | None = None,
    model: Any = "linear",
    catalogue: Iterable[str | Effect] | Mapping[str, type[Effect]] | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Diagnosis:
    """Compare a model with measurements and say which physical effect it lacks.

    Parameters
    ----------
    data : pandas.DataFrame
        One row a point: ``test_id, t, v_rel, T, sigma_n, sd, psi, mu`` (see `TriboLoads`).
    tests : pandas.DataFrame, optional
        One row a test: ``test_id`` and metadata.
    model : str, FrictionModel or object with ``predict(array[n, 5])``
        Family name or model; a model's family is refitted together with every candidate. An object that
        only predicts (an FMU) is a fixed base.
    catalogue : iterable of str or Effect, optional
        Effects to consider; by default all known ones, and ``factor:COLUMN`` for further columns of `tests`.
    seed : int
        Of the simulated noise; the same seed gives the same answer.
    progress : callable, optional
        Called with how much is done [%], 100, and what is being done.

    Returns
    -------
    Diagnosis

    Raises
    ------
    InputError
        Data without points or columns, or without a load that a trained model was given; values outside physical limits,
        an unknown model or effect.
    """
    check_seed("diagnose", seed)
    if isinstance(catalogue, str):
        raise InputError(f"catalogue: {shown(catalogue, 60)} is a text; allowed: a list of effects")
    stages = Stages(progress)
    tested = tests_beside(prepare(data, tests), model, seed)
    stages(0, "noise of the tests")  # not before: what is refused is said in one sentence
    tested = without_odd(tested, model, seed)
    measured, campaign, base, floor = tested.measured, tested.campaign, tested.base, tested.floor
    stages(15, "effects of the catalogue")
    chosen = CATALOGUE if catalogue is None else catalogue
    effects = [make_effect(e) for e in (chosen.values() if isinstance(chosen, Mapping) else chosen)]
    check_together("catalogue", effects)
    factors, about = factors_of(campaign, effects) if catalogue is None else ([], [])
    usable, notes = testable([*effects, *factors], campaign, base.effects)
    notes += about
    mu = _base_prediction(campaign, base)
    spans = spans_of(campaign, mu)
    candidates, said = evaluate_all(usable, campaign, mu, spans)
    notes += said
    whole = (measured, base_law(base.model, measured, seed)) if refitted(base) else (campaign, base)
    judged = _judge(campaign, base, candidates, seed, floor, whole, stages)
    # what is taken as it is cannot be refitted with a term
    missing = None if base.fixed else _missing(campaign, judged, seed)
    if missing is not None and judged.verdict in NAMED:
        judged.confirmed = beside_names(judged.confirmed, missing)
        if judged.verdict not in NAMED:
            missing = _missing(campaign, judged, seed)
    judged.confirmed = beside_levels(judged.confirmed, campaign, _left(campaign, judged))
    if base.fixed and judged.verdict in UNEXPLAINED:
        # a model fitted to data that contain the effect has absorbed the linear part of it
        shifted = replace(base, columns=polynomial_columns(campaign.loads, 1), scaled=False)
        if spare_averages(campaign, shifted) >= SPARE:
            beside = _judge(campaign, shifted, candidates, seed, floor, (campaign, shifted), stages)
            if beside.verdict in NAMED and beside.verdict != judged.verdict:
                judged, base, whole = beside, shifted, (campaign, shifted)
                judged.notes.append(BESIDE_A_SHIFT.format(base=base.name))
    judged.notes[:0] = notes
    judged.odd_kept, judged.odd_region = tested.odd_kept, tested.odd_region
    if base.fixed and knows_the_noise(measured, base_law(base.model, measured, seed)):
        judged.knows_noise = True
        judged.notes.append(FITTED_TO_THESE.format(base=base.name))
    stages(75, "the answer, and what to test next")
    answer = assemble(campaign, base, judged, mu, whole)
    stages(90, "empirical terms")
    if missing is not None and judged.confirmed.shares is not None and _unexplained(judged.confirmed):
        answer.formulas = offers(missing, judged.confirmed.shares.best)
        answer.warnings += [] if answer.formulas else not_offered(missing)
    if "test_id" in data.columns and len(campaign.tests) <= LISTED_TESTS:
        answer.tests = test_digests(data["test_id"], data["mu"].to_numpy(dtype=float))
    answer.synthetic = bool(data.attrs.get("synthetic", False))
    stages(100, "the answer")
    return answer


def _judge(
    campaign: BinnedTests,
    base: BaseLaw,
    candidates: list[Candidate],
    seed: int,
    floor: NoiseFloor | None,
    whole: tuple[BinnedTests, BaseLaw],
    stages: Stages,
) -> Judged:
    """Search, weigh and decide, for a base with given columns; `whole` is what is refitted to predict unseen tests."""
    stages(20, "what fits best")
    searched = EffectSearch(campaign, base, candidates, seed, floor)
    evidence, chosen = searched.weigh(_share_outside(campaign, base))
    kinds = {c.effect.name: c.effect.kind for c in searched.candidates}
    verdict = decide(evidence, kinds)
    if campaign.spikes > MOST_SPIKES and verdict != "out_of_domain":
        verdict = "data_problem"
    if campaign.spikes > MOST_SPIKES or verdict == "out_of_domain":
        return Judged(searched.found, evidence, Confirmation(verdict), searched.notes)
    stages(30, "tests that a fit did not see")
    unseen = UnseenTests(*whole, seed, stages.until(75))
    judge = UnseenTestsJudge(campaign, unseen, searched.found, searched.further)
    alike = evidence.confusion_set
    confirmed = judge(verdict, chosen, named_verdict(alike, kinds), evidence.bent, alike)
    evidence = replace(evidence, confusion_set=[n for n in alike if n not in confirmed.behind])
    return Judged(searched.found, evidence, confirmed, searched.notes, unseen, searched.beside)


def _base_prediction(campaign: BinnedTests, base: BaseLaw) -> FloatArray:
    """Return the friction coefficient of the fitted base at every point, never negative."""
    coefficients = np.linalg.lstsq(base.columns, campaign.mu - base.offset, rcond=1e-10)[0]
    return np.maximum(base.columns @ coefficients + base.offset, 1e-4)


def _share_outside(campaign: BinnedTests, base: BaseLaw) -> float:
    """Return the share of the points outside the domain that the model was trained on, every test with the same weight; 0 if it has none."""
    model = base.model
    if isinstance(model, FrictionModel):
        if not hasattr(model, "domain_"):
            return 0.0
        domain: Any = model.domain_
    else:
        domain = getattr(model, "domain", None)
    if domain is None or not hasattr(domain, "distance"):
        return 0.0
    if isinstance(domain, Domain):
        domain = domain.without(campaign.absent)
    outside = np.asarray(domain.distance(campaign.loads.as_array())) > 0.1
    return float(np.mean(means_of_tests(outside.astype(float), campaign.point_starts)))


def _left(campaign: BinnedTests, judged: Judged) -> FloatArray:
    """Return what a fit to all tests leaves in the bins, shape (m,), beside what is named."""
    if judged.unseen is None or not judged.named:
        return base_residual(campaign, judged.found)
    return judged.unseen.fitted([f.effect for f in judged.named]).residual


def _unexplained(confirmed: Confirmation) -> bool:
    """Return whether enough is left for empirical terms."""
    return confirmed.verdict in UNEXPLAINED or confirmed.leaves_much


def _missing(campaign: BinnedTests, judged: Judged, seed: int) -> Missing | None:
    """Return what is missing beside what is named; None where no tests could be left out."""
    unseen, found = judged.unseen, judged.found
    if judged.confirmed.shares is None or unseen is None:
        return None
    return Missing(
        campaign=campaign,
        columns=np.column_stack([found.columns, *(f.columns for f in judged.chosen)]),
        y=found.y,
        whiten=found.whiten,
        unseen=unseen,
        before=unseen.errors([f.effect for f in judged.chosen]).total,
        seed=seed,
        sloping=found.columns.shape[1] == 1,
    )
