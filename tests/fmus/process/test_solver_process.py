"""Solver FMUs whose solver runs in a process of its own: the same numbers, in every simulator."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from fmus import pack_forming, pack_twin
from fmus.native.compile import fmi_headers
from fmus.runtime.running import FmuError, RunningFmu, UnpackedFmu
from fmus.targets.process import MAIN, SOURCES, front_model
from forming.fe.increment import Settings as IncrementSettings
from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES

from .conftest import N


def play(fmu: RunningFmu, mu: list[str], outputs: list[str], flags: list[str], steps: int = 8) -> list[Any]:
    seen = []
    for k in range(steps):
        fmu.set_real(mu, np.full(len(mu), 0.05 + 0.01 * k))
        fmu.step(0.02 * k, 0.02)
        seen.append([*fmu.get_real(outputs), *(fmu.get_boolean(n) for n in flags)])
    return seen


@pytest.mark.parametrize(
    ("packer", "options", "start"),
    [
        (pack_forming, {"n_points": N, "mesh_size": 0.8}, {"half_angle": 50.0, "mu[2]": 0.11}),
        pytest.param(
            pack_forming,
            {"process": "bce", "n_points": N, "mesh_size": 0.8},
            {"punch_diameter": 13.0},
            marks=pytest.mark.nightly,
        ),
        (pack_twin, {}, {"F_n": 200e3, "T_tool": 100.0}),
    ],
)
def test_same_numbers_as_in_the_simulators_python(
    packer: Callable[..., Path], options: dict[str, Any], start: dict[str, float], tmp_path: Path
) -> None:
    seen, shown = [], []
    for target in ("process", "python"):
        path = packer(tmp_path / f"{target}.fmu", target=target, **options)
        assert validate_fmu(str(path)) == []
        unpacked = UnpackedFmu.of(path)
        shown.append([(v.name, v.reference, v.starts, v.unit) for v in unpacked.variables.values()])
        names = [n for n, v in unpacked.variables.items() if v.causality == "output"]
        reals = [n for n in names if unpacked.variables[n].type == "Real"]
        with RunningFmu(unpacked, start=start) as fmu:
            first = fmu.get_real(reals)
            rest = play(
                fmu, [v.name for v in unpacked.resolve("mu")], reals, [n for n in names if n not in reals]
            )
        seen.append([first.tolist(), *rest])
    assert shown[0] == shown[1]
    assert seen[0] == seen[1]  # bitwise
    assert seen[0][1] != seen[0][-1]


def test_goes_back_exactly_and_frees_its_states(forming: UnpackedFmu) -> None:
    outputs = [v.name for name in (*LOAD_NAMES, "force", "work") for v in forming.resolve(name)]
    mu, flags = [v.name for v in forming.resolve("mu")], [v.name for v in forming.resolve("active")]
    with RunningFmu(forming) as fmu:
        play(fmu, mu, outputs, flags, 3)
        state = fmu.save_state()
        ahead = play(fmu, mu, outputs, flags)
        fmu.restore_state(state)
        assert play(fmu, mu, outputs, flags) == ahead
        fmu.call("Reset")
        with pytest.raises(FmuError, match="not allowed before fmi2ExitInitializationMode"):
            fmu.step(0.0, 0.02)
        fmu.restore_state(state)
        assert play(fmu, mu, outputs, flags) == ahead
        fmu.free_state(state)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"F_n": -1.0}, r"SCT process: F_n = -1\.0 N; allowed"),
        ({"mu": float("nan")}, "mu = nan is not a finite number"),
        ({"T": 1.0}, "T is an output and cannot be set"),
        ({"bore": 3.0}, "parameter bore cannot be set after initialization"),
    ],
)
def test_refused_calls_name_the_variable_and_leave_the_instance_whole(
    running_twin: RunningFmu, values: dict[str, float], words: str
) -> None:
    fmu = running_twin
    kept = fmu.get_real(["F_n"])
    with pytest.raises(FmuError, match=words):
        fmu.set(values)
        fmu.step(0.0, 0.01)
    fmu.set_real(["F_n"], kept)
    fmu.step(0.0, 0.0)


def test_bad_parameter_is_refused_at_the_start(forming: UnpackedFmu) -> None:
    with pytest.raises(FmuError, match=r"half_angle = 500\.0 degrees; allowed: 10 to 80"):
        RunningFmu(forming, start={"half_angle": 500.0})


@pytest.mark.nightly  # by day tests/interop/test_forming.py couples it with friction in the same program
def test_runs_in_a_simulator_without_python(folder: Path, forming: UnpackedFmu, tmp_path: Path) -> None:
    """The ecos command line: only the interpreter's path is told to it."""
    found = find_spec("ecospy")
    if found is None or not found.submodule_search_locations or shutil.which("unzip") is None:
        pytest.skip("the ecos command line (extra [interop]) or unzip is missing")
    source = Path(next(iter(found.submodule_search_locations))) / "binaries" / "ecos"
    program = Path(shutil.copy(source, tmp_path / "ecos"))
    program.chmod(0o755)
    environment = {
        "LD_LIBRARY_PATH": str(Path(sys.prefix) / "lib"),
        "TRIBOFMU_PYTHON": sys.executable,
        "PATH": os.path.dirname(shutil.which("unzip") or ""),
    }
    command = [
        str(program),
        "simulate",
        "--path",
        str(forming.path),
        "--stopTime",
        "0.5",
        "--stepSize",
        "0.02",
    ]
    done = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False, timeout=300
    )
    if "libtbb" in done.stderr:
        pytest.skip("the library tbb of the extra [interop] is missing")
    assert done.returncode == 0, done.stdout + done.stderr
    (table,) = tmp_path.glob("*.csv")
    head, *rows = [[c.strip() for c in line.split(",")] for line in table.read_text().splitlines()]
    column = next(i for i, name in enumerate(head) if "force" in name)
    seen = {round(float(row[1]), 6): float(row[column]) for row in rows}
    assert len(seen) > 20
    # ecos adds up its time: the last bits of a step differ, and with them the force within the solver's tolerance
    # of equilibrium. That equal steps give equal bits is another test's matter.
    near = IncrementSettings().tolerance
    with RunningFmu(forming) as fmu:
        for k in range(25):
            if round(0.02 * k, 6) in seen and k:
                assert seen[round(0.02 * k, 6)] == pytest.approx(fmu.get_real(["force"])[0], rel=near)
            fmu.step(0.02 * k, 0.02)


