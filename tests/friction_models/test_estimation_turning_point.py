"""Where a falling term and a rising line turn, or the line wins, against what a derivative gives."""

from __future__ import annotations

import numpy as np
import pytest

from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search.law_signs import runs_against, turning_point

from .estimation_cases import measured


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_law_turns_where_its_slopes_cancel(sign: float) -> None:
    campaign = prepare(measured(np.random.default_rng(2), tests=80, points=6))
    p = campaign.average(campaign.loads.sigma_n)
    slope, size, length = 2e-5, 0.12, 400.0
    turns = length * np.log(size / (slope * length))  # where the derivative of the sum is nothing
    term = sign * size * np.exp(-p / length)
    assert turning_point(campaign, "sigma_n", sign * slope * p, term) == pytest.approx(turns, rel=0.1)
    assert turning_point(campaign, "sigma_n", -sign * slope * p, term) is None
    assert turning_point(campaign, "sigma_n", 0.0 * p, term) is None
    # by the derivative the line is steeper than the term ever is, or never so steep
    for steep, against in ((1.1, True), (0.0, False), (-1.1, False)):
        line = sign * steep * size / length * p
        assert runs_against(campaign, "sigma_n", line, term) == against
