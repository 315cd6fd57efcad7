"""Export as C, compiled, run and compared with the FMU of the same model; the folder of every export."""

from __future__ import annotations

import ctypes
import re
from pathlib import Path

import numpy as np
import pytest

from fmus.exports import TARGETS, export
from fmus.exports.numbers.table_target import tabulate
from fmus.runtime.running import RunningFmu
from fmus.source.reading import read_source
from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES, LOADS
from tests.fmus.exported import (
    NAMES,
    Compiled,
    as_c,
    c_compiler,
    deviation,
    fmu_at,
    made,
    run,
    selftest,
)
from tests.fmus.graphs import graph_bytes, node, random_loads, save


@pytest.mark.parametrize("name", NAMES)
def test_c_computes_what_the_fmu_computes(name: str, tmp_path: Path) -> None:
    model = made(name)
    folder = export(model.source, tmp_path / "c", "c")
    code = Compiled(folder)
    loads = random_loads(40, seed=3)
    loads[:2], loads[2] = (model.lower, model.upper), [q.upper for q in LOADS]
    near = np.clip(loads, model.lower - 1.0, model.upper + 1.0).clip([q.lower for q in LOADS])
    with RunningFmu(model.fmu) as fmu:
        mu = fmu_at(fmu, loads)
        distance = fmu_at(fmu, loads, "domain_distance")
        gradient = np.empty((len(near), 5))
        for i, row in enumerate(near):
            fmu.set_real(LOAD_NAMES, row)
            for k in range(5):
                gradient[i, k] = fmu.derivative(["mu"], [LOAD_NAMES[k]], np.ones(1))[0]
        fmu.set({"clamp_to_domain": False})
        free = fmu_at(fmu, near)
    many = np.empty(len(loads))
    assert code("mu_many")(ctypes.c_size_t(len(loads)), as_c(loads.T.copy()), None, None, 1, as_c(many)) == 0
    for i, row in enumerate(loads):
        result, value = code.mu(row)
        assert result == 0
        assert value == many[i]  # one point and a block of points give the same bits
        assert code("domain_distance")(as_c(row), None) == pytest.approx(distance[i], rel=1e-14)
        assert code.mu(near[i], clamp=0) == (0, pytest.approx(free[i], rel=1e-13, abs=1e-15))
        out, slope = ctypes.c_double(), np.empty(5)
        assert code("mu_gradient")(as_c(near[i]), None, None, 1, ctypes.byref(out), as_c(slope)) == 0
        np.testing.assert_allclose(slope, gradient[i], rtol=1e-11, atol=1e-18)
    np.testing.assert_allclose(many, mu, rtol=1e-13, atol=1e-16)
    assert deviation(selftest(folder)) < 1e-12


def test_c_memory_system_variables_and_refusals(tmp_path: Path) -> None:
    model = made("linear + work_exhaustion")
    code = Compiled(export(model.source, tmp_path / "memory", "c"))
    loads = random_loads(12, seed=4)
    loads[5, 2] = 0.0  # no contact: the memory stays
    state = np.array([s.start for s in model.source.states])
    with RunningFmu(model.fmu) as fmu:
        for k, row in enumerate(loads):
            fmu.set_real(LOAD_NAMES, row)
            fmu.step(0.01 * k, 0.01)
            before = state.copy()
            assert code("step")(as_c(row), None, ctypes.c_double(0.01), as_c(state)) == 0
            assert k not in (0, 1, 5) or np.array_equal(before, state) == (k == 5)
            np.testing.assert_allclose(state, fmu.get_real([s.name for s in model.source.states]), rtol=1e-13)
            assert code.mu(row, state) == (0, pytest.approx(fmu.get_real(["mu"])[0], rel=1e-13))
    kept = state.copy()
    assert code("step")(as_c(loads[0]), None, ctypes.c_double(-0.1), as_c(state)) == 1
    assert code("step")(as_c(np.full(5, np.nan)), None, ctypes.c_double(0.1), as_c(state)) == 1
    assert np.array_equal(kept, state)
    for k, bad in ((0, np.nan), (3, np.inf), (4, -np.inf)):
        row = loads[0].copy()
        row[k] = bad
        assert code.mu(row) == (1, 0.0)
        pair = np.stack([loads[0], row, loads[0]]).T.copy()
        mu = np.empty(3)
        assert code("mu_many")(ctypes.c_size_t(3), as_c(pair), None, None, 1, as_c(mu)) == 1
        assert mu[1] == 0.0 and mu[0] == mu[2] == code.mu(loads[0])[1] > 0.0

    rough = made("linear + tool_roughness")
    code = Compiled(export(rough.source, tmp_path / "rough", "c"))
    (variable,) = rough.source.system
    seen = []
    with RunningFmu(rough.fmu) as fmu:
        for value in (0.1, 0.9):
            fmu.set({variable.name: value})
            expected = fmu_at(fmu, loads[:1])[0]
            assert code.mu(loads[0], system=np.array([value])) == (0, pytest.approx(expected, rel=1e-13))
            seen.append(expected)
    assert seen[0] != seen[1]


