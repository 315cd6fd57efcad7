"""Evidence for a mechanism whose formula is somewhat wrong: against the dense Gaussian likelihood, and on planted forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kstest, multivariate_normal

from friction_models.discovery.judge.verdict import STRUCTURE_LEVEL
from friction_models.estimation.campaign.binned_tests import BinnedTests
from friction_models.estimation.search.form_error import FORM_ERROR, FormErrors, evidence, form_variance
from friction_models.estimation.search.scan import Fit, Projector, best_fit, prepare_candidate, rank
from friction_models.estimation.search.search_round import SearchRound
from friction_models.estimation.search.structure import own_misfit

from .estimation_cases import candidate, measured, searched

M = 80


def test_evidence_is_the_gain_in_likelihood_with_deviations_as_part_of_the_noise() -> None:
    rng = np.random.default_rng(0)
    base = np.ones((M, 1))
    project = Projector(base)
    column = rng.normal(size=M)
    residual = project(2.0 * column + 0.3 * rng.normal(size=M) + rng.normal(size=M))
    fit = best_fit(prepare_candidate(candidate("a", column[:, None, None]), lambda v: v, project), residual)
    q = Projector(project(rng.normal(size=(M, 4)))).q
    assert evidence(fit, q[:, :0], residual) == fit.gain

    signal = fit.signal
    variance = FORM_ERROR**2 * float(np.sum(signal**2)) / 4.0
    assert form_variance(fit, 4) == pytest.approx(variance)
    S = np.eye(M) + variance * q @ q.T
    x = project(column)
    best = (x @ np.linalg.solve(S, residual)) / (x @ np.linalg.solve(S, x))
    with_effect = multivariate_normal(np.zeros(M), S).logpdf(residual - best * x)
    noise = multivariate_normal(np.zeros(M), np.eye(M)).logpdf(residual)
    assert evidence(fit, q, residual) == pytest.approx(2.0 * (with_effect - noise) - 2.0, rel=1e-9)


def _forms(seed: int, bend: float) -> tuple[FormErrors, list[Fit], BinnedTests, SearchRound]:
    """Return candidates along speed and along pressure, where mu follows speed by a curve that is bent beside its formula."""
    data = measured(np.random.default_rng([seed, 5]), tests=40, points=8, between=0.001, sensor=0.0005)
    formula, curve = np.exp(-data["v_rel"] / 60.0), np.sin(data["v_rel"] / 60.0)
    data = data.assign(mu=data["mu"] + 0.03 * formula + bend * curve)
    # the floor knows the effect, as in the second search of a diagnosis
    campaign, found = searched(data, known=formula)
    columns = {
        "speed": campaign.average(np.exp(-campaign.loads.v_rel / 60.0)),
        "temperature": campaign.average((campaign.loads.T / 100.0) ** 3),
    }
    driver = {"speed": ("v_rel",), "temperature": ("T",)}
    prepared = [
        prepare_candidate(candidate(n, c[:, None, None], driver=driver[n]), found.whiten, found.project)
        for n, c in columns.items()
    ]
    fits = rank(prepared, found.residual)
    return FormErrors(campaign, found.whiten, found.project), fits, campaign, found


def _driven_by(fit: Fit, load: str) -> Fit:
    """Return the fit as if its effect were one of another load."""
    known = fit.prepared.candidate
    other = candidate("other", known.columns, driver=(load,))
    return replace(fit, prepared=replace(fit.prepared, candidate=other))


def test_a_wrong_form_is_seen_along_the_loads_of_the_effect() -> None:
    for seed in range(3):
        for bend, wrong in ((0.0, False), (0.003, True)):
            forms, fits, campaign, found = _forms(seed, bend)
            best = forms.ranked(fits, found.residual)[0]
            assert best.name == "speed"
            misfit = own_misfit(campaign, found, best, best.prepared.columns[:, 0], seed)
            assert (misfit.p_value < STRUCTURE_LEVEL) is wrong
            # deviations pay where the form is wrong, and cost where it is right
            assert (best.evidence > best.gain) is wrong
            assert (best.evidence > forms.evidence(_driven_by(best, "T"), found.residual) + 10.0) is wrong


def test_the_misfit_of_a_right_form_is_what_noise_gives() -> None:
    misfits = []
    for seed in range(25):
        _, fits, campaign, found = _forms(100 + seed, 0.0)
        misfits.append(own_misfit(campaign, found, fits[0], found.whiten(fits[0].binned[:, None]), seed))
    assert kstest([m.p_value for m in misfits], "uniform").pvalue > 0.05
    assert abs(np.mean([m.excess for m in misfits])) < 2.0
