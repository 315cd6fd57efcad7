"""Shapes that only scale an effect in the tests that are there are not fitted; made-up tests."""

from __future__ import annotations

import numpy as np
import pytest

from friction_models import ConstantFriction, LinearFriction
from friction_models.effects import Stribeck, Viscous
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.fit.parameters import fit_terms
from friction_models.estimation.search.base_law import base_law

from .estimation_cases import measured


@pytest.mark.parametrize("temperature", ["recorded", "not recorded"])
def test_what_no_test_shows_leaves_the_size_known(temperature: str) -> None:
    """The size of viscous friction was "not known" where no test changed the temperature."""
    rng = np.random.default_rng(5)
    data = measured(rng, between=0.001)
    data["mu"] += 1e-5 * data["sigma_n"]  # what the generator takes off
    data["sigma_n"] = 1000.0
    data = data.assign(T=60.0) if temperature == "recorded" else data.drop(columns="T")
    data["mu"] += 0.03 * (data["v_rel"] / 500.0) ** 0.6
    campaign = prepare(data)
    (term,) = fit_terms(campaign, base_law(ConstantFriction(), campaign, 0), [Viscous()]).terms
    assert {"beta", "m"} <= {*term.shape} and {"beta", "m"}.isdisjoint(term.intervals)
    assert term.intervals["k_v"][0] > 0.0, term.intervals


def test_shapes_that_tests_show_are_fitted() -> None:
    rng = np.random.default_rng(5)
    data = measured(rng, between=0.001)
    data["mu"] += 0.03 * np.exp(-0.01 * (data["T"] - 20.0)) * (data["v_rel"] / 500.0) ** 0.6
    campaign = prepare(data)
    law = base_law(LinearFriction(), campaign, 0)
    (term,) = fit_terms(campaign, law, [Viscous()]).terms
    assert "beta" in term.intervals
    (term,) = fit_terms(campaign, law, [Stribeck()]).terms
    assert {"v_s", "d"} <= {*term.intervals}
