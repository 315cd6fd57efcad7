"""One suite over every effect of the catalogue."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from sklearn.base import clone

from friction_models import LinearFriction, OnnxModel, TriboLoads, load_model
from friction_models.composed import ComposedFriction
from friction_models.discovery.binning import prepare
from friction_models.discovery.candidates import evaluate_points, spans_of
from friction_models.effects import CATALOGUE, Memory, make_effect
from friction_models.ops import LoadColumns, NumpyOps
from tests.benchmarks.discovery_campaigns import campaign

NAMES = sorted(CATALOGUE)
X = NumpyOps()
BASE = np.array([1e-5, -3e-5, -5e-6, 1e-4, 0.006])


@pytest.fixture(scope="module")
def noise_free() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Loads of a small factorial plan; its friction is replaced in every test."""
    data, tests, _ = campaign(None, seed=3, levels=2, extra=8, thin=12, twin_errors=0.0, noise=0.0)
    return data, tests


def with_effect(
    name: str, data: pd.DataFrame, tests: pd.DataFrame
) -> tuple[pd.DataFrame, dict[str, float], list[float]]:
    """Return friction = linear law + the effect with known parameters, and these parameters."""
    effect = make_effect(name)
    made = prepare(data, tests)
    grids = effect.grids(spans_of(made, made.mu))
    shape = {k: float(0.5 * (g[len(g) // 2] + g[max(len(g) // 2 - 1, 0)])) for k, g in grids.items()}
    if name == "batch":
        shape = {"deviating": 1.0}
    strength = [
        0.03 * (a.sign or -1.0) * (0.1 if "ln" in effect.equation else 1.0) for a in effect.amplitudes
    ]
    base = 0.2 + made.loads.as_array() @ BASE
    mu = base
    for _ in range(20):  # effects that see the model's own friction: iterate to agreement
        seen = base if effect.needs_mu and not effect.states else mu
        columns = evaluate_points(effect, made, seen, shape)
        mu = base + sum(a * np.broadcast_to(c, (len(mu), 1))[:, 0] for a, c in zip(strength, columns))
    return data.assign(mu=mu), shape, strength


@pytest.mark.parametrize("name", NAMES)
def test_declaration_is_complete(name: str) -> None:
    effect = make_effect(name)
    assert effect.name == name
    for text in (effect.title, effect.equation, effect.latex, effect.citation, effect.where_it_shows):
        assert len(text) > 5
    assert effect.kind in {"physics", "system", "fault"}
    assert effect.driver and effect.amplitudes
    assert len(effect.metadata) == len(effect.metadata_units)
    for shape in effect.shapes:
        assert shape.lower <= shape.start <= shape.upper and shape.unit and shape.meaning
    described = effect.describe()
    assert described["name"] == name and len(described["parameters"]) == len(effect.amplitudes) + len(
        effect.shapes
    )


@pytest.mark.parametrize("name", NAMES)
def test_regular_where_loads_vanish(name: str) -> None:
    effect = make_effect(name)
    corners = np.array(
        [[0, 20, 0, 0, 1], [0, -20, 0, 0, 0.9], [1e5, 1500, 1e4, 1e3, 50], [5, 20, 500, 0, 1]], float
    )
    L = LoadColumns(*(c[:, None] for c in corners.T))
    shape = effect.start_shape()
    states = {n: np.full((4, 1), v) for (n, _), v in zip(effect.states, effect.start_state(shape))}
    system = {m: np.full((4, 1), 0.1) for m in effect.metadata}
    memory = Memory(np.full((4, 1), 0.08), states, system)
    for column in effect.basis(X, L, shape, memory):
        assert np.isfinite(column).all()
    for k, value in enumerate(effect.advance(X, L, shape, memory, 0.5)):
        assert np.isfinite(value).all(), effect.states[k]


@pytest.mark.parametrize("name", NAMES)
def test_fit_recovers_law_and_files_repeat_it(
    name: str, noise_free: tuple[pd.DataFrame, pd.DataFrame], tmp_path: Path
) -> None:
    data, tests = noise_free
    made, _, strength = with_effect(name, data, tests)
    model = (LinearFriction() + name).fit_frame(made, tests)
    loads = TriboLoads.from_frame(made, tests)
    predicted = model.predict(loads)
    if make_effect(name).kind == "fault":
        # a fault takes part in the fit and leaves with it: what remains is the linear law
        truth = 0.2 + loads.as_array() @ BASE
        assert model.states == () and model.system_variables == ()
    else:
        truth = made["mu"].to_numpy()
    assert np.sqrt(np.mean((predicted - truth) ** 2)) < 0.04 * max(abs(s) for s in strength)
    for declared, fitted in zip(make_effect(name).amplitudes, model.amplitudes_[0].values()):
        assert fitted * declared.sign >= 0.0

    model.save(tmp_path / "model")
    assert np.array_equal(load_model(tmp_path / "model").predict(loads), predicted)
    run = OnnxModel(tmp_path / "model" / "model.onnx")
    first = loads.segments()[0]
    array = loads.as_array()[first]
    system = [model._metadata(loads)[v.name][0, 0] for v in model.system_variables] or None
    if not model.states:
        assert np.max(np.abs(run.predict(array, None, system) - predicted[first])) < 1e-9
        return
    state, assert_t = run.start_state(1), loads.t
    assert assert_t is not None
    for k, i in enumerate(range(first.start, first.stop)):
        dt = assert_t[i] - assert_t[i - 1] if k else 0.0
        _, state = run.step(array[k : k + 1], state, dt, system)
        read = run.predict(array[k : k + 1], state, system)
        assert abs(read[0] - predicted[i]) < 1e-9
        assert np.array_equal(run.predict(array[k : k + 1], state, system), read)  # reading never advances


@pytest.mark.parametrize("name", [n for n in NAMES if CATALOGUE[n].states])
def test_state_advances_with_time_only(name: str) -> None:
    effect = make_effect(name)
    shape = effect.start_shape()
    L = LoadColumns(*(np.array([[v]]) for v in (120.0, 90.0, 900.0, 4.0, 1.2)))
    states = {n: np.array([[v]]) for (n, _), v in zip(effect.states, effect.start_state(shape))}
    memory = Memory(np.array([[0.07]]), states, {})
    still = effect.advance(X, L, shape, memory, 0.0)
    assert all(np.array_equal(a, b) for a, b in zip(still, states.values()))
    # the derivative is the limit of the step, and two half steps make a whole one
    small = 1e-7
    slope = [(b - a) / small for a, b in zip(states.values(), effect.advance(X, L, shape, memory, small))]
    for given, found in zip(effect.rate(X, L, shape, memory), slope):
        assert np.allclose(given, found, rtol=1e-4)
    half = effect.advance(X, L, shape, memory, 0.005)
    again = effect.advance(X, L, shape, Memory(memory.mu, dict(zip(states, half)), {}), 0.005)
    whole = effect.advance(X, L, shape, memory, 0.01)
    assert all(np.allclose(a, b, rtol=1e-9) for a, b in zip(again, whole))


@pytest.mark.parametrize("name", NAMES)
def test_strength_zero_is_the_base(name: str, noise_free: tuple[pd.DataFrame, pd.DataFrame]) -> None:
    data, tests = noise_free
    first = data[data["test_id"].isin(tests["test_id"].iloc[:6])]
    loads = TriboLoads.from_frame(first, tests)
    mu = 0.2 + loads.as_array() @ BASE
    base = LinearFriction().fit(loads, mu)
    model = ComposedFriction(clone(base), [name]).fit(loads, mu)
    model.amplitudes_ = [dict.fromkeys(a, 0.0) for a in model.amplitudes_]
    model.base_ = base
    assert np.array_equal(model.predict(loads), base.predict(loads))
