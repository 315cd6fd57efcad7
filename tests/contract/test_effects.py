"""One suite over every effect of the catalogue, and over one that a user brings by an entry point."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from sklearn.base import clone

from benchmarks.discovery_campaigns import campaign
from fmus import pack, read_friction_fmu
from friction_models import LinearFriction, OnnxModel, TriboLoads, effects, load_model
from friction_models.common import InputError
from friction_models.common.imports import plugins
from friction_models.discovery import diagnose
from friction_models.effects import CATALOGUE, Amplitude, Effect, Memory, Shape, make_effect
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search import memory as states_of_effects
from friction_models.estimation.search.candidates import evaluate_points, spans_of
from friction_models.expressions.ops import LoadColumns, NumpyOps
from friction_models.families.composed import ComposedFriction


class Polishing(Effect):
    """An effect as a user writes it, with memory and metadata: sliding polishes a hard tool."""

    name = "polishing"
    title = "sliding polishes the tool"
    equation = "mu += c_q * hardness * (1 - polish),  d(polish)/dt = (1 - polish) v_rel/s_q"
    latex = r"c_q H (1-q)"
    citation = "a user's own"
    where_it_shows = "first millimetres on hard tools"
    driver = ("sd",)
    amplitudes = (Amplitude("c_q", "1/HRC", "friction of the rough tool", 1, 0.02),)
    shapes = (
        Shape("s_q", "mm", "distance that polishes", 1e-6, 50.0, 3.0, follows="distance", span=(20.0, 0.3)),
    )
    states = (("polish", "1"),)
    metadata = ("hardness",)
    metadata_units = ("HRC",)

    def basis(self, x: Any, L: Any, p: Mapping[str, Any], memory: Memory) -> tuple[Any, ...]:
        return (memory.system["hardness"] * (1.0 - memory.state["polish"]),)

    def rate(self, x: Any, L: Any, p: Mapping[str, Any], memory: Memory) -> tuple[Any, ...]:
        return ((1.0 - memory.state["polish"]) * L.v_rel / p["s_q"],)

    def advance(self, x: Any, L: Any, p: Mapping[str, Any], memory: Memory, dt: Any) -> tuple[Any, ...]:
        return (1.0 - (1.0 - memory.state["polish"]) * x.exp(-L.v_rel * dt / p["s_q"]),)


#: Columns of the test table as effects, one of texts and one of numbers.
FACTORS = ("factor:humidity", "factor:operator")
NAMES = sorted([*CATALOGUE, *FACTORS, Polishing.name])
STATEFUL = [n for n, e in (CATALOGUE | {Polishing.name: Polishing}).items() if e.states]
X = NumpyOps()
BASE = np.array([1e-5, -3e-5, -5e-6, 1e-4, 0.006])


@pytest.fixture(scope="module", autouse=True)
def plug_in() -> Iterator[None]:
    """Stand for an installed package that offers the user's effect."""
    entry = SimpleNamespace(name=Polishing.name, value="plugin:Polishing", load=lambda: Polishing)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plugins, "entry_points", lambda group: [entry])
        patch.setitem(CATALOGUE, Polishing.name, effects.load_catalogue()[Polishing.name])
        yield


