"""Long communication steps are pointed out where friction follows the loads, and only there."""

from __future__ import annotations

import numpy as np
import pytest

from forming import Upsetting
from forming.processes.lag_warning import lag_warnings


def law(loads, t):
    return 0.05 + 1e-5 * loads[:, 2]


@pytest.mark.parametrize(
    ("friction", "step", "said"), [(law, 0.5, True), (law, 0.2, False), (0.08, 0.5, False)]
)
def test_a_run_says_when_friction_lags(friction, step, said):
    process = Upsetting(mesh_size=1.8, n_points=12, isothermal=True)
    result = process.run(friction, 1.0, communication_step=step)
    assert any("0.5 mm in a communication step" in text for text in result.warnings) == said
    assert all(text.startswith("upsetting: ") for text in result.warnings)


def test_rounding_of_a_step_is_not_a_long_step():
    assert lag_warnings(float(np.linspace(0.0, 1.0, 6)[1]) * (1.0 + 1e-12), "run") == ()
    assert len(lag_warnings(0.21, "run")) == 1
