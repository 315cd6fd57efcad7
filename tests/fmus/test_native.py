"""Behaviour of a native friction FMU: bad input, clamping, laziness, memory, state, reproducibility."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from ctypes import c_double, c_size_t, c_uint
from pathlib import Path

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu

from fmus import pack
from fmus.native import compile as compiling
from fmus.runtime.running import FmuError, RunningFmu, UnpackedFmu
from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES, LOADS
from tests.fmus.graphs import BOX, inside, random_loads, runtime

Pack = Callable[..., Path]
INSIDE = np.array([100.0, 100.0, 1000.0, 10.0, 2.0])


def law(T: float, sigma_n: float) -> float:
    return 0.15 - 1e-4 * T + 1e-5 * sigma_n


@pytest.mark.parametrize("target", ["native", "python"])
@pytest.mark.parametrize("nodes", [1, 4])
def test_fmpy_finds_no_problem(
    packed: Pack, linear_onnx: Path, memory_onnx: Path, target: str, nodes: int
) -> None:
    assert validate_fmu(str(packed(linear_onnx, target, nodes))) == []
    assert validate_fmu(str(packed(memory_onnx, target, nodes))) == []


@pytest.mark.parametrize("target", ["native", "python"])
def test_two_models_in_one_process_give_their_own_values(packed: Pack, target: str) -> None:
    with (
        RunningFmu(UnpackedFmu.of(packed(0.04, target))) as low,
        RunningFmu(UnpackedFmu.of(packed(0.12, target))) as high,
        RunningFmu(UnpackedFmu.of(packed(0.04, target))) as again,
    ):
        for _ in range(2):
            values = [float(f.get_real(["mu"])[0]) for f in (low, high, again)]
            assert values == [0.04, 0.12, 0.04]


@pytest.mark.parametrize("target", ["native", "python"])
@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -float("inf")])
def test_not_a_number_is_an_error_that_names_the_variable(
    packed: Pack, linear_onnx: Path, target: str, bad: float
) -> None:
    with RunningFmu(UnpackedFmu.of(packed(linear_onnx, target, 4))) as fmu:
        with pytest.raises(FmuError, match=r"sigma_n\[3\] = -?(nan|inf) is not a finite number"):
            fmu.set_real(["sigma_n[2]", "sigma_n[3]"], np.array([1000.0, bad]))
        assert np.isfinite(fmu.get_real(["mu[3]"])).all()


@pytest.mark.parametrize("target", ["native", "python"])
def test_outside_the_domain_is_clamped_or_extrapolated(packed: Pack, linear_onnx: Path, target: str) -> None:
    with RunningFmu(UnpackedFmu.of(packed(linear_onnx, target))) as fmu:
        fmu.set_real(LOAD_NAMES, INSIDE)
        assert fmu.get_boolean("in_domain")
        assert fmu.get_real(["mu", "domain_distance"]) == pytest.approx([law(100.0, 1000.0), 0.0])
        fmu.set({"T": 590.0})
        assert not fmu.get_boolean("in_domain")
        assert fmu.get_real(["mu", "domain_distance"]) == pytest.approx([law(400.0, 1000.0), 190.0 / 380.0])
        fmu.set({"clamp_to_domain": False})
        assert fmu.get_real(["mu"])[0] == pytest.approx(law(590.0, 1000.0))
        assert not fmu.get_boolean("in_domain")


@pytest.mark.parametrize("target", ["native", "python"])
def test_mu_is_never_negative(packed: Pack, linear_onnx: Path, target: str) -> None:
    with RunningFmu(UnpackedFmu.of(packed(linear_onnx, target))) as fmu:
        fmu.set({"clamp_to_domain": False, "T": 2000.0, "sigma_n": 0.0})
        assert law(2000.0, 0.0) < 0.0
        assert fmu.get_real(["mu"])[0] == 0.0


def test_unphysical_loads_are_moved_to_the_physical_limit(packed: Pack, linear_onnx: Path) -> None:
    with RunningFmu(UnpackedFmu.of(packed(linear_onnx))) as fmu:
        fmu.set({"clamp_to_domain": False, "T": 100.0, "sigma_n": -1.0})
        assert fmu.get_real(["mu"])[0] == pytest.approx(law(100.0, 0.0))


@pytest.mark.parametrize("target", ["native", "python"])
def test_a_point_out_of_contact_does_not_count_for_in_domain(
    packed: Pack, linear_onnx: Path, target: str
) -> None:
    with RunningFmu(UnpackedFmu.of(packed(linear_onnx, target, 4))) as fmu:
        for i in range(4):
            fmu.set_real([f"{n}[{i + 1}]" for n in LOAD_NAMES], INSIDE)
        fmu.set_real(["sigma_n[2]"], np.array([0.0]))
        assert fmu.get_boolean("in_domain")
        assert fmu.get_real(["domain_distance[2]"])[0] > 0.0
        fmu.set_real(["sigma_n[2]"], np.array([1.0]))
        assert not fmu.get_boolean("in_domain")


@pytest.mark.parametrize("target", ["native", "python"])
def test_nodes_are_evaluated_row_by_row(packed: Pack, linear_onnx: Path, target: str) -> None:
    loads = random_loads(4, seed=5)
    with RunningFmu(UnpackedFmu.of(packed(linear_onnx, target, 4))) as fmu:
        for q, column in zip(LOADS, loads.T):
            fmu.set_real([f"{q.name}[{i + 1}]" for i in range(4)], column)
        mu = fmu.get_real([f"mu[{i + 1}]" for i in range(4)])
    np.testing.assert_allclose(mu, runtime(linear_onnx.read_bytes(), inside(loads)), rtol=1e-12)


def test_start_values_are_inside_the_domain(packed: Pack, linear_onnx: Path) -> None:
    fmu = UnpackedFmu.of(packed(linear_onnx))
    for q in LOADS:
        variable = next(v for v in fmu.raw.modelVariables if v.name == q.name)
        low, high = BOX[q.name]
        assert low <= float(variable.start) <= high
        assert (float(variable.min), float(variable.max)) == (q.lower, q.upper)
        assert variable.unit == q.unit


@pytest.mark.parametrize("target", ["native", "python"])
def test_memory_advances_in_steps_only(packed: Pack, memory_onnx: Path, target: str) -> None:
    with RunningFmu(UnpackedFmu.of(packed(memory_onnx, target))) as fmu:
        fmu.set_real(LOAD_NAMES, INSIDE)
        for _ in range(3):
            assert fmu.get_real(["mu"])[0] == pytest.approx(0.05 + 0.01 + 0.1 * 0.2)
        fmu.step(0.0, 0.0)
        assert fmu.get_real(["work"])[0] == 1.0
        fmu.step(0.0, 0.5)
        assert fmu.get_real(["work", "mu"]) == pytest.approx([1.5, 0.05 + 0.015 + 0.02])
        fmu.set({"Ra": 1.0})
        assert fmu.get_real(["mu"])[0] == pytest.approx(0.05 + 0.015 + 0.1)
        # On the loads themselves, not on the clamped ones: 900 is beyond the domain's 500 mm/s.
        fmu.set({"v_rel": 900.0})
        fmu.step(0.5, 0.5)
        assert fmu.get_real(["work"])[0] == pytest.approx(1.5 + 4.5)
        fmu.set({"sigma_n": 0.0})
        fmu.step(1.0, 0.5)
        assert fmu.get_real(["work"])[0] == pytest.approx(6.0)


@pytest.mark.parametrize("target", ["native", "python"])
def test_state_comes_back_exactly_also_through_bytes(packed: Pack, memory_onnx: Path, target: str) -> None:
    unpacked = UnpackedFmu.of(packed(memory_onnx, target, 4))
    names = [f"work[{i + 1}]" for i in range(4)] + [f"mu[{i + 1}]" for i in range(4)]
    with RunningFmu(unpacked, start={"Ra": 0.7, "work[2]": 3.0}) as fmu, RunningFmu(unpacked) as other:
        fmu.set({"v_rel[1]": 333.0})
        fmu.step(0.0, 0.1)
        saved, at_save = fmu.save_state(), fmu.get_real(names)
        fmu.step(0.1, 0.3)
        later = fmu.get_real(names)
        assert (later[:4] > at_save[:4]).all()
        other.restore_state(other.deserialize(fmu.serialize(saved)))
        for instance in (fmu, other):
            instance.restore_state(saved) if instance is fmu else None
            assert np.array_equal(instance.get_real(names), at_save)
            instance.step(0.1, 0.3)
            assert np.array_equal(instance.get_real(names), later)


def test_state_of_another_fmu_is_refused(packed: Pack, linear_onnx: Path) -> None:
    with (
        RunningFmu(UnpackedFmu.of(packed(0.04))) as one,
        RunningFmu(UnpackedFmu.of(packed(linear_onnx))) as two,
    ):
        content = one.serialize(one.save_state())
        with pytest.raises(FmuError, match="does not belong to this FMU"):
            two.deserialize(content)


def test_calls_that_are_not_allowed_say_why(packed: Pack, memory_onnx: Path) -> None:
    with RunningFmu(UnpackedFmu.of(packed(memory_onnx))) as fmu:
        with pytest.raises(FmuError, match="output"):
            fmu.set({"mu": 0.1})
        with pytest.raises(FmuError, match="memory of a point"):
            fmu.set({"work": 0.1})
        with pytest.raises(FmuError, match="value reference 99"):
            fmu.call("GetReal", (c_uint * 1)(99), c_size_t(1), (c_double * 1)())
        with pytest.raises(FmuError, match="negative"):
            fmu.step(0.0, -0.1)
        fmu.call("Terminate")
        with pytest.raises(FmuError, match="terminated mode"):
            fmu.step(0.0, 0.1)


def test_model_exchange_has_no_lag_and_memory_is_not_offered(
    packed: Pack, linear_onnx: Path, memory_onnx: Path
) -> None:
    time = np.linspace(0.0, 1.0, 11)
    signal = np.zeros(11, dtype=[("time", "f8"), ("T", "f8")])
    signal["time"], signal["T"] = time, 50.0 + 100.0 * time
    path = packed(linear_onnx)
    result = simulate_fmu(
        str(path),
        fmi_type="ModelExchange",
        start_time=0.0,
        stop_time=1.0,
        output_interval=0.1,
        input=signal,
        start_values={"sigma_n": 1000.0},
        output=["mu", "T"],
    )
    np.testing.assert_allclose(result["mu"], law(result["T"], 1000.0), rtol=1e-12)
    assert UnpackedFmu.of(packed(memory_onnx)).raw.modelExchange is None


@pytest.mark.usefixtures("built_anew")
def test_same_model_gives_the_same_bytes(linear_onnx: Path, tmp_path: Path) -> None:
    first = pack(linear_onnx, tmp_path / "a.fmu")
    second = pack(linear_onnx, tmp_path / "sub" / "b.fmu")
    assert first.read_bytes() == second.read_bytes()
    other = pack(linear_onnx, tmp_path / "c.fmu", nodes=2)
    assert UnpackedFmu.of(other).raw.guid != UnpackedFmu.of(first).raw.guid


def test_what_the_archive_carries(packed: Pack, linear_onnx: Path) -> None:
    with zipfile.ZipFile(packed(linear_onnx)) as archive:
        names = set(archive.namelist())
        assert archive.read("resources/model.onnx") == linear_onnx.read_bytes()
        assert "MAE" in archive.read("documentation/index.html").decode()
        binary = next(n for n in names if n.startswith("binaries/"))
        assert archive.getinfo(binary).file_size < 150_000
    assert {
        "sources/fmi2.c",
        "sources/model.h",
        "sources/instance.h",
        "documentation/card.json",
    } <= names


def test_windows_and_the_system_compiler(
    linear_onnx: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    both = UnpackedFmu.of(pack(linear_onnx, tmp_path / "system.fmu"))
    monkeypatch.setattr(compiling, "zig_command", lambda: None)
    with pytest.raises(InputError, match=r"platform 'win64' needs the Zig compiler"):
        pack(linear_onnx, tmp_path / "w.fmu", platforms=["linux64", "win64"])
    if compiling.system_command() is not None:
        system = UnpackedFmu.of(pack(linear_onnx, tmp_path / "system.fmu"))
        assert system.raw.guid == both.raw.guid
        with RunningFmu(system) as fmu:
            fmu.set_real(LOAD_NAMES, INSIDE)
            assert fmu.get_real(["mu"])[0] == pytest.approx(law(100.0, 1000.0))
    monkeypatch.setattr(compiling, "system_command", lambda: None)
    with pytest.raises(InputError, match="no C compiler"):
        pack(linear_onnx, tmp_path / "n.fmu")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"target": "nativ"}, "did you mean 'native'"),
        ({"fmi": "4.0"}, "unknown FMI version '4.0'"),
        ({"nodes": 0}, "nodes = 0, allowed"),
        ({"nodes": 1.5}, "nodes = 1.5, allowed"),
        ({"platforms": ["linx64"]}, "did you mean 'linux64'"),
        ({"platforms": ["linux64"], "target": "python"}, "--target native only"),
    ],
)
def test_bad_arguments(arguments: dict[str, object], words: str, linear_onnx: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=words):
        pack(linear_onnx, tmp_path / "m.fmu", **arguments)  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []
