"""Texts of an answer: numbers that agree, and sentences that the warnings beside them do not take back."""

from __future__ import annotations

import re
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import pytest

from friction_models.discovery.answer.not_first import why_not_first
from friction_models.discovery.answer.wording import confidence_text, meaning_of_numbers
from friction_models.effects import CATALOGUE
from friction_models.effects.base import Effect
from orchestrator.report.sections.evidence import ranking_html


@pytest.mark.parametrize("confidence", [0.885, 0.125, 0.625, 0.5, 0.98])
def test_one_confidence_is_one_number_on_a_page(confidence: float) -> None:
    """0.885 was 0.89 in one sentence and 88 in 100 in the next."""
    said = meaning_of_numbers(confidence)
    found = re.search(r"Confidence 0\.(\d\d): about (\d+) in 100", said)
    assert found is not None and found.group(1) == found.group(2), said
    assert confidence_text(confidence) == f"0.{found.group(2)}"


@pytest.mark.parametrize("name", CATALOGUE)
def test_the_sentence_of_an_effect_fits_every_contact(name: str) -> None:
    """Pressure saturation was said to act "above some hundred MPa", beside s_c = 0.07 MPa of oil on glass."""
    said = CATALOGUE[name]().sentence
    assert not re.search(r"\d|hundred|thousand|MPa|degC|mm", said), said


def ranked(*names: str) -> list[Any]:
    return [SimpleNamespace(name=n, effect=CATALOGUE[n]()) for n in names]


def left(**errors: float) -> Any:
    """Return the error on unseen tests by the effects that are added, their names joined."""

    def error(effects: Sequence[Effect]) -> float:
        return errors["_and_".join(sorted(e.name for e in effects)) or "none"]

    return error


def test_a_name_that_is_not_ranked_first_is_explained_by_what_was_computed() -> None:
    """"Fits best" stood above a ranking in which it was the sixth, without a word."""
    ranking = ranked("running_in", "hersey", "pressure_saturation", "viscous")
    chosen = ranking[2:3]
    error = left(none=0.39, running_in=0.387, hersey=0.114, pressure_saturation=0.169)
    said = why_not_first(chosen, ranking, ["pressure_saturation", "hersey"], error)
    assert "pressure_saturation is named first though it is number 3 of the ranking" in said
    assert "0.169 with it, 0.39 without it, and with running_in in its place 0.387" in said
    assert "but hersey in its place would be no worse (hersey: not told apart): 0.114." in said
    assert why_not_first(ranking[:1], ranking, [], error) == ""
    assert why_not_first([], ranking, [], error) == ""
    both = left(running_in=0.18, pressure_saturation=0.118, pressure_saturation_and_running_in=0.1,
                hersey_and_running_in=0.17)  # fmt: skip
    said = why_not_first([ranking[2], ranking[0]], ranking, [], both)
    assert "0.1 with it and running_in, 0.18 without it, and with hersey in its place 0.17" in said
    assert said.endswith("and without running_in, which is named as well, 0.118.")
    none_worse = why_not_first(chosen, ranking[1:], [], error)
    assert "which decide" not in none_worse and "would be no worse: 0.114" in none_worse


def test_the_page_has_the_reason_beside_the_ranking() -> None:
    found: Any = {"verdict": "explained", "effects": ["viscous"], "not_first": "viscous is <named> first"}
    found["ranking"] = [
        {"effect": n, "gain": 30.0, "evidence": 30.0, "p_value": 0.01} for n in ("stribeck", "viscous")
    ]
    html = ranking_html(found)
    assert "Viscous is &lt;named&gt; first" in html
    assert "The data tells viscous from all others." in html
