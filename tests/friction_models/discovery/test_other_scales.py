"""Contacts of other sizes than forging's: distances of metres and kilometres, temperatures below zero.

The laws are written here, in forms of their own, from what is known of these contacts; none is taken from the catalogue.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models import ConstantFriction
from friction_models.discovery import diagnose, refine
from friction_models.effects import CATALOGUE, Hersey, RunningIn, ThermalBreakdown
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search.candidates import spans_of
from friction_models.loads import FloatArray, TriboLoads


def polished(longest: float, seed: int = 0) -> pd.DataFrame:
    """Return 10 tests at constant loads: half of an excess of 0.06 is polished off in a tenth of the distance."""
    rng = np.random.default_rng(seed)
    sd = np.linspace(longest / 80, longest, 80)
    tests = []
    for k in range(10):
        v, p, T = rng.choice([40.0, 80.0, 120.0]), rng.choice([400.0, 800.0]), rng.choice([60.0, 100.0])
        mu = 0.11 + 0.06 * 2.0 ** (-sd / (0.1 * longest)) + 0.004 * rng.standard_normal()
        mu = mu + 0.003 * rng.standard_normal(80)
        loads = {"t": sd / v, "v_rel": v, "T": T, "sigma_n": p, "sd": sd, "psi": 1.0}
        tests.append(pd.DataFrame({"test_id": f"t{k:02d}", **loads, "mu": mu}))
    return pd.concat(tests, ignore_index=True)


def at_temperatures(places: FloatArray, mu: FloatArray, scatter: float, seed: int = 0) -> pd.DataFrame:
    """Return tests at a temperature each, of 12 points, with their friction, an offset each and noise."""
    rng = np.random.default_rng(seed)
    sd = np.linspace(1.0, 30.0, 12)
    tests = []
    for k, (T, own) in enumerate(zip(places, mu, strict=True)):
        v, p = rng.choice([100.0, 300.0, 1000.0]), rng.choice([0.5, 1.0, 2.0])
        measured = own + scatter * (rng.standard_normal() + rng.standard_normal(12))
        loads = {"t": sd / v, "v_rel": v, "T": T, "sigma_n": p, "sd": sd, "psi": 1.0}
        tests.append(pd.DataFrame({"test_id": f"t{k:02d}", **loads, "mu": measured}))
    return pd.concat(tests, ignore_index=True)


@pytest.mark.nightly
def test_running_in_over_a_tenth_of_the_path_is_named_whatever_the_path() -> None:
    answers = [diagnose(polished(longest), model="constant", seed=0) for longest in (30.0, 1e5, 3e6)]
    assert [a.effects for a in answers] == 3 * [["running_in"]]
    assert np.ptp([a.confidence for a in answers]) == pytest.approx(0.0, abs=1e-3)
    assert min(a.confidence for a in answers) > 0.8


@pytest.mark.parametrize("name", CATALOGUE)
def test_scan_values_are_the_same_in_other_units_of_length_and_time(name: str) -> None:
    """A limit in mm that cuts them off where paths are long would give another answer to the same measurements in m."""
    data, grids = polished(1e5), []
    for m, s in ((1.0, 1.0), (1e-3, 1.0), (1.0, 60.0)):
        other = {"t": data["t"] / s, "v_rel": m * s * data["v_rel"], "sd": m * data["sd"]}
        campaign = prepare(data.assign(**other))
        grids.append(CATALOGUE[name]().grids(spans_of(campaign, np.full(len(data), 0.1))))
    for parameter, values in grids[0].items():
        for scan in (grid[parameter] for grid in grids[1:]):
            assert scan / scan[-1] == pytest.approx(values / values[-1]), parameter


def test_a_run_of_kilometres_is_read() -> None:
    """A pin on a disc slides further in a day than a billet ever does."""
    loads = TriboLoads.from_frame(pd.DataFrame({"v_rel": [500.0], "sd": [5e6]}))
    assert loads.sd.tolist() == [5e6]


def test_a_hump_below_zero_gets_a_term() -> None:
    """Rubber on ice sticks best at one temperature, which no effect describes."""
    T = -np.linspace(1.0, 29.0, 30)
    data = at_temperatures(T, 0.1 + 0.05 / (1.0 + ((T + 14.0) / 3.0) ** 4), 0.002)
    found = diagnose(data, seed=0)
    assert found.verdict == "unknown_structure"
    assert "T" in str(found.where)
    fitted = refine(data, add=found.formulas[0].effects)
    entry = fitted.error_history_[-1]
    assert entry["after"]["rmse"] < 0.5 * entry["before"]["rmse"]


def test_breakdown_below_thirty_degrees_keeps_to_what_was_tested() -> None:
    T = np.linspace(-40.0, 25.0, 30)
    law = 0.05 + 0.08 / (1.0 + 10.0 ** (-(T + 5.0) / 9.0))
    found = diagnose(at_temperatures(T, law, 0.002), model="constant", seed=0)
    assert found.effects == ["thermal_breakdown"]
    values = found.parameters["thermal_breakdown"]["values"]
    assert -15.0 < values["T_b"]["value"] < 5.0


def test_a_value_inside_wide_bounds_is_not_at_one() -> None:
    """Bounds that span 21 decades: 107 mm/s/MPa lies in the middle of them."""
    h_0 = next(s for s in Hersey.shapes if s.name == "h_0")
    assert not h_0.at_bound(107.0)
    assert h_0.at_bound(h_0.lower)
    assert h_0.at_bound(h_0.upper)
    s_r = next(s for s in RunningIn.shapes if s.name == "s_r")
    assert not s_r.at_bound(3.0)
    T_b = next(s for s in ThermalBreakdown.shapes if s.name == "T_b")
    assert not T_b.at_bound(0.0)


@pytest.mark.parametrize("value", [-190.0, -1.0, 0.0, 250.0])
def test_temperatures_are_fitted_from_absolute_zero_on(value: float) -> None:
    T_b = next(s for s in ThermalBreakdown.shapes if s.name == "T_b")
    assert T_b.logarithmic
    assert T_b.outer(T_b.inner(value)) == pytest.approx(value, abs=1e-9)


def test_limits_of_a_fit_hold_what_was_scanned_below_zero() -> None:
    T_b = next(s for s in ThermalBreakdown.shapes if s.name == "T_b")
    low, high = ThermalBreakdown().limits(T_b, np.array([-58.0, -2.0]))
    assert low < -58.0
    assert high > 40.0  # as much room above as there is below: 0 degC is no end of a scale


def test_a_refined_model_knows_the_loads_that_it_was_trained_on() -> None:
    """Speeds and pressures that were read with 2 % noise: no training point lies outside of the domain."""
    data = polished(30.0)
    rng = np.random.default_rng(4)
    for name in ("v_rel", "sigma_n"):
        data[name] *= 1.0 + 0.02 * rng.standard_normal(len(data))
    fitted = refine(data, model="constant", add="running_in")
    loads = TriboLoads.from_frame(data)
    assert np.max(fitted.domain.distance(loads.as_array())) == 0.0
    assert isinstance(fitted.base_, ConstantFriction)
    assert np.max(fitted.base_.domain.distance(loads.as_array())) == 0.0
