"""What proposed tests promise: no more than is left where a rival can be refitted."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose
from friction_models.discovery.further_tests import hypotheses, next_tests
from friction_models.discovery.further_tests.formula_error import ENOUGH
from friction_models.discovery.further_tests.hypotheses import Hypotheses
from friction_models.discovery.further_tests.information import Outcomes
from friction_models.discovery.further_tests.protocols import POINTS, PlannedTest
from friction_models.estimation.search.significance import SAME
from friction_models.loads import FloatArray, TriboLoads

#: Distance of a test [mm], and how much friction rises over it.
LENGTH, RISE = 20.0, 0.01
CROSSED = [
    (sigma, v, tool)
    for sigma in (600.0, 1200.0, 1800.0)
    for v, tool in ((5.0, 20.0), (15.0, 200.0), (40.0, 20.0), (100.0, 200.0), (250.0, 20.0), (500.0, 200.0))
]
LAWS = ["stribeck", "hersey"]


def measured(size: float) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Tests whose friction falls with speed by `size`, not quite as a formula of the catalogue says, and rises along them."""
    rng = np.random.default_rng(5)
    sd = np.linspace(0.5, LENGTH, 40)
    frames, tests = [], []
    for k, (sigma, v, tool) in enumerate(CROSSED):
        T = tool + 2e-5 * sigma * np.sqrt(v * sd)
        mu = 0.09 + size / (1.0 + (v / 40.0) ** 1.5) + RISE * sd / LENGTH
        mu = mu + rng.normal(0.0, 0.0015) + rng.normal(0.0, 0.001, len(sd))
        points = {"t": sd / v, "v_rel": v, "T": T, "sigma_n": sigma, "sd": sd, "psi": 1.1, "mu": mu}
        frames.append(pd.DataFrame({"test_id": f"t{k:02d}", **points}))
        tests.append({"test_id": f"t{k:02d}", "T_tool": tool})
    return pd.concat(frames, ignore_index=True), pd.DataFrame(tests)


def along(sd: FloatArray) -> PlannedTest:
    """A test over some distances at one setting, within the tested loads."""
    one = np.ones(POINTS)
    loads = TriboLoads(40.0 * one, 20.0 * one, 1200.0 * one, sd, 1.1 * one, t=sd / 40.0)
    return PlannedTest("constant", {}, {"T_tool": 20.0}, loads)


@pytest.fixture(scope="module")
def asked() -> tuple[Any, ...]:
    """What `diagnose` makes hypotheses of where it asks for further tests: a strong effect, and its near twin."""
    made: list[tuple[Any, ...]] = []

    class Noted(Hypotheses):
        def __init__(self, *given: Any) -> None:
            super().__init__(*given)
            made.append(given)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(next_tests, "Hypotheses", Noted)
        diagnose(*measured(0.08), catalogue=LAWS)
    return made[-1]


@pytest.fixture(scope="module")
def known(asked: tuple[Any, ...]) -> Hypotheses:
    """The hypotheses."""
    found = Hypotheses(*asked)
    assert found.names == LAWS
    return found


def test_a_lead_that_may_be_a_matter_of_formulas_rules_no_shape_out(known: Hypotheses) -> None:
    """The rival is refitted to a new test: its shapes are as uncertain as the formulas are wrong, however strong the effect is."""
    fit = known.fits[0]
    assert fit.name == "stribeck"
    columns = known.found.project(known.found.whiten(fit.prepared.candidate.columns[:, :, 0]))
    drop = np.array([float(c @ known.found.residual) ** 2 / float(c @ c) for c in columns.T])
    behind = drop.max() - drop
    assert np.sort(behind)[1] > 5.0 * ENOUGH**2  # by its likelihood alone one shape is left
    possible = [p.index for p in known.possible[0] if p.index is not None]
    assert len(possible) > 1 and behind[possible].max() < 2.0 * SAME * fit.evidence


def test_coefficients_are_as_uncertain_as_formulas_are_wrong(
    asked: tuple[Any, ...], known: Hypotheses
) -> None:
    """As if all noise were larger, by the lead that may be a matter of formulas beside one of three standard errors."""
    *others, allowance = asked
    assert allowance == pytest.approx(SAME * known.fits[0].evidence / 9.0)
    test = along(LENGTH * (np.arange(POINTS) + 1.0) / POINTS)
    own, sure = known.predict([test]), Hypotheses(*others).predict([test])
    levels = [
        float(np.mean(o.covariance[0])) - known.overdispersion * known.found.floor.test**2
        for o in (own, sure)
    ]
    assert allowance > 5.0 and 0.3 * allowance < levels[0] / levels[1] < 1.1 * allowance
    # what they are is as before: a new test at the setting of old ones is expected where those were
    assert own.mean[0].mean() == pytest.approx(0.09 + 0.04 + 0.5 * RISE, abs=0.004)


def test_the_base_is_not_carried_on_beyond_the_tested_distance(known: Hypotheses) -> None:
    """Beside each effect it has another trend along the tests: carried on, that would tell the effects apart."""
    test = along(2.0 * LENGTH * (np.arange(POINTS) + 1.0) / POINTS)
    predicted = known.predict([test])
    means = predicted.mean[predicted.owner < len(LAWS)]
    # from 1 to 17 mm, and from 26 to 37 mm
    within, beyond = means[:, 5] - means[:, 0], means[:, -1] - means[:, -3]
    assert within == pytest.approx(0.78 * RISE * np.ones(len(means)), abs=0.1 * RISE)
    assert beyond == pytest.approx(np.zeros(len(means)), abs=0.05 * RISE)


def test_what_only_makes_up_for_wrong_formulas_is_not_promised(known: Hypotheses) -> None:
    """A rival leaves where the lead over it is more than 2 % of the evidence: three standard errors of noise are not enough."""
    one, other = (f.evidence for f in known.fits)
    lead = one - other
    assert SAME * one > lead + 9.0
    outcomes = known.predict([along(LENGTH * (np.arange(POINTS) + 1.0) / POINTS)])
    assert outcomes.owed is not None
    assert outcomes.owed[0, 1] * known.overdispersion == pytest.approx(SAME * one - 9.0 - lead)
    assert outcomes.owed[1, 0] * known.overdispersion == pytest.approx(SAME * one - 9.0)
    # five standard errors, of whose square sixteen are owed, are three
    apart = Outcomes(
        np.full(2, 0.5),
        np.arange(2),
        np.ones(2),
        np.array([[0.0], [5.0]]),
        np.ones((2, 1, 1)),
        np.full((2, 2), 16.0),
    )
    assert apart.separation(0, 1) == pytest.approx(3.0, rel=0.15)


def test_a_weak_effect_owes_nothing_to_formulas(asked: tuple[Any, ...]) -> None:
    *others, _ = asked
    outcomes = Hypotheses(*others).predict([along(LENGTH * (np.arange(POINTS) + 1.0) / POINTS)])
    assert outcomes.owed is not None and not outcomes.owed.any()


def test_what_is_owed_counts_as_much_less_as_all_leads_do(
    asked: tuple[Any, ...], known: Hypotheses, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the leads of existing tests scatter more than the noise says, a new one is divided by as much."""
    monkeypatch.setattr(hypotheses, "rivalry", lambda *_: SimpleNamespace(overdispersion=4.0))
    test = along(LENGTH * (np.arange(POINTS) + 1.0) / POINTS)
    usual, scattered = (h.predict([test]).owed for h in (known, Hypotheses(*asked)))
    assert usual is not None and scattered is not None
    assert 4.0 * scattered == pytest.approx(known.overdispersion * usual)
