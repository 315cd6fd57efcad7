"""Texts of an answer: numbers that agree, and sentences that the warnings beside them do not take back."""

from __future__ import annotations

import re

import pytest

from friction_models.discovery.answer.wording import confidence_text, meaning_of_numbers
from friction_models.effects import CATALOGUE


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
