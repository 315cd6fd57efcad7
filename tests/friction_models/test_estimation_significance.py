"""P-values and confusion sets: the rates that they promise, counted over many draws."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kstest

from friction_models.estimation.search.scan import Prepared, Projector, prepare_candidate, rank
from friction_models.estimation.search.significance import (
    REPLICATES,
    Freedom,
    Significance,
    Simulated,
    alike,
    confusion_set,
    null_noise,
    simulate,
    stays_first,
)

from .estimation_cases import candidate

M = 120
BASE = np.ones((M, 1))
ONE_TEST = np.zeros(M, dtype=int)
#: Freedom with which a floor is as good as known.
KNOWN = Freedom(1e9, 1e9)


def catalogue(rng: np.random.Generator, effects: int = 6, sets: int = 5) -> list[Prepared]:
    """Return effects whose columns are random walks: smooth, and like each other, as laws of loads are."""
    columns = np.cumsum(rng.normal(size=(M, effects, sets)), axis=0)
    return [
        prepare_candidate(candidate(f"e{k}", columns[:, k, :, None]), lambda v: v, Projector(BASE))
        for k in range(effects)
    ]


def in_noise(prepared: list[Prepared], freedom: Freedom, rng: np.random.Generator) -> Simulated:
    """Return what effects see of the noise of a single test."""
    noise = null_noise(np.zeros(M), np.ones(M), ONE_TEST, freedom, rng, REPLICATES)
    return simulate(prepared, Projector(BASE), noise)


@pytest.mark.parametrize("freedom", [5.0, 1e9])
def test_family_wise_p_values_are_uniform_where_nothing_is_missing(freedom: float) -> None:
    rng = np.random.default_rng(0)
    prepared, project, values = catalogue(rng), Projector(BASE), []
    for _ in range(200):
        # the floor is estimated: the noise is larger or smaller than it says, by chi-square of its degrees of freedom
        noise = rng.normal(size=M) * np.sqrt(freedom / rng.chisquare(freedom))
        simulated = in_noise(prepared, Freedom(freedom, freedom), rng)
        first = rank(prepared, project(noise))[0]
        values.append(Significance(prepared, simulated, np.ones(M), ONE_TEST).p_value(first.name, first.gain))
    assert kstest(values, "uniform").pvalue > 0.01
    assert 0.015 < np.mean(np.array(values) < 0.05) < 0.1


TESTS, BINS = 10, 12


def between_and_along(rng: np.random.Generator, alarm: float) -> tuple[float, dict[str, float]]:
    """Return the least p-value of ten tests whose scatter is known by three degrees of freedom and whose noise by thirty.

    Three columns differ from test to test, three along every test; the noise holds `alarm` times the first of the latter.
    """
    test = np.repeat(np.arange(TESTS), BINS)
    ones, project = np.ones(len(test)), Projector(np.ones((len(test), 1)))
    levels = rng.normal(size=(TESTS, 3))[test]
    courses = np.linalg.qr(np.linspace(-1.0, 1.0, BINS)[:, None] ** [1, 2, 3])[0][
        np.tile(np.arange(BINS), TESTS)
    ]
    columns = {f"level{k}": levels[:, k] for k in range(3)} | {f"course{k}": courses[:, k] for k in range(3)}
    prepared = [
        prepare_candidate(candidate(n, c[:, None, None]), lambda v: v, project) for n, c in columns.items()
    ]
    freedom = Freedom(3.0, 30.0)
    noise = rng.normal(size=len(test))
    shift = np.bincount(test, noise)[test] / BINS
    scales = [np.sqrt(f / rng.chisquare(f)) for f in (freedom.between, freedom.along)]
    measured = shift * scales[0] + (noise - shift) * scales[1] + alarm * columns["course0"]
    simulated = simulate(prepared, project, null_noise(ones, ones, test, freedom, rng, REPLICATES))
    told = Significance(prepared, simulated, ones, test)
    values = {f.name: told.p_value(f.name, f.gain) for f in rank(prepared, project(measured))}
    return min(values.values()), values


def test_scatter_that_is_hardly_known_does_not_hide_what_every_test_shows_along_it() -> None:
    rng = np.random.default_rng(5)
    alarms = [between_and_along(rng, 0.0)[0] < 0.05 for _ in range(200)]
    assert np.mean(alarms) < 0.09
    found = [between_and_along(rng, 1.1)[1]["course0"] < 0.05 for _ in range(60)]
    assert np.mean(found) > 0.75


def courses_and_levels(rng: np.random.Generator, level: float) -> dict[str, float]:
    """Return p-values of forty tests, each with a course of its own along it that the floor does not know.

    Three columns differ from test to test, three along every test; the data hold `level` times the first of the former.
    """
    test = np.repeat(np.arange(40), BINS)
    ones, project = np.ones(len(test)), Projector(np.ones((len(test), 1)))
    columns = {f"level{k}": rng.normal(size=40)[test] for k in range(3)}
    place = np.tile(np.linspace(-1.0, 1.0, BINS), 40)
    columns |= {f"course{k}": place ** (k + 1) for k in range(3)}
    prepared = [
        prepare_candidate(candidate(n, c[:, None, None]), lambda v: v, project) for n, c in columns.items()
    ]
    measured = project(
        rng.normal(size=len(test)) + 5.0 * rng.normal(size=40)[test] * place + level * columns["level0"]
    )
    noise = null_noise(measured, ones, test, Freedom(30.0, 300.0), rng, REPLICATES)
    told = Significance(prepared, simulate(prepared, project, noise), ones, test)
    return {f.name: told.p_value(f.name, f.gain) for f in rank(prepared, measured)}


def test_what_happens_along_the_tests_does_not_hide_what_sets_them_apart() -> None:
    rng = np.random.default_rng(8)
    alarms = [min(courses_and_levels(rng, 0.0).values()) < 0.05 for _ in range(200)]
    assert np.mean(alarms) < 0.09
    found = [courses_and_levels(rng, 0.3)["level0"] < 0.05 for _ in range(40)]
    assert np.mean(found) > 0.9


def test_an_effect_that_the_data_could_not_show_is_not_significant() -> None:
    rng = np.random.default_rng(4)
    prepared = catalogue(rng, effects=1, sets=1)
    told = Significance(prepared, in_noise(prepared, KNOWN, rng), np.ones(M), ONE_TEST)
    assert told.p_value("seen beside another one only", 1e9) == 1.0


def test_few_settings_that_tests_share_keep_what_their_tests_have_in_common() -> None:
    """Sixteen settings of five tests, whose offsets are three times the noise: normal noise of single tests would miss them."""
    rng = np.random.default_rng(6)
    setting = np.repeat(np.arange(16), 5)
    residual = 3.0 * rng.normal(size=16)[setting] + rng.normal(size=80)
    shared, alone = (
        null_noise(residual, np.ones(80), setting, Freedom(60.0, 2.0, s), rng, REPLICATES)
        for s in (True, False)
    )
    mean_square = [np.mean([n[setting == k].mean(axis=0) ** 2 for k in range(16)]) for n in (shared, alone)]
    measured = np.mean([residual[setting == k].mean() ** 2 for k in range(16)])
    assert mean_square[0] == pytest.approx(measured) and mean_square[1] < 0.1 * measured


def test_the_p_value_counts_the_simulated_gains() -> None:
    rng = np.random.default_rng(4)
    prepared = catalogue(rng, effects=1, sets=1)
    told = Significance(prepared, in_noise(prepared, KNOWN, rng), np.ones(M), ONE_TEST)
    assert told.p_value("e0", 1e9) == 1.0 / (1 + REPLICATES)
    assert told.p_value("e0", -10.0) == 1.0
    assert told.p_value("e0", told.needed(0.05)) == pytest.approx(0.05, abs=0.005)
    # one column, two taken for its amplitude: a square of a normal number
    assert told.needed(0.05) == pytest.approx(3.84 - 2.0, abs=0.6)


def test_the_true_effect_stays_in_the_confusion_set_at_the_rate_that_is_promised() -> None:
    rng = np.random.default_rng(1)
    first = rng.normal(size=M)
    second = 0.95 * first + np.sqrt(1.0 - 0.95**2) * rng.normal(size=M)
    project = Projector(BASE)
    prepared = [
        prepare_candidate(candidate(n, c[:, None, None]), lambda v: v, project)
        for n, c in (("truth", first), ("rival", second))
    ]
    simulated = in_noise(prepared, KNOWN, rng)
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
    simulated = in_noise(prepared, KNOWN, rng)
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
        ones = np.ones(len(test))
        noise = null_noise(residual, ones, test, KNOWN, rng, REPLICATES)
        told = Significance(prepared, simulate(prepared, project, noise), ones, test)
        first = rank(prepared, residual)[0]
        alarms += told.p_value(first.name, first.gain) < 0.05
    assert alarms <= 8


def test_noise_is_as_large_as_before_a_law_was_fitted_to_it() -> None:
    """Ten numbers of 30 tests take a third of the scatter between them, and hardly any of that along them."""
    rng = np.random.default_rng(3)
    tests, bins, sizes = 30, 8, []
    test = np.repeat(np.arange(tests), bins)
    level = np.ones(tests * bins)
    project = Projector(np.repeat(rng.normal(size=(tests, 10)), bins, axis=0))
    for _ in range(60):
        between, along = rng.normal(size=tests)[test], rng.normal(size=tests * bins)
        along -= np.bincount(test, along)[test] / bins
        drawn = null_noise(project(between + along), level, test, KNOWN, rng, 50, project.q)
        means = np.array([drawn[test == k].mean(axis=0) for k in range(tests)])
        sizes.append([np.mean(means**2), np.mean((drawn - means[test]) ** 2)])
    assert np.mean(sizes, axis=0) == pytest.approx([1.0, 1.0 - 1.0 / bins], rel=0.06)
