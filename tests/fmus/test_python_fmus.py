"""What PythonFMU would get wrong by itself: names, references, states; the solvers as slaves."""

from __future__ import annotations

import gc
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from fmpy.validation import validate_fmu

from fmus import check, pack, pack_forming, pack_twin
from fmus.runtime.running import FmuError, RunningFmu, UnpackedFmu
from forming import PROCESSES
from friction_models import ConstantFriction, LinearFriction
from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES

Pack = Callable[..., Path]
N = 40


def test_many_instances_and_refused_calls_leave_the_interpreter_whole(packed: Pack) -> None:
    unpacked = UnpackedFmu.of(packed(0.07, "python"))
    path_before = list(sys.path)
    for k in range(20):  # with PythonFMU alone the second refused call ends the process
        with RunningFmu(unpacked) as fmu:
            with pytest.raises(FmuError):
                fmu.set({"T": float("nan")})
            assert fmu.get_real(["mu"])[0] == 0.07
        if k % 10 == 9:
            gc.collect()
    assert sys.path == path_before


def test_packing_still_works_after_a_python_fmu_ran(packed: Pack, tmp_path: Path) -> None:
    with RunningFmu(UnpackedFmu.of(packed(0.07, "python"))):
        path = pack(ConstantFriction(0.09), tmp_path / "later.fmu", target="python")
    with RunningFmu(UnpackedFmu.of(path)) as fmu:
        assert fmu.get_real(["mu"])[0] == 0.09


def test_same_model_gives_the_same_bytes(tmp_path: Path) -> None:
    paths = [pack(ConstantFriction(0.09), tmp_path / n, target="python") for n in ("a.fmu", "b.fmu")]
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_a_load_that_was_not_measured_cannot_leave_the_domain(tmp_path: Path) -> None:
    speeds = np.repeat(np.linspace(5.0, 200.0, 8), 5)
    points = pd.DataFrame(
        {"test_id": [f"t{v:.0f}" for v in speeds], "v_rel": speeds, "mu": 0.1 - 1e-4 * speeds}
    )
    model = LinearFriction().fit_frame(points)
    for target in ("python", "native"):
        path = pack(model, tmp_path / f"{target}.fmu", target=target)
        with RunningFmu(UnpackedFmu.of(path)) as fmu:
            fmu.set({"psi": 1e4, "v_rel": 50.0, "sigma_n": 900.0})
            assert fmu.get_boolean("in_domain") and fmu.get_real(["domain_distance"])[0] == 0.0
            fmu.set({"v_rel": 395.0})
            assert not fmu.get_boolean("in_domain") and fmu.get_real(["domain_distance"])[0] == 1.0
        assert check(path).ok


