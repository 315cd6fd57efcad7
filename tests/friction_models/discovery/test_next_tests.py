"""Proposed tests: rows that the virtual laboratory runs, separations that come true there."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.discovery_campaigns import campaign
from fmus import pack, read_friction_fmu
from friction_models import ConstantFriction, effects
from friction_models.discovery import Diagnosis, diagnose
from friction_models.discovery.further_tests.next_tests import plan_rows
from friction_models.discovery.further_tests.protocols import protocols
from friction_models.discovery.further_tests.separation import ENOUGH, separated
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search.candidates import integrate
from friction_models.loads import TriboLoads
from friction_models.loads.time_steps import rests, time_steps
from friction_models.models.onnx_model import OnnxModel
from sct_twin import SctTwin
from sct_twin.virtual_lab import Campaign, run_protocol

NEEDS = {
    "constant": set(), "speed_step": {"v_levels"}, "pressure_ramp": {"sigma_end"}, "hold": {"hold_at", "hold"},
    "zero_reading": {"zero_reading"},
}  # fmt: skip


@pytest.fixture(scope="module")
def unsure() -> Diagnosis:
    return diagnose(*campaign("pressure_power", seed=60, strength=2.0, thin=8)[:2])


def test_proposals_are_rows_of_a_plan_and_the_laboratory_takes_them(unsure: Diagnosis) -> None:
    assert unsure.verdict == "ambiguous" and unsure.next_tests
    for entry in unsure.next_tests:
        assert {"protocol", "setpoints", "separates", "expected_t", "plan"} <= set(entry)
        assert set(entry["separates"]) <= set(unsure.confusion_set) and entry.get("repeats", 1) >= 1
        for row in entry["plan"]:
            assert NEEDS[row["protocol"]] <= set(row)
            assert {"sigma_set", "v_set", "T_tool", "sd_set"} <= set(row)
    rows = plan_rows(unsure.next_tests)
    assert len({json.dumps(r) for r in rows}) == len(rows)
    plan = Campaign(pd.DataFrame(rows), seed=1).tests
    assert len(plan) == len(rows) and plan["test_id"].is_unique


def test_twins_of_pressure_need_less_force_or_a_zero_reading(unsure: Diagnosis) -> None:
    best = {tuple(sorted(n["separates"])): n["protocol"] for n in reversed(unsure.next_tests)}
    assert {"pressure ramp", "zero reading"} <= set(best.values())
    ramp = next(n for n in unsure.next_tests if n["protocol"] == "pressure ramp")["plan"][0]
    assert ramp["sigma_end"] < 500.0 < ramp["sigma_set"]  # on the same contact, below all tested pressures


def test_formulas_of_one_mechanism_are_not_promised_apart(unsure: Diagnosis) -> None:
    twins = {"pressure_power", "pressure_saturation"}
    told = [n["expected_t"] for n in unsure.next_tests if set(n["separates"]) == twins]
    assert told and max(told) < ENOUGH
    remark = next(w for w in unsure.warnings if "same driver (sigma_n)" in w)
    assert all(name in remark for name in twins) and "either predicts alike" in remark
    assert not any("force_zero" in w and "same driver" in w for w in unsure.warnings)  # a reading tells it


def test_a_lead_counts_when_it_is_more_than_a_matter_of_formulas() -> None:
    clear = separated(1.0, 101.0, 200.0)
    assert clear.noise == clear.t == pytest.approx(10.0)
    small = separated(1.0, 101.0, 100_000.0)  # a thousandth of the evidence
    assert small.noise == pytest.approx(10.0) and small.t < ENOUGH
    alike = separated(1.0, 101.0, 200.0, likeness=0.995)
    assert alike.t < ENOUGH < alike.noise
    assert separated(5.0, 2.0, 200.0).t == 0.0


def test_all_protocols_stay_on_the_rig() -> None:
    points, tests, _ = campaign(None, seed=4, thin=20)
    found = {p.protocol: p for p in protocols(prepare(points, tests))}
    assert set(found) == {"speed step", "pressure ramp", "hold"}  # the tests are as long as the rig allows
    for proposal in found.values():
        for row, loads in zip(proposal.plan, proposal.loads, strict=True):
            assert row["sd_set"] <= 60.0 and 400.0 < row["sigma_set"] < 3000.0 and row["v_set"] <= 520.0
            assert (
                loads.sd[-1] == pytest.approx(row["sd_set"])
                and loads.t is not None
                and np.all(np.diff(loads.t) > 0.0)
            )
            assert loads.T.max() > row["T_tool"] + 20.0  # the contact heats
    hold = found["hold"].loads[0].t
    assert hold is not None and hold[-1] > 60.0
    short = points[points["sd"] < 15.0]
    assert "long run" in {p.protocol for p in protocols(prepare(short, tests))}


def test_a_rest_between_two_points_lets_the_contact_age(tmp_path: Path) -> None:
    sd = np.linspace(0.1, 10.0, 100)
    t = sd / 20.0 + np.where(sd > 5.0, 60.0, 0.0)
    one = np.ones(100)
    loads = TriboLoads(20.0 * one, 50.0 * one, 1000.0 * one, sd, one, t=t)
    dt = time_steps(loads, [0])
    pause = rests(loads, dt)
    assert np.flatnonzero(pause).tolist() == [int(np.argmax(sd > 5.0))] and pause.max() == pytest.approx(
        60.0, abs=0.01
    )
    effect = effects.RateState(D_c=0.5)
    frame = pd.DataFrame(loads.as_array(), columns=["v_rel", "T", "sigma_n", "sd", "psi"]).assign(
        t=t, mu=0.08, test_id="a"
    )
    age = integrate(effect, prepare(frame), np.full(100, 0.08), effect.start_shape() | {"D_c": 0.5})["age"][
        :, 0
    ]
    k = int(np.argmax(pause))
    assert age[k - 1] == pytest.approx(0.025, rel=0.01)
    assert age[k] == pytest.approx(
        60.0 * np.exp(-0.1 / 0.5), rel=0.02
    )  # healed for a minute, then slid 0.1 mm
    jumpy = frame.assign(mu=0.08 + 0.004 * np.log(5.0 / 0.5 * age))  # falls back over D_c after the rest
    model = (ConstantFriction() + effects.RateState(D_c=0.5, v_0=5.0)).fit_frame(jumpy)
    mu = model.predict_frame(jumpy)
    assert np.abs(mu - jumpy["mu"]).max() < 1e-3
    model.to_onnx(tmp_path / "aged.onnx")
    np.testing.assert_allclose(OnnxModel(tmp_path / "aged.onnx").predict_frame(jumpy), mu, rtol=1e-9)
    packed = pack(tmp_path / "aged.onnx", tmp_path / "aged.fmu")
    np.testing.assert_allclose(read_friction_fmu(packed).predict_frame(jumpy), mu, rtol=1e-9)
    steady = TriboLoads(20.0 * one, 50.0 * one, 1000.0 * one, sd, one, t=sd / 20.0)
    assert not rests(steady, time_steps(steady, [0])).any()


def test_the_proposed_protocol_separates_the_rivals_in_the_virtual_laboratory(tmp_path: Path) -> None:
    loads = product((500.0, 1500.0, 2700.0), (50.0, 400.0), (20.0, 200.0))
    rows = [{"sigma_set": s, "psi_set": 1.069, "v_set": v, "T_tool": T, "sd_set": 10.0} for s, v, T in loads]
    law = Campaign("tiny-6+3", hidden="stribeck", seed=4).true_law
    law = replace(law, hidden=tuple((e, {**p, "A": 3.0 * p["A"]}) for e, p in law.hidden))
    lab = Campaign(pd.DataFrame(rows), seed=4, law=law)
    before = SctTwin().run(lab.run(jobs=1), jobs=1)
    first = diagnose(before.points, before.tests)
    assert first.verdict == "ambiguous" and "stribeck" in first.confusion_set
    proposed = first.next_tests[0]
    assert proposed["expected_t"] > 3.0 and proposed["repeats"] == 1
    after = SctTwin().run(run_protocol(lab, proposed["plan"], seed=99, jobs=1), jobs=1)
    points = pd.concat(
        [before.points, after.points.assign(test_id="new " + after.points["test_id"])], ignore_index=True
    )
    tests = pd.concat(
        [before.tests, after.tests.assign(test_id="new " + after.tests["test_id"])], ignore_index=True
    )
    second = diagnose(points, tests)
    rival = next(n for n in proposed["separates"] if n != "stribeck")
    assert second.effects[:1] == ["stribeck"] and rival not in second.confusion_set
    earlier, later = ({r["effect"]: r["evidence"] for r in d.ranking} for d in (first, second))
    found = separated(
        earlier["stribeck"] - earlier[rival], later["stribeck"] - later[rival], max(later.values())
    )
    assert found.t > ENOUGH


def test_a_test_that_tells_nothing_is_not_proposed() -> None:
    class Copy(effects.Stribeck):
        name = "copy"

    points, tests, _ = campaign("stribeck", seed=300, strength=1.4, thin=30, extra=0)
    found = diagnose(points, tests, catalogue=["stribeck", Copy()])
    assert set(found.confusion_set) == {"stribeck", "copy"} and not found.next_tests
    assert "What to test next" not in found.report()
    said = next(w for w in found.warnings if w.startswith(("stribeck and copy", "copy and stribeck")))
    assert "no test that could be proposed is expected to separate them (at best 0.0 standard errors" in said
