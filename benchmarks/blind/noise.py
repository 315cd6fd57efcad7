"""Noise as tribometers and loggers have it. A recipe turns true friction into what is recorded."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.blind.campaign import Array, Campaign, Rng

Recipe = Callable[[Rng, Campaign, Array], Array]


def _offsets(rng: Rng, c: Campaign, scale: float) -> Array:
    return (scale * rng.standard_normal(len(c.tests)))[c.k]


def _along(c: Campaign, draw: Callable[[Array], Array]) -> Array:
    """A function of the distance, drawn anew for each test."""
    sd = c.load("sd")
    return np.concatenate([draw(sd[rows]) for rows in c.slices()])


def white(rng: Rng, c: Campaign, mu: Array) -> Array:
    """Sensor noise and a small offset of each test."""
    return mu + _offsets(rng, c, 0.002) + 0.004 * rng.standard_normal(len(mu))


def quiet(rng: Rng, c: Campaign, mu: Array) -> Array:
    """A rig far better than usual."""
    return mu + _offsets(rng, c, 0.0005) + 0.0006 * rng.standard_normal(len(mu))


def skewed(rng: Rng, c: Campaign, mu: Array) -> Array:
    """Pick-up only ever adds friction: offsets and points have a long upper tail."""
    test = 0.003 * (rng.exponential(1, len(c.tests)) - 1)
    return mu + test[c.k] + 0.004 * (rng.gamma(0.7, 1, len(mu)) - 0.7)


def heteroscedastic(rng: Rng, c: Campaign, mu: Array) -> Array:
    """Force noise counts most at low pressure; hot tests repeat worse."""
    scale = 0.006 * (500 / c.load("sigma_n")) ** 0.8
    hot = 1 + 2 * np.clip((c.load("T") - 20) / 280, 0, 1)
    return mu + _offsets(rng, c, 0.0015) * hot + scale * rng.standard_normal(len(mu))


def proportional(rng: Rng, c: Campaign, mu: Array) -> Array:
    """Scatter in per cent of friction, lognormal, between tests and along them."""
    return np.asarray(mu * np.exp(_offsets(rng, c, 0.05) + 0.07 * rng.standard_normal(len(mu))))


def quantised(rng: Rng, c: Campaign, mu: Array) -> Array:
    """A 12-bit card: the friction force has steps of 0.012 * 500 MPa * area."""
    step = 0.012 * 500 / c.load("sigma_n")
    noisy = mu + _offsets(rng, c, 0.002) + 0.0008 * rng.standard_normal(len(mu))
    return np.asarray(np.round(noisy / step) * step)


def hum(rng: Rng, c: Campaign, mu: Array) -> Array:
    """50 Hz in the force signal, never synchronous with the start; sampling folds it down."""
    phase = rng.uniform(0, 2 * np.pi, len(c.tests))[c.k]
    amplitude = 0.008 * (500 / c.load("sigma_n")) ** 0.5
    return (
        mu
        + _offsets(rng, c, 0.002)
        + amplitude * np.sin(2 * np.pi * 50.02 * c.load("t") + phase)
        + 0.0015 * rng.standard_normal(len(mu))
    )


def random_walk(rng: Rng, c: Campaign, mu: Array) -> Array:
    """Friction wanders along each test and never comes back."""

    def walk(sd: Array) -> Array:
        return np.asarray(
            np.cumsum(0.0007 * np.sqrt(np.diff(sd, prepend=0.0)) * rng.standard_normal(len(sd)))
        )

    return mu + _along(c, walk) + _offsets(rng, c, 0.0015) + 0.002 * rng.standard_normal(len(mu))


def drift(rng: Rng, c: Campaign, mu: Array) -> Array:
    """A linear creep of the zero along each test, of either direction, other in every test."""
    return (
        mu
        + _along(c, lambda sd: 0.003 * rng.standard_normal() * sd / 50)
        + _offsets(rng, c, 0.002)
        + 0.003 * rng.standard_normal(len(mu))
    )


def offsets(rng: Rng, c: Campaign, mu: Array) -> Array:
    """Tests repeat badly; each one is smooth."""
    return mu + _offsets(rng, c, 0.006) + 0.0015 * rng.standard_normal(len(mu))


def odd_tests(rng: Rng, c: Campaign, mu: Array) -> Array:
    """Some tests (one of twelve, at least one) went wrong: far off, without a trace in the test table."""
    n = len(c.tests)
    wrong = np.zeros(n)
    chosen = rng.choice(n, max(1, n // 12), replace=False)
    wrong[chosen] = rng.choice([-1, 1, 1], len(chosen)) * rng.uniform(0.012, 0.022, len(chosen))
    return mu + wrong[c.k] + _offsets(rng, c, 0.0015) + 0.003 * rng.standard_normal(len(mu))


def spikes(rng: Rng, c: Campaign, mu: Array) -> Array:
    """Heavy tails: Student's t with 2.5 degrees of freedom."""
    return mu + _offsets(rng, c, 0.002) + 0.002 * rng.standard_t(2.5, len(mu))


def red(rng: Rng, c: Campaign, mu: Array) -> Array:
    """Neighbouring points agree over about 5 mm: debris comes and goes."""

    def ou(sd: Array) -> Array:
        rho = np.exp(-np.diff(sd, prepend=sd[0]) / 5)
        out = np.empty(len(sd))
        x = rng.standard_normal()
        for i, r in enumerate(rho):
            x = r * x + np.sqrt(1 - r * r) * rng.standard_normal()
            out[i] = x
        return 0.004 * out

    return mu + _along(c, ou) + _offsets(rng, c, 0.0015) + 0.0015 * rng.standard_normal(len(mu))


def two_kinds(rng: Rng, c: Campaign, mu: Array) -> Array:
    """Two kinds of specimens that nobody wrote down: offsets have two humps."""
    return (
        mu
        + 0.0035 * rng.choice([-1.0, 1.0], len(c.tests))[c.k]
        + _offsets(rng, c, 0.001)
        + 0.003 * rng.standard_normal(len(mu))
    )


def wandering_rig(rng: Rng, c: Campaign, mu: Array) -> Array:
    """The rig wanders from test to test in an order that nobody wrote down."""
    walk = np.cumsum(0.0012 * rng.standard_normal(len(c.tests)))
    return mu + (walk - walk.mean())[rng.permutation(len(walk))][c.k] + 0.003 * rng.standard_normal(len(mu))


RECIPES: dict[str, Recipe] = {
    f.__name__: f
    for f in (
        white,
        quiet,
        skewed,
        heteroscedastic,
        proportional,
        quantised,
        hum,
        random_walk,
        drift,
        offsets,
        odd_tests,
        spikes,
        red,
        two_kinds,
        wandering_rig,
    )
}
