"""How large an effect could hide in thin data, where nothing is seen to be missing."""

from __future__ import annotations

import re
from math import erf

import numpy as np
import pandas as pd
import pytest
from scipy.stats import qmc

from friction_models.discovery import Diagnosis, diagnose
from orchestrator.report.pages.diagnosis import diagnosis_page


def averages(seed: int, tests: int, step: float = 0.0) -> pd.DataFrame:
    """Return averages whose mu is linear in the loads, and rises by `step` about 150 degC as a normal distribution does."""
    rng = np.random.default_rng(seed)
    rows = []
    for k, u in enumerate(qmc.LatinHypercube(4, seed=rng).random(tests)):
        v, T, p, psi = 5.0 * 100.0 ** u[0], 20.0 + 260.0 * u[1], 150.0 * 10.0 ** u[2], 1.0 + 14.0 * u[3]
        mu = 0.08 + 0.004 * T / 280.0 + 0.003 * v / 500.0 + step * 0.5 * (1.0 + erf((T - 150.0) / 40.0))
        loads = {"v_rel": v, "T": T, "sigma_n": p, "sd": 14.0, "psi": psi, "mu": mu + rng.normal(0.0, 0.004)}
        rows.append({"test_id": f"t{k:02d}", **loads})
    return pd.DataFrame(rows)


def said(found: Diagnosis) -> str:
    return next((w for w in found.warnings if w.startswith("smaller effects may be there")), "")


def with_temperature(found: Diagnosis) -> float:
    size = re.search(r"([0-9.e-]+) with T\b", said(found))
    assert size is not None, found.warnings
    return float(size.group(1))


def test_thin_data_say_what_could_hide() -> None:
    found = diagnose(averages(1, 20))
    assert found.verdict == "nothing_missing"
    assert with_temperature(found) > 0.03


@pytest.mark.parametrize(
    ("seeds", "missed"), [((0, 1), 0), pytest.param((0, 1, 2, 3, 4, 6, 7), 1, marks=pytest.mark.nightly)]
)
def test_the_size_is_that_from_which_on_effects_are_seen(seeds: tuple[int, ...], missed: int) -> None:
    seen, nothing = {0.33: 0, 1.3: 0}, 0
    for seed in seeds:
        found = diagnose(averages(seed, 36))
        nothing += found.verdict == "nothing_missing"
        for share in seen:
            seen[share] += bool(diagnose(averages(seed, 36, share * with_temperature(found))).effects)
    assert nothing == len(seeds)
    assert seen[1.3] >= len(seeds) - missed
    assert seen[0.33] <= 2 * missed


def test_an_effect_that_no_such_test_could_show_has_no_size() -> None:
    """Tests that repeat as badly as this: mu would have to change by more than itself."""
    rng = np.random.default_rng(4)
    v = np.array([1.1, 5.5, 10.0, 11.0, 11.0, 5.5, 1.1, 5.6, 1.1, 11.0, 11.0, 10.0])
    names = [f"r{k:02d}" for k in range(len(v))]
    data = pd.DataFrame({"test_id": names, "v_rel": v, "mu": 0.22 + rng.normal(0.0, 0.13, len(v))})
    found = diagnose(data)
    assert found.verdict == "nothing_missing"
    assert said(found) == ""
    assert any(w.startswith("an effect of v_rel would not show in tests like these") for w in found.warnings)


def test_the_sentence_does_not_say_more_than_the_warnings_allow() -> None:
    """Speeds so near one another that no effect of them could show: "nothing is missing" stood above that warning."""
    data = averages(2, 36)
    found = diagnose(data.assign(v_rel=100.0 + 5.0 * data["v_rel"].rank() / 36.0))
    assert found.verdict == "nothing_missing" and found.confidence > 0.8
    assert any(w.startswith("an effect of v_rel would not show") for w in found.warnings)
    seen = "nothing can be seen to be missing"
    assert found.sentence.startswith(seen) and found.to_dict()["sentence"] == found.sentence
    page = diagnosis_page(found, "it")
    assert f"<title>it: {seen}" in page and "there is nothing to find" not in page


def test_tests_that_wander_are_told() -> None:
    """Waves over the stroke whose beginning is another one in each test: 15 % of mu was noise, without a word."""
    rng = np.random.default_rng(4)
    along = np.linspace(0.0, 1.0, 60)
    frames = []
    for k in range(24):
        wave = np.sin(2.0 * np.pi * (1.5 * along + rng.random()))
        loads = {
            "v_rel": rng.uniform(5.0, 80.0),
            "T": rng.uniform(20.0, 200.0),
            "sigma_n": rng.uniform(100.0, 900.0),
            "sd": 40.0 * along,
        }
        frames.append(
            pd.DataFrame(
                {"test_id": f"t{k:02d}", **loads, "wave": wave, "mu": 0.08 + rng.normal(0.0, 0.001, 60)}
            )
        )
    data = pd.concat(frames, ignore_index=True)
    for size in (0.02, 0.0):
        found = diagnose(data.assign(mu=data["mu"] + size * data["wave"]).drop(columns="wave"))
        assert found.verdict == "nothing_missing", found.sentence
        assert any("along their path the tests change by 0.01" in w for w in found.warnings) == (size > 0.0)
