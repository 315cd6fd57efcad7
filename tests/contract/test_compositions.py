"""One suite over every family with every effect: what is written is read, and every command takes it."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_models import OnnxModel, TriboLoads, evaluate, load_model
from friction_models.common import InputError
from friction_models.discovery import compare, diagnose, refine
from friction_models.effects import CATALOGUE, make_effect
from friction_models.estimation.campaign.binning import prepare
from friction_models.estimation.search.candidates import evaluate_points, spans_of
from friction_models.families.constant import ConstantFriction
from friction_models.families.registry import FAMILIES, make_model
from friction_models.loads import FloatArray
from friction_models.models.base import FrictionModel

SMALL: dict[str, dict[str, int | tuple[int, ...]]] = {
    "ffnn": {"hidden": (4,), "members": 1, "epochs": 3},
    "gradient_boosting": {"trees": 5, "min_points": 5},
}
FAMILY_NAMES = sorted(FAMILIES)
EFFECT_NAMES = [*sorted(CATALOGUE), "factor:humidity", "factor:operator"]
#: Effects whose share of mu never vanishes: with them the level of friction may be theirs, and the base below 0.
LIFTING = ("pressure_power", "pressure_saturation", "viscous")


def made_up() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return nine short tests over three speeds and pressures with all metadata, and no friction yet."""
    parts = []
    for k in range(9):
        sd = np.linspace(0.2, 40.0, 8)
        set_speed, pressure = (20.0, 90.0, 400.0)[k % 3], (500.0, 1200.0, 2700.0)[k // 3]
        v = set_speed * (1.0 - 0.9 * np.exp(-sd))
        parts.append(
            pd.DataFrame(
                {
                    "test_id": f"t{k}",
                    "t": np.cumsum(np.gradient(sd) / v),
                    "v_rel": v,
                    "T": 20.0 + 40.0 * (k % 2) + 0.1 * set_speed * np.sqrt(sd / 40.0) * pressure / 2700.0,
                    "sigma_n": pressure * (1.0 - 0.1 * sd / 40.0),
                    "sd": sd,
                    "psi": 1.0 + 0.02 * sd * (1 + k % 3),
                    "mu": 0.08,
                }
            )
        )
    number = np.arange(9)
    tests = pd.DataFrame(
        {
            "test_id": [f"t{k}" for k in number],
            "order": number.astype(float),
            "Ra": 0.1 + 0.05 * (number % 4),
            "batch": ["a", "b", "c"] * 3,
            "T_tool": 20.0 + 40.0 * (number % 2),
            "operator": ["anna", "bert", "cleo", "bert", "cleo", "anna", "cleo", "anna", "bert"],
            "humidity": 30.0 + 7.0 * (number * 5 % 9),
        }
    )
    return pd.concat(parts, ignore_index=True), tests


def carried(name: str) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return tests whose friction runs from 0.03 to 0.15 by one effect alone, and scatters a little."""
    data, tests = made_up()
    if name == "viscous":  # never slow: the film carries everywhere
        data["v_rel"] += 150.0
    plan = prepare(data, tests)
    effect = make_effect(name)
    grids = effect.grids(spans_of(plan, plan.mu))
    shape: Mapping[str, float] = {k: float(g[len(g) // 2]) for k, g in grids.items()}
    first = effect.amplitudes[0]
    column = np.broadcast_to(evaluate_points(effect, plan, plan.mu, shape)[0], (len(data), 1))[:, 0]
    column = column * (first.sign or 1)
    share = (column - column.min()) / max(float(np.ptp(column)), 1e-12)
    scatter = np.random.default_rng(0).normal(0.0, 5e-4, len(data))
    return data.assign(mu=0.03 + 0.12 * share + scatter), tests


def through_onnx(model: FrictionModel, file: Path, data: pd.DataFrame, tests: pd.DataFrame) -> FloatArray:
    """Return mu from the file by ONNX Runtime, with metadata and memory set by hand, test by test."""
    run = OnnxModel(file)
    loads = TriboLoads.from_frame(data, tests)
    mu, array = np.empty(len(data)), loads.as_array()
    labels = {v.name: list(v.labels) for v in model.system_variables}
    for part in loads.segments():
        row = tests.set_index("test_id").loc[str(data["test_id"].iloc[part.start])]
        system = [labels[n].index(row[n]) if labels[n] else float(row[n]) for n in labels] or None
        state = run.start_state(1) if model.states else None
        for i in range(part.start, part.stop):
            if state is not None and i > part.start:
                dt = float(data["t"].iloc[i] - data["t"].iloc[i - 1])
                state = run.step(array[i : i + 1], state, dt, system)[1]
            mu[i] = run.predict(array[i : i + 1], state, system)[0]
    return mu


def place(family: str, effect: str) -> int:
    """Return which diagonal of the table of families and effects a cell is on."""
    return (EFFECT_NAMES.index(effect) - FAMILY_NAMES.index(family)) % len(FAMILY_NAMES)


def cells() -> list[Any]:
    """Return every effect with one of the families, every family with several effects; all others are marked for the night."""
    found = []
    for family, effect in product(FAMILY_NAMES, EFFECT_NAMES):
        negative = family == "constant" and effect in LIFTING
        daily = negative or not place(family, effect)
        found.append(pytest.param(family, effect, marks=() if daily else pytest.mark.nightly))
    return found


@pytest.mark.parametrize(("family", "effect"), cells())
def test_what_is_written_is_read_and_taken_everywhere(family: str, effect: str, tmp_path: Path) -> None:
    data, tests = carried(effect)
    model = (make_model(family, **SMALL.get(family, {})) + effect).fit_frame(data, tests)
    mu = model.predict_frame(data, tests)
    assert np.isfinite(mu).all() and (mu >= 0.0).all()
    if family == "constant" and effect in LIFTING:
        assert model.base_.mean_ < 0.0 < mu.min()  # type: ignore[attr-defined]
    same = load_model(model.save(tmp_path / "model"))
    np.testing.assert_array_equal(same.predict_frame(data, tests), mu)
    found = through_onnx(model, tmp_path / "model" / "model.onnx", data, tests)
    np.testing.assert_allclose(found, mu, rtol=0, atol=1e-9)
    assert compare({"it": same}, data, tests).errors["it"].rmse == pytest.approx(
        evaluate(same, data, tests).overall["rmse"]
    )
    # what follows takes longest; networks would be trained several times
    if place(family, effect) or family == "ffnn":
        return
    again = refine(data, tests, model=same)
    np.testing.assert_allclose(again.predict_frame(data, tests), mu, rtol=0, atol=1e-6)
    other = "stribeck" if effect != "stribeck" else "thermal_softening"
    some = data[
        data["test_id"].isin(["t0", "t1", "t4", "t5", "t8"])
    ]  # all levels of each load, at a third of the time
    assert diagnose(some, tests, model=same, catalogue=[other]).verdict


def test_a_constant_alone_is_no_negative_friction(tmp_path: Path) -> None:
    data, _ = made_up()
    model = ConstantFriction().fit_frame(data)
    model.mean_ = -0.0151
    with pytest.raises(InputError, match=r"mu is -0\.0151, allowed: a number from 0 to 10"):
        load_model(model.save(tmp_path / "model"))
