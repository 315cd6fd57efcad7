"""The convergence of local loads: orders and differences of sequences whose error is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from forming.verification import CASES
from forming.verification.local_loads import TOLERANCES, _converge, differences, order


@pytest.mark.parametrize("p", [0.5, 1.0, 2.0, 3.3])
def test_order_of_an_error_that_is_a_power(p):
    """f(h) = f + C h^p with h = 2, 1, 1/2: the differences from the last give p back."""
    values = 7.0 + 0.3 * np.array([2.0, 1.0, 0.5]) ** p
    coarse, usual = values[:2] - values[2]
    assert order(coarse, usual) == pytest.approx(p)
    # What the table adds: the difference from h / 2 misses that run's own error.
    assert usual * 2.0**p / (2.0**p - 1.0) == pytest.approx(0.3)
    assert math.isnan(order(0.1, 0.2)) and math.isnan(order(0.1, 0.0))


def test_differences_count_where_both_touch_and_the_rise_of_the_temperature():
    loads = np.tile([5.0, 120.0, 800.0, 2.0, 1.5], (10, 4, 1))
    on = np.ones((10, 4), dtype=bool)
    other = loads * [1.01, 1.0, 1.02, 1.03, 1.04] + [0.0, 5.0, 0.0, 0.0, 0.0]
    other[:2], other[5, 2] = 0.0, 0.0
    touching = on.copy()
    touching[5, 2] = False
    found = differences([(other, touching), (loads, on)], 20.0, 2)
    assert found[0] == pytest.approx([1.0, 5.0, 2.0, 3.0, 4.0])


def test_a_load_that_the_mesh_spoils_fails():
    """A process whose pressure is off by as many percent as its elements are large."""

    class Result:
        status = "ok"

        def __init__(self, h):
            self.contact = self
            self.active = np.ones((10, 4), dtype=bool)
            self.loads = np.tile([5.0, 120.0, 800.0 * (1.0 + 0.01 * h), 2.0, 1.5], (10, 4, 1))

    class Process:
        T_billet = 20.0

        def __init__(self, h):
            self.h = h

        def run(self, mu, stroke):
            return Result(self.h)

    outcome = _converge("made-up process", Process, 10.0, 1.0)
    verdicts = [row.verdict for row in outcome.rows]
    assert verdicts == ["pass", "pass", "fail", "pass", "pass"]
    assert outcome.rows[2].ours == pytest.approx(5.0 / 1.05) and outcome.rows[2].ours > TOLERANCES[2]
    assert "| 14.29 | 4.76 | 1.00 | 9.52 |" in outcome.details


def test_the_cases_are_known():
    assert {"fre-local-loads", "bce-local-loads", "ring-local-loads"} <= {case.name for case in CASES}
