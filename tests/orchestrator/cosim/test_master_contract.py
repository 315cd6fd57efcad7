"""What FMI lets an FMU say to a master, and what becomes of it: ends, discarded steps, no numbers, open inputs, loops."""

from __future__ import annotations

import json
import math
import os
import re
import signal
import threading
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fmus import pack
from fmus.archive.content import write_archive
from fmus.native.compile import build, fmi_headers
from friction_models import ConstantFriction
from friction_models.common import InputError
from orchestrator import Master, Run, SimulationError, System
from orchestrator.cli.main import run
from tests.orchestrator.native_fmus import Real, native_fmu

CLOCK = [Real("spare", "input", 2.5), Real("u", "input"), Real("at", "parameter", 9.0), Real("y", "output"), Real("calls", "output")]  # fmt: skip
#: y counts the steps; from t = at on it does what the FMU is called by.
STEP = "V(calls) += 1.0; if (t + 0.5 * h > V(at)) {{ {} }} V(y) += h * (1.0 + V(u));"
WORDS = {
    "steady": "",
    "nan": "V(y) = NAN; return 1;",
    "discards": 'm->logger(m->environment, m->name, fmi2Discard, "logStatusDiscard", "the wedge is too thin"); return 0;',
    "warns": 'm->logger(m->environment, m->name, fmi2Warning, "logStatusWarning", "the wedge is too thin"); return 0;',
    "ends": "return 0;",
}


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """FMUs in C by what they do; `native_fmu` answers a refused step by fmi2Error, here it is fmi2Discard."""
    folder = tmp_path_factory.mktemp("contract")
    made = {
        name: native_fmu(
            folder / f"{name}.fmu", CLOCK, step=STEP.format(word), refused="fmi2Discard", terminated=name == "ends"
        )
        for name, word in WORDS.items()
    }  # fmt: skip
    made["slope"] = native_fmu(
        folder / "slope.fmu", [Real("x", "input"), Real("z", "output")], step="V(z) += h * V(x);"
    )
    return made


def system(fmus: dict[str, Path], which: str, **changes: object) -> System:
    """The clock feeds an integrator."""
    content: dict[str, object] = {
        "name": "contract",
        "communication_step": 0.1,
        "stop_time": 1.0,
        "components": {
            "clock": {"fmu": str(fmus[which]), "start": {"at": 0.5, "u": 0.0, "spare": 1.0}},
            "slope": {"fmu": str(fmus["slope"])},
        },
        "connections": ["clock.y -> slope.x"],
    }
    return System.from_dict(content | changes)


def test_an_output_that_is_no_number_stops_the_run_where_it_comes_up(
    fmus: dict[str, Path], tmp_path: Path
) -> None:
    with pytest.raises(SimulationError, match=r"component 'clock' gives 'y' = nan at t = 0\.6 s.*5 steps"):
        Master(system(fmus, "nan")).run(tmp_path / "run")
    kept = Run.load(tmp_path / "run", stopped=True)
    assert len(kept.time) == 6 and np.isfinite(kept["slope.z"]).all()


@pytest.mark.parametrize("which", ["discards", "warns"])
def test_the_sentence_of_a_discarded_step_is_kept(fmus: dict[str, Path], tmp_path: Path, which: str) -> None:
    with pytest.raises(SimulationError, match=r"'clock' failed at t = 0\.5 s.*the wedge is too thin"):
        Master(system(fmus, which)).run(tmp_path / "run")


