"""The incremental process: what a simulator drives step by step."""

from __future__ import annotations

import numpy as np
import pytest

from friction_models.loads import LOAD_NAMES, InputError
from sct_twin import SctProcess


@pytest.fixture(scope="module")
def process() -> SctProcess:
    return SctProcess(F_max=330e3, T_tool=100.0, speed=200.0)


def test_loads_of_a_test_that_is_driven_from_outside(process: SctProcess) -> None:
    start = process.snapshot()
    assert process.loads._fields == LOAD_NAMES
    process.advance(0.3, 330e3, 0.0, 100.0, 0.07)
    for _ in range(20):
        loads = process.advance(0.005, 330e3, 200.0, 100.0, 0.07)
    assert loads.sd == pytest.approx(20.0)
    assert loads.v_rel == 200.0
    assert loads.sigma_n == pytest.approx(330e3 / (np.pi / 4 * 15.51**2), rel=0.01)
    assert 1.04 < loads.psi < 1.07
    assert 200.0 < loads.T < process.T_max
    process.restore(start)


def test_snapshot_is_exact_and_can_be_used_again(process: SctProcess) -> None:
    start = process.snapshot()
    runs = []
    for _ in range(2):
        process.restore(start)
        runs.append([process.advance(0.002, 3e5 + 100.0 * k, 10.0 * k, 100.0, 0.06) for k in range(15)])
    assert runs[0] == runs[1]
    process.restore(start)
    assert process.time == 0.0 and process.loads.sd == 0.0


def test_less_friction_less_heat(process: SctProcess) -> None:
    start = process.snapshot()
    hot = [process.advance(0.01, 330e3, 200.0, 100.0, 0.10) for _ in range(10)][-1]
    process.restore(start)
    cool = [process.advance(0.01, 330e3, 200.0, 100.0, 0.05) for _ in range(10)][-1]
    process.restore(start)
    assert pytest.approx(2.0 * (cool.T - 100.0), rel=0.05) == (hot.T - 100.0)


def test_impossible_inputs(process: SctProcess) -> None:
    with pytest.raises(InputError, match="mu = nan; allowed: 0 to 10"):
        process.advance(0.01, 1e5, 100.0, 20.0, float("nan"))
    with pytest.raises(InputError, match="F_max = -1"):
        SctProcess(F_max=-1.0)
