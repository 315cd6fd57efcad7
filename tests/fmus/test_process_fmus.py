"""Solver FMUs whose solver runs in a process of its own: same numbers, and what goes wrong is said."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from fmus import pack_forming, pack_twin
from fmus.native.compile import fmi_headers
from fmus.process_target import MAIN, SOURCES, front_model
from fmus.running import FmuError, RunningFmu, UnpackedFmu
from friction_models.loads import LOAD_NAMES, InputError

pytestmark = pytest.mark.skipif(
    sys.platform == "win32", reason="the tests look at processes and descriptors as POSIX has them"
)
N = 12
STAND_IN = Path(__file__).parent / "stand_in.py"


@pytest.fixture(autouse=True)
def own_python(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TRIBOFMU_PYTHON", sys.executable)
    monkeypatch.delenv("TRIBOFMU_TIMEOUT", raising=False)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("process")


@pytest.fixture(scope="module")
def twin(folder: Path) -> UnpackedFmu:
    return UnpackedFmu(pack_twin(folder / "twin.fmu", target="process"))


@pytest.fixture(scope="module")
def forming(folder: Path) -> UnpackedFmu:
    return UnpackedFmu(pack_forming(folder / "fre.fmu", target="process", n_points=N, mesh_size=0.8))


@pytest.fixture(scope="module")
def running_twin(twin: UnpackedFmu) -> Iterator[RunningFmu]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TRIBOFMU_PYTHON", sys.executable)
        fmu = RunningFmu(twin)
    with fmu:
        yield fmu


def children() -> set[int]:
    """Return the processes that this one has started and not yet collected."""
    tasks = Path("/proc/self/task")
    if not tasks.is_dir():
        pytest.skip("no /proc: the children of this process cannot be listed")
    return {int(p) for f in tasks.glob("*/children") for p in f.read_text().split()}


def gone(pid: int, seconds: float = 20.0) -> bool:
    """Return whether a process ends, or is only waiting to be collected, within a time."""
    for _ in range(int(seconds / 0.05)):
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            return True
        if state == "Z":
            return True
        time.sleep(0.05)
    return False


def script(place: Path, text: str) -> Path:
    file = place / "python-of-the-test"
    file.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
    file.chmod(0o755)
    return file


@pytest.fixture
def stand_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    def use(mode: str) -> None:
        file = script(tmp_path, f'exec "{sys.executable}" -I -S "{STAND_IN}" "$@"')
        monkeypatch.setenv("TRIBOFMU_PYTHON", str(file))
        monkeypatch.setenv("STAND_IN", mode)

    return use


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
        (pack_forming, {"process": "bce", "n_points": N, "mesh_size": 0.8}, {"punch_diameter": 13.0}),
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
        unpacked = UnpackedFmu(path)
        shown.append([(v.name, v.valueReference, v.start, v.unit) for v in unpacked.variables.values()])
        names = [n for n, v in unpacked.variables.items() if v.causality == "output"]
        reals = [n for n in names if unpacked.variables[n].type == "Real"]
        with RunningFmu(unpacked, start=start) as fmu:
            first = fmu.get_real(reals)
            rest = play(fmu, unpacked.elements("mu"), reals, [n for n in names if n not in reals])
        seen.append([first.tolist(), *rest])
    assert shown[0] == shown[1]
    assert seen[0] == seen[1]  # bitwise
    assert seen[0][1] != seen[0][-1]


def test_goes_back_exactly_and_frees_its_states(forming: UnpackedFmu) -> None:
    outputs = [n for name in (*LOAD_NAMES, "force", "work") for n in forming.elements(name)]
    mu, flags = forming.elements("mu"), forming.elements("active")
    with RunningFmu(forming) as fmu:
        play(fmu, mu, outputs, flags, 3)
        state = fmu.save()
        ahead = play(fmu, mu, outputs, flags)
        fmu.restore(state)
        assert play(fmu, mu, outputs, flags) == ahead
        fmu._call(fmu.slave.reset)
        with pytest.raises(FmuError, match="not allowed before fmi2ExitInitializationMode"):
            fmu.step(0.0, 0.02)
        fmu.restore(state)
        assert play(fmu, mu, outputs, flags) == ahead
        fmu._call(fmu.slave.freeFMUstate, state)


def test_two_instances_do_not_meet(twin: UnpackedFmu) -> None:
    before = children()
    with RunningFmu(twin, "a") as a:
        with RunningFmu(twin, "b") as b:
            assert len(children() - before) == 2
            a.set({"v_slide": 10.0})
            b.set({"v_slide": 20.0})
            for fmu in (a, b, a, b):
                fmu.step(0.0, 0.01)
            assert a.get_real(["sd"])[0] == pytest.approx(0.2)
            assert b.get_real(["sd"])[0] == pytest.approx(0.4)
        # b has ended although a runs on: a's process does not hold b's connection open.
        assert len(children() - before) == 1
        with pytest.raises(FmuError, match="belongs to another instance"), RunningFmu(twin, "c") as c:
            a.restore(c.save())
    assert children() == before


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"F_n": -1.0}, r"SCT process: F_n = -1\.0; allowed"),
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


def test_killed_process_is_reported_and_reset_starts_another(twin: UnpackedFmu) -> None:
    before = children()
    with RunningFmu(twin) as fmu:
        state = fmu.save()
        (pid,) = children() - before
        os.kill(pid, signal.SIGKILL)
        with pytest.raises(FmuError, match="was ended by signal 9"):
            fmu.step(0.0, 0.01)
        with pytest.raises(FmuError, match="the solver process is gone; fmi2Reset starts another one"):
            fmu.step(0.0, 0.01)
        fmu._call(fmu.slave.reset)
        with pytest.raises(FmuError, match="in a solver process that is gone"):
            fmu.restore(state)
        fmu._call(fmu.slave.enterInitializationMode)
        fmu._call(fmu.slave.exitInitializationMode)
        fmu.step(0.0, 0.01)
        assert fmu.get_real(["sd"])[0] > 0.0


def test_process_ends_with_the_simulator(twin: UnpackedFmu) -> None:
    """Also in the middle of a request, and when the simulator has no time to say good-bye."""
    code = f"""
