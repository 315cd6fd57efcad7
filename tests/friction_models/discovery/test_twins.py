"""Effects that contribute the same: which of them is named first does not hang on single tests."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose

from ..estimation_cases import measured

CHANGES = 4


def under_pressure(seed: int) -> pd.DataFrame:
    """Return tests in which mu falls with pressure by a hyperbolic tangent; constant pressures cannot part its twins."""
    data = measured(np.random.default_rng(seed), tests=36, points=6, between=0.002)
    return data.assign(mu=data["mu"] - 0.06 * np.tanh(data["sigma_n"] / 900.0))


def first_names(data: pd.DataFrame, rng: np.random.Generator) -> set[str]:
    """Return the first names of answers to the data without a tenth of the tests, each time another one."""
    names = np.array(sorted(data["test_id"].unique()))
    told = set()
    for _ in range(CHANGES):
        kept = rng.permutation(names)[4:]
        told.update(diagnose(data[data["test_id"].isin(kept)]).effects[:1])
    return told


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.nightly)])
def test_the_first_of_twins_does_not_hang_on_single_tests(seed: int) -> None:
    told = first_names(under_pressure(seed), np.random.default_rng(seed))
    # fewest numbers first, then the order of the catalogue; a fault last
    assert told == {"pressure_power"}
