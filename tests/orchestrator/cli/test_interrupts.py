"""Ctrl-C: one sentence and exit code 130 from every command, whenever it comes; and nothing half-written."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import pandas as pd
import pytest

from friction_models import LinearFriction
from friction_models.loads import DataSet
from orchestrator.cli.common import interrupts
from tests.orchestrator.cli.test_command_line import points
from tests.orchestrator.processes import COMMAND, interrupted
from tests.orchestrator.tiny_fmus import slow_process

#: Holds a module that interrupts the process which imports it, in the middle of its start.
AT_START = Path(__file__).with_name("interrupted_start")


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory, tiny: dict[str, Path]) -> Path:
    folder = tmp_path_factory.mktemp("user")
    frame = points(3, 12)
    roles = pd.DataFrame({"test_id": ["t0", "t1", "t2"], "role": ["train", "train", "test"]})
    DataSet(frame, roles, {"synthetic": True}).save(folder / "data")
    LinearFriction().fit_frame(frame).save(folder / "linear")
    (folder / "law.fmu").write_bytes(tiny["law"].read_bytes())
    slow_process(folder, "SlowProcess", folder / "stepping").rename(folder / "process.fmu")
    (folder / "system.yaml").write_text(
        "communication_step: 0.1\nstop_time: 1000\ncomponents:\n"
        "  friction: {fmu: law.fmu}\n  forming: {fmu: process.fmu}\n"
        "connections: ['forming.load -> friction.load', 'friction.mu -> forming.mu']\n"
    )
    return folder


#: Every command, with arguments that would be right where they are cheap to make.
COMMANDS = [
    "demo -o new",
    "lab -o new",
    "ingest data -o new",
    "twin data -o new",
    "train linear --data data -o new",
    "evaluate linear --data data --json new.json",
    "predict linear --data data -o new.csv",
    "predict-sct linear --data data -o new",
    "pack linear -o new.fmu",
    "check law.fmu",
    "export system.yaml -o new.ssp",
    "simulate system.yaml -o new",
    "compare --models linear 0.08 --data data --json new.json",
    "diagnose --data data --model linear --json new.json",
    "refine --data data --model linear --add stribeck -o new",
    "coverage --data data --history data/points.csv --json new.json",
    "attribute --press data --system system.yaml --json new.json",
    "study learning-curve --quick -o new",
    "study forming-error --quick -o new",
    "study lag --quick -o new",
    "study extrapolation --quick -o new",
    "report data -o new.html",
    "verify --json new.json",
]


def expect_a_sentence(result: tuple[int, str, str]) -> None:
    code, output, errors = result
    assert code == 130, f"{output} {errors}"
    lines = errors.splitlines()
    assert len(lines) == 1 and lines[0].startswith("tribofmu: interrupted; "), errors


#: All start alike; these are of different modules.
DAILY = ("demo", "twin", "pack", "simulate", "diagnose", "study")


@pytest.mark.parametrize(
    "command",
    [pytest.param(c, marks=() if c.split()[0] in DAILY else pytest.mark.nightly) for c in COMMANDS],
)
def test_an_interrupt_while_it_starts(place: Path, command: str) -> None:
    words = [COMMAND, *command.split()]
    expect_a_sentence(interrupted(words, place, lambda _: False, PYTHONPATH=str(AT_START)))
    assert not list(place.glob("new*")) and not list(place.glob(".new*"))


def test_an_interrupt_in_a_component_is_none_of_its_errors(place: Path) -> None:
    """The interrupt hits the Python code of an FMU, which runs in this process."""
    mark = place / "stepping"
    mark.unlink(missing_ok=True)
    result = interrupted([COMMAND, "simulate", "system.yaml", "-o", "run"], place, lambda _: mark.exists())
    code, _, errors = result
    assert code == 130 and "component" not in errors and "Traceback" not in errors
    assert errors.splitlines()[-1] == (
        "tribofmu: interrupted at t = 0 s; nothing was written, as no step was complete"
    )
    assert not (place / "run").exists()


def test_an_interrupt_where_nothing_can_be_raised_is_noticed_and_not_printed(
    capfd: pytest.CaptureFixture[str],
) -> None:
    class Held:
        def __del__(self) -> None:  # what a destructor raises goes to `sys.unraisablehook`
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.01)

    with interrupts.watched():
        held = Held()
        del held
        assert interrupts.received()
    assert not interrupts.received()  # a later command of the same process goes on
    assert capfd.readouterr().err == ""