import os, signal, sys, threading, time
from pathlib import Path
from fmus.running import RunningFmu, UnpackedFmu
fmu = RunningFmu(UnpackedFmu({str(twin.path)!r}))
pids = [p for f in Path("/proc/self/task").glob("*/children") for p in f.read_text().split()]
print(*pids, flush=True)
threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGKILL)).start()
for k in range(10**9):
    fmu.step(1e-5 * k, 1e-5)
"""
    children()  # skips without /proc
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == -signal.SIGKILL, done.stderr
    pids = [int(p) for p in done.stdout.split()]
    assert len(pids) == 1
    assert gone(pids[0])


def test_prints_and_warnings_of_libraries_do_not_get_into_the_messages(
    twin: UnpackedFmu, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    noise = """
import os, sys, threading, time
print("before everything", flush=True)
def talk():
    while True:
        sys.stdout.write("noise " * 1000 + "\\n"); sys.stdout.flush()
        os.write(1, b"TFMU" * 2000); os.write(2, b"warning " * 2000)
        time.sleep(0.001)
threading.Thread(target=talk, daemon=True).start()
"""
    (tmp_path / "sitecustomize.py").write_text(noise, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with RunningFmu(twin) as fmu:
        time.sleep(0.3)  # longer than the pipe of standard error holds what is written meanwhile
        for k in range(20):
            fmu.step(0.001 * k, 0.001)
        assert fmu.get_real(["sd"])[0] == pytest.approx(20 * 0.001 * 100.0)


@pytest.mark.parametrize(
    ("mode", "words"),
    [
        ("version", r"tribofmu 9\.9 in .* speaks version 7 of the solver protocol, this FMU version 1"),
        ("stranger", "answers, but not as a solver process"),
        ("hang", r"has not answered within 0\.3 s and was ended; TRIBOFMU_TIMEOUT sets another limit"),
        ("short", "sent 4 bytes, expected: 41"),
        ("huge", "the solver process .* ended"),
        ("dies", r"exit code 9; its last lines: Traceback\|ZeroDivisionError: 100 %% wrong"),
    ],
)
def test_wrong_answers_are_errors(
    twin: UnpackedFmu,
    stand_in: Callable[[str], None],
    mode: str,
    words: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stand_in(mode)
    before = children()
    if mode == "hang":
        monkeypatch.setenv("TRIBOFMU_TIMEOUT", "0.3")
    with pytest.raises(FmuError, match=words), RunningFmu(twin) as fmu:
        fmu.step(0.0, 0.01)
    assert children() == before


def test_flood_of_messages_does_not_stop_a_step(twin: UnpackedFmu, stand_in: Callable[[str], None]) -> None:
    stand_in("flood")
    with RunningFmu(twin) as fmu:
        fmu.step(0.0, 0.01)
        assert fmu.get_real(LOAD_NAMES).tolist() == [2.0] * 5


@pytest.mark.parametrize(
    ("python", "words"),
    [
        (
            'exec "{python}" -I -S "$@"',
            r"the Python environment .* lacks fmus; install it: pip install tribofmu",
        ),
        ("echo nothing here >&2; exit 3", "has ended with exit code 3; its last lines: nothing here"),
        (None, r"/no/python cannot be started \(No such file.*set TRIBOFMU_PYTHON"),
    ],
)
def test_unfit_python_is_named(
    twin: UnpackedFmu, python: str | None, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    chosen = script(tmp_path, python.format(python=sys.executable)) if python else Path("/no/python")
    monkeypatch.setenv("TRIBOFMU_PYTHON", str(chosen))
    with pytest.raises(FmuError, match=words):
        RunningFmu(twin)


def test_python_is_looked_for_in_order(
    stand_in: Callable[[str], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The environment variable, then the FMU's own hint, then PATH; PYTHONHOME of the host is not passed on."""
    stand_in("flood")
    file = os.environ["TRIBOFMU_PYTHON"]
    hinted = UnpackedFmu(pack_twin(tmp_path / "hinted.fmu", target="process", python=file))
    plain = UnpackedFmu(pack_twin(tmp_path / "plain.fmu", target="process"))
    monkeypatch.setenv("PYTHONHOME", "/no/home")
    monkeypatch.delenv("TRIBOFMU_PYTHON")
    monkeypatch.setenv("PATH", "/no/folder")
    RunningFmu(hinted).close()
    with pytest.raises(FmuError, match="there is no Python on PATH"):
        RunningFmu(plain)
    shutil.copy(file, tmp_path / "python")
    monkeypatch.setenv("PATH", f"/no/folder:{tmp_path}")
    RunningFmu(plain).close()
    monkeypatch.setenv("TRIBOFMU_PYTHON", "/no/python")
    with pytest.raises(FmuError, match="/no/python"):
        RunningFmu(hinted)


