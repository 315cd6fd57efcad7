"""What a diagnosis may still change in a model: derivatives of its own law, at its own parameters."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pandas as pd
import pytest

from friction_models import (
    FAMILIES,
    ConstantFriction,
    FrictionModel,
    PowerLawFriction,
    TriboLoads,
    make_model,
)
from friction_models.discovery import diagnose
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search.base_law import base_law

from .discovery.test_fixed import made

#: mm/s, MPa, mm; far from those that the family takes by default.
V0, S0, D0 = 40.0, 900.0, 6.0
#: ln C, exponents of speed, pressure, distance and expansion, temperature coefficient [1/degC].
TRUTH = np.array([2.1, -0.35, -0.4, 0.05, 0.3, -0.001])


def law(parameters: npt.NDArray[np.float64], data: pd.DataFrame) -> npt.NDArray[np.float64]:
    """Return mu of the multiplicative law, written down once more so that our code does not judge itself."""
    c, b, a, d, p, e = parameters
    factors = (data["v_rel"] + V0) ** b * (data["sigma_n"] + S0) ** a * (data["sd"] + D0) ** d
    return np.asarray(np.exp(c) * factors * data["psi"] ** p * np.exp(e * data["T"]))


def derivatives(of: Callable[[npt.NDArray[np.float64]], npt.NDArray[np.float64]]) -> npt.NDArray[np.float64]:
    """Return central differences of `of` at the true parameters, one column each."""
    steps = 1e-5 * np.eye(len(TRUTH))
    return np.column_stack([(of(TRUTH + h) - of(TRUTH - h)) / 2e-5 for h in steps])


def left_over(columns: npt.NDArray[np.float64], target: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the share of each column of `target` that `columns` cannot follow."""
    follow = np.linalg.lstsq(columns, target, rcond=None)[0]
    return np.linalg.norm(target - columns @ follow, axis=0) / np.linalg.norm(target, axis=0)


@pytest.fixture(scope="module")
def data() -> pd.DataFrame:
    """Return tests whose mean follows the law exactly; the points scatter, and the tests among each other."""
    made_up = made(0)
    rng = np.random.default_rng(1)
    frame = made_up.assign(psi=np.exp(rng.uniform(0.0, 2.0, 27))[made_up.groupby("test_id").ngroup()])
    frame["exact"] = law(TRUTH, frame)
    offsets = rng.normal(0.0, 0.001, 27)[frame.groupby("test_id").ngroup()]
    return frame.assign(mu=frame["exact"] + offsets + rng.normal(0.0, 0.001, len(frame)))


def test_columns_of_a_power_law_are_the_derivatives_of_that_law(data: pd.DataFrame) -> None:
    exact = prepare(data.assign(mu=data["exact"]))
    truth = derivatives(lambda parameters: law(parameters, data))
    own = base_law(PowerLawFriction(sigma_offset=S0, v_offset=V0, sd_offset=D0), exact)
    assert left_over(own.columns, truth).max() < 1e-5
    assert left_over(truth, own.columns).max() < 1e-5
    assert own.offset == pytest.approx(data["exact"].to_numpy(), rel=1e-6)
    # The test can fail: the columns of another law do not follow these derivatives.
    assert left_over(base_law(PowerLawFriction(), exact).columns, truth).max() > 1e-2


def test_a_power_law_of_other_offsets_lacks_nothing_on_its_own_data(data: pd.DataFrame) -> None:
    own = diagnose(data, model=PowerLawFriction(sigma_offset=S0, v_offset=V0, sd_offset=D0))
    assert own.verdict == "nothing_missing"


@pytest.mark.nightly  # by day the columns of the usual offsets do not follow these derivatives, above
def test_a_power_law_of_the_usual_offsets_lacks_something(data: pd.DataFrame) -> None:
    assert diagnose(data, model=PowerLawFriction(v_offset=1e-3)).verdict != "nothing_missing"


@pytest.mark.parametrize("name", ["constant", "linear", "polynomial"])
def test_columns_of_a_linear_family_hold_whatever_it_predicts(name: str, data: pd.DataFrame) -> None:
    model = make_model(name, **({"ridge": 0.0} if name == "polynomial" else {}))
    found = base_law(model, prepare(data))
    assert model.form == "linear" and not found.fixed
    assert (
        left_over(found.columns, model.fit_frame(data).predict_frame(data).to_numpy()[:, None]).max() < 1e-5
    )


def test_a_given_value_is_not_refitted(data: pd.DataFrame) -> None:
    found = base_law(ConstantFriction(0.07), prepare(data))
    assert found.fixed and set(found.offset) == {0.07} and found.columns.shape[1] == 1


def test_a_family_of_ones_own_needs_no_word_of_it(data: pd.DataFrame) -> None:
    class Median(FrictionModel):
        family = "median"

        def _fit(self, loads: TriboLoads, mu: npt.NDArray[np.float64], groups: object) -> None:
            self.level_ = float(np.median(mu))

        def formula(self, x, L, S=None, system=None):  # type: ignore[no-untyped-def]
            return x.constant(self.level_, L.v_rel)

        def formula_text(self) -> str:
            return "mu = median"

    found = base_law(Median(), prepare(data))
    assert found.name == "median" and not found.fixed
    # One, four loads that vary within tests or between them, psi, and predictions of tests left out.
    assert found.columns.shape[1] == 7
    assert "median" not in FAMILIES


def test_a_model_of_one_module_alone_can_be_added_to() -> None:
    code = "from friction_models.families.linear import LinearFriction; print((LinearFriction() + 'stribeck').name)"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert shown.strip() == "linear + stribeck"
