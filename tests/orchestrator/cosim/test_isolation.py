"""FMUs whose machine code crashes: in a process of their own, so that what was computed is kept and one sentence says what happened."""

from __future__ import annotations

import json
import os
import re
import signal
import threading
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest

from fmus import FmuModel, pack
from fmus.archive.content import write_archive
from fmus.archive.made_here import VARIABLE, made_here, runs_apart
from fmus.runtime.foreign_friction import friction_model
from fmus.runtime.running import FmuError
from fmus.runtime.separate_process import Apart, Died
from friction_models import ConstantFriction, LinearFriction
from friction_models.common import InputError
from orchestrator import Master, Run, SimulationError, System
from orchestrator.cli.main import run
from tests.friction_models.made_up import campaign
from tests.orchestrator.native_fmus import Real, native_fmu

#: The machine code of each crash, and what ends the process.
CRASHES = {
    "SIGSEGV": "*(volatile int *)16 = 1;",
    "SIGILL": "__builtin_trap();",
    "exit code 3": "exit(3);",
}
LOADS = {"v_rel": "mm/s", "T": "degC", "sigma_n": "MPa", "sd": "mm", "psi": "1"}


@pytest.fixture(scope="module")
def crashing(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Integrators that crash in the step from t = 0.3 on, and a friction FMU that crashes above 1800 MPa."""
    folder = tmp_path_factory.mktemp("crashing")
    variables = [Real("u", "input", 1.0), Real("y", "output")]
    found = {}
    for number, (name, code) in enumerate(CRASHES.items()):
        step = f'if (t > 0.25) {{ {code} }} V(y) += h * V(u); m->logger(m->environment, m->name, fmi2OK, "x", "alive");'
        found[name] = native_fmu(folder / f"crash{number}.fmu", variables, step=step)
    found["at once"] = native_fmu(folder / "at_once.fmu", variables, step=CRASHES["SIGSEGV"])
    loads = [Real(name, "input", 1.0, unit) for name, unit in LOADS.items()]
    code = "if (V(sigma_n) > 1800.0) { *(volatile int *)16 = 1; } V(mu) = 0.1 + 1e-9 * V(sigma_n);"
    found["friction"] = native_fmu(folder / "friction.fmu", [*loads, Real("mu", "output")], outputs=code)
    return found


def alone(fmu: Path, **part: object) -> System:
    parts = {"a": {"fmu": str(fmu)} | part}
    return System.from_dict(
        {"name": "alone", "communication_step": 0.1, "stop_time": 1.0, "components": parts}
    )


@pytest.mark.parametrize("cause", list(CRASHES))
def test_a_crash_keeps_the_steps_and_names_component_time_and_signal(
    crashing: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str], cause: str
) -> None:
    path = alone(crashing[cause]).save(tmp_path / "system.yaml")
    assert run(["simulate", str(path), "-o", str(tmp_path / "run")]) == 1
    said = capsys.readouterr().err
    assert re.search(rf"component 'a' failed at t = 0\.3 s in a step: its process .*{cause}", said), said
    kept = Run.load(tmp_path / "run", stopped=True)
    assert not kept.complete and cause in kept.message
    np.testing.assert_allclose(kept["a.y"], [0.0, 0.1, 0.2, 0.3])
    assert (tmp_path / "run" / "log.txt").read_text().count("a: alive") == 3


def test_what_an_fmu_says_of_its_maker_does_not_count(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.delenv(VARIABLE, raising=False)
    ours = pack(ConstantFriction(0.08), tmp_path / "ours.fmu")
    assert made_here(ours) and not runs_apart(ours) and runs_apart(ours, True)
    with zipfile.ZipFile(ours) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    assert b'generationTool="tribofmu' in files["modelDescription.xml"]
    (library,) = (name for name in files if name.startswith("binaries/"))
    damaged = bytearray(files[library])
    damaged[len(damaged) // 2] ^= 0xFF
    other = write_archive(tmp_path / "other.fmu", files | {library: bytes(damaged)})
    assert not made_here(other) and runs_apart(other) and not runs_apart(other, False)
    same = write_archive(tmp_path / "same.fmu", files)
    assert made_here(same), "equal bytes are the same FMU, wherever they lie"
    monkeypatch.setenv(VARIABLE, "0")
    assert not runs_apart(other)
    monkeypatch.setenv(VARIABLE, "yes")
    with pytest.raises(InputError, match=f"{VARIABLE} = 'yes'"):
        runs_apart(other)


@pytest.mark.parametrize(
    "mode", ["iterated", *(pytest.param(m, marks=pytest.mark.nightly) for m in ("gauss_seidel", "jacobi"))]
)
def test_a_process_of_its_own_changes_no_number(tmp_path: Path, mode: str) -> None:
    model = LinearFriction().fit_frame(campaign(tests=6, points=20))
    friction = pack(model, tmp_path / "friction.fmu")
    three = pack(model, tmp_path / "three.fmu", fmi="3.0")
    names = [f"{n}[{k}]" for n in LOADS for k in (1, 2, 3)]
    variables = [Real(n, "output", 1.5, LOADS[n.partition("[")[0]]) for n in names]
    variables += [Real(f"mu[{k}]", "input") for k in (1, 2, 3)]
    # Each point slides on by what its friction allows.
    step = " ".join(f"V(sd_{k}) += h * (10.0 + {k} * V(mu_{k}));" for k in (1, 2, 3))
    press = native_fmu(tmp_path / "press.fmu", variables, step=step)
    runs = {}
    for fmu in (friction, three):
        for isolate in (False, True):
            content = {
                "communication_step": 0.1,
                "stop_time": 1.0,
                "components": {
                    "friction": {"fmu": str(fmu), "step": 0.05},
                    "press": {"fmu": str(press)},
                },
                "connections": [f"press.{n} -> friction.{n}" for n in LOADS] + ["friction.mu -> press.mu"],
                "record": ["press.sd", "friction.mu"],
            }
            master = Master(System.from_dict(content), mode, isolate=isolate)
            runs[fmu, isolate] = master.run(tmp_path / f"{fmu.stem}-{isolate}")
            assert master.isolated == ({"friction", "press"} if isolate else set())
    first = runs[friction, False]
    assert np.ptp(first["press.sd"][-1]) > 1e-3
    for other in runs.values():
        np.testing.assert_array_equal(other["press.sd"], first["press.sd"])
        np.testing.assert_array_equal(other["friction.mu"], first["friction.mu"])


def test_models_that_crash_end_in_a_sentence(
    crashing: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = campaign(tests=4, points=10)
    data.loc[:, "sigma_n"] = np.linspace(100.0, 2400.0, len(data))
    data.to_csv(tmp_path / "points.csv", index=False)
    given = ["--data", str(tmp_path / "points.csv")]
    fmu = str(crashing["friction"])
    for command in (
        ["evaluate", fmu, *given],
        ["predict", fmu, *given, "-o", str(tmp_path / "out.csv")],
        ["compare", "--models", fmu, "0.08", *given],
        ["diagnose", "--model", fmu, *given],
    ):
        assert run(command) == (2 if command[0] == "compare" else 1), command
        said = capsys.readouterr().err
        assert "friction.fmu: its process was ended by SIGSEGV" in said, said
    model = friction_model(fmu)
    low = np.array([[5.0, 50.0, 500.0, 2.0, 1.1]])
    assert isinstance(model, FmuModel) and model.predict(low)[0] == pytest.approx(0.1, abs=1e-5)
    with pytest.raises(FmuError, match="SIGSEGV"):
        model.predict(low * [1.0, 1.0, 4.0, 1.0, 1.0])
    assert model.predict(low)[0] == pytest.approx(0.1, abs=1e-5), "it starts again"


@pytest.mark.parametrize("isolate", [False, True])
def test_a_wrong_guid_names_the_fmu(tmp_path: Path, isolate: bool) -> None:
    path = pack(ConstantFriction(mu=0.1), tmp_path / "law.fmu")
    with zipfile.ZipFile(path) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    text = files["modelDescription.xml"].decode()
    files["modelDescription.xml"] = re.sub(
        r'(instantiationToken|guid)="[^"]*"', r'\1="{another}"', text
    ).encode()
    write_archive(tmp_path / "other.fmu", files)
    with pytest.raises(FmuError, match=r"other\.fmu: the GUID .* does not belong to this FMU"):
        FmuModel(tmp_path / "other.fmu", isolate=isolate).predict([[5.0, 50.0, 500.0, 2.0, 1.1]])


def test_check_tells_the_crash(crashing: dict[str, Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", str(crashing["at once"])]) == 1
    assert "SIGSEGV" in capsys.readouterr().out


def test_a_wrong_guid_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ours = pack(ConstantFriction(0.08), tmp_path / "ours.fmu")
    with zipfile.ZipFile(ours) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    xml = files["modelDescription.xml"].decode()
    wrong = re.sub(r'guid="[^"]*"', 'guid="{another}"', xml)
    fmu = write_archive(tmp_path / "wrong.fmu", files | {"modelDescription.xml": wrong.encode()})
    start = dict.fromkeys(LOADS, 1.0)
    path = alone(fmu, start=start).save(tmp_path / "system.yaml")
    for isolate in ("--isolate", "--no-isolate"):
        assert run(["simulate", str(path), isolate, "-o", str(tmp_path / "run")]) == 2
        said = capsys.readouterr().err
        assert "wrong.fmu" in said and "component 'a'" in said and "{another}" in said, said
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("length", ["garbage", "short"])
def test_garbage_in_open_files_ends_in_a_sentence(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], length: str
) -> None:
    # Read as the length of a message the first is gigabytes, the second more than ever comes.
    text = {"garbage": '"garbage"', "short": r'"\0\0\1\0xyz"'}[length]
    step = f"if (t > 0.25) {{ for (int f = 3; f < 64; ++f) write(f, {text}, 7); }} V(y) += h;"
    fmu = native_fmu(tmp_path / "wild.fmu", [Real("y", "output")], step=step)
    path = alone(fmu).save(tmp_path / "system.yaml")
    assert run(["simulate", str(path), "-o", str(tmp_path / "run")]) == 1
    said = capfd.readouterr().err
    assert re.search(r"component 'a' failed at t = 0\.3 s in a step: its machine code wrote into files", said)
    assert "Traceback" not in said
    np.testing.assert_allclose(Run.load(tmp_path / "run", stopped=True)["a.y"], [0.0, 0.1, 0.2, 0.3])
    assert Apart(dict).call("__len__") == 0, "further processes start"


def test_one_interrupt_ends_a_step_that_never_ends(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    begun = tmp_path / "begun"
    step = f'if (t > 0.25) {{ fclose(fopen("{begun}", "w")); for (;;) ; }} V(y) += h;'
    fmu = native_fmu(tmp_path / "endless.fmu", [Real("y", "output")], step=step)
    path = alone(fmu).save(tmp_path / "system.yaml")

    def interrupt() -> None:
        while not begun.exists():
            time.sleep(0.05)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt, daemon=True).start()
    assert run(["simulate", str(path), "-o", str(tmp_path / "run")]) == 130
    assert "interrupted at t = 0.3 s; kept in" in capsys.readouterr().err
    np.testing.assert_allclose(Run.load(tmp_path / "run", stopped=True)["a.y"], [0.0, 0.1, 0.2, 0.3])


def hang() -> object:
    """Make an object that never answers."""
    while True:
        time.sleep(1.0)


def test_an_interrupt_leaves_an_fmu_that_hangs() -> None:
    apart = Apart(hang)
    timer = threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        apart.call("ready")
    with pytest.raises(Died):
        apart.call("ready")


def test_the_run_says_what_ran_apart(crashing: dict[str, Path], tmp_path: Path) -> None:
    with pytest.raises(SimulationError):
        Master(alone(crashing["SIGSEGV"])).run(tmp_path / "run")
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    assert manifest["components"]["a"]["isolated"] is True and manifest["status"] == "stopped"