def test_an_fmu_that_terminates_ends_a_complete_run(
    fmus: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = system(fmus, "ends").save(tmp_path / "system.yaml")
    assert run(["simulate", str(path), "-o", str(tmp_path / "run")]) == 0
    assert "'clock' ended the simulation at t = 0.5 s, before the stop time of 1 s" in capsys.readouterr().out
    ended = Run.load(tmp_path / "run")
    assert ended.complete and ended.time[-1] == pytest.approx(0.5) and "'clock' ended" in ended.message
    assert ended["clock.y"][-1] == pytest.approx(0.5)


def test_an_open_input_keeps_the_start_value_of_its_fmu_and_is_named(
    fmus: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    variables = [Real("gain", "input", 3.0), Real("y", "output")]
    fmu = native_fmu(tmp_path / "open.fmu", variables, step="V(y) += h * V(gain);")
    content = {"communication_step": 0.1, "stop_time": 1.0, "components": {"a": {"fmu": str(fmu)}}}
    path = System.from_dict(content).save(tmp_path / "system.yaml")
    assert run(["simulate", str(path), "-o", str(tmp_path / "run")]) == 0
    assert "a.gain is not connected and stays at 3.0 1" in capsys.readouterr().err
    assert Run.load(tmp_path / "run")["a.y"][-1] == pytest.approx(3.0)


def without(fmu: Path, target: Path, pattern: str, by: str = "") -> Path:
    """Copy an FMU with another text in its model description."""
    with zipfile.ZipFile(fmu) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    text = files["modelDescription.xml"].decode()
    assert re.search(pattern, text)
    files["modelDescription.xml"] = re.sub(pattern, by, text).encode()
    return write_archive(target, files)


def test_an_input_without_any_start_value_is_still_refused(fmus: dict[str, Path], tmp_path: Path) -> None:
    bare = without(fmus["slope"], tmp_path / "slope.fmu", ' start="0.0"')
    content = {"communication_step": 0.1, "stop_time": 1.0, "components": {"a": {"fmu": str(bare)}}}
    with pytest.raises(InputError, match=r"a\.x is not connected and has no start value"):
        System.from_dict(content).validate()


@pytest.mark.parametrize("mode", ["gauss_seidel", "jacobi", "iterated"])
def test_declared_feed_through_in_a_circle_is_told(fmus: dict[str, Path], tmp_path: Path, mode: str) -> None:
    parts = {"one": {"fmu": str(fmus["slope"])}, "two": {"fmu": str(fmus["slope"])}}
    circle = ["one.z -> two.x", "two.z -> one.x"]
    content = {"communication_step": 0.1, "stop_time": 1.0, "components": parts, "connections": circle}
    assert Master(System.from_dict(content), mode).warnings == []  # dependencies="": outputs answer later
    silent = without(fmus["slope"], tmp_path / "slope.fmu", ' dependencies=""')
    for part in parts.values():
        part["fmu"] = str(silent)
    master = Master(System.from_dict(content), mode)
    if mode == "iterated":
        assert master.warnings == []
        return
    (warning,) = master.warnings
    assert "algebraic loop" in warning and mode in warning
    assert {"one.z", "two.x", "two.z", "one.x"} <= set(re.findall(r"\w+\.\w", warning))
    master.run(tmp_path / "run")
    assert json.loads((tmp_path / "run" / "manifest.json").read_text())["warnings"] == [warning]
    assert warning in (tmp_path / "run" / "log.txt").read_text()


def test_a_component_takes_smaller_steps_of_its_own(fmus: dict[str, Path], tmp_path: Path) -> None:
    fmu = native_fmu(
        tmp_path / "decay.fmu",
        [Real("rate", "input", 1.0), Real("y", "output", 1.0)],
        step="V(y) *= 1.0 - h * V(rate);",
    )
    ends = {}
    for step in (None, 0.02, 0.005):
        parts = {"a": {"fmu": str(fmu)} | ({} if step is None else {"step": step})}
        content = {"communication_step": 0.1, "stop_time": 1.0, "components": parts}
        folder = tmp_path / f"run-{step}"
        ends[step] = Master(System.from_dict(content)).run(folder)
        assert len(ends[step].time) == 11
        size = step or 0.1
        assert ends[step]["a.y"][-1] == pytest.approx((1.0 - size) ** round(1.0 / size), rel=1e-12)
    assert abs(ends[0.005]["a.y"][-1] - math.exp(-1.0)) < 0.002
    again = System.load(tmp_path / "run-0.005" / "system.yaml")
    assert again.components["a"].step == 0.005
    with pytest.raises(InputError, match=r"'a': step 0\.03 s does not divide.*0\.1 s"):
        System.from_dict({**content, "components": {"a": {"fmu": str(fmu), "step": 0.03}}})
    for tiny in (1e-300, 5e-324, 9e-6):
        with pytest.raises(
            InputError, match=rf"'a': step {tiny:g} s is .* steps .*0\.1 s; allowed: 1 to 10000"
        ):
            System.from_dict({**content, "components": {"a": {"fmu": str(fmu), "step": tiny}}})
    with pytest.raises(InputError, match="step of its own"):
        again.export(tmp_path / "x.ssp")


SLOW = """
    for (int k = 0; k < 3; ++k) {
        for (clock_t begin = clock(); clock() - begin < CLOCKS_PER_SEC / 50;) continue;
        m->logger(m->environment, m->name, fmi2OK, "x", "still at work");
    }
"""


def test_an_interrupt_blames_nobody_and_keeps_the_steps(
    fmus: dict[str, Path],
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fmu = native_fmu(tmp_path / "slow.fmu", [Real("y", "output")], step="V(y) += h;" + SLOW)
    content = {"communication_step": 0.1, "stop_time": 20.0, "components": {"slow": {"fmu": str(fmu)}}}
    path = System.from_dict(content).save(tmp_path / "system.yaml")
    # Most of the time the FMU is in the C library or calls the logger back: where an interrupt gets lost or blames it.
    timer = threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT))
    advance, steps = Master._advance, iter(range(200))

    def watched(*arguments: Any) -> bool:
        if next(steps) == 3:
            timer.start()
        return advance(*arguments)

    monkeypatch.setattr(Master, "_advance", watched)
    code = run(["simulate", str(path), "-o", str(tmp_path / "run")])
    timer.cancel()
    said = capfd.readouterr().err
    assert code == 130 and "interrupted at t = " in said and "kept in" in said, said
    assert "failed" not in said and "ignored" not in said
    kept = Run.load(tmp_path / "run", stopped=True)
    assert 0 < len(kept.time) < 200 and kept.message.startswith("interrupted at t = ")


@pytest.mark.parametrize(("early", "isolate"), [(False, False), (True, True)])
def test_terminate_simulation_of_fmi3_ends_the_run(tmp_path: Path, early: bool, isolate: bool) -> None:
    """One of our FMUs, rebuilt so that it asks for the end after t = 0.45, with a whole step or in the middle of one."""
    ours = pack(ConstantFriction(0.08), tmp_path / "ours.fmu", fmi="3.0")
    with zipfile.ZipFile(ours) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    sources = {n.removeprefix("sources/"): t.decode() for n, t in files.items() if n.startswith("sources/")}
    del sources["buildDescription.xml"]
    old = "if (terminateSimulation) *terminateSimulation = fmi3False;\n    if (earlyReturn) *earlyReturn = fmi3False;"
    assert old in sources["fmi3_more.h"]
    end = "*terminateSimulation = time + h > 0.45;" + (f" *earlyReturn = {int(early)} && time + h > 0.45;")
    sources["fmi3_more.h"] = sources["fmi3_more.h"].replace(old, end)
    (library,) = (n for n in files if n.startswith("binaries/"))
    built = build(sources | fmi_headers("3.0"), "fmi3.c", Path(library).stem, None, "3.0")
    fmu = write_archive(tmp_path / "ends.fmu", files | {f"binaries/{n}": b for n, b in built.items()})
    part = {"fmu": str(fmu), "start": dict.fromkeys(("v_rel", "T", "sigma_n", "sd", "psi"), 1.0)}
    content = {"communication_step": 0.1, "stop_time": 1.0, "components": {"a": part}}
    ended = Master(System.from_dict(content), isolate=isolate).run(tmp_path / "run")
    assert ended.complete and "component 'a' ended the simulation at t = 0.5 s" in ended.message
    assert ended.time[-1] == pytest.approx(0.4 if early else 0.5)
