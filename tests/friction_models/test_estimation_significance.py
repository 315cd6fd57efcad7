"""P-values and confusion sets: the rates that they promise, counted over many draws."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kstest

from friction_models.estimation.scan import Prepared, Projector, prepare_candidate, rank
from friction_models.estimation.significance import (
    REPLICATES,
    alike,
    confusion_set,
    maximum_gains,
    null_noise,
    p_value,
    simulate,
    stays_first,
)

from .estimation_cases import candidate

M = 120
BASE = np.ones((M, 1))


def catalogue(rng: np.random.Generator, effects: int = 6, sets: int = 5) -> list[Prepared]:
    """Return effects whose columns are random walks: smooth, and like each other, as laws of loads are."""
    columns = np.cumsum(rng.normal(size=(M, effects, sets)), axis=0)
    return [
        prepare_candidate(candidate(f"e{k}", columns[:, k, :, None]), lambda v: v, Projector(BASE))
        for k in range(effects)
    ]


@pytest.mark.parametrize("freedom", [5.0, 1e9])
def test_family_wise_p_values_are_uniform_where_nothing_is_missing(freedom: float) -> None:
    rng = np.random.default_rng(0)
    prepared, project, values = catalogue(rng), Projector(BASE), []
    for _ in range(200):
        # the floor is estimated: the noise is larger or smaller than it says, by chi-square of its degrees of freedom
        noise = rng.normal(size=M) * np.sqrt(freedom / rng.chisquare(freedom))
        null = maximum_gains(
            prepared,
            simulate(
                prepared, project, null_noise(np.zeros(M), np.zeros(M, dtype=int), freedom, rng, REPLICATES)
            ),
        )
        values.append(p_value(rank(prepared, project(noise))[0].gain, null))
    assert kstest(values, "uniform").pvalue > 0.01
    assert 0.015 < np.mean(np.array(values) < 0.05) < 0.1


def test_the_p_value_counts_the_simulated_gains() -> None:
    null = np.arange(99.0)
    assert p_value(98.5, null) == 1.0 / 100.0
    assert p_value(89.0, null) == 11.0 / 100.0
    assert p_value(-1.0, null) == 1.0


def test_the_true_effect_stays_in_the_confusion_set_at_the_rate_that_is_promised() -> None:
    rng = np.random.default_rng(1)
    first = rng.normal(size=M)
    second = 0.95 * first + np.sqrt(1.0 - 0.95**2) * rng.normal(size=M)
    project = Projector(BASE)
    prepared = [
        prepare_candidate(candidate(n, c[:, None, None]), lambda v: v, project)
        for n, c in (("truth", first), ("rival", second))
    ]
    simulated = simulate(
        prepared, project, null_noise(np.zeros(M), np.zeros(M, dtype=int), 1e9, rng, REPLICATES)
    )
    signal, kept, lost = project(0.5 * first), 0, 0
    for _ in range(200):
        ranking = rank(prepared, signal + project(rng.normal(size=M)))
        lost += ranking[0].name != "truth"
        kept += "truth" in confusion_set(ranking, simulated)
    assert lost > 10  # the rival comes first often enough to try it
    assert kept >= 180  # at the level of 5 %, with the strength of the rival estimated
    # how often the truth comes first is what the draws above count
    ranking = rank(prepared, signal)
    assert ranking[0].name == "truth"
    assert stays_first(ranking, simulated) == pytest.approx(1.0 - lost / 200, abs=0.06)


def test_only_contributions_that_differ_are_told_apart() -> None:
    """Contributions that correlate by more than 0.98 count as one, however strong the signal is."""
    rng = np.random.default_rng(2)
    project = Projector(BASE)
    first, beside, other = np.linalg.qr(project(rng.normal(size=(M, 3))))[0].T
    columns = {
        "first": first,
        "twin": 0.985 * first + np.sqrt(1.0 - 0.985**2) * beside,
        "sibling": 0.97 * first + np.sqrt(1.0 - 0.97**2) * beside,
        "other": other,
    }
    prepared = [
        prepare_candidate(candidate(n, c[:, None, None]), lambda v: v, project) for n, c in columns.items()
    ]
    simulated = simulate(
        prepared, project, null_noise(np.zeros(M), np.zeros(M, dtype=int), 1e9, rng, REPLICATES)
    )
    ranking = rank(prepared, 400.0 * first + 250.0 * other)
    assert confusion_set(ranking, simulated) == ["first", "twin"]
    fits = {f.name: f for f in ranking}
    assert alike(fits["first"], fits["twin"]) == pytest.approx(0.985)
    assert stays_first([fits["first"], fits["other"]], simulated) == 1.0


def test_noise_of_few_loud_tests_is_no_effect() -> None:
    """With normal noise a column that lies in the loudest test is found far too often; with the tests' own signs it is not."""
    tests, bins = 40, 6
    test = np.repeat(np.arange(tests), bins)
    rng = np.random.default_rng(3)
    project = Projector(np.ones((tests * bins, 1)))
    alarms = 0
    for _ in range(60):
        loud = np.where(rng.random(tests) < 0.1, 4.0, 0.6)[test]
        residual = project(loud * rng.normal(size=tests)[test] + 0.1 * rng.normal(size=len(test)))
        columns = rng.normal(size=(tests, 6))[test]
        prepared = [
            prepare_candidate(candidate(f"c{k}", columns[:, [k]][:, :, None]), lambda v: v, project)
            for k in range(6)
        ]
        noise = null_noise(residual, test, 1e9, rng, REPLICATES)
        null = maximum_gains(prepared, simulate(prepared, project, noise))
        alarms += p_value(rank(prepared, residual)[0].gain, null) < 0.05
    assert alarms <= 8