@pytest.fixture(scope="module")
def forming(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pack_forming(tmp_path_factory.mktemp("forming") / "fre.fmu", n_points=N, mesh_size=0.6)


@pytest.fixture(scope="module")
def twin(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pack_twin(tmp_path_factory.mktemp("twin") / "twin.fmu")


def test_solver_fmus_are_valid_and_publish_without_direct_dependence(forming: Path, twin: Path) -> None:
    for path in (forming, twin):
        assert validate_fmu(str(path)) == []
        fmu = UnpackedFmu.of(path)
        assert all(list(o.dependencies) == [] for o in fmu.raw.outputs)
        assert fmu.raw.coSimulation.canGetAndSetFMUstate
    fmu = UnpackedFmu.of(forming)
    assert fmu.resolve("force")[0].unit == "kN"
    assert fmu.variables["half_angle"].causality == "parameter"
    assert len([v.name for v in fmu.resolve("mu")]) == len([v.name for v in fmu.resolve("active")]) == N


def test_places_of_the_markers_are_numbered_after_all_that_was_there_before(forming: Path) -> None:
    variables = UnpackedFmu.of(forming).raw.modelVariables
    assert [v.valueReference for v in variables] == list(range(len(variables)))
    # Five loads and mu at the markers, four numbers of the punch, the parameters, a flag a marker, as ever.
    assert [v.name for v in variables[5 * N : 5 * N + 5]] == [
        "stroke",
        "force",
        "work",
        "max_tau_over_k",
        "mu[1]",
    ]
    names = [v.name for v in variables[-3 * N :]]
    assert names == [f"{name}[{i + 1}]" for name in ("active", "r", "z") for i in range(N)]
    assert {v.unit for v in variables[-2 * N :]} == {"mm"}
    assert "magnitude, never negative" in variables[0].description
    assert all(v.description for v in variables)


def test_forming_fmu_is_the_solver(forming: Path) -> None:
    from forming.processes.forward_rod_extrusion import ForwardRodExtrusion

    process = ForwardRodExtrusion(n_points=N, mesh_size=0.6, half_angle=50.0)
    process.start()
    unpacked = UnpackedFmu.of(forming)
    mu, force = [v.name for v in unpacked.resolve("mu")], ["force", "stroke", "work"]
    with RunningFmu(unpacked, start={"half_angle": 50.0}) as fmu:
        fmu.step(0.0, 0.0)  # zero-length steps move nothing
        assert fmu.get_real(["stroke"])[0] == 0.0
        for k in range(6):
            given = np.full(N, 0.05 + 0.01 * k)
            fmu.set_real(mu, given)
            fmu.step(0.02 * k, 0.02)
            process.set_mu(given)
            process.advance(5.0 * 0.02 * (k + 1) - process.stroke)
            assert fmu.get_real(force) == pytest.approx(
                [process.force, process.stroke, process.work], rel=1e-9
            )
        places = [fmu.get_real([v.name for v in unpacked.resolve(n)]) for n in ("r", "z")]
        np.testing.assert_allclose(np.array(places).T, process.marker_position, atol=1e-9)
        active = process.active
        assert 0 < active.sum() < N
        loads = np.array([fmu.get_real([v.name for v in unpacked.resolve(n)]) for n in LOAD_NAMES]).T
        np.testing.assert_allclose(loads[active], process.loads()[active], rtol=1e-9, atol=1e-12)
        assert (loads[~active, 2] == 0.0).all()  # no contact, no pressure: friction keeps its memory
        with pytest.raises(FmuError, match="half_angle cannot be set after initialization"):
            fmu.set({"half_angle": 30.0})
        with pytest.raises(FmuError, match=r"mu = -0\.5 at marker 0"):
            fmu.set({"mu[1]": -0.5})
            fmu.step(0.12, 0.02)


@pytest.mark.parametrize(
    ("process", "start"),
    [
        ("fre", {"relief": 0.6, "container_length": 40.0, "press_stiffness": 400.0, "tool_modulus": 600.0}),
        pytest.param(
            "bce",
            {"nose_angle": 10.0, "tip_radius": 3.0, "relief": 0.4, "die_outer_diameter": 60.0},
            marks=pytest.mark.nightly,
        ),
        pytest.param(
            "upsetting",
            {"height": 10.0, "mesh_size": 1.25, "shear_factor": 0.5},
            marks=pytest.mark.nightly,
        ),
        ("ring", {"bore_diameter": 5.0, "h_ambient": 0.0}),
    ],
)
def test_every_process_is_an_fmu_with_its_numbers_as_parameters(
    process: str, start: dict[str, float], tmp_path: Path
) -> None:
    options: dict[str, Any] = {"n_points": 12, "mesh_size": 0.8 if process in {"fre", "bce"} else None}
    path = pack_forming(tmp_path / "x.fmu", process=process, **options)
    assert validate_fmu(str(path)) == []
    kind: Any = PROCESSES[process]
    direct = kind(**options | start)
    direct.start(0.08)
    unpacked = UnpackedFmu.of(path)
    mu = [v.name for v in unpacked.resolve("mu")]
    assert {v.unit for v in unpacked.variables.values() if v.causality == "parameter"} >= {"mm", "kW/(m2 K)"}
    assert "Punch speed [mm/s]." in str({v.name: v.description for v in unpacked.raw.modelVariables}["speed"])
    with RunningFmu(unpacked, start=start) as fmu:
        for k in range(4):
            fmu.set_real(mu, np.full(12, 0.08))
            fmu.step(0.02 * k, 0.02)
            direct.set_mu(0.08)
            direct.advance(5.0 * (0.02 * k + 0.02) - direct.stroke)
            assert fmu.get_real(["force", "work"]).tolist() == [direct.force, direct.work]
        assert direct.force > 5.0  # elements four times smaller find 9.5


def test_forming_fmu_goes_back_exactly(forming: Path) -> None:
    unpacked = UnpackedFmu.of(forming)
    outputs = [v.name for name in (*LOAD_NAMES, "force", "work") for v in unpacked.resolve(name)]
    with RunningFmu(unpacked) as fmu:
        fmu.step(0.0, 0.02)
        state, seen = fmu.save_state(), []
        for friction in (0.05, 0.15, 0.05):
            fmu.restore_state(state)
            fmu.set_real([v.name for v in unpacked.resolve("mu")], np.full(N, friction))
            fmu.step(0.02, 0.02)
            fmu.step(0.04, 0.02)
            seen.append(fmu.get_real(outputs))
        assert np.array_equal(seen[0], seen[2])
        assert not np.array_equal(seen[0], seen[1])


def test_twin_fmu_is_the_process(twin: Path) -> None:
    from sct_twin.twin.process import SctProcess

    process = SctProcess(T_tool=100.0)
    expected = process.advance(0.0, 200e3, 100.0, 100.0, 0.1)
    start = {"F_n": 200e3, "v_slide": 100.0, "T_tool": 100.0, "mu": 0.1}
    with RunningFmu(UnpackedFmu.of(twin), start=start) as fmu:
        np.testing.assert_allclose(fmu.get_real(LOAD_NAMES), expected, rtol=1e-12)
        for k in range(5):
            fmu.step(0.01 * k, 0.01)
            expected = process.advance(0.01, 200e3, 100.0, 100.0, 0.1)
            np.testing.assert_allclose(fmu.get_real(LOAD_NAMES), expected, rtol=1e-12)
        assert expected.sd == pytest.approx(5.0)
        assert expected.T > 100.0
        with pytest.raises(FmuError, match=r"F_n = -1\.0"):
            fmu.set({"F_n": -1.0})
            fmu.step(0.05, 0.01)


@pytest.mark.parametrize(
    ("packer", "arguments", "words"),
    [
        (pack_forming, {"halfangle": 40.0}, "did you mean 'half_angle'"),
        (pack_forming, {"half_angle": 4.0}, "half_angle = 4.0 degrees; allowed"),
        (pack_forming, {"stroke": 500.0}, "stroke = 500.0 mm"),
        (
            pack_forming,
            {"process": "ring", "diameter": "wide"},
            "ring compression: diameter = 'wide' mm; allowed",
        ),
        (pack_forming, {"process": "ring", "bore_diameter": 0.0}, "bore_diameter = 0.0 mm; allowed: 0.6 to"),
        (pack_twin, {"bor": 4.0}, "did you mean 'bore'"),
        (pack_twin, {"bore": -1.0}, "bore_diameter = -1.0 mm"),
        (pack_twin, {"F_max": "much"}, "F_max = 'much', allowed: a number"),
    ],
)
def test_bad_solver_parameters(
    packer: Callable[..., Path], arguments: dict[str, object], words: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=words):
        packer(tmp_path / "x.fmu", **arguments)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("installed", [True, False])
def test_pythonfmu_is_the_installed_one_or_the_one_in_the_fmu(packed: Pack, installed: bool) -> None:
    """A copy that comes with an FMU must not stand in for the installed package in the rest of the process."""
    code = f"""
import sys
from importlib.machinery import PathFinder
if not {installed}:
    class Hidden:
        def find_spec(self, name, path=None, target=None):
            if name == "pythonfmu":
                spec = PathFinder.find_spec(name, [p for p in sys.path if "fallback" in p])
                if spec is None:
                    raise ModuleNotFoundError(name, name=name)
                return spec
    sys.meta_path.insert(0, Hidden())
from fmus.runtime.running import RunningFmu, UnpackedFmu
with RunningFmu(UnpackedFmu.of({str(packed(0.07, "python"))!r})) as fmu:
    assert fmu.get_real(["mu"])[0] == 0.07
import pythonfmu
print(pythonfmu.__file__)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert ("fallback" not in done.stdout) is installed
