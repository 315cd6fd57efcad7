"""Response curves of models that remember: drawn after the distance that the caption names."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models import FrictionModel, LinearFriction
from friction_models.effects import WorkExhaustion
from friction_models.loads import LOAD_NAMES, TriboLoads
from friction_models.models.response_curves import after_sliding, remembers
from orchestrator.report.charts.responses import caption, response_chart


@pytest.fixture(scope="module")
def model() -> tuple[FrictionModel, pd.DataFrame]:
    """A law whose lubricant is used up by the work of friction."""
    rng = np.random.default_rng(3)
    rows = []
    for k in range(24):
        v, T, sigma, psi = 20 + 10 * (k % 4), 20.0 + 40 * (k % 3), 600 + 300 * (k % 5), 1.0 + 0.1 * (k % 2)
        work = 0.0
        for sd in np.linspace(0, 60, 31):
            mu = 0.06 + 0.05 * (1 - np.exp(-((work / 2.0) ** 2)))
            rows.append((f"t{k}", v, T, sigma, sd, psi, mu + rng.normal(0, 0.0005)))
            work += mu * sigma * 2.0 / 1000.0
    frame = pd.DataFrame(rows, columns=["test_id", *LOAD_NAMES, "mu"])
    return (LinearFriction() + WorkExhaustion()).fit_frame(frame), frame


def test_the_curve_is_that_of_a_test_that_slid_there(model: tuple[FrictionModel, pd.DataFrame]) -> None:
    law, frame = model
    assert remembers(law)
    points = np.array([[40.0, T, 1200.0, 30.0, 1.1] for T in (20.0, 60.0)])
    # A finer way, written out by hand.
    fine = pd.concat(
        pd.DataFrame(np.tile(p, (401, 1)), columns=list(LOAD_NAMES)).assign(
            sd=np.linspace(0.0, 30.0, 401), t=np.linspace(0.0, 30.0 / 40.0, 401), test_id=f"x{k}"
        )
        for k, p in enumerate(points)
    )
    wanted = law.predict_frame(fine.reset_index(drop=True)).to_numpy()[400::401]
    assert after_sliding(law, points) == pytest.approx(wanted, abs=3e-4)
    assert np.abs(wanted - law.predict(points)).min() > 0.005
    loads = TriboLoads.from_frame(frame)
    middle = np.median(loads.as_array(), axis=0)[None]
    drawn = response_chart(loads, [("law", {}, law)]).figure.data[1]
    at = float(np.interp(middle[0, 1], drawn.x, drawn.y))
    assert at == pytest.approx(after_sliding(law, middle)[0], abs=1e-4)
    assert "after it slid 30 mm (sd) from fresh contact, the median of the data" in caption(loads, [law])


def test_a_point_at_rest_and_one_at_the_start(model: tuple[FrictionModel, pd.DataFrame]) -> None:
    law, _ = model
    found = after_sliding(law, np.array([[0.0, 20.0, 1200.0, 30.0, 1.1], [40.0, 20.0, 1200.0, 0.0, 1.1]]))
    assert np.isfinite(found).all()
    assert found[1] == pytest.approx(law.predict([[40.0, 20.0, 1200.0, 0.0, 1.1]])[0])
