"""Readings of the friction cell without load decide between an offset of the force and a law of pressure."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from benchmarks.discovery_campaigns import campaign
from friction_models.discovery import Diagnosis, diagnose
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search.zero_reading import AFTER, AREA, BEFORE, ZERO, ZeroReading, read_zero

AREA_MM2 = 190.0
LAWS = {"pressure_power", "pressure_saturation"}


def with_reading(hidden: str, newton: float | None) -> Diagnosis:
    """Diagnose with one reading after a test, or none."""
    points, tests, _ = campaign(hidden, seed=60, strength=2.0, thin=40)
    table = tests.copy()
    if newton is not None:
        table[AREA] = AREA_MM2
        table[BEFORE] = np.random.default_rng(0).normal(0.0, 40.0, len(table))
        table[AFTER] = np.where(np.arange(len(table)) == 0, table[BEFORE] + newton, np.nan)
    return diagnose(points, table)


def needed(found: Diagnosis) -> float:
    """Return the offset that the answer names [N]."""
    values = found.parameters[ZERO]["values"]
    return float(values["k_F"]["value"] * values["s_0"]["value"] * AREA_MM2)


@pytest.mark.nightly
def test_no_reading_no_decision_and_a_reading_of_nothing_rules_an_offset_out() -> None:
    before = with_reading("pressure_power", None)
    assert ZERO in before.confusion_set and set(before.confusion_set) & LAWS
    asked = next(n for n in before.next_tests if n["protocol"] == "zero reading")
    assert asked["expected_t"] > 3.0 and ZERO in asked["separates"]
    after = with_reading("pressure_power", 15.0)
    assert set(after.confusion_set) == set(before.confusion_set) - {ZERO}
    assert ZERO not in {r["effect"] for r in after.ranking}
    assert any("reads 15 N without load" in w and "ruled out" in w for w in after.warnings)


def test_a_reading_as_large_as_the_data_need_names_the_offset() -> None:
    before = with_reading("force_zero", None)
    offset = needed(before)
    found = with_reading("force_zero", offset)
    assert found.verdict == "data_problem" and found.confusion_set == [ZERO]
    assert not any(n["protocol"] == "zero reading" for n in found.next_tests), "it was read, and it decided"
    lead = {r["effect"]: r["evidence"] for r in found.ranking}
    assert lead[ZERO] > {r["effect"]: r["evidence"] for r in before.ranking}[ZERO] + 9.0
    assert not LAWS & {r["effect"] for r in found.ranking[1:] if r["evidence"] > lead[ZERO]}


@pytest.mark.nightly
def test_a_reading_of_another_offset_rules_out_the_one_that_the_data_need() -> None:
    offset = needed(with_reading("force_zero", None))
    other = with_reading("force_zero", -offset)  # there is an offset, but not that one
    assert ZERO not in other.confusion_set
    assert any("ruled out; take the offset off" in w for w in other.warnings)


def test_records_that_lost_a_part_of_the_offset_say_less() -> None:
    kept = ZeroReading(10.0, 10.0, 0.5, 0.1, AREA_MM2)
    assert kept.present == pytest.approx(20.0) and kept.against(10.5, 0.2) < 1.0 < kept.against(4.0, 0.2)
    partly = ZeroReading(0.0, 10.0, 0.5, 0.1, AREA_MM2)
    assert partly.present == 0.0 and partly.against(4.0, 0.2) == 0.0
    assert partly.against(-3.0, 0.2) == pytest.approx(3.0 / np.sqrt(0.25 + 1.0 + 0.04))


@pytest.mark.parametrize("seed", [4, 7])
def test_a_test_that_its_reading_has_corrected_does_not_contradict_the_others(seed: int) -> None:
    """A line between two readings takes half of the offset off the record of the test that was read, and nothing off the others."""
    rng = np.random.default_rng(seed)
    stress, names = 30.0, [f"t{k:02d}" for k in range(21)]
    sd = np.linspace(0.2, 20.0, 40)
    rows = []
    for name in names:
        first, v_rel, tool = (
            np.exp(rng.uniform(np.log(400.0), np.log(2600.0))),
            np.exp(rng.uniform(np.log(20.0), np.log(300.0))),
            rng.uniform(20.0, 300.0),
        )
        read = name == names[-1]
        if read:  # as it is proposed: at the lowest pressure
            first, v_rel, tool = 450.0, 50.0, 30.0
        sigma_n, T = first * (1.0 + 0.002 * sd), tool + 40.0 * np.sqrt(sd / 20.0)
        mu = 0.06 - 5e-6 * T + rng.normal(0.0, 0.003) + stress / sigma_n * (0.5 if read else 1.0)
        loads = {"t": sd / v_rel, "v_rel": v_rel, "T": T, "sigma_n": sigma_n, "sd": sd, "psi": 1.05}
        rows.append(pd.DataFrame({"test_id": name, **loads, "mu": mu + rng.normal(0.0, 0.001, 40)}))
    table = pd.DataFrame({"test_id": names, BEFORE: rng.normal(0.0, 20.0, 21), AFTER: np.nan, AREA: 180.0})
    table.loc[20, AFTER] = stress * 180.0
    found = diagnose(pd.concat(rows, ignore_index=True), table)
    assert found.effects[0] == ZERO and found.confusion_set == [ZERO], found.sentence
    assert needed(found) * 180.0 / AREA_MM2 == pytest.approx(stress * 180.0, rel=0.2)
    assert any("1 test (t20) was corrected by its own reading" in w for w in found.warnings)


def test_what_a_table_says_about_the_zero() -> None:
    points, tests, _ = campaign("pressure_power", seed=60, strength=2.0, thin=20)
    after = np.where(np.arange(len(tests)) == 0, 950.0, np.nan)
    assert read_zero(prepare(points, tests.assign(**{AFTER: after})), 1e-4) is None  # no area
    table = tests.assign(**{AFTER: after, AREA: np.full(len(tests), AREA_MM2)})
    bare = read_zero(prepare(points, table), 1e-4)
    assert bare is not None and bare.high == pytest.approx(5.0)
    before = np.where(np.arange(len(tests)) == 0, 760.0, 20.0)
    tared = read_zero(prepare(points, table.assign(**{BEFORE: before})), 1e-4)
    assert tared is not None and tared.high == pytest.approx(1.0)
    untared = read_zero(
        prepare(points, table.assign(**{BEFORE: np.where(before > 100.0, before, 0.0)})), 1e-4
    )
    assert untared is not None and untared.high == pytest.approx(5.0)  # the others begin under load
