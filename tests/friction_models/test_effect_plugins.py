"""Effects that users write: incomplete ones and ones that fail cost a warning, not the diagnosis."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.discovery_campaigns import campaign
from friction_models import effects
from friction_models.common import InputError
from friction_models.common.imports import plugins
from friction_models.discovery import diagnose, refine
from friction_models.effects import CATALOGUE, Amplitude, Effect, Shape, load_catalogue, make_effect
from friction_models.effects.declaration import declaration_fault
from orchestrator.report.pages.diagnosis import diagnosis_page


class Squeal(Effect):
    """A complete effect; the tests below break it."""

    name = "squeal"
    title = "a wave along the distance"
    equation = "mu += c sin(2 pi sd/18)"
    latex = "c"
    citation = "none"
    where_it_shows = "along the distance"
    driver = ("sd",)
    amplitudes = (Amplitude("c", "1", "height", 0, 0.01),)

    def basis(self, x: Any, L: Any, p: Any, memory: Any) -> tuple[Any, ...]:
        return (np.sin(L.sd * 2 * np.pi / 18.0),)


class OnlyName(Effect):
    name = "only_name"


class Entry:
    """Stands for an entry point."""

    name, value = "theirs", "package:Theirs"

    def __init__(self, effect: Any) -> None:
        self.effect = effect

    def load(self) -> Any:
        return self.effect


def broken(**parts: Any) -> type[Effect]:
    return type("Broken", (Squeal,), parts)


def test_effects_have_words_for_people() -> None:
    """``label is missing: sentence.`` is a headline; effects of users that give neither have both."""
    for effect in CATALOGUE.values():
        assert effect.label[0].isupper() and effect.label != effect.name
        assert effect.sentence[0].islower() and not effect.sentence.endswith(".")
        assert "\n" not in effect.sentence and ":" not in effect.sentence
    assert len({e.sentence for e in CATALOGUE.values()}) == len(CATALOGUE)
    assert (Squeal.label, Squeal.sentence) == ("Squeal", "a wave along the distance")
    # An effect that builds on another one does not take over its words.
    own = type("Own", (effects.Stribeck,), {"name": "stribeck_of_mine", "title": "mine"})
    assert (own.label, own.sentence) == ("Stribeck of mine", "mine")
    assert declaration_fault(broken(sentence=3)) == "sentence = 3; allowed: a text"


def test_names_of_before_can_be_imported() -> None:
    assert effects.Memory is effects.EffectContext and effects.Shape is effects.ShapeParameter


def test_the_catalogue_declares_everything() -> None:
    assert [declaration_fault(e) for e in CATALOGUE.values()] == [None] * len(CATALOGUE)
    assert declaration_fault(Squeal) is None


@pytest.mark.parametrize(
    ("effect", "said"),
    [
        (OnlyName, "title = None"),
        (broken(driver=()), "driver"),
        (broken(driver="sd"), "driver = 'sd'"),
        (broken(amplitudes=()), "amplitudes"),
        (broken(shapes=(Shape("c", "1", "m", 0.0, 1.0, 0.5),)), "'c' stands twice"),
        (broken(kind="magic"), "kind = 'magic'"),
        (broken(metadata=("Ra",)), "metadata_units"),
        (broken(states=(("age", "s"),)), "states without rate"),
        (broken(driver=("speed",)), "driver 'speed'; allowed: v_rel, T, sigma_n, sd, psi, or metadata"),
        (broken(name="sigma_n"), "name = 'sigma_n'; allowed: a name that neither a load nor mu has"),
        (
            broken(shapes=(Shape("L", "mm", "m", 5.0, 1.0, 2.0),)),
            "shape 'L' from 5 to 1; allowed: a lower bound",
        ),
        (broken(states=(("T", "degC"),)), "state 'T'; allowed: a name that neither a load nor mu has"),
        (broken(basis=Effect.basis), "basis is not written"),
    ],
)
def test_an_incomplete_effect_is_left_out_with_a_warning(
    effect: type[Effect], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plugins, "entry_points", lambda group: [Entry(effect), Entry(Squeal)])
    with pytest.warns(UserWarning, match="'theirs'.*is left out: ") as seen:
        catalogue = load_catalogue()
    assert said in str(seen[0].message)
    assert set(catalogue) == set(CATALOGUE) | {"squeal"} and catalogue["squeal"] is Squeal
    with pytest.raises(InputError, match="allowed"):
        make_effect(effect)


def test_an_effect_that_fails_is_not_tested_and_the_others_are() -> None:
    points, tests, _ = campaign("wear_out", seed=21, strength=1.2, thin=60, extra=0)

    def fails(*given: Any) -> Any:
        raise RuntimeError("oops")

    def not_finite(self: Any, x: Any, L: Any, p: Any, memory: Any) -> Any:
        return (np.full_like(L.sd, np.nan),)

    def wrong_shape(self: Any, x: Any, L: Any, p: Any, memory: Any) -> Any:
        return (np.ones((3, 7)),)

    theirs = [
        broken(name="raises", basis=fails)(),
        broken(name="nan", basis=not_finite)(),
        broken(name="shape", basis=wrong_shape)(),
        broken(name="two", basis=lambda *given: (1.0, 2.0))(),
        broken(name="state", states=(("age", "s"),), advance=fails)(),
        broken(name="grids", grids=fails)(),
    ]
    answer = diagnose(points, tests, catalogue=["wear_out", *theirs])
    assert answer.effects == ["wear_out"] and [r["effect"] for r in answer.ranking] == ["wear_out"]
    for effect in theirs:
        assert any(
            w.startswith(f"{effect.name} was not tested: effect {effect.name!r}") for w in answer.warnings
        )
    assert any("RuntimeError: oops" in w for w in answer.warnings)
    with pytest.raises(InputError, match="effect 'raises': basis fails"):
        refine(points, tests, add=[theirs[0]])


@pytest.mark.nightly
def test_an_effect_handed_over_is_shown_like_those_of_the_catalogue() -> None:
    points, tests, _ = campaign(None, seed=22, thin=60, extra=0)
    waves = points.assign(mu=points["mu"] + 0.01 * np.sin(points["sd"] * 2 * np.pi / 18.0))
    answer = diagnose(waves, tests, catalogue=["wear_out", Squeal()])
    assert answer.effects == ["squeal"]
    assert "share of mu" in answer.report()
    page = diagnosis_page(answer, "linear")
    assert "Source: none" in page and "squeal: share of mu" in page


def test_an_effect_of_numpy_cannot_be_written_to_a_file(tmp_path: Path) -> None:
    points, tests, _ = campaign("wear_out", seed=3, thin=54)
    model = refine(points, tests, model="linear", add=[Squeal()], force=True)
    with pytest.raises(InputError, match=r"'squeal': basis cannot be written .*allowed: functions of x"):
        model.save(tmp_path / "model")
    assert not (tmp_path / "model").exists()
