"""Friction cards: own ones from a folder, hostile ones, the formula of a law, and a card as prior for few tests."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from friction_models import ConstantFriction, LinearFriction, PolynomialFriction, TriboLoads
from friction_models.cards import fit_from_card, load_card, load_cards, search_cards
from friction_models.cards.card import card_from
from friction_models.common import InputError
from friction_models.expressions.formula_text import read_formula
from friction_models.expressions.ops import NumpyOps

CONTENT: dict[str, object] = {
    "name": "soap",
    "title": "Soap on steel",
    "lubricant": "soap",
    "workpiece": "steel",
    "tool": "tool steel",
    "test": "made up",
    "basis": "synthetic",
    "measured": "nothing",
    "synthetic": "all of it",
    "law": "mu0 - a*(sigma_n - 1000)/1000",
    "constants": {"mu0": 0.08, "a": 0.02},
    "domain": {"sigma_n": [500.0, 2000.0]},
    "uncertainty": {"mu": 0.01, "of": "made up"},
    "source": {"text": "made up for the tests", "address": "none", "licence": "none"},
}


def changed(**more: object) -> dict[str, object]:
    return {**CONTENT, **more}


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (changed(law="__import__('os').system('true')"), "law: .* holds Call; allowed: numbers"),
        (changed(law="mu0.real"), "holds Attribute"),
        (changed(law="[mu0][0]"), "holds Subscript"),
        (changed(law="mu0 if sigma_n else a"), "holds IfExp"),
        (changed(law="'a'*1000000000"), "holds Constant"),
        (changed(law="-" * 60 + "mu0"), "too many brackets"),
        (changed(law="mu0*" * 400 + "1"), "is no formula, allowed: a text of 1 to 1000"),
        (changed(law="9**9**9**9 + mu0"), "mu is no number below 10|is no number"),
        (changed(law="mu1 + 1"), "unknown name 'mu1'; allowed: T, a, mu0"),
        (changed(law="log(sigma_n - 1000)"), "mu is no number below 10"),
        (changed(law="mu0 + T"), "depends on 'T', allowed: loads whose range stands in the domain"),
        (changed(law="mu0*1000"), "mu is no number below 10"),
        (changed(name="other"), "name 'other', allowed: that of the file"),
        (changed(basis="guessed"), "unknown basis 'guessed'"),
        (changed(basis="measured"), "basis 'measured' without held_out"),
        (changed(domain={"pressure": [1, 2]}), "unknown key of domain 'pressure'"),
        (changed(domain={"sigma_n": [2000, 500]}), "allowed: lower <= upper"),
        (changed(domain={"sigma_n": [-5, 500]}), "allowed: a number from 0"),
        (changed(domain={"sigma_n": [".nan", 500]}), "allowed: a number from 0"),
        (changed(constants={"mu0": True, "a": 1}), "constant 'mu0' is True"),
        (changed(constants={"mu0": float("nan"), "a": 1}), "constant 'mu0' is nan"),
        (changed(constants={"sigma_n": 1.0}), "constant 'sigma_n', allowed|unknown name"),
        (changed(uncertainty={"mu": -1, "of": "x"}), "uncertainty is -1"),
        (changed(source={"text": "x"}), "'address' is missing"),
        (changed(title=["a"]), r"title is \['a'\], allowed: a text"),
        (changed(title="x" * 3000), "allowed: a text of at most 2000"),
        (changed(licence="MIT"), "unknown key of a card 'licence'"),
        ([1, 2], "a card is"),
    ],
)
def test_a_card_that_is_none_is_refused_with_a_sentence(content: Any, words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        card_from(content, "soap", "soap.yaml")
    assert str(caught.value).startswith("soap.yaml") and "\n" not in str(caught.value)


def test_own_cards_lie_in_a_folder_and_are_checked_when_read(tmp_path: Path) -> None:
    (tmp_path / "soap.yaml").write_text(yaml.safe_dump(CONTENT), encoding="utf-8")
    assert list(load_cards(tmp_path)) == ["soap"]
    assert list(search_cards("steel SOAP", tmp_path)) == ["soap"] and not search_cards("graphite", tmp_path)
    card = load_card(f"card:{tmp_path / 'soap'}")
    assert card.model().card["data"]["synthetic"] is True
    assert card.model().predict([[0, 20, 1500, 0, 1]]) == pytest.approx([0.07])
    assert card.model().predict([[0, 20, 9000, 0, 1]]) == pytest.approx([0.06])  # the edge of its domain
    (tmp_path / "bomb.yaml").write_text("a: &a [x, x]\nb: *a\n")
    with pytest.raises(InputError, match=r"bomb\.yaml: holds an alias"):
        load_cards(tmp_path)
    (tmp_path / "bomb.yaml").write_text("!!python/object/apply:os.system ['true']\n")
    with pytest.raises(InputError, match=r"bomb\.yaml: not YAML"):
        load_cards(tmp_path)
    (tmp_path / "bomb.yaml").write_text("x" * 70_000)
    with pytest.raises(InputError, match="70000 bytes, allowed: at most 65536"):
        load_cards(tmp_path)
    with pytest.raises(InputError, match="no such folder; allowed: a folder of cards"):
        load_cards(tmp_path / "none")
    with pytest.raises(InputError, match=r"nothing\.yaml: no such card"):
        load_card(f"card:{tmp_path / 'nothing'}")


def test_a_formula_is_arithmetic_as_it_is_written() -> None:
    x = NumpyOps()
    values = {"a": 2.0, "b": np.array([[3.0], [-3.0]])}
    for text, own in (
        ("-a**2 + b", np.array([[-1.0], [-7.0]])),
        ("a^-1*abs(b)", np.array([[1.5], [1.5]])),
        ("where(b >= 0, a/4, min(b, -4) + max(a, 5))", np.array([[0.5], [1.0]])),
        ("exp(log(a)) - tanh(0*b) + sqrt(4)", np.array([[4.0], [4.0]])),
    ):
        np.testing.assert_allclose(read_formula(text, values).value(x, values), own, rtol=1e-14)


def truth(loads: np.ndarray) -> np.ndarray:
    """A law near the card: 0.006 higher, steeper by a tenth."""
    return 0.086 - 0.022 * (loads[:, 2] - 1000.0) / 1000.0


def test_a_card_helps_where_tests_are_few_and_is_outweighed_where_they_are_many() -> None:
    """Tests at two neighbouring pressures, with scatter from test to test, say little of the slope; the card does."""
    card = card_from(CONTENT, "soap", "soap.yaml")
    rng = np.random.default_rng(5)
    new = np.column_stack(
        [np.full(50, 50.0), np.full(50, 80.0), np.linspace(500, 2000, 50), np.full((50, 2), 1.0)]
    )
    errors: dict[tuple[int, bool], list[float]] = {}
    for tests in (3, 300):
        for _ in range(20 if tests == 3 else 4):
            narrow = rng.uniform(900, 1100, tests) if tests == 3 else rng.uniform(500, 2000, tests)
            loads = np.repeat(
                np.column_stack([np.full(tests, 50.0), np.full(tests, 80.0), narrow, np.ones((tests, 2))]),
                5,
                0,
            )
            names = np.repeat([f"t{k}" for k in range(tests)], 5)
            mu = truth(loads) + np.repeat(rng.normal(0.0, 0.006, tests), 5)
            for prior in (True, False):
                model = LinearFriction()
                weight = fit_from_card(
                    model, card, TriboLoads.from_array(loads), mu, names, None if prior else 0
                )
                assert (weight > 0) == prior
                error = float(np.sqrt(((model.predict(new) - truth(new)) ** 2).mean()))
                errors.setdefault((tests, prior), []).append(error)
    few = np.median(errors[3, True]), np.median(errors[3, False])
    assert few[0] < 0.006 and 2 * few[0] < few[1], few
    many = np.median(errors[300, True]), np.median(errors[300, False])
    assert abs(many[0] - many[1]) < 1e-3
    data = model.training_["data"]
    assert data["provenance"]["prior"] == "card soap" and data["points"] == 1500


def test_what_a_prior_cannot_do_is_said() -> None:
    card = load_card("seal-kdn")
    loads = TriboLoads.from_array([[5, 20, 0.2, 0, 1], [5, 20, 0.4, 0, 1]])
    mu = np.array([0.06, 0.03])

    class NoWeights(ConstantFriction):
        def _fit(self, loads: Any, mu: Any, groups: Any) -> None:  # type: ignore[override]
            self.mean_ = 0.0

    with pytest.raises(InputError, match="takes no weights, so it takes no prior"):
        fit_from_card(NoWeights(), card, loads, mu)
    with pytest.raises(InputError, match="prior tests = -1, allowed"):
        fit_from_card(LinearFriction(), card, loads, mu, tests=-1)
    model = PolynomialFriction()
    assert fit_from_card(model, card, loads, mu, tests=1000.0) == 1000.0
    at = [[7, 20, 0.3, 0, 1]]
    assert model.predict(at) == pytest.approx(card.model().predict(at), rel=0.3)
    assert model.domain.to_dict()["sigma_n"] == pytest.approx([0.1024, 0.7051], rel=0.02)
