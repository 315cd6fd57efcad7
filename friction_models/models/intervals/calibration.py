"""Calibration of prediction intervals on whole tests that the model has not seen."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from sklearn.base import clone

from ...common import InputError
from ...expressions.ops import NumpyOps
from ...loads import LOAD_NAMES, LOADS, FloatArray, TriboLoads
from ...loads.splits import k_fold
from ..domain import Domain
from .features import feature, feature_ranges
from .prediction_interval import (
    LEAST_TESTS,
    PROBABILITIES,
    SMALLEST_ERROR,
    PredictionInterval,
)

FOLDS = 5
#: Points of a test that take part: neighbours say the same, and the folds cost that much less.
POINTS_A_TEST = 100
#: A width that depends on the loads must predict the errors of tests left out better by so many standard errors.
CLEARLY = 1.5
#: Fewest tests for a width that depends on the loads: five coefficients and a constant need ten times as many.
TESTS_FOR_LOADS = 40
#: Largest logarithm of the width at a corner of the domain, counted from its middle.
STEEPEST = 3.0
#: A load takes part where its feature varies by more than this to both sides of its middle.
LEAST_HALF = 1e-4


def calibrated(
    predicted: FloatArray,
    source: str,
    loads: TriboLoads,
    mu: FloatArray,
    groups: npt.NDArray[np.str_],
    domain: Domain,
    level: float,
) -> PredictionInterval:
    """Return the interval that follows from predictions of tests left out, NaN where there is none.

    Raises InputError where fewer than four tests were left out.
    """
    rows = np.flatnonzero(np.isfinite(predicted))
    tests = np.unique(groups[rows])
    if len(tests) < LEAST_TESTS:
        raise InputError(f"interval: {len(tests)} tests were left out, allowed: at least {LEAST_TESTS}")
    error = np.maximum(np.abs(predicted[rows] - mu[rows]), SMALLEST_ERROR)
    _, test = np.unique(groups[rows], return_inverse=True)
    weight = 1.0 / (np.bincount(test)[test] * len(tests))
    beta, scale = _width(loads.as_array()[rows], error, test, weight, domain)
    return PredictionInterval(
        level=float(level),
        tests=len(tests),
        points=len(rows),
        constant=float(beta[0]),
        slopes=tuple(beta[1:].tolist()),
        scores=tuple(_quantiles(error / scale, weight).tolist()),
        source=source,
        coverage={},
    )


def folds_of(
    model: Any, loads: TriboLoads, mu: FloatArray, groups: npt.NDArray[np.str_], folds: int, seed: int
) -> tuple[FloatArray, str]:
    """Predict every test by a clone of `model` that has not seen it; see `FrictionModel.left_out`.

    NaN stands at the points that did not take part (`POINTS_A_TEST`).
    """
    rows = thinned(groups)
    own, target, tests = loads.take(rows), mu[rows], groups[rows]
    count = min(folds, len(np.unique(tests)))
    predicted = np.full(len(mu), np.nan)
    for train, held in k_fold(tests, count, seed):
        fitted = clone(model).fit(own.take(train), target[train], tests[train])
        predicted[rows[held]] = fitted.predict(own.take(held))
    return predicted, f"{count} folds of whole tests"


def thinned(groups: npt.NDArray[np.str_]) -> npt.NDArray[np.int_]:
    """Return rows that keep at most `POINTS_A_TEST` points of each test, evenly over it, in their order."""
    order = np.argsort(groups, kind="stable")
    _, start, count = np.unique(groups[order], return_index=True, return_counts=True)
    kept = [
        order[a + np.unique(np.linspace(0, n - 1, min(n, POINTS_A_TEST)).round().astype(int))]
        for a, n in zip(start.tolist(), count.tolist())
    ]
    return np.sort(np.concatenate(kept))


def _quantiles(scores: FloatArray, weight: FloatArray) -> FloatArray:
    """Return the smallest scores whose cumulated weight reaches each of `PROBABILITIES`."""
    order = np.argsort(scores, kind="stable")
    reached = np.cumsum(weight[order])
    place = np.searchsorted(reached, PROBABILITIES - 1e-9)
    return scores[order][np.minimum(place, len(scores) - 1)]


def _width(
    loads: FloatArray, error: FloatArray, test: npt.NDArray[np.int_], weight: FloatArray, domain: Domain
) -> tuple[FloatArray, FloatArray]:
    """Return coefficients of the logarithm of the width, shape (6,), and the width at each point.

    The widths are those of a model that did not see the test, so that what follows from them is honest. The constant
    alone stands unless the loads predict the size of the errors of tests left out clearly better.
    """
    count = int(test.max()) + 1
    alone = np.r_[math.log(float(weight @ error)), np.zeros(len(LOADS))]
    flat = np.full(len(error), math.exp(alone[0]))
    if count < TESTS_FOR_LOADS:
        return alone, flat
    x = NumpyOps()
    columns = [feature(x, n, loads[:, j]) for j, n in enumerate(LOAD_NAMES)]
    ends = feature_ranges(domain)
    middle = np.array([0.5 * (a + b) for a, b in ends])
    half = np.array([0.5 * (b - a) for a, b in ends])
    measured = [n not in domain.absent for n in LOAD_NAMES]
    varied = np.flatnonzero((half > LEAST_HALF) & measured)
    X = np.column_stack([np.ones(len(error)), *((columns[j] - middle[j]) / half[j] for j in varied)])
    fold = np.random.default_rng(0).permutation(count)[test] % FOLDS
    scale, plain = np.empty(len(error)), np.empty(len(error))
    for k in range(FOLDS):
        held = fold == k
        own = ~held
        share = weight[own] / weight[own].sum()
        scale[held] = np.exp(X[held] @ _log_linear(X[own], error[own], share, count))
        plain[held] = float(share @ error[own])
    # Deviance of an exponential distribution of the sizes, test by test: both see the same tests.
    gain = np.log(plain) + error / plain - np.log(scale) - error / scale
    by_test = np.bincount(test, weights=gain * weight * count, minlength=count)
    if by_test.mean() <= CLEARLY * by_test.std(ddof=1) / math.sqrt(count):
        return alone, flat
    beta = _log_linear(X, error, weight, count)
    slopes = np.zeros(len(LOADS))
    slopes[varied] = beta[1:] / half[varied]
    return np.r_[beta[0] - slopes @ middle, slopes], scale


def _log_linear(X: FloatArray, error: FloatArray, weight: FloatArray, tests: int) -> FloatArray:
    """Fit ``E error = exp(X beta)`` by scoring, as for a gamma distribution with a logarithmic link.

    A ridge as strong as a few tests holds slopes that the data does not fix near 0.
    """
    ridge = np.diag([0.0, *np.full(X.shape[1] - 1, 4.0 / tests)])
    beta = np.r_[math.log(float(weight @ error)), np.zeros(X.shape[1] - 1)]
    matrix = X.T @ (weight[:, None] * X) + ridge
    for _ in range(25):
        ratio = np.minimum(error * np.exp(-(X @ beta)), 50.0)
        step = np.linalg.solve(matrix, X.T @ (weight * (ratio - 1.0)) - ridge @ beta)
        beta = beta + np.clip(step, -1.0, 1.0)
        # Inside the domain every column is within -1 and 1.
        beta[1:] *= min(1.0, STEEPEST / max(float(np.abs(beta[1:]).sum()), 1e-12))
        if np.abs(step).max() < 1e-8:
            break
    return beta
