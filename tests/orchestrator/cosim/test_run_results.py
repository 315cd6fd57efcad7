"""Results of a run that were written by others or damaged: converted, or refused in one sentence."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from friction_models.common import InputError
from friction_models.common.netcdf_files import Dataset, NetcdfVariable, write_dataset
from friction_models.loads import LOADS
from orchestrator.cosim import run_results
from orchestrator.cosim.run_results import read_results

STEPS, POINTS = 5, 3
VALUES = {f"forming.{q.name}": (q.unit, np.full((STEPS, POINTS), q.lower + 1.0)) for q in LOADS} | {
    "forming.stroke": ("mm", np.arange(float(STEPS))),
    "forming.force": ("kN", np.arange(float(STEPS))),
    "forming.active": ("1", np.ones((STEPS, POINTS))),
    "friction.mu": ("1", np.full((STEPS, POINTS), 0.08)),
    "motor.T": ("N.m", np.ones(STEPS)),
    "oil.sigma_n": ("GPa", np.ones(STEPS)),
}
Change = Callable[[str, np.ndarray], tuple[str, np.ndarray]]


def written(path: Path, name: str = "", change: Change | None = None) -> Path:
    """Write results of which one is another; the length of its dimensions is in their names."""
    time = ("s", np.linspace(0.0, 0.4, STEPS))
    parts = {"time": time, **VALUES}
    if change is not None:
        parts[name] = change(*parts[name])
    variables = {
        label: NetcdfVariable(
            tuple(f"d{k}_{size}" for k, size in enumerate(a.shape)), a, {"units": unit} if unit else {}
        )
        for label, (unit, a) in parts.items()
    }
    variables["time"] = variables["time"]._replace(dimensions=("time",))
    write_dataset(Dataset(variables, {"time": variables.pop("time")}, {}), path)
    return path


def test_what_is_no_load_or_force_keeps_its_unit(tmp_path: Path) -> None:
    same = read_results(written(tmp_path / "same.nc"))
    assert same.values.keys() == same.units.keys() == VALUES.keys()
    told = read_results(written(tmp_path / "told.nc", "forming.force", lambda _, a: ("1", a)))
    np.testing.assert_array_equal(told.values["forming.force"], same.values["forming.force"])
    assert same.units["motor.T"] == "N.m" and same.units["oil.sigma_n"] == "MPa"
    np.testing.assert_array_equal(same.values["oil.sigma_n"], 1000.0)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("time", lambda _, a: ("ms", 1e3 * a)),
        ("forming.sigma_n", lambda _, a: ("GPa", 1e-3 * a)),
        ("forming.T", lambda _, a: ("K", a + 273.15)),
        ("forming.force", lambda _, a: ("N", 1e3 * a)),
        ("forming.stroke", lambda _, a: ("m", 1e-3 * a)),
        ("friction.mu", lambda _, a: ("%", 1e2 * a)),
        ("forming.sd", lambda _, a: ("", a)),
    ],
)
def test_units_of_others_are_converted(tmp_path: Path, name: str, change: Change) -> None:
    same = read_results(written(tmp_path / "same.nc"))
    found = read_results(written(tmp_path / "other.nc", name, change))
    assert found.units == same.units
    np.testing.assert_allclose(found.time, same.time)
    for label, values in same.values.items():
        np.testing.assert_allclose(found.values[label], values, err_msg=label)


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("forming.sigma_n", lambda _, a: ("N", a), "unknown unit of column 'forming.sigma_n' 'N'; allowed: GPa"),
        ("forming.force", lambda _, a: ("MPa", a), "unknown unit of column 'forming.force' 'MPa'; allowed: MN"),
        ("time", lambda u, a: (u, a[:0]), "time has the shape (0,); allowed: one step at least"),
        ("time", lambda u, a: (u, a[:1]), "time has the shape (1,); allowed: one step at least"),
        ("time", lambda u, a: (u, a[:3]), "has the shape (5, 3); allowed: (3, points)"),
        ("time", lambda u, a: (u, a * np.nan), "one finite number a step"),
        ("forming.T", lambda u, a: (u, a.T), "'forming.T' has the shape (3, 5); allowed: (5, points)"),
        ("forming.psi", lambda u, a: (u, a[:, :2]), "'forming.psi' has the shape (5, 2); allowed: (5, 3)"),
        ("forming.active", lambda u, a: (u, a[:, 0]), "'forming.active' has the shape (5,); allowed: (5, 3)"),
        ("forming.force", lambda u, a: (u, a[:2]), "'forming.force' has the shape (2,); allowed: (5,)"),
        ("motor.T", lambda u, a: (u, a[0].repeat(8).reshape(2, 2, 2)), "'motor.T' has the shape (2, 2, 2)"),
    ],
)  # fmt: skip
def test_what_breaks_later_is_refused(tmp_path: Path, name: str, change: Change, words: str) -> None:
    file = written(tmp_path / "results.nc", name, change)
    with pytest.raises(InputError, match=re.escape(str(file)) + ": .*" + re.escape(words)) as error:
        read_results(file)
    assert "\n" not in str(error.value)


def test_a_huge_file_is_refused_before_it_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_results, "MOST_NUMBERS", 20)
    with pytest.raises(InputError, match=r"results\.nc: \d+ numbers; allowed: at most 20"):
        read_results(written(tmp_path / "results.nc"))