@pytest.mark.usefixtures("built_anew")
def test_compiles_without_warnings_for_all_systems_and_again_to_the_same_bytes(tmp_path: Path) -> None:
    if find_spec("ziglang") is None:
        pytest.skip("the Zig compiler (extra [cross]) is missing")
    platforms = ["linux64", "win64"]
    paths = [pack_twin(tmp_path / n, target="process", platforms=platforms) for n in ("a.fmu", "b.fmu")]
    assert paths[0].read_bytes() == paths[1].read_bytes()
    native = Path(__file__).parents[3] / "fmus" / "native"
    for name in SOURCES:
        (tmp_path / name).write_text((native / name).read_text(encoding="utf-8"), encoding="utf-8")
    for name, text in fmi_headers().items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    config = {
        "names": ["x", "u", "p"],
        "first_input": 1,
        "first_parameter": 2,
        "further": 0,
        "start": [0.0] * 3,
        "flags": 0,
    }
    (tmp_path / "front_model.h").write_text(f'#define TF_GUID "x"\n{front_model("twin", config)}')
    for target in ("x86_64-linux-gnu.2.17", "x86_64-windows-gnu", "aarch64-macos.11.0"):
        flags = ["-std=c99", "-Wall", "-Wextra", "-Wshadow", "-Werror", "-c", MAIN, "-o", "front.o"]
        command = [sys.executable, "-m", "ziglang", "cc", "-target", target, *flags]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"target": "proces"}, "did you mean 'process'"),
        ({"process": "bcee"}, "did you mean 'bce'"),
        ({"platforms": ["win64"]}, "platforms = .*allowed with the target 'process' only"),
        ({"target": "process", "python": "a\nb"}, "one line"),
        ({"process": "bce", "exit_diameter": 3.0}, "exit_diameter"),
    ],
)
def test_bad_options(options: dict[str, Any], words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=words):
        pack_forming(tmp_path / "x.fmu", **options)
    assert list(tmp_path.iterdir()) == []
