"""Damage, full disks and floods of text from elsewhere: a short sentence that names what it is about."""

from __future__ import annotations

import json
import resource
import signal
import subprocess
from pathlib import Path
from typing import Any

import pytest

from friction_models import ComposedFriction, LinearFriction, load_model
from friction_models.common import InputError, shown
from friction_models.loads import DataSet
from orchestrator.cli.main import run
from tests.orchestrator.cli.test_command_line import points
from tests.orchestrator.processes import COMMAND, environment
from tests.orchestrator.tiny_fmus import law, write_system


@pytest.fixture
def place(tmp_path: Path, tiny: dict[str, Path], monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "project"
    folder.mkdir()
    DataSet(points(4, 12), None, {}).save(folder / "data")
    write_system(folder, tiny)
    monkeypatch.chdir(folder)
    return folder


HISTORIES: list[Any] = [
    "x" * 100_000,
    ["x" * 100_000],
    [{}],
    [None],
    [{"added": "stribeck", "judged_by": "x", "before": {}, "after": {}}],
    [{"added": ["stribeck"], "judged_by": 3, "before": {"rmse": 0.1, "mae": 0.1}, "after": {"rmse": 0.1, "mae": 0.1}}],
    [{"added": ["stribeck"], "judged_by": "x", "before": {"rmse": "0.1", "mae": 0.1}, "after": {}}],
    {"added": 1},
]  # fmt: skip


def in_history(content: Any, history: Any) -> int:
    """Replace every training history in a card; return how many there were."""
    found = 0
    for key, value in list(content.items()) if isinstance(content, dict) else []:
        if key == "error_history":
            content[key], found = history, found + 1
        else:
            found += in_history(value, history)
    return found


def test_a_damaged_training_history_is_a_sentence(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ComposedFriction(LinearFriction(), ["stribeck"]).fit_frame(points(4, 12)).save(place / "better")
    card = place / "better" / "card.json"
    whole = json.loads(card.read_text())
    del whole["sha256"]["model"]
    good = {"rmse": 0.1, "mae": 0.1}
    rounds = [{"added": ["stribeck"], "judged_by": "two tests", "before": good, "after": good}]
    assert in_history(whole, rounds) == 1
    card.write_text(json.dumps(whole))
    assert load_model(place / "better").error_history_ == rounds
    for history in HISTORIES:
        in_history(whole, history)
        card.write_text(json.dumps(whole))
        with pytest.raises(InputError, match="error_history"):
            load_model(place / "better")
        words = ["refine", "--data", "data", "--model", "better", "--add", "running_in", "-o", "next"]
        assert run(words) == 2
        said = capsys.readouterr().err
        assert "better" in said and len(said) < 500 and len(said.splitlines()) == 1


def test_floods_of_text_become_a_line(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    law(place, "Calm")
    script = place / "Loud.py"
    text = (
        (place / "Calm.py")
        .read_text()
        .replace("class Calm", "class Loud")
        .replace(
            "return self.loads[0] <",
            "raise ValueError('\\x1b[31mflood\\n' * 20000)\n        return self.loads[0] <",
        )
    )
    script.write_text(text)
    from pythonfmu import FmuBuilder

    FmuBuilder.build_FMU(script, dest=place, canGetAndSetFMUstate=True)
    capsys.readouterr()
    assert run(["simulate", "system.yaml", "--swap", "friction=Loud.fmu", "-o", "run"]) == 1
    said = capsys.readouterr().err.splitlines()[-1]
    assert said.startswith("tribofmu: error: ") and len(said) < 1600 and "\x1b" not in said
    (place / "plan.csv").write_text("sigma_set,v_set,T_tool\n" + "9" * 100_000 + ",1,1\n")
    assert run(["lab", "--plan", "plan.csv", "-o", "campaign"]) == 2
    said = capsys.readouterr().err
    assert len(said) < 1600 and "plan.csv" in said


def test_text_from_elsewhere_is_cut_and_cleaned() -> None:
    assert shown("a\n b\t\x1b[31m c\x00") == "a b [31m c"
    assert shown("x" * 10**6, 20) == "x" * 16 + " ..."
    assert shown("short", 5) == "short"


FULL = {
    "model": "train linear --data data -o out",
    "table": "predict 0.08 --data data -o out.csv",
    "fmu": "export system.yaml -o out.ssp",
}


@pytest.mark.parametrize(
    "words",
    [pytest.param(w, id=k, marks=() if k == "model" else pytest.mark.nightly) for k, w in FULL.items()],
)
def test_a_file_that_cannot_grow_is_named(place: Path, words: str) -> None:
    before = sorted(place.iterdir())

    def small_files() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (300, 300))

    done = subprocess.run(
        [COMMAND, *words.split()],
        cwd=place,
        env=environment(place, PYTHONDONTWRITEBYTECODE="1", NUMBA_DISABLE_JIT="1"),
        capture_output=True,
        text=True,
        preexec_fn=small_files,
        check=False,
    )
    assert done.returncode == 1, done.stderr
    said = done.stderr.splitlines()[-1]
    name = words.split()[-1]
    assert said in {f"tribofmu: error: {p}: File too large" for p in (name, place / name)}, done.stderr
    assert sorted(place.iterdir()) == before
