"""Kept upsettings: what was damaged, changed or exchanged is computed again."""

from __future__ import annotations

import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from forming.tools.punch_geometry import PunchGeometry
from sct_twin.virtual_lab import specimen_runs
from sct_twin.virtual_lab.contact.specimen_run import SpecimenCase, SpecimenRun
from sct_twin.virtual_lab.rig.specimen import Rig

PUNCH = PunchGeometry(15.0, 15.0, bore_diameter=20.0)


def run(cache: Path | None, force: float = 2e4) -> SpecimenRun:
    case = SpecimenCase(PUNCH, force, 3.0, Rig().material, 0.07, 20.0, 20.0, 10.0)
    return specimen_runs.compute_run(case, cache and str(cache))


@pytest.fixture
def computed(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The forces of the upsettings that were computed, not read."""
    forces: list[float] = []
    real: Callable[..., Any] = specimen_runs.upset_specimen

    def noted(case: SpecimenCase) -> Any:
        forces.append(case.force)
        return real(case)

    monkeypatch.setattr(specimen_runs, "upset_specimen", noted)
    return forces


def altered(file: Path) -> None:
    """Write the same arrays with another force: a sound file with other values."""
    with np.load(file) as stored:
        arrays = dict(stored)
    name = next(n for n, a in arrays.items() if a.dtype.kind == "f" and a.size > 1)
    arrays[name] = arrays[name] * 1.5
    with file.open("wb") as stream:
        np.savez(stream, **arrays)


DAMAGES: dict[str, Callable[[Path], object]] = {
    "empty": lambda f: f.write_bytes(b""),
    "cut": lambda f: f.write_bytes(f.read_bytes()[:300]),
    "noise": lambda f: f.write_bytes(bytes(range(256)) * 9),
    "one bit": lambda f: f.write_bytes((b := f.read_bytes())[:900] + bytes([b[900] ^ 1]) + b[901:]),
    "other values": altered,
    "no checksum": lambda f: f.with_name(f.name + ".kept").unlink(),
    "damaged checksum": lambda f: f.with_name(f.name + ".kept").write_text("{" * 9),
}


def test_damaged_runs_are_computed_again(tmp_path: Path, computed: list[float]) -> None:
    first = run(tmp_path)
    (file,) = tmp_path.glob("*.npz")
    for name, damage in DAMAGES.items():
        damage(file)
        del computed[:]
        again = run(tmp_path)
        assert computed == [2e4], name
        np.testing.assert_array_equal(again.force, first.force)
        run(tmp_path)
        assert computed == [2e4], f"{name} does not heal"


def exchange(one: Path, two: Path) -> None:
    aside = one.with_name("aside")
    one.rename(aside)
    two.rename(one)
    aside.rename(two)


@pytest.mark.parametrize("endings", [("",), ("", ".kept")])
def test_runs_that_changed_places_are_computed_again(
    tmp_path: Path, computed: list[float], endings: tuple[str, ...]
) -> None:
    small, large = run(tmp_path, 1e4), run(tmp_path, 2e4)
    assert small.force[-1] != large.force[-1]
    one, two = sorted(tmp_path.glob("*.npz"))
    for ending in endings:
        exchange(one.with_name(one.name + ending), two.with_name(two.name + ending))
    del computed[:]
    assert run(tmp_path, 1e4).force[-1] == small.force[-1]
    assert run(tmp_path, 2e4).force[-1] == large.force[-1]
    assert computed == [1e4, 2e4]


def test_the_cache_is_the_users_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "cache" / "tribofmu").mkdir(parents=True, mode=0o755)
    run(None)
    folder = tmp_path / "cache" / "tribofmu"
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert len(list(folder.glob("*.npz"))) == 1
