"""An output of the same name is kept where something of it would be lost, and only there."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import pytest

from friction_models import LinearFriction
from friction_models.common import InputError, atomic_path, grown, write_text
from friction_models.common.folders import STUDY
from friction_models.common.replaced_outputs import KEEP, keeping_earlier
from orchestrator.cli.common.files_named import Writes, _checked
from orchestrator.cli.main import run
from tests.orchestrator.cli.test_command_line import points
from tests.orchestrator.tiny_fmus import write_system


@pytest.fixture(autouse=True)
def as_usual(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(KEEP, raising=False)


@pytest.fixture
def place(tmp_path: Path, tiny: dict[str, Path], monkeypatch: pytest.MonkeyPatch) -> Path:
    """A user's folder, the current one."""
    monkeypatch.chdir(tmp_path)
    points(3, 12).to_csv("points.csv", index=False)
    LinearFriction().fit_frame(points(3, 12)).save("linear")
    write_system(tmp_path, tiny)
    return tmp_path


def test_a_run_of_the_same_name_is_kept(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["simulate", "system.yaml", "-o", "runs/a"]
    assert run(words) == 0
    before = (place / "runs/a/results.nc").read_bytes()
    # The same run again differs in its times alone: nothing is lost, nothing kept.
    assert run(words) == 0
    assert [p.name for p in (place / "runs").iterdir()] == ["a"]
    capsys.readouterr()
    assert run([*words, "--mode", "jacobi"]) == 0
    assert "note: runs/a: what was there before is kept as runs/a.1\n" in capsys.readouterr().err
    assert (place / "runs/a.1/results.nc").read_bytes() == before
    assert (place / "runs/a/results.nc").read_bytes() != before
    assert run(words) == 0
    assert sorted(p.name for p in (place / "runs").iterdir()) == ["a", "a.1", "a.2"]
    # What was kept is a run like any other.
    assert run(["report", "runs/a.2", "-o", "a.html"]) == 0


def test_what_only_the_earlier_run_holds_is_not_lost(place: Path) -> None:
    assert run(["simulate", "system.yaml", "--csv", "-o", "a"]) == 0
    assert run(["simulate", "system.yaml", "-o", "a"]) == 0
    assert (place / "a.1/results.csv").is_file() and not (place / "a/results.csv").exists()
    # What --local-errors adds is part of a run.
    (place / "a/local_errors.nc").write_bytes((place / "a/results.nc").read_bytes())
    assert run(["simulate", "system.yaml", "-o", "a"]) == 0
    assert (place / "a.2/local_errors.nc").is_file()


def test_files_are_kept_too(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for mu in ("0.08", "0.08", "0.1"):
        assert run(["pack", mu, "-o", "friction.fmu"]) == 0
    assert capsys.readouterr().err.count("what was there before is kept") == 1
    assert run(["pack", "0.08", "-o", "again.fmu"]) == 0
    assert (place / "friction.fmu.1").read_bytes() == (place / "again.fmu").read_bytes()
    assert not (place / "friction.fmu.2").exists()
    for mu in ("0.08", "0.1"):
        words = ["evaluate", mu, "--data", "points.csv", "--json", "errors.json"]
        assert run(words) == 0
    assert (place / "errors.json.1").is_file()


def test_models_are_kept_and_the_command_can_be_told_not_to(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run(["train", "linear", "--data", "points.csv", "-o", "linear"]) == 0
    kept = {p.name for p in place.glob("linear.*")}
    assert run(["train", "constant", "--data", "points.csv", "-o", "linear"]) == 0
    assert {p.name for p in place.glob("linear.*")} == {f"linear.{len(kept) + 1}"} | kept
    monkeypatch.setenv(KEEP, "no")
    assert run(["train", "linear", "--data", "points.csv", "-o", "linear"]) == 0
    assert len(list(place.glob("linear.*"))) == len(kept) + 1


def test_a_command_that_fails_moves_nothing(place: Path) -> None:
    assert run(["pack", "0.08", "-o", "friction.fmu"]) == 0
    before = sorted(p.name for p in place.iterdir())
    assert run(["pack", "nothing-there", "-o", "friction.fmu"]) == 2
    assert sorted(p.name for p in place.iterdir()) == before


def test_what_cannot_be_put_in_place_leaves_the_earlier_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "a.txt"
    file.write_text("old")

    def refused(self: Path, target: Path) -> Path:
        if target == file and self.name != "a.txt.1":
            raise OSError(5, "no room")
        os.replace(self, target)
        return Path(target)

    monkeypatch.setattr(Path, "replace", refused)
    with pytest.raises(OSError, match=r"a\.txt"), keeping_earlier([file]) as moved, atomic_path(file) as new:
        new.write_text("new")
    assert moved == [] and [p.name for p in tmp_path.iterdir()] == ["a.txt"] and file.read_text() == "old"


def test_long_names_and_names_that_are_taken(tmp_path: Path) -> None:
    for name in ("x" * 254, "b"):
        file = tmp_path / name
        (tmp_path / "b.1").mkdir(exist_ok=True)
        for text in ("one", "two"):
            with keeping_earlier([file]) as moved, atomic_path(file) as new:
                new.write_text(text)
        assert moved[0].now.read_text() == "one"
    assert moved[0].now.name == "b.2"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no FIFOs here")
def test_a_pipe_is_not_replaced_by_a_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="no plain file"), atomic_path(tmp_path / "pipe"):
        pass


@_checked
def toy_study(out: Annotated[Path, Writes("STUDY")], depth: float) -> None:
    """Do what a study does: keep its jobs, write anew what it makes of them."""
    write_text(grown(out, STUDY) / "jobs" / f"{depth}" / "result.json", "{}")
    write_text(out / "wear.csv", f"{depth}")
    write_text(out / "failed.json", f"{depth}")


def test_a_study_with_other_options_keeps_the_results_before(tmp_path: Path) -> None:
    def names() -> list[str]:
        return sorted(p.relative_to(out).as_posix() for p in out.rglob("*.*") if not p.name.startswith("."))

    out = tmp_path / "study"
    for _ in range(2):  # the same again leaves no copy
        toy_study(out=out, depth=0.1)
    first = ["failed.json", "jobs/0.1", "jobs/0.1/result.json", "wear.csv"]
    assert names() == first
    toy_study(out=out, depth=0.2)
    assert names() == sorted([*first, "jobs/0.2", "jobs/0.2/result.json", "wear.csv.1"])
    assert (out / "wear.csv.1").read_text() == "0.1" and (out / "wear.csv").read_text() == "0.2"
