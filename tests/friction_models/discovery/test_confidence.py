"""The confidence: what it rests on, and the prior of made-up campaigns that it is fitted to."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmarks.prior.campaigns import KINDS, campaign
from benchmarks.prior.laws import LAWS, OUTSIDE
from benchmarks.prior.study import Answer, fitted, kind_of, right
from friction_models.discovery import diagnose
from friction_models.discovery.judge import confidence as module
from friction_models.discovery.judge.confidence import (
    LIMITS,
    MOST_IN_ANOTHER_FORM,
    MOST_PARTLY,
    MOST_WHERE_ONE_STANDS_OUT,
    WEIGHTS,
    confidence,
)
from friction_models.discovery.judge.confirmation import Confirmation
from friction_models.discovery.judge.doubts import (
    EVEN,
    LIKELY,
    MOSTLY,
    Doubt,
    Sureness,
    doubts_of,
    least,
    sureness,
)
from friction_models.discovery.judge.error_budget import ErrorShares
from friction_models.discovery.judge.judged import Judged
from friction_models.discovery.judge.unseen_tests_judge import _certainly_missing
from friction_models.effects import CATALOGUE
from friction_models.loads import LOAD_NAMES


def test_the_grounds_of_an_answer_give_its_confidence() -> None:
    made = next(m for m in map(campaign, range(40)) if m.kind == "single" and min(m.strengths) > 3.0)
    said = diagnose(made.points, made.tests)
    assert set().union(*(w for _, w in WEIGHTS.values())) <= set(said.grounds)
    assert said.confidence == pytest.approx(
        min(confidence(said.verdict, said.grounds), said.grounds["most"]), abs=1e-3
    )


def test_what_speaks_for_an_answer_makes_it_surer() -> None:
    for verdict, ground in (
        ("explained", "certain"),
        ("explained", "gap"),
        ("ambiguous", "certain"),
        ("unknown_structure", "reference"),
        ("nothing_missing", "log_tests"),
    ):
        names = {n for _, w in WEIGHTS.values() for n in w} | {"beyond", "left"}
        low, high = (dict.fromkeys(names, 0.5) | {"left": 0.0, ground: value} for value in (0.5, 3.0))
        assert LIMITS[0] <= confidence(verdict, low) < confidence(verdict, high) <= LIMITS[1], (
            verdict,
            ground,
        )
    low, high = ({**dict.fromkeys(names, 0.5), "log_tests": 3.5, "seen": s} for s in (2.5, 0.0))
    assert confidence("nothing_missing", low) < confidence("nothing_missing", high)


def test_what_is_predicted_better_than_by_its_formula_is_not_sure() -> None:
    grounds = dict.fromkeys({n for _, w in WEIGHTS.values() for n in w}, 6.0) | {"left": 0.0}
    for verdict in ("explained", "ambiguous", "data_problem"):
        assert confidence(verdict, grounds | {"beyond": 2.0}) > 0.9
        assert confidence(verdict, grounds | {"beyond": 4.0, "left": 0.3}) == MOST_PARTLY
        assert confidence(verdict, grounds | {"beyond": 4.0}) == MOST_IN_ANOTHER_FORM
    nothing = [confidence("nothing_missing", grounds | {"beyond": b}) for b in (0.0, 4.0)]
    assert nothing[0] == nothing[1]


def test_nothing_is_missing_is_not_sure_where_an_effect_stands_out() -> None:
    grounds = dict.fromkeys({n for _, w in WEIGHTS.values() for n in w}, 0.0) | {"log_tests": 5.0}
    assert confidence("nothing_missing", grounds | {"seen": 1.2}) > 0.9
    assert confidence("nothing_missing", grounds | {"seen": 1.4}) == MOST_WHERE_ONE_STANDS_OUT


def _doubts(verdict: str, tests: int = 30, *, fixed: bool = False, **known: Any) -> list[Doubt]:
    """Return what speaks against an answer to so many tests of mu = 1 with a noise of 0.01."""
    grounds = {name: known.pop(name, 0.0) for name in ("reference", "beyond")} | {"seen": 3.0}
    campaign: Any = SimpleNamespace(
        tests=["t"] * tests, mu=np.ones(tests), point_test=np.arange(tests), system={}
    )
    floor = SimpleNamespace(known=True, total=0.01, sensor=0.001)
    found: Any = SimpleNamespace(floor=floor, ranking=[])
    evidence: Any = None
    confirmed = Confirmation(verdict, **{k: known.pop(k) for k in ("shares", "products") if k in known})
    judged = Judged(found, evidence, confirmed, [], **known)
    base: Any = SimpleNamespace(fixed=fixed, offset=np.zeros(tests))
    return doubts_of(campaign, base, judged, grounds, level_is_off=False)


@pytest.mark.parametrize("odd", [False, True])
@pytest.mark.parametrize(
    ("tests", "reference", "beyond", "sure"),
    [(30, 0.0, 1.9, True), (30, 0.0, 2.1, False), (30, 2.6, 2.6, False), (7, 0.0, 0.0, False)],
)
def test_nothing_is_missing_is_not_sure_where_the_reference_doubts_or_knows_nothing(
    tests: int, reference: float, beyond: float, sure: bool, odd: bool
) -> None:
    """The reference predicts better by two standard errors, believed or not; of seven tests it says nothing about what sets them apart.

    Tests that are odd, and stay, hide what is missing.
    """
    doubts = _doubts("nothing_missing", tests, reference=reference, beyond=beyond, odd_kept=odd)
    said = sureness(0.95, doubts)
    most = LIKELY if odd or tests < 8 else 0.95 if sure else MOSTLY
    assert said.value == most and bool(said.held_by) is (most < 0.95)


@pytest.mark.parametrize(
    ("known", "most"),
    [
        ({}, 1.0),
        ({"knows_noise": True}, EVEN),
        ({"odd_kept": True}, MOSTLY),
        ({"products": {"a": ("T", "sigma_n")}}, EVEN),
        ({"shares": ErrorShares(1.0, 0.95, 0.5, 3.0, (0.4, 1.2), "reference", 3.0)}, MOSTLY),
    ],
)
def test_a_reason_to_doubt_a_name_holds_it(known: dict[str, Any], most: float) -> None:
    doubts = _doubts("explained", **known)
    assert least(doubts) == most and len(doubts) == (most < 1.0)


def test_the_worst_doubt_holds_an_answer_and_is_told() -> None:
    doubts = [Doubt("one", MOSTLY), Doubt("two", EVEN), Doubt("two", EVEN)]
    assert sureness(0.9, doubts) == Sureness(EVEN, ("two",)) and sureness(0.4, doubts) == Sureness(0.4)


@pytest.mark.parametrize(
    ("missing", "certain", "said"), [(0.4, 2.6, True), (0.1, 2.6, False), (0.1, 3.2, True), (0.4, 2.0, False)]
)
def test_of_much_that_is_missing_less_certainty_is_asked(missing: float, certain: float, said: bool) -> None:
    shares = ErrorShares(1.0, 1.0, 1.0 - missing, certain, (0.4, 1.2), "reference", certain)
    assert _certainly_missing(shares) is said


def test_the_fit_finds_the_shares_of_right_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Answers that are right with a chance known here, by another formula: the confidence must come out as that chance."""
    rng = np.random.default_rng(3)
    rows: list[Answer] = []
    known: list[bool] = []
    for verdict in ("explained", "ambiguous", "unknown_structure", "nothing_missing"):
        for _ in range(1500):
            grounds = {n: float(rng.uniform(0.0, 3.0)) for _, w in WEIGHTS.values() for n in w} | {
                "beyond": 0.0,
                "left": 0.0,
                "most": 1.0,
            }
            good = rng.random() < 0.5 + 0.15 * grounds[next(iter(WEIGHTS[kind_of(verdict)][1]))]
            kind = {"unknown_structure": "outside", "nothing_missing": "null"}.get(verdict, "single")
            if not good:
                kind = "single" if kind != "single" else "null"
            hidden = [["stribeck"]] if kind == "single" else []
            names = ["stribeck"] if verdict in {"explained", "ambiguous"} else []
            rows.append(
                {"seed": len(rows), "kind": kind, "laws": [], "hidden": hidden, "strengths": [1.0] * len(hidden),
                 "verdict": verdict, "effects": names, "confusion_set": names, "confidence": 0.5, "grounds": grounds}
            )  # fmt: skip
            known.append(bool(good))
    assert list(map(right, rows)) == known
    monkeypatch.setattr(module, "WEIGHTS", fitted(rows))
    monkeypatch.setattr(module, "MOST_WHERE_ONE_STANDS_OUT", 1.0)  # a limit beside what is fitted
    for verdict in ("explained", "nothing_missing"):
        said = np.array([confidence(verdict, r["grounds"]) for r in rows if r["verdict"] == verdict])
        was = np.array([k for r, k in zip(rows, known, strict=True) if r["verdict"] == verdict])
        for k in (said < 0.7, said >= 0.8):
            assert abs(said[k].mean() - was[k].mean()) < 0.05


def test_laws_of_the_prior_fit_their_names() -> None:
    assert {n for law in LAWS for n in law.names} - {"factor:lot"} <= set(CATALOGUE)
    assert not any(law.names for law in OUTSIDE)
    made = campaign(3)
    table = made.points.merge(made.tests, on="test_id")
    for law in [*LAWS, *OUTSIDE]:
        term = law.term(table, np.random.default_rng(1))
        assert term.shape == (len(table),) and np.isfinite(term).all() and np.ptp(term) > 0.0, law.key


def test_campaigns_of_the_prior_are_as_varied_as_said() -> None:
    made = [campaign(seed) for seed in range(60)]
    kinds = pd.Series([m.kind for m in made]).value_counts(normalize=True)
    assert all(abs(kinds.get(k, 0.0) - share) < 0.2 for k, share in KINDS.items())
    for m in made:
        assert (m.points[[*LOAD_NAMES, "mu"]].to_numpy() >= 0.0).all() and m.points["mu"].max() < 1.0
        assert len(m.strengths) == len(m.laws) == {"null": 0, "pair": 2}.get(m.kind, 1)
        assert all(law.names for law in m.laws) == (m.kind != "outside")
    pd.testing.assert_frame_equal(made[5].points, campaign(5).points)
