"""Answers on measured data: graded by the lists, named as the catalogue names effects."""

from __future__ import annotations

import pytest

from benchmarks.measured import page, tables, variants
from benchmarks.measured.answers import Answer, Lists
from benchmarks.measured.grade import grade
from benchmarks.measured.origins import ORIGINS
from benchmarks.measured.run import INVARIANCES, expected, over_budget, same, tempted
from friction_models.discovery.answer.diagnosis import VERDICTS
from friction_models.effects import CATALOGUE


def said(verdict: str, *effects: str, confusion: tuple[str, ...] = ()) -> Answer:
    return {
        "status": "answered",
        "verdict": verdict,
        "effects": list(effects),
        "confusion_set": list(confusion),
    }


WANTED: Lists = {
    "acceptable": [
        {"verdict": "explained", "any_of": ["viscous", "hersey"], "only_from": ["viscous", "hersey"]},
        {"verdict": "ambiguous", "any_of": ["viscous"], "only_from": ["viscous"]},
    ],
    "debatable": [
        {"verdict": "explained", "all_of": ["stribeck", "hersey"]},
        {"verdict": "unknown_structure"},
    ],
    "wrong": [{"verdict": "explained", "names": ["wear_out"], "because": "no distance"}],
}


@pytest.mark.parametrize(
    ("answer", "right"),
    [
        (said("explained", "viscous"), "acceptable"),
        (said("explained", "viscous", "hersey"), "acceptable"),
        (said("explained", "viscous", "wear_out"), "wrong"),
        (said("explained"), "wrong"),
        (said("explained", "stribeck"), "wrong"),
        (said("explained", "stribeck", "hersey"), "debatable"),
        (said("ambiguous", "wear_out", confusion=("wear_out", "viscous")), "acceptable"),
        (said("ambiguous", "wear_out", confusion=("wear_out",)), "wrong"),
        (said("unknown_structure"), "debatable"),
        (said("nothing_missing"), "wrong"),
    ],
)
def test_grades(answer: Answer, right: str) -> None:
    assert grade(answer, WANTED) == right


def test_reasons_of_wrong_answers_are_found() -> None:
    assert list(tempted(said("explained", "viscous", "wear_out"), WANTED)) == ["no distance"]
    assert not list(tempted(said("partly_explained", "wear_out"), WANTED))


def test_the_names_of_the_lists_are_those_of_the_catalogue() -> None:
    for name, wanted in expected().items():
        assert wanted["call"]["function"] in tables.TABLES and wanted["call"]["function"] in ORIGINS, name
        assert wanted["because"] and (wanted["acceptable"] or wanted["debatable"]), name
        for entry in [*wanted["acceptable"], *wanted["debatable"]]:
            assert entry["verdict"] in VERDICTS, name
            names = {*entry.get("all_of", []), *entry.get("any_of", []), *entry.get("only_from", [])}
            assert all(n in CATALOGUE or n.startswith("factor:") for n in names), name
        for entry in wanted["wrong"]:
            assert all(n in CATALOGUE for n in entry.get("names", [])), name
    assert set(INVARIANCES) <= set(variants.VARIANTS)


def test_a_budget_that_does_not_add_up_is_seen() -> None:
    budget = {"floor": 3.0, "explained": 4.0, "missing": 0.0}
    assert over_budget({"budget": budget, "mean_square": 25.0}) == 0.0
    assert over_budget({"budget": budget, "mean_square": 50.0}) == pytest.approx(0.5)


def test_a_refusal_is_a_changed_answer() -> None:
    before = said("explained", "viscous", "hersey")
    assert same(before, said("explained", "viscous")) == (True, True)
    assert same(before, said("explained", "hersey")) == (True, False)
    assert same(before, {"status": "refused", "said": "no"}) == (False, False)


def test_rates_have_intervals() -> None:
    assert page.share(5, 10) == ("5 of 10 (50 %)", "24 to 76 %")
    assert page.share(0, 0) == ("none", "")
