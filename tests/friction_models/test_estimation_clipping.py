"""Readings that end at one value are told; readings that a logger rounds, or that nothing disturbs, are not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from friction_models.estimation.campaign.binning import prepare
from friction_models.loads import FloatArray

from .estimation_cases import measured


def said(change: Callable[[FloatArray], FloatArray], seed: int = 3) -> list[str]:
    data = measured(np.random.default_rng(seed), tests=20, points=120, between=0.006)
    return [w for w in prepare(data.assign(mu=change(data["mu"].to_numpy()))).warnings if "clipped" in w]


@pytest.mark.parametrize("share", [0.03, 0.2])
def test_an_amplifier_that_reads_no_further_is_told(share: float) -> None:
    (largest,) = said(lambda mu: np.minimum(mu, np.quantile(mu, 1.0 - share)))
    assert f"{share * 2400:.0f} of 2400 points read the largest mu" in largest
    (smallest,) = said(lambda mu: np.maximum(mu, np.quantile(mu, share)))
    assert "the smallest mu" in smallest


def test_a_logger_that_rounds_and_then_reads_no_further_is_told() -> None:
    rounded = said(
        lambda mu: np.minimum(0.0005 * np.round(mu / 0.0005), 0.0005 * np.round(np.median(mu) / 0.0005))
    )
    assert len(rounded) == 1


@pytest.mark.parametrize("step", [0.0005, 0.002, 0.005])
@pytest.mark.parametrize("seed", range(4))
def test_a_logger_that_rounds_is_not_clipped(step: float, seed: int) -> None:
    assert said(lambda mu: step * np.round(mu / step), seed) == []


def test_measurements_as_they_are_and_one_value_are_not_clipped() -> None:
    assert said(lambda mu: mu) == []
    assert said(lambda mu: np.full(len(mu), 0.1)) == []
    assert said(lambda mu: np.where(mu > np.median(mu), 0.12, 0.1)) == []
