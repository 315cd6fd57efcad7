"""Do settings differ by more than repeats do? Repeats that were run with other batches and tools; made-up tests."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd

from friction_models import LinearFriction
from friction_models.discovery.judge.beside_repeats import BesideRepeats
from friction_models.discovery.judge.unseen_tests import UnseenTests
from friction_models.estimation.campaign.binned_tests import BinnedTests
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.noise.repeats import repeats_of
from friction_models.estimation.search.base_law import base_law

SETTINGS, SCATTER = 15, 0.003


def repeated(seed: int, apart: float) -> tuple[BinnedTests, np.ndarray]:
    """Return tests, two at each setting, and what a model leaves of their averages; `apart`: scatter from setting to setting."""
    rng = np.random.default_rng([seed, 5])
    names = [f"t{k:02d}" for k in range(2 * SETTINGS)]
    setting = np.repeat(np.arange(SETTINGS), 2)
    tests = pd.DataFrame({"test_id": names})
    tests["batch"] = rng.permutation([f"batch {k % 4}" for k in range(len(names))])
    tests["tool"] = rng.permutation([f"tool {k % 3}" for k in range(len(names))])
    level = rng.normal(0.0, apart, SETTINGS)[setting] + rng.normal(0.0, SCATTER, len(names))
    level += 0.004 * tests["batch"].str[-1].astype(float).to_numpy()
    data = pd.DataFrame(
        {
            "test_id": names,
            "v_rel": np.geomspace(5.0, 400.0, SETTINGS)[setting],
            "T": 20.0,
            "sigma_n": np.tile([500.0, 900.0, 1500.0], SETTINGS // 3)[setting],
            "sd": 20.0,
            "psi": 1.2,
            "mu": 0.1 + level,
        }
    )
    return prepare(data, tests), level - level.mean()


def said(apart: float) -> list[float]:
    """Return the p-values of made-up campaigns."""
    found = [repeats_of(*repeated(seed, apart)) for seed in range(40)]
    return [r.p_value for r in found if r is not None]


def test_settings_that_are_alike_differ_by_chance_as_often_as_said() -> None:
    p = said(0.0)
    assert len(p) == 40
    # the levels of batch and tool that are taken out of the repeats make these no witness against the settings
    assert sum(v < 0.05 for v in p) <= 6 and 0.3 < np.mean(p) < 0.7


def test_settings_that_differ_are_seen() -> None:
    assert sum(v < 0.05 for v in said(4.0 * SCATTER)) >= 36


def test_the_judge_looks_at_batches_and_tools_too() -> None:
    """What unseen tests are predicted with need not hold them; without, settings differ by the batches they were run with."""
    campaign, left = repeated(3, 0.0)
    bare = replace(campaign, system={})
    straight: Any = SimpleNamespace(residual=lambda kept: left)
    unseen = UnseenTests(bare, base_law(LinearFriction(), bare))
    found = BesideRepeats(campaign, unseen, straight)._repeats([])
    assert found == repeats_of(campaign, left) != repeats_of(bare, left)
