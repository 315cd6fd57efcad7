"""Pressure saturation follows the laws that it is named after, and models of the law without a knee stay what they were."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from friction_models import LinearFriction, load_model
from friction_models.common import InputError
from friction_models.discovery import diagnose
from friction_models.effects import EffectContext, PressureSaturation
from friction_models.expressions.ops import LoadColumns, NumpyOps

from .estimation_cases import measured

FLOW_STRESS = 700.0  # MPa


def wanheim_and_bay(sigma_n: np.ndarray, f: float) -> np.ndarray:
    """Return mu by the formulas of Bay (J. Mech. Working Technology 14 (1987) 203) for a friction factor of the real contact."""
    root = np.sqrt(1.0 - f)
    limit = (1.0 + np.pi / 2.0 + np.arccos(f) + np.sqrt(1.0 - f**2)) / (np.sqrt(3.0) * (1.0 + root))
    at_limit, p = 1.0 - root, sigma_n / FLOW_STRESS
    above = at_limit + (f - at_limit) * (1.0 - np.exp((limit - p) * at_limit / ((f - at_limit) * limit)))
    stress = np.where(p <= limit, at_limit * p / limit, above)
    return np.asarray(stress / np.sqrt(3.0) / p)


def left_by(law: np.ndarray, sigma_n: np.ndarray, n: float) -> float:
    """Return the largest misfit of the effect with a knee of sharpness n and the best pressure, as a share of the law's range."""
    p = sigma_n[:, None]
    loads = LoadColumns(10.0 + 0.0 * p, 20.0 + 0.0 * p, p, 0.0 * p, 1.0 + 0.0 * p)

    def residual(log_s_c: float) -> np.ndarray:
        shape = {"s_c": float(np.exp(log_s_c)), "n": n}
        columns = np.hstack(PressureSaturation().basis(NumpyOps(), loads, shape, EffectContext()))
        return np.asarray(law - columns @ np.linalg.lstsq(columns, law, rcond=None)[0])

    best = minimize_scalar(lambda s: residual(s) @ residual(s), bounds=np.log([100.0, 1e4]), method="bounded")
    return float(np.abs(residual(best.x)).max() / np.ptp(law))


@pytest.mark.parametrize("f", [0.2, 0.35, 0.5])
def test_the_curves_of_wanheim_and_bay_need_the_knee(f: float) -> None:
    sigma_n = np.linspace(100.0, 3500.0, 200)
    law = wanheim_and_bay(sigma_n, f)
    assert min(left_by(law, sigma_n, n) for n in np.linspace(2.0, 6.0, 17)) < 0.06
    assert left_by(law, sigma_n, 1.0) > 0.2


def test_low_pressures_lose_nothing_in_rounding() -> None:
    p = np.logspace(-12, 5, 400)[:, None]
    loads = LoadColumns(10.0 + 0.0 * p, 20.0 + 0.0 * p, p, 0.0 * p, 1.0 + 0.0 * p)
    for n in (1.0, 3.0, 6.0):
        found = PressureSaturation().basis(NumpyOps(), loads, {"s_c": 800.0, "n": n}, EffectContext())[0][
            :, 0
        ]
        assert found[0] == pytest.approx(1.0, abs=1e-6)
        assert np.all(np.diff(found) < 1e-6) and found[-1] == pytest.approx(800.0 / 1e5, rel=1e-6)


def test_the_law_of_wanheim_and_bay_is_named() -> None:
    for seed in range(3):
        data = measured(np.random.default_rng(seed), tests=30, points=12, between=0.002)
        found = diagnose(data.assign(mu=data["mu"] + 1.5 * wanheim_and_bay(data["sigma_n"].to_numpy(), 0.35)))
        assert found.effects == ["pressure_saturation"], found.sentence


def without_n(card: Any) -> Any:
    """Return a card as it was before the law had its knee."""
    if isinstance(card, list):
        return [without_n(entry) for entry in card]
    return {k: without_n(v) for k, v in card.items() if k != "n"} if isinstance(card, dict) else card


def test_a_model_without_the_knee_is_read_as_the_law_that_it_was(tmp_path: Path) -> None:
    data = measured(np.random.default_rng(0), tests=20, points=6)
    model = (LinearFriction() + PressureSaturation(n=1.0)).fit_frame(data)
    file = model.save(tmp_path / "model") / "card.json"
    now = json.loads(file.read_text(encoding="utf-8"))
    del now["sha256"]["model"]  # a card of that time has the hashes of the files only
    file.write_text(json.dumps(without_n(now)), encoding="utf-8")
    loads = data[["v_rel", "T", "sigma_n", "sd", "psi"]].to_numpy()
    assert np.array_equal(load_model(file.parent).predict(loads), model.predict(loads))
    file.write_text(json.dumps(now).replace('"s_c"', '"s_d"'), encoding="utf-8")
    with pytest.raises(InputError, match="pressure_saturation"):
        load_model(file.parent)
