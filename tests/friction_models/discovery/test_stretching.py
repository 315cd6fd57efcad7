"""Planned tests stretch as the tests that were run do; made-up tests."""

from __future__ import annotations

import numpy as np
import pytest

from friction_models.discovery.further_tests.protocols import possible_tests
from friction_models.discovery.further_tests.stretching import Stretching
from friction_models.estimation.campaign.binning import prepare

from ..estimation_cases import measured


def test_a_planned_test_grows_as_the_tests_do() -> None:
    """A test at constant expansion tells it from the distance, but no rig can run it."""
    data = measured(np.random.default_rng(3), tests=20)
    data["psi"] = 1.0 + 0.25 * (data["sd"] / data["sd"].max()) ** 0.7
    usual = data["psi"].mean()
    for test in possible_tests(prepare(data)):
        loads = test.loads
        inside = loads.sd <= data["sd"].max()
        grown = 1.0 + 0.25 * (loads.sd[inside] / data["sd"].max()) ** 0.7
        assert loads.psi[inside] == pytest.approx(grown, abs=0.03), test.protocol
        assert loads.psi.min() < usual < loads.psi.max()


def test_what_does_not_grow_along_a_test_does_not_in_a_planned_one() -> None:
    found = Stretching.learn(prepare(measured(np.random.default_rng(3))))
    assert found.along(1.2, np.array([0.0, 10.0, 100.0])).tolist() == pytest.approx([1.2] * 3)
    nothing = Stretching.learn(prepare(measured(np.random.default_rng(3)).assign(psi=1.0)))
    assert nothing.along(1.3, np.array([5.0])).tolist() == pytest.approx([1.3])
