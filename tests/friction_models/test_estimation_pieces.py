"""Averages of neighbouring points stand for these where a formula is evaluated many times: also with memory, rests and uneven bins."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models.effects import make_effect
from friction_models.estimation.campaign.binned_tests import PIECES, BinnedTests
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search.candidates import bin_means, evaluate_points


def recorded(points: int, rest: float = 0.0) -> pd.DataFrame:
    """Return six tests whose speed steps up and down in all of them, and that may rest for some seconds after a third of the way."""
    rng = np.random.default_rng(4)
    sd = np.linspace(0.05, 40.0, points)
    frames = []
    for k in range(6):
        v = np.where(np.floor(sd / 7.0) % 2 == 0, 20.0, 150.0) * (1.0 + 0.2 * k)
        stops = np.where(np.arange(points) == points // 3, rest, 0.0)
        t = np.cumsum(np.diff(sd, prepend=0.0) / v + stops)
        loads = {
            "v_rel": v,
            "T": 60.0 + 20.0 * np.sqrt(sd),
            "sigma_n": 400.0 + 300.0 * k + 2.0 * sd,
            "sd": sd,
        }
        frames.append(pd.DataFrame({"test_id": f"t{k}", "t": t, **loads, "psi": 1.1 + 0.01 * sd}))
    table = pd.concat(frames, ignore_index=True)
    return table.assign(mu=0.08 + rng.normal(0.0, 0.001, len(table)))


def exact(campaign: BinnedTests, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the bin means of an effect, of averages and of all points, at its typical shape."""
    effect = make_effect(name)
    shape = effect.start_shape()
    at_points = np.hstack(evaluate_points(effect, campaign, campaign.mu, shape))
    return bin_means(effect, campaign, campaign.mu, shape)[:, 0], campaign.average(at_points)


@pytest.mark.parametrize("rest", [0.0, 30.0])
@pytest.mark.parametrize(
    "name", ["rate_state", "work_exhaustion", "static_peak", "stribeck", "thermal_breakdown"]
)
def test_means_are_those_of_all_points(name: str, rest: float) -> None:
    few, all_points = exact(prepare(recorded(4000, rest)), name)
    assert np.ptp(all_points) > 0.01
    assert few == pytest.approx(all_points, abs=0.01 * np.ptp(all_points))


def test_no_piece_holds_points_before_and_after_a_rest() -> None:
    campaign = prepare(recorded(4000, 30.0))
    pieces = campaign.pieces
    assert len(pieces.mu) <= PIECES * len(campaign.starts) + 3 * 7 * len(campaign.tests)
    slid = np.diff(campaign.loads.t if campaign.loads.t is not None else np.zeros(0))
    before = np.flatnonzero(slid > 10.0)
    assert len(before) == len(campaign.tests)
    ends = np.cumsum(pieces.weight)
    assert set(before + 1) <= set(ends.astype(int))
    assert np.sum(pieces.course.pause) == pytest.approx(np.sum(campaign.course.pause), rel=0.01)


def test_averages_weigh_by_the_points_they_hold() -> None:
    campaign = prepare(recorded(333))
    pieces = campaign.pieces
    assert len(pieces.mu) < len(campaign.mu)
    assert pieces.average(pieces.mu) == pytest.approx(campaign.average(campaign.mu), rel=1e-12)
    assert pieces.average(pieces.loads.sd) == pytest.approx(campaign.average(campaign.loads.sd), rel=1e-12)
    assert pieces.pieces is pieces or len(pieces.pieces.mu) <= len(pieces.mu)


def test_few_points_stay_as_they_are() -> None:
    campaign = prepare(recorded(40))
    assert campaign.pieces is campaign
