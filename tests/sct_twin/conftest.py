"""One tiny synthetic campaign for all tests of the twin."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from friction_models.common.cached_results import cache_folder
from sct_twin import RawCampaign, SctRecord, SctTwin, TwinResult
from sct_twin.virtual_lab import Campaign
from tests.made_once import made_once


@pytest.fixture(scope="session")
def lab_cache() -> Path:
    """Where all campaigns keep their upsetting runs, under a hash of the solver: no process computes one again."""
    return cache_folder()


@pytest.fixture(scope="session")
def tiny(run_folder: Path, lab_cache: Path) -> RawCampaign:
    """Six training and three held-out tests with a hidden effect."""
    lab = Campaign(plan="tiny-6+3", hidden="running_in", seed=3, cache=lab_cache)
    return RawCampaign.load(made_once(run_folder / "tiny-lab", lambda out: lab.run(out=out, jobs=1)))


@pytest.fixture(scope="session")
def twinned(
    tiny: RawCampaign, run_folder: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[TwinResult, Path]:
    """The campaign after the twin, and its data-set folder; the twin takes the tests that another process has evaluated."""
    out = tmp_path_factory.mktemp("data") / "tiny"
    shutil.copytree(made_once(run_folder / "tiny-data", lambda d: SctTwin().run(tiny, out=d, jobs=1)), out)
    return SctTwin().run(tiny, out=out, jobs=1), out


def made_up(
    mu: Callable[[np.ndarray], np.ndarray] | float = 0.08,
    v_set: float = 50.0,
    mass: float = 25.0,
    noise: float = 0.0,
    direction: float = 1.0,
    sliding: float = 12.0,
    ramp: float = 0.02,
) -> SctRecord:
    """A record with a known coefficient of friction of the sliding distance."""
    rng = np.random.default_rng(5)
    rate = 1000.0
    slide = np.arange(int((sliding / v_set + ramp) * rate)) / rate
    v = v_set * np.where(slide < ramp, 0.5 * (1.0 - np.cos(np.pi * slide / ramp)), 1.0)
    load = np.concatenate([np.zeros(100), np.linspace(0.0, 94e3, 400), np.full(300, 94e3)])
    F_n = np.concatenate([load, np.full(len(slide), 94e3)])
    v = np.concatenate([np.zeros(len(load)), v])
    a = np.gradient(v, 1.0 / rate)
    sd = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) / rate)])
    friction = np.where(v > 0, mu(sd) if callable(mu) else mu, 0.0) * F_n

    def noisy(values: np.ndarray, deviation: float) -> np.ndarray:
        return values + noise * deviation * rng.standard_normal(len(values))

    return SctRecord(
        "made-up",
        np.arange(len(v)) / rate,
        noisy(F_n + 25.0, 90.0),
        noisy(direction * (friction + mass * 1e-3 * a) - 40.0, 35.0),
        noisy(7.0 + direction * sd, 0.0015),
        noisy(direction * a, 150.0),
        noisy(np.full(len(v), 20.0), 0.1),
        {"T_tool": 20.0, "bore": 15.51},
    )


@pytest.fixture
def record_maker() -> Callable[..., SctRecord]:
    return made_up