def test_wrong_time_limit_is_refused(twin: UnpackedFmu, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TRIBOFMU_TIMEOUT", "soon")
    with pytest.raises(FmuError, match="TRIBOFMU_TIMEOUT = 'soon', allowed: seconds from 0"):
        RunningFmu(twin)


def test_nothing_is_left_open_and_threads_may_start_at_once(
    twin: UnpackedFmu, stand_in: Callable[[str], None]
) -> None:
    stand_in("flood")
    before, failures = children(), []
    RunningFmu(twin).close()
    descriptors = len(os.listdir("/dev/fd"))

    def work() -> None:
        try:
            for _ in range(5):
                with RunningFmu(twin) as fmu:
                    fmu.step(0.0, 0.01)
        except Exception as error:
            failures.append(error)

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failures == []
    assert children() == before
    assert len(os.listdir("/dev/fd")) == descriptors


def test_descriptors_of_the_simulator_are_closed_in_the_process(twin: UnpackedFmu, tmp_path: Path) -> None:
    before = children()
    with (tmp_path / "open").open("w") as stream:
        os.set_inheritable(stream.fileno(), True)
        with RunningFmu(twin):
            (pid,) = children() - before
            held = {os.path.realpath(f"/proc/{pid}/fd/{n}") for n in os.listdir(f"/proc/{pid}/fd")}
            assert str(tmp_path / "open") not in held


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
    with RunningFmu(forming) as fmu:
        for k in range(25):
            if round(0.02 * k, 6) in seen and k:
                assert seen[round(0.02 * k, 6)] == pytest.approx(fmu.get_real(["force"])[0], abs=1e-5)
            fmu.step(0.02 * k, 0.02)


def test_compiles_without_warnings_for_all_systems_and_again_to_the_same_bytes(tmp_path: Path) -> None:
    if find_spec("ziglang") is None:
        pytest.skip("the Zig compiler (extra [cross]) is missing")
    platforms = ["linux64", "win64", "macos"]
    paths = [pack_twin(tmp_path / n, target="process", platforms=platforms) for n in ("a.fmu", "b.fmu")]
    assert paths[0].read_bytes() == paths[1].read_bytes()
    native = Path(__file__).parents[2] / "fmus" / "native"
    for name in SOURCES:
        (tmp_path / name).write_text((native / name).read_text(encoding="utf-8"), encoding="utf-8")
    for name, text in fmi_headers().items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    config = {
        "names": ["x", "u", "p"],
        "first_input": 1,
        "first_parameter": 2,
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
