"""Model exchange: continuous states against closed forms, derivatives, events of in_domain, refusals."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.fmi2 import FMU2Model
from fmpy.fmi3 import FMU3Model

from fmus import pack
from fmus.runtime.running import FmuError, RunningFmu, UnpackedFmu
from friction_models.families.registry import make_model
from friction_models.loads import LOAD_NAMES
from tests.fmus.graphs import campaign
from tests.fmus.memory_models import AGE_0, C, D, K, age_at, ageing_bytes, mu_at

Ageing = Callable[[str, int], Path]
LOADS_INSIDE = {"v_rel": 40.0, "T": 100.0, "sigma_n": 1000.0, "sd": 10.0, "psi": 2.0}


@pytest.fixture(scope="module")
def ageing(tmp_path_factory: pytest.TempPathFactory) -> Ageing:
    folder = tmp_path_factory.mktemp("ageing")
    (folder / "model.onnx").write_bytes(ageing_bytes())
    made: dict[tuple[str, int], Path] = {}

    def get(fmi: str, nodes: int = 1) -> Path:
        if (fmi, nodes) not in made:
            path = folder / f"{fmi}-{nodes}.fmu"
            made[fmi, nodes] = pack(folder / "model.onnx", path, nodes=nodes, fmi=fmi)
        return made[fmi, nodes]

    return get


def run(path: Path, kind: str, start: dict[str, Any], signal: Any = None, **more: Any) -> Any:
    options = {"stop_time": 1.0, "output_interval": 0.05, "relative_tolerance": 1e-9} | more
    output = ["mu", "age", "in_domain"]
    return simulate_fmu(str(path), fmi_type=kind, start_values=start, input=signal, output=output, **options)


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_memory_follows_its_closed_form(ageing: Ageing, fmi: str) -> None:
    result = run(ageing(fmi, 1), "ModelExchange", LOADS_INSIDE)
    exact = age_at(result["time"], 40.0)
    assert exact[-1] < 0.5 * AGE_0
    np.testing.assert_allclose(result["age"].ravel(), exact, rtol=1e-6)
    np.testing.assert_allclose(result["mu"].ravel(), mu_at(exact, 100.0), rtol=1e-7)


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_many_points_are_states_of_their_own(ageing: Ageing, fmi: str) -> None:
    speeds = [40.0, 80.0, 160.0]
    path = ageing(fmi, 3)
    loads = {n: [v] * 3 for n, v in LOADS_INSIDE.items()} | {"v_rel": speeds}
    start: dict[str, Any] = loads
    names = ["age"]
    if fmi == "2.0":
        start = {f"{n}[{i + 1}]": v[i] for n, v in loads.items() for i in range(3)}
        names = ["age[1]", "age[2]", "age[3]"]
    result = simulate_fmu(
        str(path),
        fmi_type="ModelExchange",
        stop_time=0.5,
        output_interval=0.1,
        relative_tolerance=1e-9,
        start_values=start,
        output=names,
    )
    ages = np.column_stack([result[n] for n in names])
    expected = np.column_stack([age_at(result["time"], v) for v in speeds])
    np.testing.assert_allclose(ages, expected, rtol=1e-6)


def test_a_point_without_contact_keeps_its_memory(ageing: Ageing) -> None:
    result = run(ageing("2.0", 1), "ModelExchange", LOADS_INSIDE | {"sigma_n": 0.0})
    np.testing.assert_array_equal(result["age"], AGE_0)


def test_effect_of_the_catalogue_agrees_with_its_exact_steps(tmp_path: Path) -> None:
    points, tests = campaign()
    model = (make_model("linear") + "rate_state").fit_frame(points, tests)
    path = str(pack(model, tmp_path / "rate.fmu"))
    common = {
        "stop_time": 0.2,
        "output_interval": 0.01,
        "start_values": {"v_rel": 10.0},
        "output": ["mu", "age"],
    }
    smooth = simulate_fmu(path, fmi_type="ModelExchange", relative_tolerance=1e-9, **common)
    steps = simulate_fmu(path, fmi_type="CoSimulation", **common)
    assert steps["age"][-1] < 0.9 * steps["age"][0]
    np.testing.assert_allclose(smooth["age"], steps["age"], rtol=1e-5)
    np.testing.assert_allclose(smooth["mu"], steps["mu"], rtol=1e-6)


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_in_domain_changes_at_an_event_on_the_border(ageing: Ageing, fmi: str) -> None:
    signal = np.zeros(2, dtype=[("time", "f8"), ("T", "f8")])
    signal["T"] = [100.0, 700.0]
    signal["time"] = [0.0, 1.0]
    start = {k: v for k, v in LOADS_INSIDE.items() if k != "T"}
    result = run(ageing(fmi, 1), "ModelExchange", start, signal, record_events=True)
    inside = result["in_domain"].astype(bool)
    change = int(np.argmin(inside))
    assert inside[:change].all() and not inside[change:].any()
    # Both sides of the event are recorded, at the time when T passes 400 degC.
    assert result["time"][change] == pytest.approx(0.5, abs=1e-6)
    assert result["time"][change - 1] == pytest.approx(0.5, abs=1e-6)


@pytest.fixture(params=["2.0", "3.0"])
def continuous(request: pytest.FixtureRequest, ageing: Ageing) -> Iterator[tuple[Any, UnpackedFmu]]:
    """An instance in continuous-time mode."""
    unpacked = UnpackedFmu.of(ageing(request.param, 1))
    kind = FMU2Model if request.param == "2.0" else FMU3Model
    fmu: Any = kind(
        guid=unpacked.raw.guid,
        unzipDirectory=str(unpacked.folder),
        modelIdentifier=unpacked.raw.modelExchange.modelIdentifier,
        instanceName="me",
    )
    fmu.instantiate()
    setter = fmu.setReal if request.param == "2.0" else fmu.setFloat64
    if request.param == "2.0":
        fmu.setupExperiment()
    fmu.enterInitializationMode()
    setter([unpacked.variables[n].reference for n in LOAD_NAMES], list(LOADS_INSIDE.values()))
    fmu.exitInitializationMode()
    update(fmu)
    fmu.enterContinuousTimeMode()
    yield fmu, unpacked
    fmu.freeInstance()


def update(fmu: Any) -> None:
    fmu.newDiscreteStates() if isinstance(fmu, FMU2Model) else fmu.updateDiscreteStates()


def test_a_boolean_waits_for_the_event(continuous: tuple[Any, UnpackedFmu]) -> None:
    fmu, unpacked = continuous
    setter = fmu.setReal if isinstance(fmu, FMU2Model) else fmu.setFloat64
    temperature, shown = (unpacked.variables[n].reference for n in ("T", "in_domain"))
    setter([temperature], [500.0])
    assert fmu.getBoolean([shown])[0]
    needs_event, ends = fmu.completedIntegratorStep()
    assert needs_event and not ends
    assert fmu.getBoolean([shown])[0]
    fmu.enterEventMode()
    update(fmu)
    assert not fmu.getBoolean([shown])[0]
    fmu.enterContinuousTimeMode()
    assert not fmu.getBoolean([shown])[0]
    assert not fmu.completedIntegratorStep()[0]


def test_states_that_are_no_numbers_and_wrong_calls_are_refused(continuous: tuple[Any, UnpackedFmu]) -> None:
    fmu, _ = continuous
    from ctypes import c_double

    buffer = (c_double * 2)(np.nan, 0.0)
    for values, count in ((buffer, 1), (buffer, 2)):
        with pytest.raises(Exception, match="SetContinuousStates failed"):
            fmu.setContinuousStates(values, count)
    fmu.getContinuousStates(buffer, 1)
    assert buffer[0] == AGE_0
    fmu.getNominalsOfContinuousStates(buffer, 1)
    assert buffer[0] == AGE_0
    for call in (fmu.enterInitializationMode, fmu.enterContinuousTimeMode):
        with pytest.raises(Exception, match="failed"):
            call()


def test_derivative_of_the_memory(continuous: tuple[Any, UnpackedFmu]) -> None:
    fmu, _ = continuous
    from ctypes import c_double

    buffer = (c_double * 1)(0.3)
    fmu.setContinuousStates(buffer, 1)
    rates = fmu.getDerivatives if isinstance(fmu, FMU2Model) else fmu.getContinuousStateDerivatives
    rates(buffer, 1)
    assert buffer[0] == pytest.approx(1.0 - 40.0 * 0.3 / D)


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_directional_derivatives_of_mu_and_of_the_rate(ageing: Ageing, fmi: str) -> None:
    """Against central differences; the model is bilinear, so that these are exact but for rounding."""
    unpacked = UnpackedFmu.of(ageing(fmi, 1))
    knowns = [*LOAD_NAMES, "age", "Ra"]
    outputs = ["mu", "domain_distance", "der(age)"]
    at = LOADS_INSIDE | {"age": 0.4, "Ra": 0.3}

    def values(changed: dict[str, float]) -> np.ndarray:
        with RunningFmu(unpacked, start=changed) as fmu:
            return fmu.get_real(outputs)

    with RunningFmu(unpacked, start=at) as fmu:
        for name in knowns:
            h = 1e-4 * max(at[name], 1.0)
            central = (values(at | {name: at[name] + h}) - values(at | {name: at[name] - h})) / (2.0 * h)
            got = fmu.derivative(outputs, [name], np.ones(1))
            np.testing.assert_allclose(got, central, rtol=1e-8, atol=1e-10, err_msg=name)
        np.testing.assert_allclose(fmu.derivative(["mu"], ["age"], np.array([2.0])), 2.0 * K)
        # What is no output follows its own seed.
        got = fmu.derivative(["T", "age", "Ra", "psi"], ["T", "age", "Ra"], np.array([2.0, 3.0, 4.0]))
        np.testing.assert_array_equal(got, [2.0, 3.0, 4.0, 0.0])
        # A seed of several knowns adds up, and leaves nothing behind for the next call.
        both = fmu.derivative(outputs, ["age", "Ra"], np.array([1.0, 1.0]))
        single = [fmu.derivative(outputs, [n], np.ones(1)) for n in ("age", "Ra")]
        np.testing.assert_allclose(both, single[0] + single[1], rtol=1e-14)
        for bad, words in (
            ((["mu"], ["mu"], np.ones(1)), "with respect to mu"),
            ((["mu"], ["T"], np.array([np.nan])), "seed of T = -?nan"),
        ):
            with pytest.raises(FmuError, match=words):
                fmu.derivative(*bad)
        np.testing.assert_allclose(fmu.derivative(outputs, ["Ra"], np.ones(1)), single[1], rtol=1e-14)


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_what_is_held_at_a_limit_does_not_move(ageing: Ageing, fmi: str) -> None:
    unpacked = UnpackedFmu.of(ageing(fmi, 1))
    with RunningFmu(unpacked, start=LOADS_INSIDE | {"T": 450.0}) as fmu:
        along = ["T"], np.ones(1)
        # Clamped to 400 degC; the distance from the domain goes on, in units of its width.
        np.testing.assert_allclose(fmu.derivative(["mu", "domain_distance"], *along), [0.0, 1.0 / 380.0])
        fmu.set({"clamp_to_domain": False})
        np.testing.assert_allclose(fmu.derivative(["mu"], *along), [C])
        fmu.set({"Ra": -10.0})
        assert fmu.get_real(["mu"])[0] == 0.0
        np.testing.assert_array_equal(fmu.derivative(["mu"], *along), [0.0])
        # Beyond the physical limit of 0 MPa there is no contact, and the memory rests.
        fmu.set({"sigma_n": -1.0})
        np.testing.assert_array_equal(fmu.derivative(["der(age)"], ["v_rel"], np.ones(1)), [0.0])


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_memory_that_is_no_equation_is_for_co_simulation_only(
    fmi: str, memory_onnx: Path, tmp_path: Path
) -> None:
    unpacked = UnpackedFmu.of(pack(memory_onnx, tmp_path / "memory.fmu", fmi=fmi))
    assert unpacked.raw.modelExchange is None
    messages: list[str] = []
    kind = FMU2Model if fmi == "2.0" else FMU3Model
    fmu: Any = kind(
        guid=unpacked.raw.guid,
        unzipDirectory=str(unpacked.folder),
        modelIdentifier=unpacked.raw.coSimulation.modelIdentifier,
        instanceName="me",
    )
    if fmi == "3.0":
        with pytest.raises(Exception, match="instantiate"):
            fmu.instantiate(logMessage=lambda _e, _s, _c, text: messages.append(text.decode()))
        assert "no differential equation" in messages[0]
    else:
        with pytest.raises(Exception, match="instantiate"):
            fmu.instantiate()
    fmu.freeLibrary()


def test_description_of_the_states(ageing: Ageing) -> None:
    for fmi in ("2.0", "3.0"):
        description: Any = UnpackedFmu.of(ageing(fmi, 3)).raw
        rates = [d.variable for d in description.derivatives]
        names = ["der(age)"] if fmi == "3.0" else [f"der(age[{i}])" for i in (1, 2, 3)]
        assert [r.name for r in rates] == names
        assert [r.derivative.name for r in rates] == [n[4:-1] for n in names]
        assert {r.unit for r in rates} == {"1"}
        assert {float(r.derivative.nominal) for r in rates} == {AGE_0}
        indicators = description.numberOfEventIndicators
        assert indicators == 1
        output = next(u for u in description.outputs if u.variable.name.startswith("mu"))
        parameters = ["Ra", "clamp_to_domain"] if fmi == "3.0" else []
        assert [d.name.partition("[")[0] for d in output.dependencies] == [*LOAD_NAMES, "age", *parameters]
