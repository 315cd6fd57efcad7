"""Names and budget rest on the prediction of whole tests that no fit has seen."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.stats import qmc
from scipy.stats import t as student

from benchmarks.discovery_campaigns import campaign
from benchmarks.literature import cases, make
from friction_models import LinearFriction
from friction_models.common import InputError
from friction_models.discovery import diagnose, refine
from friction_models.discovery.judge.error_budget import BELIEVED, error_shares, helps, lead, likely
from friction_models.discovery.judge.unseen_tests import ErrorsByTest, UnseenTests, folds_of_tests
from friction_models.effects import make_effect
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search.base_law import base_law

POINTS = 40


def one_test(name: str, t: np.ndarray, v: float, sigma: float, mu: np.ndarray) -> pd.DataFrame:
    return pd.DataFrame(
        {"test_id": name, "t": t, "v_rel": v, "T": 25.0, "sigma_n": sigma, "sd": v * t, "psi": 1.0, "mu": mu}
    )


def left_by_the_model(found) -> float:  # type: ignore[no-untyped-def]
    a = found.averages
    return float(np.sqrt(np.average(a["before"] ** 2, weights=a["points"])))


def along_and_between(seed: int) -> pd.DataFrame:
    """Return 18 tests that all rise a little along the way, and differ much by pressure and speed."""
    rng = np.random.default_rng([seed, 1])
    frames = []
    for k, (sigma, v) in enumerate(
        (s, v) for s in (40.0, 60.0) for v in (50.0, 120.0, 300.0) for _ in range(3)
    ):
        t = np.linspace(0.0, 150.0, POINTS)
        level = 0.17 + 0.03 * np.log(v / 120.0) - 0.03 * (sigma > 50.0) + rng.normal(0.0, 0.004)
        frames.append(
            one_test(
                f"t{k}", t, v, sigma, level + 0.008 * (t / 150.0) ** 0.6 + rng.normal(0.0, 0.002, POINTS)
            )
        )
    return pd.concat(frames, ignore_index=True)


#: The others say the same of other noise.
SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.nightly) for seed in (1, 2))]


@pytest.mark.parametrize("seed", SEEDS)
def test_a_small_rise_along_every_test_does_not_hide_what_sets_tests_apart(seed: int) -> None:
    found = diagnose(along_and_between(seed), model="constant")
    between = {"rising_speed", "viscous", "pressure_saturation", "pressure_power", "force_zero"}
    if found.verdict == "explained":
        assert between & set(found.effects)
    else:
        assert found.error_budget["missing"] > 0.005 or between & set(found.confusion_set + found.effects)


def one_material_apart(seed: int, wander: float) -> tuple[pd.DataFrame, pd.DataFrame]:
    rng = np.random.default_rng([seed, 2])
    frames, batches = [], []
    for b in range(4):
        for i in range(3):
            t = np.linspace(0.0, 300.0, POINTS)
            slow = np.interp(t, np.linspace(0.0, 300.0, 8), rng.normal(0.0, wander, 8)) if wander else 0.0
            mu = 0.45 - 0.09 * (b == 2) + rng.normal(0.0, 0.018) + slow + rng.normal(0.0, 0.002, POINTS)
            frames.append(one_test(f"{b}{i}", t, 250.0, 2.0, mu))
            batches.append(f"lot {b}")
    data = pd.concat(frames, ignore_index=True)
    return data, pd.DataFrame({"test_id": data["test_id"].unique(), "batch": batches})


@pytest.mark.nightly
def test_a_material_far_from_the_others_is_named_though_the_first_noise_holds_it() -> None:
    answers = [diagnose(*one_material_apart(seed, 0.0), model="constant") for seed in range(4)]
    assert sum(a.effects == ["batch"] for a in answers) >= 3


@pytest.mark.parametrize("seed", SEEDS)
def test_the_floor_is_never_above_what_the_model_leaves(seed: int) -> None:
    for wander in (0.0, 0.04):
        found = diagnose(*one_material_apart(seed, wander), model="constant")
        # Named though the first noise holds it.
        assert wander or seed or found.effects == ["batch"]
        b, left = found.error_budget, left_by_the_model(found)
        assert b["floor"] <= left * 1.0001 and found.noise_floor["total"] <= left * 1.0001
        assert np.hypot(np.hypot(b["floor"], b["explained"]), b["missing"]) == pytest.approx(left, rel=1e-6)


def test_a_rising_threshold_is_not_named_where_friction_falls_everywhere() -> None:
    rng = np.random.default_rng(3)
    rows = []
    for p in np.linspace(0.3, 1.7, 6):
        for v in (250.0, 700.0, 1200.0, 1800.0):
            for start in np.linspace(8.0, 20.0, 6):
                T = start + 0.05 * p * v * (1.0 + 0.1 * rng.normal())
                rows.append(
                    (
                        v,
                        T,
                        p,
                        0.05 + 0.02 / p**0.4 + 0.05 / (1.0 + (T - 5.0) / 30.0) + rng.normal(0.0, 0.0005),
                    )
                )
    data = pd.DataFrame(rows, columns=["v_rel", "T", "sigma_n", "mu"])
    found = diagnose(data.assign(test_id=[f"t{k:03d}" for k in range(len(data))]))
    assert "thermal_breakdown" not in found.confusion_set + found.effects
    assert found.verdict != "nothing_missing"


@pytest.mark.parametrize(
    ("seed", "name"),
    [
        (300, "flash_temperature"),
        *(
            pytest.param(*case, marks=pytest.mark.nightly)
            for case in ((301, "wear_out"), (302, "thermal_softening"), (303, "stribeck"))
        ),
    ],
)
def test_what_is_named_refine_accepts(seed: int, name: str) -> None:
    points, tests, _ = campaign(name, seed=seed, strength=1.2, thin=40, extra=0)
    found = diagnose(points, tests)
    assert found.effects
    try:
        history = refine(
            points, tests.drop(columns="role", errors="ignore"), add=found.effects
        ).error_history_
    except InputError as error:  # pragma: no cover - the fault that this test looks for
        pytest.fail(f"{found.effects} named and then refused: {error}")
    assert history[-1]["after"]["rmse"] < history[-1]["before"]["rmse"]


def test_order_of_rows_names_of_tests_and_unit_of_length_do_not_matter() -> None:
    points, tests, _ = campaign("wear_out", seed=311, strength=2.0, thin=40, extra=16, levels=2)
    found = diagnose(points, tests)
    shuffled = diagnose(points.sample(frac=1.0, random_state=2), tests.sample(frac=1.0, random_state=3))
    assert shuffled.to_dict() == found.to_dict()
    names = {name: f"x{k}" for k, name in enumerate(reversed(points["test_id"].unique()))}
    renamed = diagnose(points.replace({"test_id": names}), tests.replace({"test_id": names}))
    assert (renamed.verdict, renamed.effects) == (found.verdict, found.effects)
    assert renamed.confidence == pytest.approx(found.confidence, abs=1e-6)
    metres = diagnose(points.assign(v_rel=points["v_rel"] / 1000.0, sd=points["sd"] / 1000.0), tests)
    assert (metres.verdict, metres.effects) == (found.verdict, found.effects)
    assert metres.confidence == pytest.approx(found.confidence, abs=0.02)


def test_unseen_tests_are_not_in_the_fit() -> None:
    """A test that no other resembles is predicted by a line through the others, worked out here."""
    rng = np.random.default_rng(5)
    rows = [
        {
            "test_id": f"t{k}",
            "sigma_n": s,
            "mu": 0.1 - 1e-4 * s + (0.05 if k == 4 else 0.0) + 1e-4 * rng.normal(),
        }
        for k, s in enumerate(np.linspace(100.0, 400.0, 8))
        for _ in range(5)
    ]
    campaign = prepare(pd.DataFrame(rows))
    unseen = UnseenTests(campaign, base_law(LinearFriction(), campaign))
    assert sorted(unseen.fold_of_test.tolist()) == list(range(8))  # each alone
    sigma, mu = campaign.loads.sigma_n, campaign.mu
    others = campaign.point_test != 4
    line = np.polyfit(sigma[others], mu[others], 1)
    expected = (mu - np.polyval(line, sigma))[~others].mean()
    assert unseen.residual()[campaign.test == 4].mean() == pytest.approx(expected, rel=1e-6)


def test_errors_between_and_along_tests_add_up() -> None:
    campaign = prepare(along_and_between(0))
    unseen = UnseenTests(campaign, base_law(LinearFriction(), campaign))
    errors = unseen.errors([make_effect("wear_out")])
    residual = unseen.residual([make_effect("wear_out")])
    first = campaign.test == 0
    square = np.average(residual[first] ** 2, weights=campaign.count[first])
    assert errors.total[0] == pytest.approx(square)
    assert errors.between[0] == pytest.approx(np.average(residual[first], weights=campaign.count[first]) ** 2)


def test_help_is_a_matter_of_whole_tests() -> None:
    rng = np.random.default_rng(1)
    before = ErrorsByTest(rng.chisquare(1, 60), np.full(60, 0.1))
    assert helps(before, ErrorsByTest(0.5 * before.between, before.within))
    assert not helps(before, ErrorsByTest(rng.permutation(before.between), before.within), needed=2.0)
    assert helps(before, ErrorsByTest(before.between, 0.3 * before.within))
    gain, certain = lead(np.array([2.0, 4.0]), np.array([1.0, 1.0]))
    # two standard errors, of two tests; as rare as so many of 27
    assert gain == 2.0 and certain == pytest.approx(student(26).isf(student(1).sf(2.0)))
    many = rng.normal(0.3, 1.0, 40)
    assert lead(many, np.zeros(40))[1] == pytest.approx(many.mean() / (many.std(ddof=1) / np.sqrt(40)))


def test_what_is_left_beside_a_name_grows_with_its_certainty() -> None:
    """A gain is missing by as much as is likely, not in full from some level on: one test more or less does not decide."""
    rng = np.random.default_rng(2)
    named, gain = 4.0 + rng.normal(size=40), rng.normal(size=40)
    named[0] += 100.0  # all predictions alike may err more in one test
    nothing = np.zeros(40)
    base = ErrorsByTest(np.full(40, 9.0), nothing)
    left = []
    for certain in (0.5, 1.5, 2.2, 2.4, 8.0):
        better = named - 1.0 - (gain - gain.mean()) / gain.std(ddof=1) * np.sqrt(40) / certain
        known = [ErrorsByTest(better, nothing)]
        model = ErrorsByTest(named, nothing)
        shares = error_shares(base, model, known, model)
        assert shares.missing == pytest.approx(likely(certain)) and shares.believed == (certain > BELIEVED)
        alone = error_shares(model, model, known, model, BELIEVED)
        assert (alone.missing > 0.0) == (certain > BELIEVED)
        left.append(shares.left)
    assert left[0] == 0.0 and np.all(np.diff(left) > 0.0) and left[3] - left[2] < 0.02


def test_one_test_beyond_all_others_does_not_hide_what_is_known_of_them() -> None:
    """The reference halves the errors of 39 tests, and of one beyond all of them it knows nothing."""
    own, nothing = np.full(40, 4.0), np.zeros(40)
    own[:8] = 6.0
    known = 0.5 * own
    known[3] = 1000.0
    model = ErrorsByTest(own, nothing)
    shares = error_shares(model, model, [ErrorsByTest(known, nothing)], model, BELIEVED)
    assert shares.believed and shares.missing > 0.45 * shares.base
    known[3:30] = 1000.0
    assert error_shares(model, model, [ErrorsByTest(known, nothing)], model, BELIEVED).missing == 0.0


def test_structure_is_what_curves_predict_beyond_the_same_law_with_the_same_weights() -> None:
    """The law, fitted so that tests weigh as much as they know, predicts as well as the curves do: nothing bends."""
    rng = np.random.default_rng(3)
    refitted, nothing = ErrorsByTest(4.0 + rng.random(40), np.zeros(40)), np.zeros(40)
    weighed = ErrorsByTest(refitted.between - 1.0 - rng.random(40), nothing)
    curves = ErrorsByTest(weighed.between + 0.1 * rng.normal(size=40), nothing)
    assert error_shares(refitted, refitted, [curves], refitted, BELIEVED).missing > 1.2
    assert error_shares(refitted, refitted, [curves], weighed, BELIEVED).missing == 0.0


def test_folds_hold_every_test_once() -> None:
    assert sorted(np.bincount(folds_of_tests(22, 0)).tolist()) == [5, 5, 6, 6]
    fold = folds_of_tests(24, 0).reshape(-1, 4)
    assert (np.sort(fold, axis=1) == np.arange(4)).all() and len(np.unique(fold, axis=0)) > 1
    assert folds_of_tests(3, 0).tolist() == [0, 0, 0]


def test_a_window_of_two_loads_that_few_tests_meet_is_something_missing() -> None:
    # no law of the catalogue; the few tests in the window make a lead of 2.1 standard errors on unseen tests
    rng = np.random.default_rng([11, 6])
    u = qmc.LatinHypercube(3, seed=rng).random(60)
    v, T, sigma = 5.0 * 100.0 ** u[:, 0], 20.0 + 280.0 * u[:, 1], 400.0 + 2200.0 * u[:, 2]
    window = np.exp(-(((sigma - 1500.0) / 500.0) ** 2) - (np.log(v / 60.0) / 0.9) ** 2)
    level = 0.1 + 5e-6 * (T - 150.0) + 0.045 * window + rng.normal(0.0, 0.009, 60)
    loads = {"v_rel": v, "T": T, "sigma_n": sigma, "psi": np.full(60, 1.2)}
    data = pd.DataFrame({"test_id": np.repeat([f"t{k}" for k in range(60)], 8)}).assign(
        **{name: np.repeat(values, 8) for name, values in loads.items()},
        sd=np.tile(2.0 * np.arange(1, 9), 60),
        mu=np.repeat(level, 8) + rng.normal(0.0, 0.002, 480),
    )
    answer = diagnose(
        data, catalogue=("pressure_power", "surface_expansion", "wear_out", "thermal_softening")
    )
    assert answer.verdict == "unknown_structure" and answer.error_budget["missing"] > 0.0


@pytest.mark.nightly
def test_a_fault_that_only_mends_the_form_of_what_is_named_is_not_named() -> None:
    # another author's campaign, whose law depends on temperature and pressure; an offset of the force is not in it
    case = next(c for c in cases(120) if c.laws == ("breakdown_lowered",) and c.recipe == "quantised")
    made = make(case)
    assert diagnose(made.data, made.tests).effects == ["hot_pressure_breakdown"]


@pytest.mark.nightly
def test_refine_judges_by_the_tests_that_diagnose_judges_by() -> None:
    data = along_and_between(0)
    slipped = data["test_id"] == "t7"
    data.loc[slipped, "mu"] += 0.12  # the gauge slipped
    said = diagnose(data, model="constant").warnings
    assert any("left out (t7)" in sentence for sentence in said)
    entry = refine(data, model="constant", add="rising_speed").error_history_[-1]
    without = refine(data[~slipped], model="constant", add="rising_speed").error_history_[-1]
    assert entry["judged_by"] == without["judged_by"] + ", without t7, which diagnose leaves out, too"
    for when in ("before", "after"):
        assert entry[when] == pytest.approx(without[when])
