"""FMPy opens, validates, describes and runs every kind of our FMUs without a word of warning."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from fmpy import dump, read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

from fmus import pack, pack_twin
from friction_models import LinearFriction, TriboLoads

KINDS: dict[str, dict[str, object]] = {
    "native, FMI 2": {},
    "native, FMI 2, 20 nodes": {"nodes": 20},
    "native, FMI 3": {"fmi": "3.0"},
    "native, FMI 3, 20 nodes": {"fmi": "3.0", "nodes": 20},
    "python": {"target": "python"},
    "map": {"target": "map", "axes": "sigma_n"},
    "twin": {},
}


@pytest.fixture(scope="module")
def linear() -> LinearFriction:
    rng = np.random.default_rng(0)
    low, high = np.array([5.0, 20.0, 500.0, 0.0, 1.0]), np.array([500.0, 300.0, 2000.0, 60.0, 10.0])
    loads = TriboLoads(*(low + (high - low) * rng.random((50, 5))).T)
    return LinearFriction().fit(loads, 0.08 - 1e-5 * loads.sigma_n, np.repeat(np.arange(10), 5))


#: Each version, the map and a solver; the others differ by their number of points, or run in Python.
DAILY = ("native, FMI 2, 20 nodes", "native, FMI 3", "map", "twin")


@pytest.mark.parametrize(
    "kind", [pytest.param(k, marks=() if k in DAILY else pytest.mark.nightly) for k in KINDS]
)
def test_fmpy_has_nothing_to_say(
    kind: str, linear: LinearFriction, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "x.fmu"
    made = pack_twin(file) if kind == "twin" else pack(linear, file, **KINDS[kind])  # type: ignore[arg-type]
    capfd.readouterr()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", ResourceWarning)  # of objects that other tests left behind
        assert validate_fmu(str(made)) == []
        dump(str(made))
        if kind != "twin":
            inputs = [v for v in read_model_description(str(made)).modelVariables if v.causality == "input"]
            shapes = [(v.name, float, (20,) if v.dimensions else ()) for v in inputs]
            signals = np.zeros(2, [("time", float), *shapes])
            signals["time"] = 0.0, 0.2
            for name, _, _ in shapes:
                signals[name] = 1.0 if name.startswith("psi") else 10.0
            simulate_fmu(str(made), stop_time=0.2, input=signals)
    said = capfd.readouterr()
    assert said.err == "" and "warn" not in said.out.lower()