@pytest.fixture(scope="module")
def noise_free() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Loads of a small factorial plan; its friction is replaced in every test."""
    data, tests, _ = campaign(None, seed=3, levels=2, extra=8, thin=12, twin_errors=0.0, noise=0.0)
    number = np.arange(len(tests))
    return data, tests.assign(
        hardness=np.linspace(0.3, 1.0, len(tests)),
        operator=np.array(["anna", "bert", "cleo"])[number * 7 % 5 % 3],
        humidity=30.0 + number * 11 % 41,
    )


def with_effect(
    name: str, data: pd.DataFrame, tests: pd.DataFrame
) -> tuple[pd.DataFrame, dict[str, float], list[float]]:
    """Return friction = linear law + the effect with known parameters, and these parameters."""
    effect = make_effect(name)
    made = prepare(data, tests)
    grids = effect.grids(spans_of(made, made.mu))
    shape = {k: float(0.5 * (g[len(g) // 2] + g[max(len(g) // 2 - 1, 0)])) for k, g in grids.items()}
    if name in {"batch", "factor:operator"}:
        shape["deviating"] = 1.0
    strength = [
        0.03 * (a.sign or -1.0) * (0.1 if "ln" in effect.equation else 1.0) for a in effect.amplitudes
    ]
    base = 0.2 + made.loads.as_array() @ BASE
    mu = base
    for _ in range(40):  # effects that see the model's own friction: iterate to agreement
        columns = evaluate_points(effect, made, mu, shape)
        new = base + sum(a * np.broadcast_to(c, (len(mu), 1))[:, 0] for a, c in zip(strength, columns))
        mu = 0.5 * (mu + new) if effect.needs_mu else new
    return data.assign(mu=mu), shape, strength


@pytest.mark.parametrize("name", NAMES)
def test_declaration_is_complete(name: str) -> None:
    effect = make_effect(name)
    assert effect.name == name
    for text in (
        effect.title,
        effect.equation,
        effect.latex,
        effect.citation,
        effect.where_it_shows,
        effect.label,
        effect.sentence,
    ):
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
    made, shape, strength = with_effect(name, data, tests)
    model = (LinearFriction() + name).fit_frame(made, tests)
    found = list(model.amplitudes_[0].values())
    if model.effects_[0].pooled:  # an offset a level: that of the deviating one above the others
        found = [found[1] - 0.5 * (found[0] + found[2])]
    if name == "batch" and model.shapes_[0]["deviating"] != shape["deviating"]:
        # of two batches, the one lies as far above as the other below
        shape, strength = {"deviating": model.shapes_[0]["deviating"]}, [-s for s in strength]
    assert found == pytest.approx(strength, rel=0.01)
    free = {s.name for s in model.effects_[0].free_shapes}
    assert {k: v for k, v in model.shapes_[0].items() if k in free} == pytest.approx(
        {k: v for k, v in shape.items() if k in free}, rel=0.01
    )
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


@pytest.mark.parametrize("name", STATEFUL)
def test_state_advances_with_time_only(name: str) -> None:
    effect = make_effect(name)
    shape = effect.start_shape()
    L = LoadColumns(*(np.array([[v]]) for v in (120.0, 90.0, 900.0, 4.0, 1.2)))
    states = {n: np.array([[v]]) for (n, _), v in zip(effect.states, effect.start_state(shape))}
    system = {m: np.array([[0.5]]) for m in effect.metadata}
    memory = Memory(np.array([[0.07]]), states, system)
    still = effect.advance(X, L, shape, memory, 0.0)
    assert all(np.array_equal(a, b) for a, b in zip(still, states.values()))
    # the derivative is the limit of the step, and two half steps make a whole one
    small = 1e-7
    slope = [(b - a) / small for a, b in zip(states.values(), effect.advance(X, L, shape, memory, small))]
    for given, found in zip(effect.rate(X, L, shape, memory), slope):
        assert np.allclose(given, found, rtol=1e-4)
    half = effect.advance(X, L, shape, memory, 0.005)
    again = effect.advance(X, L, shape, Memory(memory.mu, dict(zip(states, half)), system), 0.005)
    whole = effect.advance(X, L, shape, memory, 0.01)
    assert all(np.allclose(a, b, rtol=1e-9) for a, b in zip(again, whole))


@pytest.mark.parametrize("name", [n for n in STATEFUL if n != Polishing.name])
def test_states_at_once_are_those_of_single_steps(name: str) -> None:
    rng = np.random.default_rng(8)
    rows = []
    for test, points in enumerate((7, 30, 1, 18)):
        sd = np.cumsum(rng.uniform(0.1, 2.0, points))
        v = rng.uniform(1.0, 300.0, points)
        rest = np.where(np.arange(points) == 5, 40.0, 0.0)  # a stop between two strokes
        rows.append(
            pd.DataFrame(
                {"test_id": f"t{test}", "t": np.cumsum(np.diff(sd, prepend=0.0) / v + rest), "v_rel": v}
                | {"T": 80.0, "sigma_n": rng.uniform(300.0, 900.0, points), "sd": sd, "psi": 1.2, "mu": 0.08}
            )
        )
    campaign, effect = prepare(pd.concat(rows, ignore_index=True)), make_effect(name)
    shape = effect.start_shape()
    if effect.states_need_shapes:
        first = next(iter(shape))
        shape[first] = shape[first] * np.array([[0.5, 1.0, 3.0]])
    at_once = states_of_effects.integrate(effect, campaign, campaign.mu, shape)
    names = [name for name, _ in effect.states]

    def advance(rows: Any, L: LoadColumns, held: Any, seconds: Any) -> Any:
        memory = Memory(campaign.mu[rows, None], dict(zip(names, held)), {})
        return [
            np.broadcast_to(new, old.shape)
            for old, new in zip(held, effect.advance(X, L, shape, memory, seconds[:, None]))
        ]

    sets = max(np.size(value) for value in shape.values())
    start = [np.broadcast_to(s, (4, sets)) for s in effect.start_state(shape)]
    for state, single in zip(names, campaign.course.step_by_step(start, advance)):
        assert np.ptp(single) > 0.0
        assert at_once[state] == pytest.approx(single, rel=1e-12)


class Faded(Effect):
    """A memory of the speed whose step is linear in it, written as `linear_step` alone."""

    name, title, equation, latex = "faded", "memory of the speed", "mu += k z", "k z"
    citation, where_it_shows, driver = "a user's own", "after steps of the speed", ("v_rel",)
    amplitudes = (Amplitude("k", "1", "strength", 0, 0.02),)
    shapes = (Shape("D", "mm", "distance of memory", 0.1, 100.0, 5.0),)
    states = (("z", "1"),)

    def basis(self, x: Any, L: Any, p: Mapping[str, Any], memory: Memory) -> tuple[Any, ...]:
        return (memory.state["z"],)

    def rate(self, x: Any, L: Any, p: Mapping[str, Any], memory: Memory) -> tuple[Any, ...]:
        return ((L.v_rel / 100.0 - memory.state["z"]) * L.v_rel / p["D"],)

    def linear_step(self, x: Any, L: Any, p: Mapping[str, Any], memory: Memory, dt: Any) -> tuple[Any, ...]:
        keep = x.exp(-L.v_rel * dt / p["D"])
        return (keep, (1.0 - keep) * L.v_rel / 100.0)


class TooShort(Faded):
    def linear_step(self, x: Any, L: Any, p: Mapping[str, Any], memory: Memory, dt: Any) -> tuple[Any, ...]:
        keep, gain = super().linear_step(x, L, p, memory, dt)
        return (keep[:3, 0], gain)


class Growing(Faded):
    """A state that runs away."""

    def rate(self, x: Any, L: Any, p: Mapping[str, Any], memory: Memory) -> tuple[Any, ...]:
        return (1e4 * memory.state["z"] + 1.0,)

    def linear_step(self, x: Any, L: Any, p: Mapping[str, Any], memory: Memory, dt: Any) -> tuple[Any, ...]:
        growth = x.exp(1e4 * dt)
        return (growth, (growth - 1.0) / 1e4)


class Other(Faded):
    """Another memory under the same name of its state."""

    name = "other"


class Faster(Faded):
    """Steps of half the distance that its rate has."""

    def linear_step(self, x: Any, L: Any, p: Mapping[str, Any], memory: Memory, dt: Any) -> tuple[Any, ...]:
        return super().linear_step(x, L, p, memory, 2.0 * dt)


class Turned(Faded):
    def linear_step(self, x: Any, L: Any, p: Mapping[str, Any], memory: Memory, dt: Any) -> tuple[Any, ...]:
        return (1.0, x.sqrt(dt - 1.0 + 0.0j))


class Undefined(Faded):
    def basis(self, x: Any, L: Any, p: Mapping[str, Any], memory: Memory) -> tuple[Any, ...]:
        return (x.log(-p["D"] - memory.state["z"]),)


class Twice(Faded):
    def advance(self, x: Any, L: Any, p: Mapping[str, Any], memory: Memory, dt: Any) -> tuple[Any, ...]:
        return (memory.state["z"],)


def test_a_step_is_the_same_in_a_fit_and_in_a_prediction(
    noise_free: tuple[pd.DataFrame, pd.DataFrame],
) -> None:
    """Written once, as `linear_step`: a fit would use another step than a prediction if `advance` stayed that of Euler."""
    data, _ = noise_free
    truth = data.assign(mu=0.08)
    made = prepare(truth)
    z = states_of_effects.integrate(Faded(), made, made.mu, Faded().start_shape())["z"][:, 0]
    model = ComposedFriction(LinearFriction(), [Faded(D=5.0)])
    model.fit_frame(truth.assign(mu=0.08 + 0.02 * z / max(z.max(), 1e-9)))
    predicted = model.predict(TriboLoads.from_frame(truth))
    assert predicted == pytest.approx(0.08 + 0.02 * z / z.max(), abs=1e-9)


def test_steps_that_contradict_or_have_no_shape_are_refused(
    noise_free: tuple[pd.DataFrame, pd.DataFrame],
) -> None:
    with pytest.raises(InputError, match="advance and linear_step both written; allowed: one of them"):
        make_effect(Twice())
    made = prepare(noise_free[0])
    with pytest.raises(InputError, match=r"linear_step gives the shape \(3,\); allowed: "):
        states_of_effects.integrate(TooShort(), made, made.mu, TooShort().start_shape())


def test_two_effects_cannot_remember_under_one_name(
    noise_free: tuple[pd.DataFrame, pd.DataFrame],
) -> None:
    """A fit kept the two states apart, a prediction went on with one of them: mu was wrong in silence."""
    points, tests = noise_free
    both = [Faded(D=5.0), Other(D=50.0)]
    said = "state 'z' stands in faded and other; allowed: a name of its own for each state"
    with pytest.raises(InputError, match=f"composed: {said}"):
        ComposedFriction(LinearFriction(), both).fit_frame(points.assign(mu=0.08))
    with pytest.raises(InputError, match=f"catalogue: {said}"):
        diagnose(points.assign(mu=0.08), tests, catalogue=both)
    with pytest.raises(
        InputError, match="catalogue: effect 'stribeck' stands twice; allowed: each effect once"
    ):
        diagnose(points.assign(mu=0.08), tests, catalogue=["stribeck", "stribeck"])


@pytest.mark.parametrize(
    ("effect", "said"),
    [
        (
            Faster,
            r"a short step changes state 'z' by \S+ a second, its rate by \S+; allowed: the same law in both",
        ),
        (Growing, r"state 'z' is not finite, as with D = \S+; allowed: finite numbers"),
        (Turned, "linear_step gives complex numbers; allowed: real ones"),
        (Undefined, r"basis is not finite, as with D = \S+; allowed: finite numbers"),
    ],
)
@pytest.mark.filterwarnings("error")
def test_an_effect_that_gives_no_numbers_is_told_by_name(
    effect: type[Effect], said: str, noise_free: tuple[pd.DataFrame, pd.DataFrame]
) -> None:
    points, tests = noise_free[0].iloc[::8], noise_free[1]
    found = diagnose(points.assign(mu=0.08), tests, catalogue=["stribeck", effect()])
    assert any(re.match(f"faded was not tested: effect 'faded': {said}", w) for w in found.warnings)
    with pytest.raises(InputError, match=f"effect 'faded': {said}"):
        ComposedFriction(LinearFriction(), [effect()]).fit_frame(points.assign(mu=0.08))


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


def test_a_users_effect_leaves_in_a_native_fmu(
    noise_free: tuple[pd.DataFrame, pd.DataFrame], tmp_path: Path
) -> None:
    data, tests = noise_free
    made, _, _ = with_effect(Polishing.name, data, tests)
    model = (LinearFriction() + Polishing.name).fit_frame(made, tests)
    first = made[made["test_id"].isin(tests["test_id"].iloc[:2])]
    fmu = read_friction_fmu(pack(model, tmp_path / "polishing.fmu", nodes=1))
    expected = model.predict_frame(first, tests)
    np.testing.assert_allclose(fmu.predict_frame(first, tests), expected, rtol=1e-9)
