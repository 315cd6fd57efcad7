"""FMI 3.0 friction FMUs: arrays of any length, state, derivatives both ways, dependencies, refusals, description."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.validation import validate_fmu

from fmus import pack
from fmus.archive.content import read_description
from fmus.interface.friction_variables import MAX_NODES
from fmus.native.compile import fmi_headers
from fmus.runtime.running import FmuError, RunningFmu, UnpackedFmu
from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES
from tests.fmus.graphs import inside, random_loads, runtime
from tests.fmus.memory_models import AGE_0, D, ageing_bytes

Get = Callable[..., UnpackedFmu]


def by_fmpy(running: RunningFmu) -> Any:
    """Return fmpy's object for the same instance: it has a method for every function of the standard."""
    description = running.fmu.raw
    slave: Any = FMU3Slave(
        guid=description.guid,
        unzipDirectory=str(running.fmu.folder),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="friction",
    )
    slave.component = running.slave._component
    return slave


def call(running: RunningFmu, function: Callable[..., Any], *arguments: Any) -> None:
    """Call a method of fmpy's object; a refusal becomes the error of `RunningFmu`, with the FMU's own words."""
    running._messages.forget()
    try:
        function(*arguments)
    except Exception as error:
        raise running._failure("", 0.0, error) from None


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory: pytest.TempPathFactory, linear_onnx: Path, memory_onnx: Path) -> Get:
    folder = tmp_path_factory.mktemp("fmi3")
    (folder / "ageing.onnx").write_bytes(ageing_bytes())
    models = {"linear": linear_onnx, "memory": memory_onnx, "ageing": folder / "ageing.onnx"}
    made: dict[tuple[str, int, str], UnpackedFmu] = {}

    def get(name: str, nodes: int = 1, fmi: str = "3.0") -> UnpackedFmu:
        key = (name, nodes, fmi)
        if key not in made:
            path = pack(
                models[name], folder / f"{name}-{nodes}-{fmi}.fmu", nodes=nodes, fmi=fmi, arrays=fmi == "3.0"
            )
            made[key] = UnpackedFmu.of(path)
        return made[key]

    return get


@pytest.mark.parametrize("name", [pytest.param("linear", marks=pytest.mark.nightly), "memory", "ageing"])
@pytest.mark.parametrize("nodes", [pytest.param(1, marks=pytest.mark.nightly), 3])
def test_fmpy_finds_no_problem(unpacked: Get, name: str, nodes: int) -> None:
    assert validate_fmu(str(unpacked(name, nodes).path)) == []


@pytest.mark.parametrize("points", [1, 2, 3, 5, 16, 17, 40])
def test_one_file_serves_any_number_of_points(unpacked: Get, linear_onnx: Path, points: int) -> None:
    fmu = unpacked("linear")
    loads = random_loads(points, seed=points)
    with RunningFmu(fmu, points=points) as running:
        running.set_real(LOAD_NAMES, loads.T)
        mu = running.get_real(["mu"])
        np.testing.assert_allclose(mu, runtime(linear_onnx.read_bytes(), inside(loads)), rtol=1e-12)
        # A point alone has the same bits as in a block of many.
        for i in range(points):
            with RunningFmu(fmu) as alone:
                alone.set_real(LOAD_NAMES, loads[i])
                assert alone.get_real(["mu"])[0] == mu[i]


@pytest.mark.parametrize("name", ["memory", "ageing"])
def test_steps_are_those_of_fmi_2(unpacked: Get, name: str) -> None:
    state = {"memory": "work", "ageing": "age"}[name]
    loads = random_loads(3, seed=4)
    with RunningFmu(unpacked(name), points=3) as three, RunningFmu(unpacked(name, 3, "2.0")) as two:
        for k in range(4):
            three.set_real(LOAD_NAMES, np.roll(loads, k, axis=0).T)
            names = [f"{n}[{i + 1}]" for n in LOAD_NAMES for i in range(3)]
            two.set_real(names, np.roll(loads, k, axis=0).T.ravel())
            for running in (three, two):
                running.step(0.1 * k, 0.1)
            for variable in ("mu", state, "domain_distance"):
                expected = two.get_real([f"{variable}[{i + 1}]" for i in range(3)])
                np.testing.assert_array_equal(three.get_real([variable]), expected)
            assert three.get_boolean("in_domain") == two.get_boolean("in_domain")


