"""Models that are taken as they are: their level counts, and what they follow already hides nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from sklearn.ensemble import RandomForestRegressor
from sklearn.linear_model import LinearRegression

from friction_models import ConstantFriction, LinearFriction
from friction_models.common import InputError
from friction_models.discovery import compare, diagnose
from friction_models.discovery.judge.doubts import LIKELY
from friction_models.discovery.judge.level_offset import level_of
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search.base_law import base_law
from friction_models.loads import LOAD_NAMES
from friction_models.models.onnx_model import OnnxModel
from tests.friction_models import made_up

LEVEL = 0.074


def made(seed: int, peak: float = 0.0) -> pd.DataFrame:
    """Return 27 synthetic tests; `peak` is the hidden part, which fades with speed."""
    rng = np.random.default_rng(seed)
    tests = []
    for k in range(27):
        speed, pressure, warm = [5, 100, 450][k % 3], [500, 1500, 2600][k // 3 % 3], [20, 120, 250][k // 9]
        sd = np.linspace(0.1, 50.0, 40)
        v = speed * (1.0 - np.exp(-sd / 2.0))
        loads = {
            "t": np.cumsum(np.gradient(sd) / v),
            "v_rel": v,
            "T": warm + pressure * np.sqrt(v * sd) * 1e-3,
            "sigma_n": pressure * (1.0 - 0.05 * sd / 50.0),
            "sd": sd,
            "psi": 1.1 + 0.01 * sd * rng.uniform(),
        }
        mu = (
            LEVEL
            + rng.normal(0.0, 0.004)
            + rng.normal(0.0, 0.002, len(sd))
            + peak / (1.0 + (v / 40.0) ** 1.4)
        )
        tests.append(pd.DataFrame({"test_id": f"f{k:02d}", **loads, "mu": mu}))
    return pd.concat(tests, ignore_index=True)


class AsItIs:
    """A law from anywhere: it only predicts."""

    def __init__(self, law: Callable[[np.ndarray], np.ndarray]) -> None:
        self.law = law

    def predict(self, loads: np.ndarray) -> np.ndarray:
        """Return mu at loads of shape (n, 5)."""
        return self.law(np.asarray(loads))


def flat(mu: float) -> AsItIs:
    """Return a law that knows no load."""
    return AsItIs(lambda loads: np.full(len(loads), mu))


def test_a_wrong_level_is_not_called_complete() -> None:
    for model in (flat(0.04), ConstantFriction(0.04)):
        found = diagnose(made(1), model=model)
        assert found.verdict == "unknown_structure" and found.confidence > 0.9 and not found.effects
        assert "off by the same amount everywhere" in found.sentence
        assert (
            found.where[-1]["shape"].startswith("constant offset +0.03") and not found.where[-1]["variables"]
        )
        assert found.error_budget["missing"] == pytest.approx(LEVEL - 0.04, abs=0.003)
        assert np.mean([b["bias"] for b in found.bias]) == pytest.approx(LEVEL - 0.04, abs=0.005)
        assert found.worst_tests[0]["rms"] > 0.03
        assert "constant offset" in found.report()


@pytest.mark.parametrize(
    ("seeds", "wrong"), [(range(10, 13), 0), pytest.param(range(13, 22), 1, marks=pytest.mark.nightly)]
)
def test_the_right_level_is_complete(seeds: range, wrong: int) -> None:
    verdicts = [diagnose(made(seed), model=flat(LEVEL)).verdict for seed in seeds]
    assert verdicts.count("nothing_missing") >= len(seeds) - wrong


@pytest.mark.nightly
def test_an_effect_is_found_beside_a_wrong_level() -> None:
    found = diagnose(made(2, peak=0.02), model=flat(0.04))
    assert found.effects == ["stribeck"] and any("lies at least 0.03" in w for w in found.warnings)
    right = diagnose(made(2, peak=0.02), model=flat(LEVEL))
    assert right.effects == ["stribeck"] and not any("lies" in w for w in right.warnings)


def test_a_model_fitted_over_the_effect_still_lacks_it() -> None:
    data = made(4, peak=0.02)
    fitted = LinearFriction().fit_frame(data)
    found = diagnose(data, model=AsItIs(fitted.predict))
    assert found.verdict in {"explained", "ambiguous"} and found.effects == ["stribeck"]
    assert any("linear in the loads" in w for w in found.warnings)
    assert diagnose(data, model=fitted).effects == ["stribeck"]


def test_few_tests_and_blurred_data_are_no_finding() -> None:
    data = made(5)
    few = diagnose(data[data["test_id"] < "f04"])
    assert few.confidence <= LIKELY and "nothing can be seen" in few.sentence
    rng = np.random.default_rng(8)
    blurred = diagnose(data.assign(mu=data["mu"] + np.where(rng.random(len(data)) < 0.3, 0.4, 0.0)))
    assert blurred.confidence <= 0.9 and any(
        "more than half of mu" in w or "far off" in w for w in blurred.warnings
    )


def test_memory_and_system_variables_of_a_fixed_model_act(tmp_path: Path) -> None:
    data = made(6)
    rough = pd.DataFrame(
        {
            "test_id": data["test_id"].unique(),
            "Ra": np.random.default_rng(1).choice([0.02, 0.3], 27),
        }
    )
    model = (LinearFriction() + "rate_state" + "tool_roughness").fit_frame(data, rough)
    model.save(tmp_path / "model")
    fixed = OnnxModel(tmp_path / "model" / "model.onnx")
    law = base_law(fixed, prepare(data, rough))
    assert law.fixed
    np.testing.assert_allclose(law.offset, model.predict_frame(data, rough), atol=1e-9)
    assert np.ptp(law.offset - np.asarray(fixed.predict(data[list(LOAD_NAMES)].to_numpy()))) > 1e-4


def test_any_regressor_is_judged_and_one_that_cannot_predict_is_refused() -> None:
    frame = made_up.campaign(12, 12)
    loads = frame[list(LOAD_NAMES)].to_numpy()
    fitted = RandomForestRegressor(5, random_state=0).fit(loads, frame["mu"])
    answer = diagnose(frame, model=fitted, catalogue=["stribeck"])
    assert "the RandomForestRegressor model" in answer.sentence
    three = LinearRegression().fit(loads[:, :3], frame["mu"])
    for model, said in (
        (
            RandomForestRegressor(5),
            "predict fails (NotFittedError: This RandomForestRegressor instance is not",
        ),
        (three, "predict fails (ValueError: X has 5 features, but LinearRegression is expecting 3"),
    ):
        for judge in (lambda m: diagnose(frame, model=m), lambda m: compare({"it": m}, frame)):
            with pytest.raises(InputError) as caught:
                judge(model)
            assert said in str(caught.value) and "of the loads v_rel, T, sigma_n, sd, psi" in str(
                caught.value
            )
    for model in (RandomForestRegressor, 3.0, None):
        with pytest.raises(InputError, match="allowed is a family name, a model, or an object"):
            diagnose(frame, model=model)
        with pytest.raises(InputError, match="cannot predict; allowed: an object that is fitted"):
            compare({"it": model}, frame)


def test_columns_of_the_map_never_touch() -> None:
    found = diagnose(made_up.campaign(20, 20), model="constant", catalogue=["stribeck"])
    for scale in (1.0, 30.0, 3000.0):
        averages = found.averages.assign(
            before=scale * found.averages["before"], sigma_n=30.0 * scale * found.averages["sigma_n"]
        )
        lines = replace(found, averages=averages, where=[]).report().splitlines()
        first = next(k for k, line in enumerate(lines) if line.startswith("The same over sigma_n and T"))
        rows = [line.split() for line in lines[first + 2 : first + 9]]
        assert len(rows[0]) in {6, 12}
        assert all(np.isfinite([float(x) for x in row]).all() for row in rows)  # no two numbers in one word


@pytest.mark.parametrize("factor", [1.25, 1.0])
def test_a_law_that_is_off_by_a_factor_is_told_so(factor: float) -> None:
    """The force of a cell that reads a quarter too much: no effect of a load, though what is left falls where friction falls."""

    def law(loads: np.ndarray) -> np.ndarray:
        return np.asarray(0.12 * np.exp(-loads[:, 1] / 300.0) - 1e-5 * (loads[:, 2] - 1500.0))

    data = made(3)
    noise = data["mu"] - LEVEL
    mu = factor * (law(data[list(LOAD_NAMES)].to_numpy()) + noise)
    found = diagnose(data.assign(mu=mu), model=AsItIs(law))
    if factor != 1.0:
        assert found.verdict == "unknown_structure" and not found.effects
        assert "off by the same factor everywhere" in found.sentence
        factors = [float(w.split()[3]) for w in found.warnings if w.startswith("measured friction is")]
        assert factors == [pytest.approx(factor, abs=0.04)]
    else:
        assert found.verdict == "nothing_missing", found.sentence


def test_names_that_could_stand_for_the_model_itself_leave_it_its_factor() -> None:
    """An effect that runs nearly as the predictions do: the fit shares the factor out between both, by chance."""
    rng = np.random.default_rng(0)
    predicted = rng.uniform(0.06, 0.12, 60)
    alike = predicted + 1e-4 * rng.standard_normal(60)
    left = -0.25 * predicted + 1e-5 * rng.standard_normal(60) + 0.4 * (alike - predicted)
    search: Any = SimpleNamespace(
        floor=SimpleNamespace(known=True, total=1e-3),
        columns_with=lambda chosen: np.column_stack([np.ones(60), predicted, alike]),
        whiten=lambda values: 1e3 * values,
        y=left,
        freedom=SimpleNamespace(between=20.0),
    )
    level = level_of(search, [], scaled=True)
    assert level.factor == pytest.approx(0.75, abs=0.01)
