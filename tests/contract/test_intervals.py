"""Prediction intervals of every family: the same bounds from `predict_interval`, ONNX Runtime, C and Python FMUs."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from fmus import FmuModel, pack
from fmus.checks.report import Notes
from fmus.checks.trial_friction import friction as friction_trial
from fmus.native.generate import generate
from fmus.runtime.running import FmuError, RunningFmu, UnpackedFmu
from fmus.source.reading import read_source
from fmus.targets import native as native_target
from fmus.targets.native import without_interval
from friction_models import OnnxModel, TriboLoads, load_model
from friction_models.common import InputError
from friction_models.families.registry import FAMILIES
from friction_models.loads import LOAD_NAMES
from friction_models.models.base import FrictionModel
from friction_models.models.intervals.between_levels import Widening
from friction_models.models.intervals.calibration import calibrated
from friction_models.models.intervals.prediction_interval import LEVEL

from ..friction_models.made_up import EDGES, anywhere, campaign
from .test_models import fresh

FRAME = campaign(12, 8)
LOADS = TriboLoads.from_frame(FRAME)
#: A composition with memory stands for all.
NAMES = (*sorted(FAMILIES), "linear + work_exhaustion")
#: What stands for all in C: the margin knows nothing of the law, only whether there is memory.
PACKED = {"linear": ("2.0",), "linear + work_exhaustion": ("3.0",)}
POINTS = np.vstack([anywhere(40, seed=3), EDGES, 1.4 * anywhere(20, seed=5)])


def interval_model(name: str) -> FrictionModel:
    """Return a fitted model whose width depends on every load, which so few tests do not show by themselves."""
    model = fresh(name).fit_frame(FRAME)
    mu, tests = FRAME["mu"].to_numpy(), FRAME["test_id"].to_numpy().astype(str)
    predicted, source = model.left_out(LOADS, mu, tests, folds=2, seed=0)
    interval = calibrated(predicted, source, LOADS, mu, tests, model.domain, LEVEL)
    slopes = (0.2, 1e-3, -0.1, 0.15, -0.05)
    # two gaps of one load, and one of another: between levels the width grows, to either side of them it does not
    between = (
        Widening("v_rel", 20.0, 80.0, 0.004),
        Widening("v_rel", 80.0, 400.0, 0.002),
        Widening("T", 60.0, 180.0, 0.003),
    )
    constant = interval.constant - 0.5
    model.interval_ = replace(interval, slopes=slopes, constant=constant, between=between)
    return model


@pytest.fixture(scope="module")
def models() -> dict[str, FrictionModel]:
    return {name: interval_model(name) for name in NAMES}


@pytest.fixture(scope="module")
def fmus(models: dict[str, FrictionModel], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("fmus")
    made = {
        f"{name}-{fmi}": pack(models[name], folder / f"{k}-{fmi}.fmu", fmi=fmi, nodes=3, interval=True)
        for k, name in enumerate(PACKED)
        for fmi in PACKED[name]
    }
    for k, name in enumerate(PACKED):
        path = folder / f"python-{k}.fmu"
        made[f"{name}-python"] = pack(models[name], path, target="python", nodes=3, interval=True)
    return made


@pytest.mark.parametrize("name", NAMES)
def test_onnx_runtime_gives_the_same_bounds(
    models: dict[str, FrictionModel], name: str, tmp_path: Path
) -> None:
    model = models[name]
    session = OnnxModel(model.to_onnx(tmp_path / "a.onnx"))
    for got, wanted in zip(session.predict_interval(POINTS), model.predict_interval(POINTS)):
        np.testing.assert_allclose(got, wanted, rtol=1e-9, atol=1e-9)
    low, high = model.predict_interval(POINTS)
    mu = model.predict(POINTS)
    assert (low >= 0.0).all() and (low <= mu).all() and (mu < high).all() and np.isfinite(high).all()
    assert (tmp_path / "a.onnx").read_bytes() == model.to_onnx(tmp_path / "b.onnx").read_bytes()


@pytest.mark.parametrize("name", ["linear", "linear + work_exhaustion"])
def test_mu_stays_the_first_output_and_a_saved_model_keeps_its_interval(
    models: dict[str, FrictionModel], name: str, tmp_path: Path
) -> None:
    import onnx

    model = models[name]
    same = load_model(model.save(tmp_path / "model"))
    names = [o.name for o in onnx.load(tmp_path / "model" / "model.onnx").graph.output]
    assert names[0] == "mu" and names[-1] == "mu_margin"
    assert same.interval == model.interval
    np.testing.assert_array_equal(same.predict_interval_frame(FRAME), model.predict_interval_frame(FRAME))
    again = same.save(tmp_path / "again")
    for file in ("model.onnx", "card.json", "card.md"):
        assert (again / file).read_bytes() == (tmp_path / "model" / file).read_bytes()


@pytest.mark.parametrize("name", PACKED)
def test_fmus_give_the_same_bounds(
    models: dict[str, FrictionModel], fmus: dict[str, Path], name: str
) -> None:
    model = models[name]
    inside = np.asarray(model.domain.clamp(POINTS))
    mu, margin = model.predict(inside), (model.interval or pytest.fail()).margins(POINTS, model.domain)
    for key in (k for k in fmus if k.rpartition("-")[0] == name):
        fmu = UnpackedFmu.of(fmus[key])
        groups = [v.name for q in LOAD_NAMES for v in fmu.resolve(q)]
        got = []
        with RunningFmu(fmu) as running:
            for i in range(0, len(POINTS) - 2, 3):
                running.set_real(groups, POINTS[i : i + 3].T)
                got.append(
                    [running.get_real([v.name for v in fmu.resolve(n)]) for n in ("mu_high", "mu", "mu_low")]
                )
        high, centre, low = np.array(got).transpose(1, 0, 2).reshape(3, -1)
        rows = slice(0, len(high))
        np.testing.assert_allclose(centre, mu[rows], rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(high, (mu + margin)[rows], rtol=1e-9)
        np.testing.assert_allclose(low, np.maximum(mu - margin, 0.0)[rows], rtol=1e-9, atol=1e-11)
        frame = FRAME[["test_id", "t", *LOAD_NAMES]].iloc[:24]
        bounds = FmuModel(fmus[key]).predict_interval_frame(frame)
        np.testing.assert_allclose(bounds, model.predict_interval_frame(frame), rtol=1e-7, atol=1e-9)


def test_check_knows_the_bounds(fmus: dict[str, Path], tmp_path: Path) -> None:
    notes = Notes(tmp_path / "found.jsonl")
    friction_trial(UnpackedFmu.of(fmus["linear + work_exhaustion-3.0"]), notes)
    found = [json.loads(line) for line in notes.result.read_text().splitlines()]
    bounds = [(outcome, text) for outcome, _, text in found if text.startswith("mu_low and mu_high")]
    # Around mu, and against ONNX Runtime; with the default number of points and with another one.
    assert len(bounds) == 4 and {outcome for outcome, _ in bounds} == {"passed"}
    assert not [text for outcome, _, text in found if outcome == "failed"]
    for key in ("linear-2.0", "linear + work_exhaustion-3.0", "linear-python"):
        assert validate_fmu(str(fmus[key])) == []


@pytest.mark.parametrize("key", ["linear-2.0", "linear + work_exhaustion-3.0"])
def test_derivatives_of_the_bounds(fmus: dict[str, Path], key: str) -> None:
    fmu = UnpackedFmu.of(fmus[key])
    inputs, bounds = LOAD_NAMES, ("mu_low", "mu_high")
    points, direction = anywhere(3, seed=9), np.random.default_rng(2).uniform(-1.0, 1.0, (3, 5))
    direction *= [10.0, 10.0, 100.0, 1.0, 0.5]

    def at(h: float) -> np.ndarray:
        running.set_real(inputs, (points + h * direction).T)
        return np.asarray(running.get_real(bounds))

    with RunningFmu(fmu) as running:
        slope = (at(1e-5) - at(-1e-5)) / 2e-5
        at(0.0)
        got = running.derivative(bounds, inputs, direction.T)
        np.testing.assert_allclose(got, slope, rtol=1e-5, atol=1e-9)
        assert np.abs(got[:3] - got[3:]).max() > 1e-6
        if key.endswith("3.0"):
            weights = np.random.default_rng(3).uniform(-1.0, 1.0, 6)
            adjoint = running.adjoint(bounds, inputs, weights)
            assert adjoint @ direction.T.ravel() == pytest.approx(weights @ got, rel=1e-9)


@pytest.mark.parametrize("key", ["linear-2.0", "linear + work_exhaustion-3.0", "linear-python"])
def test_bounds_cannot_be_set(fmus: dict[str, Path], key: str) -> None:
    with RunningFmu(UnpackedFmu.of(fmus[key])) as running:
        name = "mu_high" if key.endswith("3.0") else "mu_high[2]"
        with pytest.raises(FmuError, match="cannot be set"):
            running.set_real([name], np.full(len(running.fmu.resolve(name)), 0.1))


def test_without_the_option_nothing_changes(
    models: dict[str, FrictionModel], fmus: dict[str, Path], tmp_path: Path
) -> None:
    model = models["linear"]
    source = read_source(model)
    assert "margin" not in generate(source, source.interface(1)) and source.interval == 0.95
    folder = Path(native_target.__file__).parents[1]
    for file in (*(folder / "native").glob("*.[ch]"), folder / "slaves" / "friction_slave.py"):
        text = without_interval(file.read_text(encoding="utf-8"))
        assert not [word for word in ("INTERVAL", "<interval>", "margin", "tf_bound") if word in text], (
            file.name
        )
    default = pack(model, tmp_path / "default.fmu", target="python")
    assert not {"mu_low", "mu_high"} & set(UnpackedFmu.of(default).variables)
    again = pack(model, tmp_path / "again.fmu", target="python", nodes=3, interval=True)
    assert again.read_bytes() == fmus["linear-python"].read_bytes()
    plain = fresh("linear").fit_frame(FRAME)
    with pytest.raises(InputError, match="no prediction interval"):
        pack(plain, tmp_path / "x.fmu", interval=True)
    with pytest.raises(InputError, match="target 'ufric' has no prediction interval"):
        pack(model, tmp_path / "x", target="ufric", interval=True)
    with pytest.raises(InputError, match="packed with"):
        FmuModel(again).predict_interval_frame(FRAME, level=0.5)
    with pytest.raises(InputError, match="an FMU packed with one"):
        FmuModel(default).predict_interval_frame(FRAME)
