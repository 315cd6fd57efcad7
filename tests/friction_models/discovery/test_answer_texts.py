"""Texts of an answer: numbers that agree, and sentences that the warnings beside them do not take back."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_models.discovery import diagnose
from friction_models.discovery.answer.changes import changes_text
from friction_models.discovery.answer.not_first import why_not_first
from friction_models.discovery.answer.wording import confidence_text, meaning_of_numbers, settings_text
from friction_models.discovery.formulas.offers import FormulaOffer, offer_lines
from friction_models.discovery.judge.judged import Judged, alternatives
from friction_models.effects import CATALOGUE, make_effect
from friction_models.effects.base import Effect
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.noise.repeats import repeats_of
from orchestrator.report.sections.evidence import budget_html, ranking_html


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
    """ "Fits best" stood above a ranking in which it was the sixth, without a word."""
    ranking = ranked("running_in", "hersey", "pressure_saturation", "viscous")
    chosen = ranking[2:3]
    error = left(none=0.39, running_in=0.387, hersey=0.114, pressure_saturation=0.169)
    said = why_not_first(chosen, ranking, ["pressure_saturation", "hersey"], error)
    assert "pressure_saturation is named first though it is number 3 of the ranking" in said
    assert said.endswith(
        "which decide over names, the error (rms of mu) is 0.169 with it, 0.39 without it, and with running_in in its place 0.387."
    )
    assert why_not_first(ranking[:1], ranking, [], error) == ""
    assert why_not_first([], ranking, [], error) == ""
    both = left(running_in=0.18, pressure_saturation=0.118, pressure_saturation_and_running_in=0.1)
    said = why_not_first([ranking[2], ranking[0]], ranking, [], both)
    assert "0.1 with it and running_in, 0.18 without it" in said
    assert said.endswith("and without running_in, which is named as well, 0.118.")
    better = why_not_first(chosen, ranking[1:], ["pressure_saturation", "hersey"], error)
    assert "which decide" not in better
    assert better.endswith("but hersey in its place would be better (not told apart): 0.114.")
    as_good = left(none=0.39, hersey=0.168, pressure_saturation=0.169)
    assert "hersey in its place would be no worse: 0.168" in why_not_first(chosen, ranking[1:], [], as_good)


def test_the_page_has_the_reason_beside_the_ranking() -> None:
    found: Any = {"verdict": "explained", "effects": ["viscous"], "not_first": "viscous is <named> first"}
    found["ranking"] = [
        {"effect": n, "gain": 30.0, "evidence": 30.0, "p_value": 0.01} for n in ("stribeck", "viscous")
    ]
    html = ranking_html(found)
    assert "Viscous is &lt;named&gt; first" in html
    assert "The data tells viscous from all others." in html
    two = {
        "effects": ["viscous", "stribeck"],
        "confusion_set": ["viscous", "hersey", "stribeck", "flash_temperature"],
    }
    two["alternatives"] = alternatives(two["effects"], two["confusion_set"])
    html = ranking_html(found | two)
    assert "cannot tell these apart: viscous, hersey; nor these: stribeck, flash_temperature." in html


def at_pressures(pressures: Any) -> pd.DataFrame:
    """Return averages at these pressures, one a test, with some scatter."""
    rng = np.random.default_rng(1)
    names = [f"r{k:02d}" for k in range(len(pressures))]
    mu = 0.1 + 0.001 * rng.standard_normal(len(pressures))
    return pd.DataFrame({"test_id": names, "sigma_n": pressures, "mu": mu})


@pytest.mark.parametrize(
    ("pressures", "said"),
    [
        (np.linspace(1.0, 40.0, 64), "settings that agree within 3 % of the range of their loads"),
        (np.repeat([10.0, 20.0, 30.0, 40.0], 4), "16 tests at 4 repeated settings"),
        # a machine meets a set point to within one per cent
        (
            np.repeat([10.0, 20.0, 30.0, 40.0], 4) * np.tile([1.0, 1.003, 0.998, 1.002], 4),
            "4 repeated settings",
        ),
    ],
)
def test_a_ladder_of_small_steps_holds_no_repeats(pressures: Any, said: str) -> None:
    """ "62 tests at 14 repeated settings" was said of tests of which no two were at the same pressure."""
    campaign = prepare(at_pressures(pressures))
    repeats = repeats_of(campaign, campaign.average(campaign.mu))
    assert repeats is not None
    assert settings_text(repeats.to_dict()).endswith(said)
    # a file of an earlier version
    earlier = repeats.to_dict()
    del earlier["exact"]
    assert "repeated settings" in settings_text(earlier)


@pytest.mark.parametrize("scale", [1.0, 1e-7])
def test_the_budget_of_very_small_numbers_has_digits(scale: float) -> None:
    """With a mu of 1e-9 every line was 0.00000."""
    data = at_pressures(np.repeat([10.0, 20.0, 30.0, 40.0], 4))
    found = diagnose(data.assign(mu=scale * data["mu"]))
    lines = found.report().split("Error budget")[1].split("\n\n")[0].splitlines()[1:]
    values = [line[16:].split()[0] for line in lines if line[2:9] in {"before ", "noise f", "still m"}]
    assert len(values) == 3 and len({len(v) for v in values}) == 1, lines
    assert all(re.fullmatch(r"0\.\d{5}" if scale == 1.0 else r"\d\.\d\de[+-]\d\d", v) for v in values), values
    assert float(values[0]) > 0.0 and float(values[1]) > 0.0
    changed = changes_text(found.to_dict(), found)
    assert f"noise floor     {values[1]} (unchanged)" in changed
    page: Any = found.to_dict()
    assert ("e-11" in budget_html(page).split("<table")[1]) == (scale != 1.0)


def test_a_term_that_no_resample_prefers_says_what_it_was_chosen_for() -> None:
    """It was listed with "first in 0 % of resamples", as if nothing spoke for it."""
    effects = tuple(make_effect(f"empirical:{t}") for t in ("bump(T)", "wave(sd)"))
    one = FormulaOffer(effects[0].name, "mu += ...", 0.9, (0.8, 1.0), 0.0, effects[:1], (0.008, 0.005))
    both = replace(one, name="both", effects=effects)
    lines = offer_lines([one, both, replace(one, stability=0.25)])
    assert lines[1].endswith("; chosen for its error on unseen tests; it was first in none of the resamples")
    assert lines[3].endswith("; one of the terms was first in none of the resamples")
    assert lines[5].endswith("; first in 25 % of resamples")


def test_what_is_explained_has_no_rivals_left() -> None:
    """A law of two loads gave way to two laws of one each, and was still said not to be told from the first of them."""
    fits = [SimpleNamespace(name=name) for name in ("rising_speed", "thermal_softening")]
    evidence: Any = SimpleNamespace(confusion_set=["rising_speed", "viscous"])
    for verdict, alike in (("explained", ["rising_speed"]), ("ambiguous", ["rising_speed", "viscous"])):
        confirmed: Any = SimpleNamespace(verdict=verdict, chosen=fits, rivals=())
        judged = Judged(found=Any, evidence=evidence, confirmed=confirmed, notes=[])  # type: ignore[arg-type]
        assert judged.confusion == alike
