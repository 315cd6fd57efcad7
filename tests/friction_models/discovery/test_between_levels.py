"""Between the levels of a plan the formula of an effect stands for measurements: the diagnosis says so."""

from itertools import product

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose, refine
from friction_models.discovery.refinement_rounds import history_text
from friction_models.loads import FloatArray

from .test_next_tests import made


def between(speeds: tuple[float, ...]) -> list[str]:
    """Return what is said of gaps, of tests whose friction falls with speed."""
    rows = list(product((600.0, 1200.0, 1800.0), speeds, (20.0, 120.0)))
    found = diagnose(*made(rows, "v_rel"), catalogue=["stribeck", "thermal_softening"])
    assert found.effects == ["stribeck"]
    return [w for w in found.warnings if "no test measured" in w]


def test_a_fall_that_no_test_saw_is_a_matter_of_the_formula() -> None:
    (said,) = between((5.0, 10.0, 400.0, 900.0))
    assert "v_rel between 10 and 400 mm/s" in said
    assert "a test at about 63.2 mm/s would" in said


def test_tests_in_the_fall_need_no_warning() -> None:
    assert between((5.0, 15.0, 45.0, 130.0, 400.0)) == []


@pytest.mark.nightly
def test_a_test_between_the_levels_is_proposed() -> None:
    """The gap in which the named effect falls, not another one; speed steps pass the speeds that no test had."""
    rows = list(product((600.0, 1200.0, 1800.0), (5.0, 50.0, 500.0), (20.0, 120.0)))
    found = diagnose(*made(rows, "v_rel"), catalogue=["stribeck", "hersey", "flash_temperature"])
    assert found.effects == ["stribeck"]
    gaps = [n for n in found.next_tests if n["protocol"] == "between levels"]
    assert all(n["plan"][0]["protocol"] == "constant" for n in gaps)
    assert 15.8 in [n["plan"][0]["v_set"] for n in gaps]
    assert any("a test at about 15.8 mm/s would" in w for w in found.warnings)
    steps = [n["setpoints"]["v_rel [mm/s]"] for n in found.next_tests if n["protocol"] == "speed step"]
    assert steps == [[5.0, 15.8, 158.0, 500.0]]


@pytest.mark.parametrize("load", ["T", pytest.param("psi", marks=pytest.mark.nightly)])
def test_the_test_that_a_warning_asks_for_is_in_the_plan(load: str) -> None:
    """Also where the first gap parts rivals better, where nothing is a rival, and of an expansion; they lay in other gaps."""
    rng, tests = np.random.default_rng(4), []
    sd = np.linspace(0.5, 20.0, 20)
    levels = {"T": (20.0, 160.0, 300.0), "psi": (1.2, 2.5, 6.0)}[load]
    table = []
    for k, (p, v, x) in enumerate(product((200.0, 490.0, 890.0), (5.0, 50.0, 500.0), levels * 2)):
        tool, psi = (x, 1.2) if load == "T" else (100.0, x)
        law = 0.03 * (1.0 - (x / 330.0) ** 5) if load == "T" else 0.03 * np.arctan(4.0 * np.log(x))
        mu = 0.08 + law + rng.normal(0.0, 0.002) + rng.normal(0.0, 0.001, 20)
        loads = {"v_rel": v, "T": tool + 0.2 * sd, "sigma_n": p, "sd": sd, "psi": psi}
        tests.append(pd.DataFrame({"test_id": f"t{k:02d}", **loads, "mu": mu}))
        table.append({"test_id": f"t{k:02d}", "T_tool": tool, "psi_set": psi})
    found = diagnose(pd.concat(tests, ignore_index=True), pd.DataFrame(table))
    (asked,) = [w for w in found.warnings if f"no test measured {load} between" in w]
    middle = float(asked.rpartition("at about ")[2].split()[0])
    rows = [row for n in found.next_tests for row in n["plan"]]
    setting = {"T": "T_tool", "psi": "psi_set"}[load]
    assert any(abs(float(row[setting]) - middle) < 0.05 * middle for row in rows)
    assert f"what {found.effects[0]} does there" in found.report() or len(found.next_tests) > 1


def film(psi: FloatArray) -> FloatArray:
    """A root that saturates: no formula of the catalogue."""
    return np.asarray(0.06 * np.sqrt(1.0 - 1.0 / psi))


def three_levels(seed: int) -> pd.DataFrame:
    """Return 54 tests at three expansions, which a straight line and any saturation follow together."""
    rng = np.random.default_rng([seed, 71])
    tests = []
    for k in range(54):
        v, T, p = 5.0 * 60.0 ** rng.random(), rng.uniform(20.0, 200.0), rng.uniform(400.0, 2000.0)
        sd = np.linspace(0.5, 30.0, 12)
        psi = (1.07, 5.0, 20.0)[k % 3] * (1.0 + 0.01 * sd / 30.0)
        mu = 0.08 + 1e-5 * v + 3e-5 * T + film(psi) + rng.normal(0.0, 0.007) + rng.normal(0.0, 0.002, 12)
        loads = {"v_rel": v, "T": T, "sigma_n": p, "sd": sd, "psi": psi}
        tests.append(pd.DataFrame({"test_id": f"t{k:02d}", **loads, "mu": mu}))
    return pd.concat(tests, ignore_index=True)


def test_between_three_levels_an_effect_and_a_line_are_no_larger_than_it_takes() -> None:
    """Large and cancelling each other, they met the levels as well, and lay up to 0.03 off between them: worse than the line alone."""
    psi = np.geomspace(1.1, 20.0, 60)
    loads = np.column_stack([np.tile([50.0, 100.0, 1000.0, 15.0], (60, 1)), psi])
    truth = 0.08 + 1e-5 * 50.0 + 3e-5 * 100.0 + film(psi)
    for seed in (1, 4, 8):
        data = three_levels(seed)
        plain, added = (refine(data, add=add).predict(loads) - truth for add in ([], "surface_expansion"))
        assert np.mean(added**2) < 0.75**2 * np.mean(plain**2), seed


def test_below_the_slowest_test_friction_stays_within_what_was_seen() -> None:
    """At three speeds any fall below the slowest one fits as well; mu was 153 at rest, and a curve between the speeds was a step."""
    rng, tests = np.random.default_rng(5), []
    sd = np.linspace(0.5, 30.0, 20)

    def law(v: FloatArray) -> FloatArray:
        return np.asarray(0.035 / (1.0 + (v / 20.0) ** 1.3))

    for v, T, p in product((5.0, 50.0, 400.0), (20.0, 150.0, 280.0), (400.0, 1000.0, 2000.0)):
        mu = 0.11 - 4e-5 * T + law(np.full(20, v)) + rng.normal(0.0, 0.0015) + rng.normal(0.0, 0.001, 20)
        loads = {"v_rel": v, "T": T, "sigma_n": p, "sd": sd, "psi": 2.0}
        tests.append(pd.DataFrame({"test_id": f"t{len(tests):02d}", **loads, "mu": mu}))
    model = refine(pd.concat(tests, ignore_index=True), add="stribeck")
    v = np.array([0.0, 2.0, 4.0, 8.0, 12.0, 20.0, 400.0])
    found = model.predict(np.column_stack([v, np.tile([150.0, 1000.0, 15.0, 2.0], (len(v), 1))]))
    assert np.max(np.abs(found - found[-1] - law(v) + law(v[-1:]))) < 0.012
    text = history_text(model.error_history_)  # type: ignore[attr-defined]
    assert "Read the parameters with care" in text and "no test measured v_rel between 5 and 50 mm/s" in text
