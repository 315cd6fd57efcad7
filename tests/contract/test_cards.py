"""One suite run over every friction card of the package: what a user may rely on, whatever the card."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from fmus.exports.common import Reference
from fmus.source.reading import read_source
from friction_models import OnnxModel, load_model
from friction_models.cards import Card, load_card, load_cards, read_card
from friction_models.loads import LOAD_NAMES, LOADS

CARDS = load_cards()
#: Measurements of third parties: they lie beside the repository and are not part of it.
MEASURED = Path(__file__).parents[2].parent / "shared" / "data"


def test_there_are_enough_cards_and_enough_of_them_are_measured() -> None:
    assert len(CARDS) >= 20
    measured = [c for c in CARDS.values() if c.basis == "measured"]
    assert len(measured) >= 10 and all(c.held_out is not None for c in measured)


@pytest.fixture(scope="module", params=sorted(CARDS))
def card(request: pytest.FixtureRequest) -> Card:
    return CARDS[request.param]


def test_a_card_says_where_it_comes_from_and_where_it_holds(card: Card) -> None:
    assert card.domain, "a range of at least one load"
    assert len(card.source["text"]) > 20 and card.source["licence"]
    assert re.match(r"https://|the work that this project builds on", card.source["address"])
    assert (
        card.uncertainty is not None
        or "not stated" in card.uncertainty_of
        or "scatter" in card.uncertainty_of
    )
    assert (card.basis == "synthetic") == bool(card.model().card["data"]["synthetic"])
    assert card.measured and card.synthetic
    if card.held_out is not None:  # no worse than the mean of mu, which any law must beat to be one
        assert card.held_out.rmse <= card.held_out.constant_rmse
        assert card.uncertainty is not None and card.uncertainty <= card.held_out.rmse * 1.001
    assert card.matches(card.title) and card.matches(card.name)
    for text in (card.name, card.title, card.lubricant, card.source["text"]):
        assert " ".join(text.split()) in card.text()


def test_the_law_of_a_card_is_a_model_like_any_other(card: Card, tmp_path: Path) -> None:
    model = card.model()
    loads = np.vstack([card.sample(200), [[q.lower for q in LOADS], [q.upper for q in LOADS]]])
    mu = model.predict(loads)
    assert np.isfinite(mu).all() and (mu >= 0.0).all() and mu.max() < 10.0
    # Written out once more, by Python itself: the law is what stands in the file.
    names = {"exp": np.exp, "log": np.log, "sqrt": np.sqrt, "tanh": np.tanh, "abs": np.abs}
    names |= {"min": np.minimum, "max": np.maximum, "where": np.where}
    inside = {
        n: np.clip(loads[:, k], *card.domain.get(n, (-np.inf, np.inf))) for k, n in enumerate(LOAD_NAMES)
    }
    with np.errstate(divide="ignore"):
        own = eval(card.law.replace("^", "**"), {"__builtins__": {}}, {**names, **card.constants, **inside})  # noqa: S307
    np.testing.assert_allclose(mu, np.broadcast_to(own, mu.shape), rtol=1e-12)
    assert model.name == f"card {card.name}"
    saved = load_model(model.save(tmp_path / "model"))
    np.testing.assert_array_equal(saved.predict(loads), mu)
    assert saved.name == model.name
    np.testing.assert_allclose(OnnxModel(tmp_path / "model" / "model.onnx").predict(loads), mu, rtol=1e-12)
    assert Reference(read_source(f"card:{card.name}")).mu(loads[:5]) == pytest.approx(mu[:5], rel=1e-12)
    assert load_model(f"card:{card.name}").formula_text() == model.formula_text() == saved.formula_text()


def test_a_card_is_written_as_it_is_read(card: Card, tmp_path: Path) -> None:
    (tmp_path / f"{card.name}.yaml").write_text(yaml.safe_dump(card.to_dict()), encoding="utf-8")
    assert read_card(tmp_path / f"{card.name}.yaml") == card == load_card(f"card:{tmp_path / card.name}")


@pytest.mark.skipif(not MEASURED.is_dir(), reason="the measurements are not part of the repository")
def test_the_cards_of_measurements_can_be_made_again() -> None:
    from benchmarks.friction_cards import WANTED, made

    assert {w.name for w in WANTED} == {n for n, c in CARDS.items() if c.basis == "measured"}
    for wanted in WANTED:
        content, kept = made(wanted, MEASURED), CARDS[wanted.name].to_dict()
        constants, held = content["constants"], content["held_out"]
        assert constants == pytest.approx(kept["constants"], rel=1e-3), wanted.name
        assert held["rmse"] == pytest.approx(kept["held_out"]["rmse"], rel=0.01), wanted.name
        assert {k: held[k] for k in ("tests", "points", "how")} == {
            k: kept["held_out"][k] for k in ("tests", "points", "how")
        }
