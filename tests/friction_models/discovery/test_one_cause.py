"""Loads, or columns of the test table, that are the same in all tests: no formula tells their effects apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose
from friction_models.discovery.judge.doubts import LIKELY, MOSTLY
from friction_models.discovery.judge.identifiability import _tied_loads, one_load
from friction_models.estimation.campaign.binning import prepare


@pytest.mark.nightly
def test_a_surface_that_grows_with_the_distance_in_every_test() -> None:
    """Friction follows a logistic curve of the one, and so of the other."""
    rng = np.random.default_rng(2)
    sd = np.linspace(0.0, 30.0, 40)
    rows = []
    for test in range(24):
        T, sigma_n, v_rel = rng.uniform(30.0, 250.0), rng.uniform(100.0, 900.0), rng.uniform(2.0, 60.0)
        mu = 0.08 + 0.03 / (1.0 + np.exp(-(sd - 15.0) / 2.5)) + 1e-5 * sigma_n + rng.normal(0.0, 0.003)
        points = {"test_id": f"t{test:02d}", "v_rel": v_rel, "T": T, "sigma_n": sigma_n}
        rows.append(
            pd.DataFrame({**points, "sd": sd, "psi": 1.0 + sd / 20.0, "mu": mu + rng.normal(0.0, 0.002, 40)})
        )
    found = diagnose(pd.concat(rows, ignore_index=True))
    assert found.verdict == "ambiguous", found.sentence
    assert {"surface_expansion", "wear_out"} <= {*found.confusion_set}
    assert found.confidence <= MOSTLY
    assert any("along the tests" in w and "psi" in w and "sd" in w for w in found.warnings), found.warnings


def three_levels(
    seed: int, **other: Sequence[object]
) -> tuple[np.random.Generator, pd.DataFrame, pd.DataFrame]:
    """Return 45 single means without mu, and a table of three batches with a level of another column for each."""
    rng = np.random.default_rng(seed)
    level = rng.integers(3, size=45)
    columns = {n: np.array(values)[level] for n, values in {"batch": ["A", "B", "C"], **other}.items()}
    tests = pd.DataFrame({"test_id": [f"t{k:02d}" for k in range(45)], **columns})
    loads = {"v_rel": rng.uniform(2.0, 60.0, 45), "T": rng.uniform(30.0, 250.0, 45)}
    return rng, tests[["test_id"]].assign(**loads), tests


def test_one_tool_for_each_batch() -> None:
    """Rougher tools rub more; each batch of the lubricant was tested with a tool of its own."""
    rng, data, tests = three_levels(1, Ra=[0.2, 0.5, 1.1])
    mu = 0.1 + 0.03 * np.sqrt(tests["Ra"]) + 2e-5 * data["T"] + rng.normal(0.0, 0.004, 45)
    found = diagnose(data.assign(mu=mu), tests)
    assert found.verdict == "ambiguous", found.sentence
    assert {*found.confusion_set} == {"tool_roughness", "batch"}


def test_one_operator_for_each_batch() -> None:
    """A column that is no effect of the catalogue is a rival, too; what crosses them is told, and no load that would not."""
    rng, data, tests = three_levels(5, operator=["kim", "lee", "moe"])
    mu = 0.1 + 0.012 * (tests["batch"] == "C") + 2e-5 * data["T"] + rng.normal(0.0, 0.003, 45)
    found = diagnose(data.assign(mu=mu), tests)
    assert found.verdict == "ambiguous", found.sentence
    assert {*found.confusion_set} == {"batch", "factor:operator"}
    assert any("batch (A, B, C) and operator (kim, lee, moe) change together" in w for w in found.warnings)
    # the same without such a table is plain
    assert diagnose(data.assign(mu=mu), tests.drop(columns="operator")).verdict == "explained"


@pytest.mark.nightly
def test_two_loads_of_one_law_that_are_one_load() -> None:
    """Pressure and temperature rise together in every test: an effect of both, or of either, fits."""
    rng = np.random.default_rng(8)
    rows = []
    for test in range(24):
        T = rng.uniform(60.0, 200.0) + np.linspace(0.0, 50.0, 20)
        mu = 0.08 + 0.03 / (1.0 + np.exp(-(T - 170.0) / 12.0)) + rng.normal(0.0, 0.002)
        points = {"test_id": f"t{test:02d}", "v_rel": rng.uniform(2.0, 60.0), "T": T, "sigma_n": 4.0 * T}
        rows.append(pd.DataFrame({**points, "t": np.arange(20.0), "mu": mu + rng.normal(0.0, 0.001, 20)}))
    data = pd.concat(rows, ignore_index=True)
    found = diagnose(data)
    assert found.confidence <= LIKELY, found.sentence
    assert any("from test to test T moves with sigma_n" in w for w in found.warnings), found.warnings
    assert one_load(prepare(data), ("T", "sigma_n")) == ["T", "sigma_n"]
    assert one_load(prepare(data), ("v_rel",)) == []


def test_a_second_name_may_only_mend_the_form_of_the_first() -> None:
    """Film is used up by work; in tests of one length the surface grows with it: both were named, 0.9 sure."""
    rng = np.random.default_rng(3)
    sd = np.linspace(0.5, 30.0, 40)
    rows = []
    for test in range(27):
        v_rel, T, p = (
            (6.0, 25.0, 80.0)[test % 3],
            (25.0, 110.0, 200.0)[test // 3 % 3],
            (160.0, 300.0, 450.0)[test // 9],
        )
        work = 0.08 * p * sd / (0.08 * 300.0 * 18.0)
        mu = 0.08 + 0.017 * (1.0 + np.tanh((work - 1.0) / 0.22)) + rng.normal(0.0, 0.0034)
        rows.append(
            pd.DataFrame({"test_id": f"t{test:02d}", "t": sd / v_rel, "v_rel": v_rel, "T": T + sd * np.sqrt(v_rel) * p * 1e-4,
             "sigma_n": p * (0.95 + 0.05 * np.tanh(sd / 4.0)), "sd": sd, "psi": 1.0 + 0.1 * sd / 30.0 * p / 300.0, "mu": mu + rng.normal(0.0, 0.0017, 40)})
        )  # fmt: skip
    found = diagnose(pd.concat(rows, ignore_index=True))
    assert len(found.effects) < 2 or found.confidence <= MOSTLY, found.sentence


def test_only_the_load_that_moves_with_another_one_is_said_to() -> None:
    rng = np.random.default_rng(4)
    pressure, speed = rng.uniform(300.0, 1200.0, 20), rng.uniform(5.0, 100.0, 20)
    at = np.repeat(np.arange(20), 5)
    data = pd.DataFrame(
        {
            "test_id": [f"t{k:02d}" for k in at],
            "v_rel": speed[at],
            "sigma_n": pressure[at],
            "psi": 1.0 + pressure[at] / 1000.0,
            "sd": np.tile(np.linspace(1.0, 20.0, 5), 20),
            "mu": 0.1,
        }
    )
    (told,) = _tied_loads(prepare(data), ("v_rel", "sigma_n"))
    assert told.startswith("from test to test sigma_n moves with psi (correlation +1.00)")
