"""What can go wrong with a solver process: it is said, nothing hangs, and nothing stays behind."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from fmus import pack_twin
from fmus.runtime.running import FmuError, RunningFmu, UnpackedFmu
from friction_models.loads import LOAD_NAMES

from .processes import children, gone, script

pytestmark = pytest.mark.skipif(
    sys.platform == "win32", reason="the tests look at processes and descriptors as POSIX has them"
)


@pytest.mark.nightly
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
            with pytest.raises(FmuError, match="belongs to another instance"):
                a.restore_state(b.save_state())
        # b has ended although a runs on: a's process does not hold b's connection open.
        assert len(children() - before) == 1
    assert children() == before


def test_killed_process_is_reported_and_reset_starts_another(twin: UnpackedFmu) -> None:
    before = children()
    with RunningFmu(twin) as fmu:
        state = fmu.save_state()
        (pid,) = children() - before
        os.kill(pid, signal.SIGKILL)
        with pytest.raises(FmuError, match="was ended by signal 9"):
            fmu.step(0.0, 0.01)
        with pytest.raises(FmuError, match="the solver process is gone; fmi2Reset starts another one"):
            fmu.step(0.0, 0.01)
        fmu.call("Reset")
        with pytest.raises(FmuError, match="in a solver process that is gone"):
            fmu.restore_state(state)
        fmu.call("EnterInitializationMode")
        fmu.call("ExitInitializationMode")
        fmu.step(0.0, 0.01)
        assert fmu.get_real(["sd"])[0] > 0.0


def test_process_ends_with_the_simulator(twin: UnpackedFmu) -> None:
    """Also in the middle of a request, and when the simulator has no time to say good-bye."""
    code = f"""
import os, signal, sys, threading, time
from pathlib import Path
from fmus.runtime.running import RunningFmu, UnpackedFmu
fmu = RunningFmu(UnpackedFmu.of({str(twin.path)!r}))
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
    monkeypatch.setattr(
        "fmus.runtime.c_interface.offer_interpreter", lambda: None
    )  # as in a simulator that knows nothing
    file = os.environ["TRIBOFMU_PYTHON"]
    hinted = UnpackedFmu.of(pack_twin(tmp_path / "hinted.fmu", target="process", python=file))
    plain = UnpackedFmu.of(pack_twin(tmp_path / "plain.fmu", target="process"))
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


def test_our_own_hosts_offer_their_interpreter(forming: UnpackedFmu, monkeypatch: pytest.MonkeyPatch) -> None:
    """The Python on PATH may be another one than that of the command."""
    from fmus.runtime.instance import Instance

    monkeypatch.delenv("TRIBOFMU_PYTHON", raising=False)
    monkeypatch.setenv("PATH", "/nowhere")
    with Instance("forming", forming) as instance:
        instance.initialize([], 1.0)
