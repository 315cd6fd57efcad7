"""Some tries of the fuzz, and whether it would notice what it looks for."""

from __future__ import annotations

import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

from tests.acceptance.attacks import ATTACKS, Attack
from tests.acceptance.hostile import SECRET

pytest.importorskip("resource", reason="the fuzz forks, which this system does not")

from .archive_damage import by_suffix
from .child import Ended
from .stock import GOOD, Box, good, put_foreign
from .trying import _judged, _touched

ROOT = Path(__file__).resolve().parents[2]
TWIN = next(a for a in ATTACKS if a.command == "twin")
EVALUATE = next(a for a in ATTACKS if a.command == "evaluate")


@pytest.mark.slow
@pytest.mark.parametrize("tries", [5, pytest.param(60, marks=pytest.mark.nightly)])
def test_commands_stand_damaged_inputs_and_hostile_outputs(tries: int, tmp_path: Path) -> None:
    """Among the tries are an output that is an input, and a folder of somebody else."""
    page = tmp_path / "report.md"
    numbers = ["--quick", "--first", "138", "--tries", str(tries), "-j", "1"]
    command = [sys.executable, "-m", "tests.fuzz", *numbers, "-o", str(page)]
    environment = os.environ | {"OMP_NUM_THREADS": "1", "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, page.read_text("utf-8") if page.is_file() else done.stderr[-3000:]
    assert f"{tries} tries with seed 1" in page.read_text("utf-8")


@pytest.mark.parametrize("attack", ATTACKS, ids=lambda a: f"{a.command}-{a.parameter}-{a.kind}")
def test_every_attack_has_a_good_file(attack: Attack) -> None:
    """Whoever adds a command adds what the damage starts from."""
    assert good(attack) in GOOD.values()


def ended(code: int, err: str = "", out: str = "", left: bool = False) -> Ended:
    return Ended(code, out, err, 0.1, left)


@pytest.mark.parametrize(
    ("seen", "words"),
    [
        (ended(2, "tribofmu: error: a.csv: empty; allowed: a table\n"), ""),
        (ended(0, "run: 1/2 steps\n"), ""),
        (ended(-11), "signal 11"),
        (ended(3), "exit code 3"),
        (ended(1, "Traceback (most recent call last):\n  ..."), "traceback"),
        (ended(1, "tribofmu: error: KeyError: 'mu'\n"), "Python exception"),
        (ended(0, "/x/y.py:3: RuntimeWarning: overflow\n"), "Python exception"),
        (ended(2, "tribofmu: error: one\nand two\n"), "2 lines"),
        (ended(2, ""), "lines instead"),
        (ended(2, f"tribofmu: error: {'a' * 9000}\n"), "too long"),
        (ended(2, f"tribofmu: error: {SECRET}\n"), "another file"),
        (ended(2, "tribofmu: error: \x1b[2J\n"), "control characters"),
        (ended(0, out="a" * 200_000), "too much"),
        (ended(0, left=True), "left running"),
        (Ended(-9, "", "", float("nan"), False), "no end"),
    ],
)
def test_words_and_codes_are_judged(seen: Ended, words: str) -> None:
    found = _judged(EVALUATE, seen)
    assert any(words in w for w in found) if words else not found, found


def test_changed_files_are_seen(tmp_path: Path) -> None:
    """What a command may touch is its output; a folder of somebody else stays as it is."""
    box = Box.__new__(Box)
    box.root = tmp_path
    put_foreign(tmp_path / "neighbour")
    before = box.look()
    (tmp_path / "neighbour" / "notes.txt").write_text("gone")
    (tmp_path / "neighbour" / "results.nc").unlink()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "a.csv").write_text("1")
    after, out = box.look(), tmp_path / "out"
    outside = _touched(TWIN, ended(0), before, after, out, box)
    assert sorted(w.partition(":")[0] for w in outside) == [
        "changed outside the output",
        "removed outside the output",
    ]
    inside = _touched(TWIN, ended(0), before, after, tmp_path / "neighbour", box)
    assert {
        "changed in a folder of somebody else: neighbour/notes.txt",
        "written outside the output: out",
    } <= {*inside}
    assert _touched(EVALUATE, ended(2), {}, {"out": "folder", "out/a.csv": "x"}, out, box)
    assert not _touched(TWIN, ended(2), {}, {"out": "folder", "out/a.csv": "x"}, out, box), (
        "kept for the next run"
    )


def test_the_same_seed_makes_the_same_damage() -> None:
    content = b"test_id,t,mu\nt0,0.0,0.1\nt0,0.1,0.2\n"
    once, again = ([by_suffix(random.Random(k), "a.csv", content) for k in range(50)] for _ in range(2))
    assert once == again and len({*once}) > 30
