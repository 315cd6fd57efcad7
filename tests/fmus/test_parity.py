"""The generated C of every family and every effect: ONNX Runtime's values, its own derivatives, equal blocks."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import onnxruntime
import pytest

from friction_models.families.linear import LinearFriction
from friction_models.families.polynomial import PolynomialFriction
from friction_models.families.power_law import PowerLawFriction
from friction_models.families.registry import FAMILIES
from friction_models.loads import LOAD_NAMES, LOADS
from tests.fmus.catalogue import EXPORTED, NAMES, content_of, model_of
from tests.fmus.compiled import Array, Compiled

POINTS = 10_000
LOWER = np.array([q.lower for q in LOADS])
UPPER = np.array([q.upper for q in LOADS])
#: Every low-or-high combination of five loads, shape (32, 5).
CORNERS = np.array(np.meshgrid(*[[0.0, 1.0]] * 5)).reshape(5, -1).T


#: By day every family, and the effects with memory and variables of their own. The generated C knows operators, not effects:
#: those are tested one by one in `test_generator`, the graphs of the effects in tests/contract.
DAILY = [*FAMILIES, *(n for n in NAMES if n.count(" + ") > 1)]
CASES = [pytest.param(n, marks=() if n in DAILY else pytest.mark.nightly) for n in NAMES]


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Callable[[bool], Compiled]:
    """The models of the day or those of the night, each in one library."""

    @cache
    def made(daily: bool) -> Compiled:
        names = [n for n in NAMES if (n in DAILY) == daily]
        return Compiled({n: content_of(n) for n in names}, tmp_path_factory.mktemp("parity"))

    return made


@pytest.fixture
def models(library: Callable[[bool], Compiled], name: str) -> Compiled:
    """The library of the model that a test is about."""
    return library(name in DAILY)


def domain_of(models: Compiled, name: str) -> tuple[Array, Array]:
    limits = np.array([models.sources[name].domain[q] for q in LOAD_NAMES])
    return limits[:, 0], limits[:, 1]


def loads_of(models: Compiled, name: str) -> Array:
    """Return random and edge points within the physical limits, shape (POINTS, 5)."""
    rng = np.random.default_rng(7)
    low, high = domain_of(models, name)
    edges = [low + (high - low) * CORNERS, LOWER + (UPPER - LOWER) * CORNERS]
    edges += [np.clip(CORNERS * tiny, LOWER, UPPER) for tiny in (0.0, 5e-324, 1e-300, 1e-12)]
    edges.append(np.where(CORNERS > 0.5, np.nextafter(high, np.inf), np.nextafter(low, -np.inf)))
    inside = rng.uniform(low, high, size=(4000, 5))
    beyond = rng.uniform(low - (high - low), high + (high - low), size=(3000, 5))
    anywhere = np.exp(rng.uniform(np.log(1e-9), np.log(1e6), size=(POINTS, 5)))
    points = np.clip(np.vstack([*edges, inside, beyond, anywhere])[:POINTS], LOWER, UPPER)
    return rng.permutation(points)


def states_of(models: Compiled, name: str, points: int) -> Array:
    """Return random states around the start values, with zeros, tiny and huge ones, shape (points, k)."""
    starts = np.array([s.start for s in models.sources[name].states])
    rng = np.random.default_rng(5)
    factor = np.exp(rng.normal(scale=3.0, size=(points, len(starts))))
    states = (np.abs(starts) + (starts == 0.0)) * factor
    for k, value in enumerate((0.0, 5e-324, 1e-300, 1e-9, 1e9)):
        states[k :: points // 20] = value
    return states


def system_of(models: Compiled, name: str, factor: float = 1.0) -> Array:
    return np.array([factor * p.start for p in models.sources[name].system])


def runtime(content: bytes, loads: Array, states: Array, system: Array, dt: float) -> dict[str, Array]:
    session = onnxruntime.InferenceSession(content, providers=["CPUExecutionProvider"])
    offered = {"loads": loads, "state": states, "system": system[None, :], "dt": np.array([dt])}
    feed = {i.name: offered[i.name] for i in session.get_inputs()}
    return dict(zip((o.name for o in session.get_outputs()), session.run(None, feed), strict=True))


def test_every_exported_effect_takes_part() -> None:
    assert len(EXPORTED) == 18
    for name in NAMES:
        for amplitudes in getattr(model_of(name), "amplitudes_", []):
            assert all(a != 0.0 for a in amplitudes.values())


@pytest.mark.parametrize("name", CASES)
def test_values_are_those_of_onnx_runtime(name: str, models: Compiled) -> None:
    loads = loads_of(models, name)
    states, system = states_of(models, name, POINTS), system_of(models, name, 1.3)
    expected = runtime(content_of(name), loads, states, system, 2e-3)
    for build in models.builds():
        mu = models.mu(name, loads, states, system, build)
        np.testing.assert_allclose(mu, expected["mu"][:, 0], rtol=1e-12, atol=1e-14, err_msg=build)
        assert (mu >= 0.0).all()
    assert name == "constant" or np.ptp(expected["mu"]) > 1e-3
    if states.size:
        following = models.step(name, loads, states, 2e-3, system)
        np.testing.assert_allclose(following, expected["state_next"], rtol=1e-12, atol=1e-14)
        assert (following != states).any()
        rate = models.rate(name, loads, states, system)
        np.testing.assert_allclose(rate, expected["state_der"], rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("name", CASES)
def test_a_point_has_the_same_bits_alone_and_anywhere_in_a_block(name: str, models: Compiled) -> None:
    loads = loads_of(models, name)
    states, system = states_of(models, name, POINTS), system_of(models, name)
    for build in models.builds():
        alone = models.mu(name, loads, states, system, build)
        for first in (0, 1, 7, 14):
            assert np.array_equal(models.mu(name, loads, states, system, build, first), alone)
    chosen = "wide" if models.has_wide else "plain"
    assert np.array_equal(
        models.mu(name, loads, states, system), models.mu(name, loads, states, system, chosen)
    )


@pytest.mark.parametrize("name", ["ffnn + work_exhaustion + tool_roughness"])
def test_compilers_without_extensions_get_the_plain_build(
    name: str, models: Compiled, tmp_path_factory: pytest.TempPathFactory
) -> None:
    flags = ("-DTF_PLAIN_ONLY", "-Wpedantic")
    strict = Compiled({name: content_of(name)}, tmp_path_factory.mktemp("strict"), *flags)
    assert not strict.has_wide
    loads = loads_of(models, name)
    states, system = states_of(models, name, POINTS), system_of(models, name)
    expected = models.mu(name, loads, states, system, "plain")
    assert np.array_equal(strict.mu(name, loads, states, system), expected)
    assert np.array_equal(strict.mu(name, loads, states, system, first=3), expected)


def smooth_points(models: Compiled, name: str, count: int = 120) -> tuple[Array, Array, Array]:
    """Return loads well inside the domain, states and system variables."""
    low, high = domain_of(models, name)
    share = np.random.default_rng(3).uniform(0.05, 0.95, size=(count, 5))
    starts = np.array([s.start for s in models.sources[name].states])
    factor = np.random.default_rng(4).uniform(0.3, 3.0, size=(count, len(starts)))
    return low + share * (high - low), (starts + (starts == 0.0)) * factor, system_of(models, name)


@pytest.mark.parametrize("name", CASES)
def test_derivatives_are_those_of_the_values(name: str, models: Compiled) -> None:
    loads, states, system = smooth_points(models, name)
    low, high = domain_of(models, name)
    kinds = ["mu", "der"] if states.size else ["mu"]
    directions = [np.where(np.arange(5) == i, high - low, 0.0) for i in range(5)]
    n, k, m = len(loads), states.shape[1], len(system)
    seeds = [(np.tile(d, (n, 1)), np.zeros((n, k)), np.zeros(m)) for d in directions]
    seeds += [(np.zeros((n, 5)), states * (np.arange(k) == i), np.zeros(m)) for i in range(k)]
    seeds += [(np.zeros((n, 5)), np.zeros((n, k)), 1.0 * (np.arange(m) == i)) for i in range(m)]
    together = [np.sum(parts, axis=0) for parts in zip(*seeds, strict=True)]
    for what in kinds:

        def value(s: float, seed: tuple[Array, ...], what: str = what) -> Array:
            point = [a + s * d for a, d in zip((loads, states, system), seed, strict=True)]
            if what == "mu":
                return models.mu(name, point[0], point[1], point[2])
            return models.rate(name, point[0], point[1], point[2])

        total: Array | float = 0.0
        for seed in seeds:
            got, change = models.derivative(what, name, (loads, states, system), seed)
            assert np.array_equal(got, value(0.0, seed))
            total = total + change
            wide, near = (difference(value, seed, h) for h in (2e-3, 1e-3))
            scale = np.abs(change) + 0.1 * np.abs(got) + 1e-9
            smooth = np.abs(wide - near) < 1e-7 * scale  # no kink and no step of a tree nearby
            assert smooth.mean() > 0.8
            assert (np.abs(change - near) <= 1e-6 * scale)[smooth].all()
        _, change = models.derivative(what, name, (loads, states, system), together)
        np.testing.assert_allclose(change, total, rtol=1e-10, atol=1e-12 * np.abs(total).max(initial=0.0))


def difference(value: object, seed: tuple[Array, ...], h: float) -> Array:
    """Return a central difference of fourth order."""
    assert callable(value)
    first, second = (value(k * h, seed) - value(-k * h, seed) for k in (1, 2))
    return (8.0 * first - second) / (12.0 * h)


@pytest.mark.parametrize("name", ["linear", "polynomial", "power_law"])
def test_derivatives_are_the_analytic_ones(name: str, models: Compiled) -> None:
    model = model_of(name)
    loads, states, system = smooth_points(models, name)
    v, T, p, sd, psi = loads.T
    if isinstance(model, LinearFriction):
        expected = np.tile(model.coef_, (len(loads), 1))
    elif isinstance(model, PowerLawFriction):
        a = model.coef_
        mu = np.exp(
            a[0]
            + a[1] * np.log((v + 1.0) / 100.0)
            + a[2] * T / 100.0
            + a[3] * np.log((p + 100.0) / 1000.0)
            + a[4] * np.log((sd + 1.0) / 10.0)
            + a[5] * np.log(psi)
        )
        slopes = [a[1] / (v + 1.0), a[2] / 100.0 + 0.0 * T, a[3] / (p + 100.0), a[4] / (sd + 1.0), a[5] / psi]
        expected = mu[:, None] * np.array(slopes).T
    else:
        assert isinstance(model, PolynomialFriction)
        z = model.scaling_.apply(loads)
        expected = np.zeros_like(loads)
        for coefficient, term in zip(model.coef_, model.terms, strict=True):
            for j in range(5):
                rest = [k for k in term if k != j] + [j] * (term.count(j) - 1)
                if j in term:
                    expected[:, j] += term.count(j) * coefficient * np.prod(z[:, rest], axis=1)
        expected /= model.scaling_.scale
    for j in range(5):
        seed = (np.tile(1.0 * (np.arange(5) == j), (len(loads), 1)), states, system)
        mu, change = models.derivative("mu", name, (loads, states, system), seed)
        assert (mu > 0.0).mean() > 0.9
        held = mu > 0.0
        np.testing.assert_allclose(change[held], expected[held, j], rtol=1e-10, atol=1e-17)
    assert (np.abs(expected).max(axis=0) > 0.0).all()
