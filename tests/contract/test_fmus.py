"""One suite over every model family and every effect: its FMU computes what the model computes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from fmus import pack, read_friction_fmu
from fmus.runtime.running import RunningFmu, UnpackedFmu
from friction_models.effects import CATALOGUE, make_effect
from friction_models.families.registry import FAMILIES, make_model
from friction_models.loads import LOAD_NAMES, LOADS, TriboLoads
from friction_models.models.base import FrictionModel
from friction_models.models.onnx_model import OnnxModel
from tests.fmus.graphs import campaign, random_loads

QUICK = {"ffnn": {"hidden": (8, 8), "members": 2, "epochs": 4}}
PREDICTING = [name for name in CATALOGUE if name not in {"sensor_drift", "force_zero", "twin_heating"}] + [
    "factor:operator",
    "factor:humidity",
]
NAMES = [*FAMILIES, *(f"linear + {e}" for e in PREDICTING)]


def daily(effect: str) -> bool:
    """Whether the FMU of an effect has variables of its own; of those without, whose values `test_parity` compares, one is enough."""
    made = make_effect(effect)
    return bool(made.states or made.metadata) or effect == "stribeck"


#: `test_parity` compares the values of all families; these differ most.
CASES = [
    pytest.param(f, marks=() if f in ("polynomial", "gradient_boosting") else pytest.mark.nightly)
    for f in FAMILIES
] + [pytest.param(f"linear + {e}", marks=() if daily(e) else pytest.mark.nightly) for e in PREDICTING]
Made = Callable[[str], tuple[FrictionModel, Path]]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    folder = tmp_path_factory.mktemp("contract")
    points, tests = campaign()
    tests["operator"] = [("anna", "bert", "cleo")[k * 7 % 3] for k in range(len(tests))]
    known: dict[str, tuple[FrictionModel, Path]] = {}

    def get(name: str) -> tuple[FrictionModel, Path]:
        if name not in known:
            base, _, effect = name.partition(" + ")
            model = make_model(base, **QUICK.get(base, {}))
            model = model + effect if effect else model
            for needed in make_effect(effect).metadata if effect else ():
                if needed not in tests:
                    tests[needed] = np.linspace(0.1, 1.0, len(tests))
            model.fit_frame(points, tests)
            known[name] = model, pack(model, folder / f"{len(known)}.fmu", nodes=3)
        return known[name]

    return get


@pytest.mark.parametrize("name", CASES)
def test_native_fmu_is_valid_and_agrees_with_onnx_runtime(name: str, made: Made) -> None:
    model, path = made(name)
    assert validate_fmu(str(path)) == []
    unpacked = UnpackedFmu.of(path)
    onnx = OnnxModel(unpacked.folder / "resources" / "model.onnx")
    points = random_loads(150, seed=8)
    lower, upper = np.array(model.domain.lower), np.array(model.domain.upper)
    points[:2] = lower, upper
    points[2:7] = np.where(np.eye(5, dtype=bool), lower, 0.5 * (lower + upper))
    points[7] = [0.0, 20.0, 0.0, 0.0, 1.0]
    points[8] = [q.upper for q in LOADS]
    inputs = [v.name for q in LOADS for v in unpacked.resolve(q.name)]
    for clamp in (True, False):
        if not clamp:
            points = np.clip(points, lower - 0.3 * (upper - lower), upper + 0.3 * (upper - lower))
            points = np.maximum(points, [q.lower for q in LOADS])
        mu, distance = np.empty(len(points)), np.empty(len(points))
        with RunningFmu(unpacked) as fmu:
            fmu.set({"clamp_to_domain": clamp})
            for i in range(0, len(points), 3):
                fmu.set_real(inputs, points[i : i + 3].T.ravel())
                mu[i : i + 3] = fmu.get_real([v.name for v in unpacked.resolve("mu")])
                distance[i : i + 3] = fmu.get_real([v.name for v in unpacked.resolve("domain_distance")])
        expected = onnx.predict(model.domain.clamp(points) if clamp else points)
        np.testing.assert_allclose(mu, expected, rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(distance, model.domain.distance(points), rtol=1e-13)
        assert (mu >= 0.0).all()


@pytest.mark.parametrize(
    "name", [n for n in NAMES if n.endswith(("work_exhaustion", "rate_state", "tool_roughness"))]
)
def test_memory_and_metadata_act_as_in_the_model(name: str, made: Made) -> None:
    model, path = made(name)
    points, _ = campaign()
    loads = TriboLoads.from_frame(points)
    if model.states:
        np.testing.assert_allclose(read_friction_fmu(path).predict(loads), model.predict(loads), rtol=1e-9)
    for variable in model.system_variables:
        unpacked = UnpackedFmu.of(path)
        onnx = OnnxModel(unpacked.folder / "resources" / "model.onnx")
        row = loads.as_array()[:1]
        with RunningFmu(unpacked) as fmu:
            fmu.set_real([f"{n}[2]" for n in LOAD_NAMES], row[0])
            for value in (variable.min, variable.max):
                fmu.set({variable.name: value})
                assert fmu.get_real(["mu[2]"]) == pytest.approx(onnx.predict(row, system=[value]), rel=1e-12)


@pytest.mark.parametrize("name", ["polynomial", "ffnn", "power_law", "linear + stribeck"])
def test_derivatives_are_those_of_the_value(name: str, made: Made) -> None:
    model, path = made(name)
    unpacked = UnpackedFmu.of(path)
    row = 0.6 * np.array(model.domain.lower) + 0.4 * np.array(model.domain.upper)
    names = [f"{n}[1]" for n in LOAD_NAMES]
    with RunningFmu(unpacked) as fmu:

        def mu_at(loads: np.ndarray) -> float:
            fmu.set_real(names, loads)
            return float(fmu.get_real(["mu[1]"])[0])

        for i in range(5):
            h = 1e-5 * np.where(np.arange(5) == i, np.maximum(row, 1.0), 0.0)
            central = (mu_at(row + h) - mu_at(row - h)) / (2.0 * h[i])
            mu_at(row)
            got = fmu.derivative(["mu[1]"], [names[i]], np.ones(1))[0]
            assert got == pytest.approx(central, rel=1e-6, abs=1e-9 / max(row[i], 1.0))
