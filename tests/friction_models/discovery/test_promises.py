"""What proposed tests promise: no more than is left where a rival can be refitted."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose
from friction_models.discovery.further_tests import next_tests
from friction_models.discovery.further_tests.hypotheses import Hypotheses
from friction_models.discovery.further_tests.protocols import POINTS, PlannedTest
from friction_models.estimation.search.significance import SAME
from friction_models.loads import TriboLoads

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


@pytest.fixture(scope="module")
def known() -> Hypotheses:
    """What `diagnose` takes to be possible where it asks for further tests: a strong effect, and its near twin."""
    made: list[Hypotheses] = []

    class Noted(Hypotheses):
        def __init__(self, *given: Any) -> None:
            super().__init__(*given)
            made.append(self)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(next_tests, "Hypotheses", Noted)
        diagnose(*measured(0.08), catalogue=LAWS)
    assert made[-1].names == LAWS
    return made[-1]


def test_a_lead_that_may_be_a_matter_of_formulas_rules_no_shape_out(known: Hypotheses) -> None:
    """The rival is refitted to a new test: its shapes are as uncertain as the formulas are wrong, however strong the effect is."""
    fit = known.fits[0]
    assert fit.name == "stribeck"
    columns = known.found.project(known.found.whiten(fit.prepared.candidate.columns[:, :, 0]))
    drop = np.array([float(c @ known.found.residual) ** 2 / float(c @ c) for c in columns.T])
    behind = drop.max() - drop
    assert np.sort(behind)[1] > 5.0 * next_tests.ENOUGH**2  # by its likelihood alone one shape is left
    possible = [p.index for p in known.possible[0] if p.index is not None]
    assert len(possible) > 1 and behind[possible].max() < 2.0 * SAME * fit.evidence


def test_the_base_is_not_carried_on_beyond_the_tested_distance(known: Hypotheses) -> None:
    """Beside each effect it has another trend along the tests: carried on, that would tell the effects apart."""
    one, sd = np.ones(POINTS), 2.0 * LENGTH * (np.arange(POINTS) + 1.0) / POINTS
    test = PlannedTest(
        "long run",
        {},
        {"T_tool": 20.0},
        TriboLoads(40.0 * one, 30.0 * one, 900.0 * one, sd, 1.1 * one, t=sd / 40.0),
    )
    predicted = known.predict([test])
    means = predicted.mean[predicted.owner < len(LAWS)]
    # from 1 to 17 mm, and from 26 to 37 mm
    within, beyond = means[:, 5] - means[:, 0], means[:, -1] - means[:, -3]
    assert within == pytest.approx(0.78 * RISE * np.ones(len(means)), abs=0.1 * RISE)
    assert beyond == pytest.approx(np.zeros(len(means)), abs=0.05 * RISE)
