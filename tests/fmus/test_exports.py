"""Exports for codes that load no FMUs: each is compiled, run and compared with the FMU of the same model."""

from __future__ import annotations

import ctypes
import json
import re
import shutil
import subprocess
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

from fmus import pack
from fmus.exports import export
from fmus.exports.table_target import tabulate
from fmus.native import compile as compiling
from fmus.running import RunningFmu, UnpackedFmu
from fmus.source import read_source
from friction_models.loads import LOAD_NAMES, LOADS, InputError
from friction_models.registry import make_model
from tests.fmus.graphs import Array, campaign, graph_bytes, node, random_loads, save

NAMES = [
    "constant",
    "polynomial",
    "ffnn",
    "gradient_boosting",
    "linear + work_exhaustion",
    "linear + tool_roughness",
]
QUICK = {"ffnn": {"hidden": (8, 8), "members": 1, "epochs": 4}, "gradient_boosting": {}}
STRICT = ["-std=c99", "-O1", "-ffp-contract=off", "-Wall", "-Wextra", "-Wshadow", "-pedantic", "-Werror"]
#: Every argument list is the host's; a subroutine need not use all of it.
FORTRAN = ["-O1", "-Wall", "-Werror", "-Wno-unused-dummy-argument"]
PROGRAM_LINE = re.compile(r"ok: .*largest deviation.* ([0-9.]+E?e?[-+]?\d*)")


class Made:
    """A saved model and its FMU."""

    def __init__(self, name: str, folder: Path) -> None:
        base, _, effect = name.partition(" + ")
        model = make_model(base, **QUICK.get(base, {}))
        model = model + effect if effect else model
        points, tests = campaign()
        model.fit_frame(points, tests)
        model.save(folder / "model")
        self.source = read_source(folder / "model")
        self.fmu = UnpackedFmu(pack(folder / "model", folder / "m.fmu"))
        self.lower, self.upper = (np.array(x) for x in (model.domain.lower, model.domain.upper))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Made]:
    known: dict[str, Made] = {}

    def get(name: str) -> Made:
        if name not in known:
            known[name] = Made(name, tmp_path_factory.mktemp("export"))
        return known[name]

    return get


def c_compiler() -> list[str]:
    command = compiling.system_command() or compiling.zig_command()
    if command is None:
        pytest.skip("no C compiler: neither Zig nor cc, gcc or clang")
    return command


