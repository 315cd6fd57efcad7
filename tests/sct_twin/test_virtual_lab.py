"""The virtual laboratory: plans, labels, determinism, and hidden effects that matter."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from friction_models.common import InputError
from sct_twin import RawCampaign
from sct_twin.virtual_lab import HIDDEN, Campaign, load_truth
from sct_twin.virtual_lab.law import ContactLaw, LawInput, TrueLaw
from sct_twin.virtual_lab.plans import make_plan


def test_factorial_plan() -> None:
    plan = make_plan("factorial-81+30", seed=4)
    train, test = (plan[plan["role"] == role] for role in ("train", "test"))
    assert len(train) == 81 and len(test) == 30
    factors = ["sigma_set", "psi_set", "v_set", "T_tool"]
    assert len(train[factors].drop_duplicates()) == 81
    assert sorted(train["v_set"].unique()) == [5.0, 200.0, 500.0]
    for name in factors:
        assert test[name].between(train[name].min(), train[name].max()).all()
    assert sorted(plan["order"]) == list(range(1, 112))
    assert plan["sd_set"].between(55.0, 60.0).all()
    assert plan["synthetic"].all()


def test_reduced_plan_is_balanced() -> None:
    plan = make_plan("reduced-27+10", seed=0)
    train = plan[plan["role"] == "train"]
    factors = ["sigma_set", "psi_set", "v_set", "T_tool"]
    for i, first in enumerate(factors):
        for second in factors[:i]:
            assert (pd.crosstab(train[first], train[second]) == 3).all().all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"plan": "factorail-81"}, "unknown plan 'factorail-81'.*did you mean 'factorial-81"),
        ({"plan": "factorial-80"}, "factorial has 81 tests"),
        ({"hidden": "stribek"}, "unknown hidden effect 'stribek'.*did you mean 'stribeck'"),
        ({"seed": -1}, "seed -1; allowed"),
    ],
)
def test_names_that_do_not_exist(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Campaign(**arguments)  # type: ignore[arg-type]


def test_every_file_says_synthetic(tiny: RawCampaign) -> None:
    assert json.loads((tiny.folder / "campaign.json").read_text())["synthetic"] is True
    assert pd.read_csv(tiny.folder / "tests.csv")["synthetic"].all()
    assert tiny.synthetic
    assert json.loads((tiny.folder / "truth.json").read_text())["synthetic"] is True


def test_records_hold_no_truth(tiny: RawCampaign) -> None:
    header = tiny.raw_file("sct001").read_text().splitlines()[:2]
    assert header == ["t,F_n,F_r,s,a,T_plate", "s,N,N,mm,mm/s2,degC"]
    text = (tiny.folder / "campaign.json").read_text() + (tiny.folder / "tests.csv").read_text()
    assert "hidden" not in text and "running_in" not in text and "law" not in text


@pytest.mark.parametrize("jobs", [1, pytest.param(2, marks=pytest.mark.nightly)])
def test_same_seed_same_files(tiny: RawCampaign, tmp_path: Path, lab_cache: Path, jobs: int) -> None:
    lab = Campaign(plan="tiny-6+3", hidden="running_in", seed=3, cache=lab_cache)
    again = lab.run(out=tmp_path / "again", jobs=jobs)
    for test_id in tiny.tests["test_id"]:
        assert again.raw_file(test_id).read_bytes() == tiny.raw_file(test_id).read_bytes()
    # Two seeds of one plan: the same test with other noise.
    plan = pd.DataFrame([{"sigma_set": 1000.0, "v_set": 100.0, "T_tool": 60.0, "sd_set": 12.0}])
    one, other = (
        Campaign(plan, hidden="running_in", seed=seed, cache=lab_cache).run(jobs=1) for seed in (3, 4)
    )
    assert one.raw_file("sct001").read_bytes() != other.raw_file("sct001").read_bytes()


def test_an_interrupted_campaign_goes_on(tiny: RawCampaign, tmp_path: Path, lab_cache: Path) -> None:
    lab = Campaign(plan="tiny-6+3", hidden="running_in", seed=3, cache=lab_cache)

    def stop(done: int, total: int, what: str) -> None:
        if done == 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        lab.run(out=tmp_path / "c", jobs=1, progress=stop)
    assert not (tmp_path / "c" / "campaign.json").exists()
    seen: list[int] = []
    done = lab.run(out=tmp_path / "c", jobs=1, progress=lambda d, n, w: seen.append(d))
    assert min(d for d in seen if d) >= 4
    assert done.raw_file("sct009").read_bytes() == tiny.raw_file("sct009").read_bytes()
    assert load_truth(done.folder)[1].keys() == load_truth(tiny.folder)[1].keys()
    assert sorted(p.name for p in done.folder.iterdir()) == sorted(p.name for p in tiny.folder.iterdir())


def loads(n: int = 4000) -> LawInput:
    rng = np.random.default_rng(0)
    sigma, sd = rng.uniform(500, 2750, n), rng.uniform(0, 55, n)
    v = rng.choice([5.0, 200.0, 500.0], n)
    return LawInput(v, rng.uniform(20, 500, n), sigma, sd, rng.uniform(1.03, 1.8, n), 0.06 * sigma * sd, {})


@pytest.mark.parametrize("name", sorted(set(HIDDEN) - {"batch", "tool_roughness", "static_peak"}))
def test_a_hidden_effect_is_not_linear_in_the_loads(name: str) -> None:
    i = loads()
    effect = HIDDEN[name]
    y = effect.contribution(i, effect.parameters)
    X = np.column_stack([np.ones(len(i.T)), i.v_rel, i.T, i.sigma_n, i.sd, i.psi])
    rest = y - X @ np.linalg.lstsq(X, y, rcond=None)[0]
    assert 0.002 < rest.std() < 0.012
    assert np.isfinite(y).all()


@pytest.mark.parametrize("name", sorted(HIDDEN))
def test_laws_are_regular_at_zero_loads(name: str) -> None:
    law = ContactLaw(TrueLaw.draw(name, 0))
    mu = law(np.array([[0.0, 20.0, 0.0, 0.0, 1.0]]), 0.0)
    assert np.isfinite(mu).all() and (mu > 0).all()


def test_law_with_memory_counts_work_once_a_step() -> None:
    law = ContactLaw(TrueLaw.draw("work_exhaustion", 0))
    points = np.array([[100.0, 100.0, 2000.0, 0.0, 1.1]])
    first = law(points, 0.0)
    points[0, 3] = 50.0
    worn = law(points, 1.0)
    assert worn > first + 0.02
    assert law(points, 1.0) == pytest.approx(worn, abs=1e-12)


def test_law_survives_its_file() -> None:
    law = TrueLaw.draw("stribeck+wear_out", 5)
    again = TrueLaw.from_dict(json.loads(json.dumps(law.to_dict())))
    assert np.array_equal(law.mu(loads()), again.mu(loads()))