def test_header_is_good_for_cpp_and_a_wrong_source_fails_its_self_test(tmp_path: Path) -> None:
    folder = export(made("polynomial").source, tmp_path / "c", "c", name="Mine")
    assert (folder / "Mine_friction.h").is_file()
    (folder / "use.cpp").write_text(
        '#include "Mine_friction.h"\nint main() { return MINE_FRICTION_LOADS - 5; }\n'
    )
    run(
        [
            *c_compiler(),
            "-x",
            "c++",
            "-Wall",
            "-Wextra",
            "-pedantic",
            "-Werror",
            "-c",
            "use.cpp",
            "-o",
            "use.o",
        ],
        folder,
    )
    source = folder / "Mine_friction.c"
    text = source.read_text()
    source.write_text(
        text.replace(
            "tf_model_mu(inside, state, system, mu);",
            "tf_model_mu(inside, state, system, mu);\n    *mu *= 1.0 + 1e-9;",
        )
    )
    assert source.read_text() != text
    with pytest.raises(AssertionError, match="expected"):
        selftest(folder)


def test_a_graph_without_domain_extrapolates_and_needs_limits_for_a_table(tmp_path: Path) -> None:
    """mu = 0.15 - 1e-4 T + 1e-5 sigma_n, no metadata."""
    weights = {"w": np.array([[0.0], [-1e-4], [1e-5], [0.0], [0.0]]), "b": np.array([0.15])}
    path = save(graph_bytes([node("Gemm", "loads w b", "mu")], weights), tmp_path / "line.onnx")
    source = read_source(path)
    folder = export(source, tmp_path / "c", "c")
    assert deviation(selftest(folder)) < 1e-12
    code = Compiled(folder)
    row = np.array([1e4, 500.0, 9000.0, 1e3, 100.0])
    assert code.mu(row) == (0, pytest.approx(0.15 - 0.05 + 0.09))
    assert code("domain_distance")(as_c(row), None) == 0.0
    row[1], row[2] = 2000.0, 0.0
    assert code.mu(row) == (0, 0.0)  # -0.05, and mu is never negative
    row[2] = -5.0  # moved to the physical limit
    row[1] = 100.0
    assert code.mu(row) == (0, pytest.approx(0.14))
    with pytest.raises(InputError, match="no trained range of 'T' is recorded; allowed: give it as limits"):
        export(source, tmp_path / "t", "table", axes=["T", "sigma_n"])
    table = tabulate(source, axes=["T", "sigma_n"], limits={"T": (20.0, 200.0), "sigma_n": (0.0, 1000.0)})
    np.testing.assert_allclose(table.mu, [[0.148, 0.158], [0.13, 0.14]], rtol=1e-12)


@pytest.mark.parametrize("target", TARGETS)
def test_folder_is_complete_reproducible_and_replaces_its_own_kind_only(target: str, tmp_path: Path) -> None:
    source = made("polynomial").source
    first = export(source, tmp_path / "a", target)
    second = export(source, tmp_path / "sub" / "b", target)
    names = sorted(str(p.relative_to(first)) for p in first.rglob("*") if p.is_file())
    assert {"README.txt", "LICENSE.txt", "card.json", "model.onnx", "export.json"} <= set(names)
    for name in names:
        assert (first / name).read_bytes() == (second / name).read_bytes()
    assert (first / "model.onnx").read_bytes() == source.onnx
    for p in first.rglob("*"):
        if p.is_file() and p.name not in {"model.onnx", "LICENSE.txt"}:
            assert not re.search(r"@[A-Z_0-9]+@", p.read_text()), p
    (first / "mine.txt").write_text("a folder with other files in it is refused")
    with pytest.raises(InputError, match=r"mine\.txt"):
        export(source, first, target)
    (first / "mine.txt").unlink()
    export(source, first, target)
    assert (first / "export.json").is_file()
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.tex").write_text("...")
    with pytest.raises(InputError, match="holds other files"):
        export(source, tmp_path / "full", target)
    assert (tmp_path / "full" / "thesis.tex").read_text() == "..."


def test_bad_targets_names_and_paths(tmp_path: Path) -> None:
    source = made("constant").source
    with pytest.raises(InputError, match="did you mean 'ufric'"):
        export(source, tmp_path / "x", "ufrik")
    for name in ("2mu", "a b", "x" * 25, "", 'a"'):
        with pytest.raises(InputError, match="letters, digits and underscores"):
            export(source, tmp_path / "x", "c", name=name)
    with pytest.raises(InputError, match="option of the target 'c'"):
        export(source, tmp_path / "x", "c", tolerance=1.0)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="is a file; allowed: a new or empty folder"):
        export(source, tmp_path / "file", "c")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file"]