def run(command: list[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def deviation(output: str) -> float:
    found = PROGRAM_LINE.search(output)
    assert found, output
    return float(found[1])


def fmu_at(fmu: RunningFmu, loads: Array, what: str = "mu") -> Array:
    values = np.empty(len(loads))
    for i, row in enumerate(loads):
        fmu.set_real(LOAD_NAMES, row)
        values[i] = fmu.get_real([what])[0]
    return values


# --- C ---


class Compiled:
    """A C export as a shared library."""

    def __init__(self, folder: Path) -> None:
        source = next(folder.glob("*friction.c"))
        self.prefix = source.stem
        run([*c_compiler(), *STRICT, "-shared", "-fPIC", source.name, "-o", "export.so", "-lm"], folder)
        self.library = ctypes.CDLL(str(folder / "export.so"))
        self("domain_distance").restype = ctypes.c_double
        self("mu_many").restype = ctypes.c_size_t

    def __call__(self, name: str):  # type: ignore[no-untyped-def]
        return getattr(self.library, f"{self.prefix}_{name}")

    def mu(
        self, row: Array, state: Array | None = None, system: Array | None = None, clamp: int = 1
    ) -> tuple[int, float]:
        out = ctypes.c_double(-1.0)
        return self("mu")(_array(row), _array(state), _array(system), clamp, ctypes.byref(out)), out.value


def _array(values: Array | None):  # type: ignore[no-untyped-def]
    return (
        None
        if values is None
        else np.ascontiguousarray(values).ctypes.data_as(ctypes.POINTER(ctypes.c_double))
    )


@pytest.mark.parametrize("name", NAMES)
def test_c_computes_what_the_fmu_computes(name: str, made: Callable[[str], Made], tmp_path: Path) -> None:
    model = made(name)
    folder = export(model.source, tmp_path / "c", "c")
    code = Compiled(folder)
    loads = random_loads(40, seed=3)
    loads[:2], loads[2] = (model.lower, model.upper), [q.upper for q in LOADS]
    near = np.clip(loads, model.lower - 1.0, model.upper + 1.0).clip([q.lower for q in LOADS])
    references = [model.fmu.variables[n].valueReference for n in ("mu", *LOAD_NAMES)]
    with RunningFmu(model.fmu) as fmu:
        mu = fmu_at(fmu, loads)
        distance = fmu_at(fmu, loads, "domain_distance")
        gradient = np.empty((len(near), 5))
        for i, row in enumerate(near):
            fmu.set_real(LOAD_NAMES, row)
            for k in range(5):
                gradient[i, k] = fmu.slave.getDirectionalDerivative(
                    references[:1], [references[1 + k]], [1.0]
                )[0]
        fmu.set({"clamp_to_domain": False})
        free = fmu_at(fmu, near)
    many = np.empty(len(loads))
    assert (
        code("mu_many")(ctypes.c_size_t(len(loads)), _array(loads.T.copy()), None, None, 1, _array(many)) == 0
    )
    for i, row in enumerate(loads):
        result, value = code.mu(row)
        assert result == 0
        assert value == many[i]  # one point and a block of points give the same bits
        assert code("domain_distance")(_array(row), None) == pytest.approx(distance[i], rel=1e-14)
        assert code.mu(near[i], clamp=0) == (0, pytest.approx(free[i], rel=1e-13, abs=1e-15))
        out, slope = ctypes.c_double(), np.empty(5)
        assert code("mu_gradient")(_array(near[i]), None, None, 1, ctypes.byref(out), _array(slope)) == 0
        np.testing.assert_allclose(slope, gradient[i], rtol=1e-11, atol=1e-18)
    np.testing.assert_allclose(many, mu, rtol=1e-13, atol=1e-16)
    assert deviation(selftest(folder)) < 1e-12


def selftest(folder: Path) -> str:
    source = next(folder.glob("*friction.c")).name
    run([*c_compiler(), *STRICT, "selftest.c", source, "-o", "selftest", "-lm"], folder)
    return run(["./selftest"], folder)


def test_c_memory_system_variables_and_refusals(made: Callable[[str], Made], tmp_path: Path) -> None:
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
            assert code("step")(_array(row), None, ctypes.c_double(0.01), _array(state)) == 0
            assert k not in (0, 1, 5) or np.array_equal(before, state) == (k == 5)
            np.testing.assert_allclose(state, fmu.get_real([s.name for s in model.source.states]), rtol=1e-13)
            assert code.mu(row, state) == (0, pytest.approx(fmu.get_real(["mu"])[0], rel=1e-13))
    kept = state.copy()
    assert code("step")(_array(loads[0]), None, ctypes.c_double(-0.1), _array(state)) == 1
    assert code("step")(_array(np.full(5, np.nan)), None, ctypes.c_double(0.1), _array(state)) == 1
    assert np.array_equal(kept, state)
    for k, bad in ((0, np.nan), (3, np.inf), (4, -np.inf)):
        row = loads[0].copy()
        row[k] = bad
        assert code.mu(row) == (1, 0.0)
        pair = np.stack([loads[0], row, loads[0]]).T.copy()
        mu = np.empty(3)
        assert code("mu_many")(ctypes.c_size_t(3), _array(pair), None, None, 1, _array(mu)) == 1
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


def test_header_is_good_for_cpp_and_a_wrong_source_fails_its_self_test(
    made: Callable[[str], Made], tmp_path: Path
) -> None:
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
    assert code("domain_distance")(_array(row), None) == 0.0
    row[1], row[2] = 2000.0, 0.0
    assert code.mu(row) == (0, 0.0)  # -0.05, and mu is never negative
    row[2] = -5.0  # moved to the physical limit
    row[1] = 100.0
    assert code.mu(row) == (0, pytest.approx(0.14))
    with pytest.raises(InputError, match="no trained range of 'T' is recorded; allowed: give it as limits"):
        export(source, tmp_path / "t", "table", axes=["T", "sigma_n"])
    table = tabulate(source, axes=["T", "sigma_n"], limits={"T": (20.0, 200.0), "sigma_n": (0.0, 1000.0)})
    np.testing.assert_allclose(table.mu, [[0.148, 0.158], [0.13, 0.14]], rtol=1e-12)


# --- Fortran ---


def build_fortran(folder: Path, parts: list[str], *flags: str) -> None:
    fortran = shutil.which("gfortran")
    if fortran is None:
        pytest.skip("gfortran is not installed: the Fortran of this export is not compiled and not run")
    source = next(folder.glob("*friction.c"))
    run([*c_compiler(), *STRICT, "-c", source.name, "-o", "model.o"], folder)
    run([fortran, *FORTRAN, *flags, *parts, "model.o", "-o", "driver", "-lm"], folder)


@pytest.mark.parametrize("name", NAMES)
def test_ufric_follows_the_fmu_through_iterations_and_cutbacks(
    name: str, made: Callable[[str], Made], tmp_path: Path
) -> None:
    model = made(name)
    folder = export(model.source, tmp_path / "ufric", "ufric")
    assert max(map(len, (folder / "ufric.f").read_text().splitlines())) <= 72
    build_fortran(folder, ["ufric.f", "selftest.f90"])
    assert deviation(run(["./driver"], folder)) < 1e-12
    rng = np.random.default_rng(6)
    rows, time = [], 0.0
    nodes = {17: 0.0, 400_001: 0.0, 23: 0.0}  # sliding distance of each
    with RunningFmu(model.fmu) as a, RunningFmu(model.fmu) as b, RunningFmu(model.fmu) as c:
        fmus = dict(zip(nodes, (a, b, c)))
        for inc in range(1, 9):
            dt = float(rng.uniform(0.002, 0.01))
            lengths = [3.0 * dt, dt, dt] if inc == 5 else [dt, dt]
            for attempt, length in enumerate(lengths):
                for number in nodes:
                    if number == 23 and inc in (4, 5):
                        continue  # out of contact
                    v = rng.uniform(-300.0, 300.0, 2)
                    T, sigma = rng.uniform(20.0, 350.0), rng.uniform(200.0, 3000.0)
                    mu = -1.0
                    if attempt == len(lengths) - 1:
                        speed = float(np.hypot(*v))
                        nodes[number] += speed * dt
                        fmus[number].set_real(LOAD_NAMES, np.array([speed, T, sigma, nodes[number], 1.0]))
                        fmus[number].step(time, dt)
                        mu = fmus[number].get_real(["mu"])[0]
                    values = (time + length, 0.0, 0.0, *v, T, sigma, mu)
                    rows.append(f"{number} {inc} " + " ".join(repr(float(x)) for x in values))
            time += dt
    (folder / "fmu.txt").write_text("\n".join(rows) + "\n")
    assert deviation(run(["./driver", "fmu.txt"], folder)) < 1e-12


def test_ufric_keeps_many_points_apart_and_survives_bad_loads(
    made: Callable[[str], Made], tmp_path: Path
) -> None:
    model = made("linear + work_exhaustion")
    folder = export(model.source, tmp_path / "ufric", "ufric")
    build_fortran(folder, ["ufric.f", "selftest.f90"], "-fcheck=all")
    loads = np.array([100.0, 80.0, 1000.0, 0.0, 1.0])
    rows, many = [], range(1, 40_000, 13)
    with RunningFmu(model.fmu) as fmu:
        mu = []
        for inc in (1, 2, 3):
            loads[3] += 0.5  # 100 mm/s for 5 ms
            fmu.set_real(LOAD_NAMES, loads)
            fmu.step(0.005 * (inc - 1), 0.005)
            mu.append(float(fmu.get_real(["mu"])[0]))
    assert len(set(mu)) == 3
    for inc in (1, 2, 3):
        for number in many:
            rows.append(f"{number} {inc} {0.005 * inc!r} 0. 0. 60. 80. 80. 1000. {mu[inc - 1]!r}")
            if number == 14:  # an iteration that went wrong leaves nothing behind
                rows.insert(-1, f"{number} {inc} {0.005 * inc!r} 0. 0. NaN 80. 80. 1000. -1.")
    (folder / "many.txt").write_text("\n".join(rows) + "\n")
    output = run(["./driver", "many.txt"], folder)
    assert deviation(output) < 1e-12
    assert output.count("mu      not computed, a load is not finite (first at point 14, increment 1)") == 1


def test_ufric_carries_sliding_distance_and_memory_through_a_remeshing(
    made: Callable[[str], Made], tmp_path: Path
) -> None:
    """Points on a line slide at speeds of their own; a remeshing turns the numbers round and adds some."""
    model = made("linear + work_exhaustion")
    folder = export(model.source, tmp_path / "ufric", "ufric")
    code = folder / "ufric.f"
    text = code.read_text()
    code.write_text(text.replace("tf_remesh = 0.0d0", "tf_remesh = 1.5d0"))
    build_fortran(folder, ["ufric.f", "selftest.f90"], "-fcheck=all")
    dt, count = 0.01, 20
    rows: list[str] = []
    with ExitStack() as stack:
        fmus = [stack.enter_context(RunningFmu(model.fmu)) for _ in range(count)]
        sd = np.zeros(count)
        for inc in range(1, 7):
            calls = []
            for k in range(count):  # material point k, 1 mm apart, moving on by 0.1 mm an increment
                speed = 50.0 + 20.0 * k
                sd[k] += speed * dt
                fmus[k].set_real(LOAD_NAMES, np.array([speed, 100.0, 900.0, sd[k], 1.0]))
                fmus[k].step(dt * (inc - 1), dt)
                number = k + 1 if inc < 4 else 40 - k  # 21 to 40: half of the numbers are new
                if inc < 4:
                    number += 10
                calls.append((number, k + 0.1 * inc, speed, fmus[k].get_real(["mu"])[0]))
            if inc >= 4:
                calls.append((5, 100.0, 77.0, -1.0))  # contact far away is new contact
            for final in (False, True):
                for number, x, speed, mu in calls if inc != 4 else calls[::-1]:
                    values = (dt * inc, x, 0.0, speed, 0.0, 100.0, 900.0, mu if final else -1.0)
                    rows.append(f"{number} {inc} " + " ".join(repr(float(v)) for v in values))
    (folder / "remesh.txt").write_text("\n".join(rows) + "\n")
    assert deviation(run(["./driver", "remesh.txt"], folder)) < 1e-12
    code.write_text(text)  # without the setting the numbers keep what they have, and that is wrong
    build_fortran(folder, ["ufric.f", "selftest.f90"])
    with pytest.raises(AssertionError, match="expected"):
        run(["./driver", "remesh.txt"], folder)


@pytest.mark.parametrize("name", NAMES)
def test_vfric_and_vfriction_follow_the_fmu(name: str, made: Callable[[str], Made], tmp_path: Path) -> None:
    model = made(name)
    folder = export(model.source, tmp_path / "vfric", "vfric")
    assert max(map(len, (folder / "vfric.f").read_text().splitlines())) <= 72
    build_fortran(folder, ["vfric.f", "selftest/selftest.f90"], "-I", "selftest")
    assert deviation(run(["./driver", "selftest/selftest.txt"], folder)) < 1e-12
    system = [0.6 for _ in model.source.system]
    rng = np.random.default_rng(7)
    rows = [" ".join(repr(x) for x in (1.0, 20.0, *system))]
    start = {p.name: x for p, x in zip(model.source.system, system)}
    with RunningFmu(model.fmu, start=start) as a, RunningFmu(model.fmu, start=start) as b:
        sd, first, time = {3: 0.0, 7: 0.0}, {3: 0.0, 7: 0.0}, 0.0
        for inc in range(1, 9):
            dt = float(rng.uniform(1e-4, 1e-3))
            present = [(n, f) for n, f in ((3, a), (7, b)) if not (n == 7 and inc == 4)]
            rows.append(f"{inc} {dt!r} {len(present)}")
            for number, fmu in present:
                slip = rng.normal(size=3) * 0.1
                T, sigma, area = rng.uniform(20, 350), rng.uniform(300, 3000), rng.uniform(1.0, 1.5) * inc
                first[number] = first[number] or area
                speed = float(np.sqrt((slip**2).sum())) / dt
                sd[number] += speed * dt
                fmu.set_real(
                    LOAD_NAMES, np.array([speed, T, sigma * area / area, sd[number], area / first[number]])
                )
                fmu.step(time, dt)
                mu = fmu.get_real(["mu"])[0]
                values = (*slip, sigma * area, area, T - 20.0, T + 20.0, mu)
                rows.append(f"{number} " + " ".join(repr(float(x)) for x in values))
            time += dt
    (folder / "fmu.txt").write_text("\n".join(rows) + "\n")
    assert deviation(run(["./driver", "fmu.txt"], folder)) < 1e-12


def test_vfric_compiles_in_single_precision_and_refuses_too_few_state_variables(
    made: Callable[[str], Made], tmp_path: Path
) -> None:
    folder = export(made("linear + work_exhaustion").source, tmp_path / "vfric", "vfric")
    driver = folder / "selftest" / "selftest.f90"
    text = driver.read_text()
    driver.write_text(text.replace("depvar = 4", "depvar = 3"))
    assert driver.read_text() != text
    build_fortran(folder, ["vfric.f", "selftest/selftest.f90"], "-I", "selftest")
    done = subprocess.run(
        ["./driver", "selftest/selftest.txt"], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert "DEPVAR = 3 in *FRICTION, USER; needed: at least 4" in done.stdout
    (folder / "selftest" / "vaba_param.inc").write_text("      implicit real (a-h, o-z)\n")
    run(["gfortran", *FORTRAN, "-Wno-conversion", "-I", "selftest", "-c", "vfric.f"], folder)


# --- table ---


@pytest.mark.parametrize(
    "name", ["constant", "polynomial", "ffnn", "gradient_boosting", "linear + tool_roughness"]
)
def test_table_is_as_good_as_it_says_against_the_fmu(
    name: str, made: Callable[[str], Made], tmp_path: Path
) -> None:
    from scipy.interpolate import RegularGridInterpolator

    model = made(name)
    folder = export(model.source, tmp_path / "table", "table", tolerance=5e-4)
    head, units, *rows = (folder / "mu_table.csv").read_text().splitlines()
    assert (head, units) == ("sigma_n,T,psi,v_rel,mu", "MPa,degC,1,mm/s,1")
    data = np.array([[float(x) for x in r.split(",")] for r in rows])
    lines = [np.unique(column) for column in data.T[:4]]
    grid = data[:, 4].reshape([len(x) for x in lines])
    assert np.array_equal(data[:, :4], np.stack(np.meshgrid(*lines, indexing="ij"), -1).reshape(-1, 4))
    compact = [x for x in (folder / "mu_table.txt").read_text().splitlines() if not x.startswith("#")]
    assert [float(x) for x in " ".join(compact[2:9:2]).split()] == [x for axis in lines for x in axis]
    body = np.array([x.split() for x in compact[10:]], dtype=float)
    np.testing.assert_allclose(body.ravel(), data[:, 4], rtol=1e-6)
    rng = np.random.default_rng(8)
    points = rng.uniform([x[0] for x in lines], [x[-1] for x in lines], size=(300, 4))
    sd = model.source.interface(1).start(LOADS[3])

    def loads(at: Array) -> Array:
        return np.column_stack([at[:, 3], at[:, 1], at[:, 0], np.full(len(at), sd), at[:, 2]])

    some = rng.choice(len(data), size=min(40, len(data)), replace=False)
    with RunningFmu(model.fmu) as fmu:
        np.testing.assert_allclose(fmu_at(fmu, loads(data[some, :4])), data[some, 4], rtol=1e-6)
        off = np.abs(RegularGridInterpolator(lines, grid)(points) - fmu_at(fmu, loads(points)))
    summary = (folder / "README.txt").read_text()
    report = json.loads((folder / "table.json").read_text())
    assert report["rows"] == len(data)
    if name == "gradient_boosting":  # jumps cannot be interpolated; the rest of the loads must still be good
        assert "tolerance 0.0005 NOT met: mu jumps between grid lines" in summary
        assert report["largest error"] > 5e-4 > np.quantile(off, 0.97)
    else:
        assert "tolerance 0.0005 met" in summary
        assert report["largest error"] <= 5e-4
        assert off.max() <= 5e-4
    if name == "polynomial":
        coarse = tabulate(model.source, points=dict.fromkeys(("sigma_n", "T", "psi", "v_rel"), 2))
        assert coarse.largest > 5e-4 > off.max()


def test_table_says_when_the_tolerance_is_not_met_and_what_it_leaves_out(made: Callable[[str], Made]) -> None:
    polynomial = made("polynomial").source
    small = tabulate(polynomial, tolerance=1e-6, max_rows=40)
    assert not small.met and small.mu.size <= 40 and "NOT met: max_rows is reached" in small.summary()
    assert small.left_out["sd"] > 1e-3
    full = tabulate(polynomial, axes=LOAD_NAMES, points={"sd": 4}, limits={"psi": (2.0, 9.0)}, fixed={})
    assert full.mu.shape[3] == 4 and full.axes["psi"][[0, -1]].tolist() == [2.0, 9.0] and full.left_out == {}
    typed = tabulate(polynomial, axes="T, sigma_n", tolerance="1e-3", max_rows=100.0)  # type: ignore[arg-type]
    assert list(typed.axes) == ["T", "sigma_n"] and typed.tolerance == 1e-3
    rough = made("linear + tool_roughness").source
    at = [tabulate(rough, axes=["T"], system={rough.system[0].name: x}).mu[0] for x in (0.1, 0.9)]
    assert at[0] != at[1]


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("linear + work_exhaustion", {}, "a table has no memory and this model has"),
        ("polynomial", {"axes": ["sigma", "T"]}, "did you mean 'sigma_n'"),
        ("polynomial", {"axes": ["T", "T"]}, "one or more different loads"),
        ("polynomial", {"points": {"T": 1}}, "points of 'T' = 1, allowed: 2 to"),
        ("polynomial", {"limits": {"T": (300.0, 20.0)}}, "limits of 'T'"),
        ("polynomial", {"fixed": {"T": 20.0}}, "unknown name in fixed 'T'; allowed: sd"),
        ("polynomial", {"system": {"Ra": 1.0}}, "unknown name in system 'Ra'"),
        ("polynomial", {"points": {"T": 2.5}}, "points of 'T' = 2.5, allowed: a whole number"),
        ("polynomial", {"points": 5}, "points = 5, allowed: a mapping"),
        ("polynomial", {"limits": {"T": 5}}, "limits of 'T' are 5, allowed: two numbers"),
        ("polynomial", {"limits": {"T": (-300.0, 20.0)}}, "limit of 'T' = -300.0, allowed"),
        ("polynomial", {"tolerance": "small"}, "tolerance = 'small', allowed"),
        ("polynomial", {"tolerance": float("nan")}, "tolerance = nan, allowed"),
        ("polynomial", {"max_rows": 3}, "max_rows = 3, allowed: 16 to"),
        ("polynomial", {"tolerence": 1e-3}, "did you mean 'tolerance'"),
    ],
)
def test_bad_table_options(
    name: str, options: dict[str, object], words: str, made: Callable[[str], Made], tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=words):
        export(made(name).source, tmp_path / "t", "table", **options)
    assert list(tmp_path.iterdir()) == []


def test_a_fresh_point_of_a_model_with_memory_can_be_tabulated(
    made: Callable[[str], Made], tmp_path: Path
) -> None:
    folder = export(made("linear + work_exhaustion").source, tmp_path / "t", "table", start_memory=True)
    assert "THIS MODEL HAS MEMORY" in (folder / "README.txt").read_text()


# --- folder ---


@pytest.mark.parametrize("target", ["c", "ufric", "vfric", "table"])
def test_folder_is_complete_reproducible_and_replaces_its_own_kind_only(
    target: str, made: Callable[[str], Made], tmp_path: Path
) -> None:
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
    (first / "mine.txt").write_text("kept only until the export is written again")
    export(source, first, target)
    assert not (first / "mine.txt").exists()
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.tex").write_text("...")
    with pytest.raises(InputError, match="holds other files"):
        export(source, tmp_path / "full", target)
    assert (tmp_path / "full" / "thesis.tex").read_text() == "..."


def test_bad_targets_names_and_paths(made: Callable[[str], Made], tmp_path: Path) -> None:
    source = made("constant").source
    with pytest.raises(InputError, match="did you mean 'ufric'"):
        export(source, tmp_path / "x", "ufrik")
    for name in ("2mu", "a b", "x" * 25, "", 'a"'):
        with pytest.raises(InputError, match="letters, digits and underscores"):
            export(source, tmp_path / "x", "c", name=name)
    with pytest.raises(InputError, match="option of the target 'c'"):
        export(source, tmp_path / "x", "c", tolerance=1.0)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="this is a file"):
        export(source, tmp_path / "file", "c")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file"]
