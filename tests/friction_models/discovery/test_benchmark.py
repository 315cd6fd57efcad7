"""The benchmark of the diagnosis: what it is made of, and that it can be interrupted."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from benchmarks.discovery import Sizes, chain, oracle, study
from benchmarks.discovery.form_sets import SETS
from benchmarks.discovery.forms import FIRST, SECOND
from benchmarks.discovery.generator import NOISE_LEVELS, NULLS, PHYSICAL, SCATTER, campaign
from friction_models.effects import CATALOGUE


def test_the_cases_are_those_that_are_asked_for() -> None:
    cases = list(study.cases(12))
    for forms in SETS.values():
        assert len(forms.effects) >= 14 and set(forms.effects) <= set(CATALOGUE)
        assert len(forms.outside) == 4 and not set(forms.outside) & set(CATALOGUE) and len(forms.pairs) == 3
    assert len(NULLS) >= 3 and len(NOISE_LEVELS) == 3
    kinds = [c.kind for c in cases]
    assert kinds.count("null") >= 200 and kinds.count("single") >= 200 and kinds.count("lacking") >= 200
    for kind in ("null", "single", "lacking"):
        drawn = Counter((c.forms, c.noise) for c in cases if c.kind == kind)
        assert set(drawn) == {(f, n) for f in SETS for n in NOISE_LEVELS}
        assert max(drawn.values()) - min(drawn.values()) <= 4  # sets may hide more or fewer effects
    assert {c.null for c in cases if c.kind == "null"} == set(NULLS)
    assert {c.left_out for c in cases if c.kind == "left_out"} == set(FIRST.effects)
    assert len({c.key for c in cases}) == len(cases)


def test_the_two_sets_hide_different_forms() -> None:
    assert len(campaign(3).tests) == 111 and len(campaign(3, forms="second").tests) == 120
    assert {n for n, f in FIRST.effects.items() if f is SECOND.effects[n]} == set()


@pytest.mark.parametrize(
    ("forms", "name"),
    [
        (f, n)
        for f, s in SETS.items()
        for n in [*list(s.effects)[:: {"first": 6, "second": 7}.get(f, 11)], list(s.outside)[1]]
    ],
)
def test_hidden_parts_have_the_strength_they_claim(forms: str, name: str) -> None:
    made = campaign(3, (name,), forms=forms)
    points, tests, part, law = made[:4]
    assert 0.5 <= made.strength == made.drawn <= 2.0 and np.std(part) == pytest.approx(
        made.strength * SCATTER
    )
    assert (tests["role"] == "test").sum() == 30 and len(part) == len(law) == len(points)


@pytest.mark.parametrize(("noise", "limited"), [(1.0, False), (1.6, True)])
def test_the_strength_of_what_a_linear_law_leaves(noise: float, limited: bool) -> None:
    """Judged by a law of the measured loads, whose errors leave a little more; mu stays physical."""
    made = campaign(8, ("thermal_softening",), noise=noise, lacking=True)
    assert 0.5 <= made.drawn <= 2.0 and (made.strength < made.drawn) == limited
    assert PHYSICAL[0] <= made.law.min() + 1e-12 and made.law.max() <= PHYSICAL[1]
    assert np.isclose(made.law.min(), PHYSICAL[0]) == limited
    train = made.points["test_id"].isin(made.tests.loc[made.tests["role"] == "train", "test_id"]).to_numpy()
    loads = made.points[oracle.LOADS].to_numpy()[train]
    columns = np.column_stack([np.ones(len(loads)), loads / loads.std(axis=0)])
    part = made.part[train]
    rest = part - columns @ np.linalg.lstsq(columns, part, rcond=None)[0]
    assert np.std(rest) == pytest.approx(made.strength * noise * SCATTER, rel=0.05)
    assert np.std(part) > 2.0 * np.std(rest)


def test_averages_are_one_point_a_test() -> None:
    points, tests, part, law = campaign(3, (), "averaged points")[:4]
    assert len(points) == len(tests) == len(part) == len(law) == 111


def test_a_study_goes_on_where_it_was_and_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []

    def fake(case: study.Case) -> study.Outcome:
        done.append(case.key)
        right = case.kind != "null"
        return {
            "kind": case.kind, "hidden": list(case.hidden), "null": case.null, "noise": case.noise, "left_out": case.left_out,
            "forms": case.forms, "seed": case.seed, "clarity": 9.0,
            "verdict": "explained" if right else "nothing_missing", "effects": list(case.hidden), "confidence": 1.0,
            "first": case.hidden[0] if right else "", "confusion_set": list(case.hidden), "strength": 1.0,
            "drawn": 1.5 if case.kind == "lacking" else 1.0, "clipped": 0.0,
        }  # fmt: skip

    monkeypatch.setattr(study, "run_case", fake)
    results = study.run_all(tmp_path, 1, lambda text: None)
    study.run_all(tmp_path, 1, lambda text: None)
    assert len(done) == len(results) == len(set(done))
    page = study.summary(results)
    text = "\n".join(page["lines"])
    for label in study.SERIES.values():
        assert f"| right effect first; {label} | 18 of 18 (100 %) | 82 to 100 % | at least 90 % |" in text
    assert text.index(study.SERIES["single"]) < text.index(study.SERIES["lacking"])
    assert "| false alarms, nothing missing | 0 of 18 (0 %) | 0 to 18 % |" in text
    assert "in 18 of its 18 campaigns the strength was lowered" in page["text"]


def test_parts_of_the_page_keep_their_sizes(tmp_path: Path) -> None:
    assert Sizes.kept(tmp_path) == Sizes()
    Sizes(2, 0, 3).keep(tmp_path)
    assert Sizes.kept(tmp_path) == Sizes(2, 0, 3)


def test_the_chain_is_counted() -> None:
    row: chain.Outcome = {
        "hidden": "stribeck",
        "seed": 1,
        "verdict": "explained",
        "effects": ["stribeck"],
        "confusion_set": ["stribeck"],
        "before": 4e-3,
        "after": 1e-3,
    }
    found: list[chain.Outcome] = [
        row,
        {**row, "hidden": "running_in", "before": 1.5e-3},
        {
            **row,
            "hidden": "nothing",
            "verdict": "nothing_missing",
            "effects": [],
            "confusion_set": [],
            "before": 1e-3,
        },
    ]
    text = "\n".join(chain.summary(found)["lines"])
    assert (
        "| hidden effect named first | 1 of 2 |" in text
        and "| false alarms, nothing missing | 0 of 1 |" in text
    )
    assert "| at least half of the avoidable error removed | 1 of 2 |" in text


def test_the_oracle_knows_how_clear_a_hidden_part_is() -> None:
    """Half as clear in twice the noise; what a linear law follows changes nothing."""
    made = campaign(5, ("surface_expansion",))
    clear = oracle.clarity(made, 1.0, "first")
    assert oracle.clarity(made, 2.0, "first") == pytest.approx(clear / 2.0)
    train = made.points["test_id"].isin(made.tests.loc[made.tests["role"] == "train", "test_id"]).to_numpy()
    linear = made.points[oracle.LOADS].to_numpy()[train] @ [1e-5, -3e-5, 1e-6, 0.0, 0.01]
    part = made.part.copy()
    part[train] += linear - linear.mean()
    assert oracle.clarity(made._replace(part=part), 1.0, "first") == pytest.approx(clear, rel=1e-6)
    assert oracle.power(0.0) == pytest.approx(oracle.LEVEL / len(CATALOGUE)) and oracle.power(9.0) > 0.999


def test_wilson_intervals() -> None:
    assert study.wilson(5, 10) == pytest.approx((0.2366, 0.7634), abs=1e-4)
    assert study.wilson(0, 200)[1] == pytest.approx(0.0188, abs=1e-4)


@pytest.mark.nightly
def test_one_case_of_each_kind_runs() -> None:
    single = study.run_case(study.Case("single", ("wear_out",), 49_001))
    assert single["verdict"] in {"explained", "ambiguous"} and single["hidden"] == ["wear_out"]
    assert single["after"] < single["before"] and single["removed"] > 0.3
    null = study.run_case(study.Case("null", (), 49_002, "curved noise"))
    assert null["verdict"] == "nothing_missing" and "removed" not in null
