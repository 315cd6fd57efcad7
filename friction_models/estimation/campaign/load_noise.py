"""Loads without the noise of their sensors: friction follows the load, and not that noise."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from ...loads import LOAD_NAMES, FloatArray, TriboLoads
from .settings import is_held

#: Terms of the course of a load along a test, at most.
TERMS = 6
#: Fewest points of a test that tell noise from a course.
LEAST_POINTS = 10
#: What a course leaves is noise if its variance is less than so many times that of white noise.
NOISY = 3.0
#: Share of the variance of a load in a test from which noise matters.
MATTERS = 1e-3
#: Shares of the variance of a load over all tests between which it is taken away: below it flattens no slope, and beyond it the load
#: may really change so fast.
LEAST, MOST = 5e-5, 0.2


def without_noise(loads: TriboLoads, starts: npt.NDArray[np.intp]) -> TriboLoads:
    """Return loads that follow smooth courses in those tests where nothing but white noise is left beside them.

    Within a test mu scatters little, so that noisy loads there outvote what the levels of tests say: slopes come out too flat,
    by the share of the noise (errors in the variables; Fuller, Measurement Error Models (1987), section 1.1). What a load is likely
    to have been takes the place of what was read (regression calibration; Carroll et al., Measurement Error in Nonlinear Models
    (2006), chapter 4). Steps, ramps with corners and oscillations leave more than white noise and stay as they are.

    - `starts`, shape (tests,): first points of the tests, which lie one after the other.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> p, T = np.repeat([300.0, 900.0], 20), np.tile(np.linspace(20, 80, 20), 2)
    >>> read = p + rng.normal(0, 5, 40)
    >>> loads = TriboLoads(v_rel=np.full(40, 9.0), T=T, sigma_n=read, sd=np.ones(40), psi=np.ones(40))
    >>> smooth = without_noise(loads, np.array([0, 20]))
    >>> [round(float(np.std(x - p)), 1) for x in (read, smooth.sigma_n)], bool((smooth.T == T).all())
    ([4.6, 0.2], True)
    """
    sizes = np.diff(np.r_[starts, len(loads)])
    smooth: dict[str, Any] = {}
    for name in LOAD_NAMES:
        values = np.asarray(getattr(loads, name), dtype=np.float64)
        if name == "sd" or np.ptp(values) == 0.0:
            continue
        courses = values.copy()
        for size in np.unique(sizes[sizes >= LEAST_POINTS]):
            rows = starts[sizes == size, None] + np.arange(size)
            courses[rows] = _courses(values[rows])
        courses = np.clip(courses, values.min(), values.max())  # no course leaves what was read
        noise = float(np.mean((values - courses) ** 2))
        if LEAST * float(np.var(values)) < noise < MOST * float(np.var(values)):
            smooth[name] = courses
    return replace(loads, **smooth) if smooth else loads


def _courses(values: FloatArray) -> FloatArray:
    """Return the smooth courses of a load along tests, shape (tests, n); as they are where they leave more than noise, or hardly any.

    The number of terms is that of the least Bayes information criterion. Noise is known from the median of second differences, in
    which the corners of a course hardly count.
    """
    n = values.shape[1]
    noise = (1.4826 * np.median(np.abs(np.diff(values, 2, axis=1)), axis=1)) ** 2 / 6.0
    basis = _basis(n)
    shares = values @ basis
    left = np.maximum(np.sum(values**2, axis=1)[:, None] - np.cumsum(shares**2, axis=1), 1e-300)
    terms = 1 + np.argmin(n * np.log(left) + np.arange(1, TERMS + 1) * np.log(n), axis=1)
    variance = np.take_along_axis(left, terms[:, None] - 1, axis=1)[:, 0] / (n - terms)
    taken = (noise > MATTERS * np.var(values, axis=1)) & (variance < NOISY * noise)
    smooth = (shares * (np.arange(TERMS) < terms[:, None])) @ basis.T
    return np.where(taken[:, None], smooth, values)


def as_set(loads: TriboLoads) -> TriboLoads:
    """Return loads of which those that a machine, or the room, held have their mean everywhere: a slope along their noise is one of chance.

    Examples
    --------
    >>> room = [25.3, 24.6, 25.1]
    >>> loads = TriboLoads(v_rel=[1.0, 5.0, 9.0], T=room, sigma_n=[1.0, 2.0, 3.0], sd=np.zeros(3), psi=np.ones(3))
    >>> as_set(loads).T.tolist(), as_set(loads).sigma_n.tolist()
    ([25.0, 25.0, 25.0], [1.0, 2.0, 3.0])
    """
    held: dict[str, Any] = {}
    for name in ("v_rel", "T", "sigma_n"):
        values = np.asarray(getattr(loads, name), dtype=np.float64)
        if np.ptp(values) > 0.0 and is_held(name, values):
            held[name] = np.full(len(values), np.mean(values))
    return replace(loads, **held) if held else loads


@lru_cache(maxsize=64)
def _basis(n: int) -> FloatArray:
    """Return orthonormal polynomials in the root of the place along a test, shape (n, TERMS): contacts warm up with the root of time."""
    root = np.sqrt(np.linspace(0.0, 1.0, n))
    return np.asarray(np.linalg.qr(np.vander(root, TERMS, increasing=True))[0])
