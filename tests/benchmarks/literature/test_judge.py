"""The judge and the table, with a stand-in for the diagnosis."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binom

from benchmarks.literature import Case, cases, stand_in
from benchmarks.literature.answers import Answer, read, score
from benchmarks.literature.calibration import by_counting, reliability
from benchmarks.literature.judge import done_ids, judge_case, run
from benchmarks.literature.names import EFFECT, name, plain
from benchmarks.literature.registry import REGISTER
from benchmarks.literature.table import load, report
from friction_models.effects import CATALOGUE


def _case(kind: str, *laws: str, recipe: str = "plain") -> Case:
    return Case("x", kind, laws, recipe, 1)


def test_names_of_all_laws_exist() -> None:
    for law in REGISTER.values():
        for key in (*law.accept, *law.twins, *law.tolerated):
            assert name(key)
    assert plain("factor:film_weight [g/m2]") == plain("factor:Film_weight") == "factor:film_weight"
    assert set(EFFECT.values()) <= set(CATALOGUE)


def test_score_of_single_effects() -> None:
    case = _case("single", "rise_eyring")
    good = score(case, Answer("explained", ["rising_speed"], ["rising_speed", "viscous"], 0.9))
    assert (
        good["first"]
        and good["in_set"]
        and good["exact"]
        and good["set_size"] == 2
        and not good["wrong_names"]
    )
    twin = score(case, Answer("explained", ["viscous"], ["viscous"], 0.9))
    assert not twin["first"] and twin["first_or_twin"] and twin["right"] and not twin["in_set"]
    bad = score(case, Answer("explained", ["wear_out"], [], 0.9))
    assert not bad["first_or_twin"] and bad["wrong_names"] == ["wear_out"] and not bad["right"]
    silent = score(case, Answer("nothing_missing", [], [], 0.9))
    assert not silent["first"] and not silent["in_set"] and silent["set_size"] is None


def test_score_of_pairs_needs_each_law_once() -> None:
    case = _case("pair", "pressure_root", "stribeck_brown")
    assert score(case, Answer("explained", ["stribeck", "pressure_saturation"]))["exact"]
    two = score(case, Answer("explained", ["pressure_power", "pressure_saturation"]))
    assert not two["exact"] and not two["exact_or_twin"] and two["first_or_twin"]
    assert score(case, Answer("explained", ["flash_temperature", "pressure_power"]))["exact_or_twin"]


def test_score_of_nulls_and_of_laws_outside() -> None:
    assert score(_case("null"), Answer("unknown_structure"))["false_alarm"]
    assert not score(_case("null"), Answer("nothing_missing"))["false_alarm"]
    assert not score(_case("null", recipe="odd_tests"), Answer("data_problem"))["false_alarm"]
    out = _case("outside", "out_reflow")
    assert score(out, Answer("unknown_structure"))["abstains"]
    assert not score(out, Answer("partly_explained", ["wear_out"]))["abstains"]
    mixed = _case("mixed", "softening_wlf", "out_reflow")
    assert score(mixed, Answer("partly_explained", ["thermal_softening"]))["abstains"]


def test_answers_are_read_from_several_spellings() -> None:
    answer = read(stand_in.Diagnosis("explained", ["Stribeck"], 0.5, ["stribeck", "viscous+wear_out"]))
    assert answer.effects == ["stribeck"] and answer.confusion == ["stribeck", "viscous", "wear_out"]


def test_calibration() -> None:
    error, table = reliability([0.95] * 10, [True] * 5 + [False] * 5)
    assert error == pytest.approx(0.45) and table[-1].n == 10
    assert reliability([1.0, 0.0], [True, False])[0] == 0.0


def test_few_answers_miss_their_confidence_by_chance() -> None:
    right = np.arange(11)
    exact = float(binom.pmf(right, 10, 0.7) @ np.abs(right / 10 - 0.7))
    assert by_counting([0.7] * 10, draws=4000) == pytest.approx(exact, rel=0.05)
    assert by_counting([1.0] * 10) == 0.0


def test_judge_a_case_in_this_process() -> None:
    line = judge_case(
        Case("one", "single", ("softening_wlf",), "lhs30", 11, points=40, n_heldout=5), stand_in
    )
    assert line["status"] == "ok" and line["refinement"]["rms_base"] > line["refinement"]["rms_floor"]


@pytest.mark.nightly
def test_run_resumes_times_out_and_is_printed(tmp_path: Path) -> None:
    everything = cases(30)
    todo = [next(c for c in everything if c.kind == kind) for kind in ("null", "single", "pair", "outside")]
    slow = next(c for c in everything if c.style == "four")
    refused = next(c for c in everything if c.style == "no_psi")
    out = tmp_path / "results.jsonl"
    assert run(todo, out, "benchmarks.literature.stand_in", 1, 60.0, verbose=False) == 4
    assert run([*todo, slow, refused], out, "benchmarks.literature.stand_in", 2, 6.0, verbose=False) == 2
    lines = {x["id"]: x for x in load([out])}
    assert len(lines) == 6 == len(done_ids(out))
    assert lines[slow.id]["status"] == "timeout" and lines[refused.id]["status"] == "refused"
    with out.open("a") as file:
        file.write(json.dumps({"id": "half"})[:-3])
    assert len(done_ids(out)) == 6
    text = report(list(lines.values()))
    for part in (
        "False alarms",
        "Single effects",
        "Several effects",
        "Outside the catalogue",
        "Refinement",
        "Confidence",
        "Times",
    ):
        assert part in text