def test_fmpy_simulates_scalars_and_arrays(unpacked: Get) -> None:
    for nodes in (1, 3):
        path = str(unpacked("ageing", nodes).path)
        speed = [40.0, 80.0, 160.0][:nodes]
        results = {
            kind: simulate_fmu(
                path,
                fmi_type=kind,
                stop_time=0.1,
                output_interval=0.001,
                relative_tolerance=1e-8,
                start_values={"v_rel": speed},
                output=["mu", "age"],
            )
            for kind in ("CoSimulation", "ModelExchange")
        }
        assert results["CoSimulation"]["age"].shape == (101, nodes)
        assert (results["CoSimulation"]["age"][-1] < AGE_0).all()
        # The graph steps with Euler's rule: first order in the step of 1 ms.
        np.testing.assert_allclose(
            results["CoSimulation"]["mu"], results["ModelExchange"]["mu"], rtol=3e-3, atol=0.0
        )


def test_state_comes_back_also_into_an_instance_of_another_size(unpacked: Get) -> None:
    fmu = unpacked("memory")
    with RunningFmu(fmu, points=5) as first, RunningFmu(fmu) as second:
        first.set_real(["v_rel"], np.arange(1.0, 6.0))
        first.step(0.0, 0.5)
        state = first.save_state()
        at_save = first.get_real(["work", "mu"])
        first.step(0.5, 0.5)
        later = first.get_real(["work", "mu"])
        content = first.serialize(state)
        second.restore_state(second.deserialize(content))
        assert by_fmpy(second).getUInt64([fmu.variables["n"].reference]) == [5]
        second.fmu = fmu.sized({"n": 5})
        for running in (first, second):
            running.restore_state(state) if running is first else None
            np.testing.assert_array_equal(running.get_real(["work", "mu"]), at_save)
            running.step(0.5, 0.5)
            np.testing.assert_array_equal(running.get_real(["work", "mu"]), later)
        damaged = bytearray(content)
        for place in (3, len(damaged) // 2, len(damaged) - 1):
            damaged[place] ^= 1
            with pytest.raises(FmuError, match=r"serialized state (is damaged|does not belong)"):
                second.deserialize(bytes(damaged))
            damaged[place] ^= 1
        with pytest.raises(FmuError, match="serialized state"):
            second.deserialize(content[:-8])


def test_adjoint_is_the_transposed_directional_derivative(unpacked: Get) -> None:
    fmu = unpacked("ageing")
    points = 3
    unknowns, knowns = ["mu", "domain_distance", "der(age)"], [*LOAD_NAMES, "age", "Ra"]
    with RunningFmu(fmu, points=points) as running:
        running.set_real(LOAD_NAMES, random_loads(points, seed=2).T)
        rows, columns = (sum(len(running.fmu.resolve(n)) for n in names) for names in (unknowns, knowns))
        forward = np.column_stack([running.derivative(unknowns, knowns, e) for e in np.eye(columns)])
        adjoint = np.vstack([running.adjoint(unknowns, knowns, e) for e in np.eye(rows)])
        assert np.count_nonzero(forward) > 2 * points
        np.testing.assert_allclose(adjoint, forward, rtol=1e-14, atol=0.0)
        # A point depends on itself alone.
        by_load = forward[:points, :points]
        assert np.count_nonzero(by_load - np.diag(np.diag(by_load))) == 0
        rng = np.random.default_rng(0)
        seed, weight = rng.normal(size=columns), rng.normal(size=rows)
        along = weight @ running.derivative(unknowns, knowns, seed)
        assert running.adjoint(unknowns, knowns, weight) @ seed == pytest.approx(along, rel=1e-12)
        for variable in ("time", "domain_indicator"):
            with pytest.raises(FmuError, match=f"derivatives of {variable}"):
                running.derivative([variable], ["T"], np.ones(points))
        huge = np.full(points, 1e308)
        with pytest.raises(FmuError, match="with respect to Ra is not a finite number"):
            running.adjoint(["mu"] * 100, ["Ra"], np.tile(huge, 100))
        with pytest.raises(FmuError, match=r"seed of T\[1\] = inf"):
            running.derivative(["mu"], ["T", "T"], np.tile(huge, 2))
        np.testing.assert_array_equal(running.derivative(["mu"], ["T"], np.zeros(points)), 0.0)
        with pytest.raises(FmuError, match=r"adjoint derivatives of T\[1\]"):
            running.adjoint(["T"], ["T"], np.ones(3))
        with pytest.raises(FmuError, match=r"seed of mu\[2\] = -?nan"):
            running.adjoint(["mu"], ["T"], np.array([1.0, np.nan, 1.0]))


def dependencies(running: RunningFmu, reference: int) -> tuple[list[int], list[int], list[int], list[int]]:
    """Return the answer of fmi3GetVariableDependencies (fmpy's own wrapper of it does not run)."""
    count, name = ctypes.c_size_t(0), ctypes.c_uint32(reference)
    running.call("GetNumberOfVariableDependencies", name, ctypes.byref(count))
    n = count.value
    of, at, kinds = (ctypes.c_size_t * n)(), (ctypes.c_size_t * n)(), (ctypes.c_int * n)()
    known = (ctypes.c_uint32 * n)()
    running.call("GetVariableDependencies", name, of, known, at, kinds, count)
    return list(of), list(known), list(at), list(kinds)


def test_dependencies_by_element(unpacked: Get) -> None:
    fmu = unpacked("ageing")
    reference = {v.own: v.reference for v in fmu.variables.values()}
    with RunningFmu(fmu, points=2) as running:
        for name, known in (
            ("mu", [*LOAD_NAMES, "age", "Ra", "clamp_to_domain"]),
            ("domain_distance", [*LOAD_NAMES]),
            ("der(age)", [*LOAD_NAMES, "age", "Ra"]),
        ):
            dependents, independents, elements, kinds = dependencies(running, reference[name])
            pairs = list(zip(dependents, independents, elements))
            points = [(i, k, 1 if k in {"Ra", "clamp_to_domain"} else i) for i in (1, 2) for k in known]
            assert pairs == [(i, reference[k], element) for i, k, element in points]
            # The same at the level of variables.
            unknowns = [*fmu.raw.outputs, *fmu.raw.derivatives]
            listed = next(u.dependencies for u in unknowns if u.variable.name == name)
            assert [v.name for v in listed] == known
            assert set(kinds) == {5}  # fmi3Dependent
        dependents, _, elements, _ = dependencies(running, reference["in_domain"])
        assert set(dependents) == {1} and elements == [1] * 5 + [2] * 5
        with pytest.raises(FmuError, match="no calculated variable"):
            dependencies(running, reference["T"])


def test_calls_that_are_not_allowed_say_why(unpacked: Get) -> None:
    fmu = unpacked("memory")
    reference = {v.own: v.reference for v in fmu.variables.values()}
    with RunningFmu(fmu, points=3) as running:
        slave = by_fmpy(running)
        for function, arguments, words in (
            (slave.setFloat64, ([reference["T"]], [1.0, np.nan, 2.0]), r"T\[2\] = -?nan is not a finite number"),
            (slave.setFloat64, ([reference["T"]], [1.0, 2.0]), "number of values"),
            (slave.getFloat64, ([reference["T"]], 2), "number of values"),
            (slave.setFloat64, ([reference["mu"]], [1.0] * 3), r"mu\[1\] is an output"),
            (slave.setFloat64, ([reference["work"]], [1.0] * 3), "memory of a point"),
            (slave.setFloat64, ([reference["time"]], [1.0]), "independent"),
            (slave.setFloat64, ([reference["domain_indicator"]], [1.0]), "domain_indicator is calculated"),
            (slave.setBoolean, ([reference["in_domain"]], [True]), "in_domain is an output"),
            (slave.getFloat64, ([4711],), "no Float64 variable with value reference 4711"),
            (slave.getInt32, ([reference["T"]],), "no Int32 variable"),
            (slave.getString, ([1],), "no String variable"),
            (slave.getClock, ([1],), "no Clock variable"),
            (slave.setUInt64, ([reference["n"]], [2]), "setting n is not allowed in step mode"),
            (slave.enterConfigurationMode, (), "not allowed in step mode"),
            (slave.enterEventMode, (), "not allowed in step mode"),
            (slave.enterStepMode, (), "hasEventMode is false"),
            (slave.doStep, (0.0, -1.0), "negative"),
            (slave.doStep, (0.0, np.inf), "not a finite number"),
        ):  # fmt: skip
            before = running.get_real(["T", "work", "mu"])
            with pytest.raises(FmuError, match=words):
                call(running, function, *arguments)
            np.testing.assert_array_equal(running.get_real(["T", "work", "mu"]), before)
        running.step(0.0, 0.0)
        for bad in (0, MAX_NODES + 1, 2**63):
            with pytest.raises(InputError, match=f"'n' = {bad}, allowed: 1 to {MAX_NODES}"):
                RunningFmu(fmu, points=bad)
            running.call("Reset")
            slave.enterConfigurationMode()
            with pytest.raises(FmuError, match=f"n = {bad}, allowed: 1 to {MAX_NODES}"):
                call(running, slave.setUInt64, [reference["n"]], [bad])


def test_model_exchange_with_a_chosen_number_of_points(unpacked: Get) -> None:
    fmu = unpacked("ageing")
    reference = {v.own: v.reference for v in fmu.variables.values()}
    model: Any = FMU3Model(
        guid=fmu.raw.guid,
        unzipDirectory=str(fmu.folder),
        modelIdentifier=fmu.raw.modelExchange.modelIdentifier,
        instanceName="me",
    )
    model.instantiate()
    assert model.getNumberOfContinuousStates() == 1
    model.enterConfigurationMode()
    model.setUInt64([reference["n"]], [2])
    model.exitConfigurationMode()
    model.enterInitializationMode()
    model.setFloat64([reference["v_rel"]], [20.0, 40.0])
    model.exitInitializationMode()
    model.updateDiscreteStates()
    model.enterContinuousTimeMode()
    assert model.getNumberOfContinuousStates() == 2
    assert model.getNumberOfEventIndicators() == 1
    values = (ctypes.c_double * 2)()
    model.getContinuousStates(values, 2)
    assert list(values) == [AGE_0, AGE_0]
    model.getContinuousStateDerivatives(values, 2)
    assert list(values) == pytest.approx([1.0 - 20.0 * AGE_0 / D, 1.0 - 40.0 * AGE_0 / D])
    model.reset()
    assert model.getUInt64([reference["n"]]) == [1]
    model.freeInstance()


def test_every_function_of_the_standard_is_there(unpacked: Get) -> None:
    fmu = unpacked("linear")
    text = fmi_headers("3.0")["fmi3Functions.h"]
    names = re.findall(r"^FMI3_Export\s+fmi3\w+TYPE\s+(fmi3\w+);", text, flags=re.MULTILINE)
    assert len(names) > 70
    library = next((fmu.folder / "binaries").rglob("friction_*"))
    loaded = ctypes.CDLL(str(library))
    assert [n for n in names if not hasattr(loaded, n)] == []


def test_scheduled_execution_and_wrong_tokens_give_no_instance(unpacked: Get) -> None:
    fmu = unpacked("linear")
    messages: list[bytes] = []
    slave: Any = FMU3Slave(
        guid="{another}",
        unzipDirectory=str(fmu.folder),
        modelIdentifier=fmu.raw.coSimulation.modelIdentifier,
        instanceName="wrong",
    )
    with pytest.raises(Exception, match="instantiate"):
        slave.instantiate(logMessage=lambda _e, _s, _c, text: messages.append(text))
    assert b"does not belong to this FMU" in messages[0]
    slave.freeLibrary()


@pytest.mark.usefixtures("built_anew")
def test_same_model_gives_the_same_bytes(linear_onnx: Path, tmp_path: Path) -> None:
    first = pack(linear_onnx, tmp_path / "a.fmu", fmi="3.0")
    second = pack(linear_onnx, tmp_path / "sub" / "b.fmu", fmi="3.0")
    assert first.read_bytes() == second.read_bytes()


def test_description_of_arrays_and_units(unpacked: Get) -> None:
    fmu = unpacked("ageing", 3)
    variables = {v.name: v for v in fmu.raw.modelVariables}
    references = [v.valueReference for v in fmu.raw.modelVariables]
    assert sorted(references) == list(range(len(variables)))
    for name in (*LOAD_NAMES, "mu", "domain_distance", "age", "der(age)"):
        assert variables[name].shape == (3,)
    for name in ("Ra", "in_domain", "clamp_to_domain", "domain_indicator", "n", "time"):
        assert not variables[name].dimensions
    assert (variables["n"].start, variables["n"].causality) == ("3", "structuralParameter")
    # The range seen in training is no limit of a system variable, zero roughness is.
    assert (float(variables["Ra"].min), variables["Ra"].max) == (0.0, None)
    assert "trained from 0.1 to 2" in variables["Ra"].description
    units = {u.name: u.baseUnit for u in fmu.raw.unitDefinitions}
    assert (units["MPa"].factor, units["MPa"].kg, units["MPa"].m, units["MPa"].s) == (1e6, 1, -1, -2)
    assert (units["degC"].K, units["degC"].offset) == (1, 273.15)
    root = read_description(fmu.path)
    for kind in ("CoSimulation", "ModelExchange"):
        flags = dict(root.find(kind).attrib)
        assert flags["providesDirectionalDerivatives"] == flags["providesAdjointDerivatives"] == "true"
        assert flags["canSerializeFMUState"] == flags["providesPerElementDependencies"] == "true"
        assert flags["needsExecutionTool"] == "false"
