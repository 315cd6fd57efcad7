"""Loads, or columns of the test table, that are the same in all tests: no formula tells their effects apart."""

from __future__ import annotations

import numpy as np
import pandas as pd

from friction_models.discovery import diagnose


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
    assert found.confidence <= 0.5
    assert any("along the tests" in w and "psi" in w and "sd" in w for w in found.warnings), found.warnings


def test_one_tool_for_each_batch() -> None:
    """Rougher tools rub more; each batch of the lubricant was tested with a tool of its own."""
    rng = np.random.default_rng(1)
    tool = rng.integers(3, size=45)
    tests = pd.DataFrame(
        {
            "test_id": [f"t{k:02d}" for k in range(45)],
            "batch": np.array(["A", "B", "C"])[tool],
            "Ra": np.array([0.2, 0.5, 1.1])[tool],
        }
    )
    data = tests[["test_id"]].assign(v_rel=rng.uniform(2.0, 60.0, 45), T=rng.uniform(30.0, 250.0, 45))
    mu = 0.1 + 0.03 * np.sqrt(tests["Ra"]) + 2e-5 * data["T"] + rng.normal(0.0, 0.004, 45)
    found = diagnose(data.assign(mu=mu), tests)
    assert found.verdict == "ambiguous", found.sentence
    assert {*found.confusion_set} == {"tool_roughness", "batch"}
