"""Model cards: what a user reads before trusting a model."""

from __future__ import annotations

import json

from friction_models import ConstantFriction, FeedForwardFriction, LinearFriction
from friction_models.effects import Stribeck
from friction_models.families.composed import ComposedFriction
from friction_models.loads import LOAD_NAMES
from friction_models.models.model_card import card_text

from .made_up import campaign

FRAME = campaign(6, 20)


def test_card_says_what_a_user_must_know() -> None:
    model = LinearFriction().fit_frame(FRAME, info={"synthetic": True, "plan": "made up"})
    model.record_errors("test", {"mae": 0.5, "rmse": 0.6, "bias": -0.1, "points": 7, "tests": 1})
    card = model.card
    assert card["family"] == card["name"] == "linear"
    assert card["data"] == {"points": 120, "tests": 6, "synthetic": True, "provenance": {"plan": "made up"}}
    assert card["splits"]["train"] == [f"t{i:02d}" for i in range(6)]
    assert list(card["errors"]) == ["train", "test"]
    assert set(card["errors"]["train"]) >= {"mae", "rmse", "bias", "points", "tests", "mae_worst_test"}
    assert list(card["domain"]) == list(LOAD_NAMES)
    assert {"python", "tribofmu", "numpy", "scikit-learn"} <= set(card["versions"])
    assert json.loads(json.dumps(card, allow_nan=False)) == card


def test_text_labels_synthetic_data_and_lists_errors_and_domain() -> None:
    text = card_text(LinearFriction().fit_frame(FRAME, info={"synthetic": True}).card)
    assert "SYNTHETIC" in text
    assert "| train | 0.0" in text
    assert "| sd | sliding distance of the workpiece point | 0.5 | 60 | mm |" in text
    assert "SYNTHETIC" not in card_text(LinearFriction().fit_frame(FRAME, info={"synthetic": False}).card)
    assert "Origin of the data: measured" in card_text(
        LinearFriction().fit_frame(FRAME, info={"synthetic": False}).card
    )
    assert "Origin of the data: not recorded" in card_text(LinearFriction().fit_frame(FRAME).card)


def test_a_given_constant_has_a_card_without_training() -> None:
    card = ConstantFriction(0.08).card
    assert card["data"]["points"] == 0 and card["errors"] == {}
    assert "not fitted to data" in card_text(card)


def test_tests_held_out_in_training_are_listed() -> None:
    card = FeedForwardFriction(hidden=(4,), epochs=1).fit_frame(FRAME).card
    assert 1 <= len(card["splits"]["validation"]) <= 4
    assert set(card["splits"]["validation"]) < set(card["splits"]["train"])
    assert "held out to stop the training: t0" in card_text(card)


def test_bases_and_effects_are_written_by_name() -> None:
    text = card_text(ComposedFriction(LinearFriction(), [Stribeck()]).fit_frame(FRAME).card)
    assert "- Parameter base: linear" in text and "- Parameter effects: stribeck" in text and "{" not in text
