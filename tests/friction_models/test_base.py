"""Domain, and what the base class promises whatever the family."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_models import ConstantFriction, FrictionModel, LinearFriction, TriboLoads
from friction_models.common import InputError
from friction_models.families.registry import FAMILIES, make_model
from friction_models.loads import LOAD_NAMES, LOADS
from friction_models.models.domain import Domain

from .made_up import anywhere, campaign

BOX = Domain((0.0, 20.0, 500.0, 0.0, 1.0), (500.0, 300.0, 2750.0, 60.0, 1.0))


def test_distance_is_the_largest_relative_exceedance() -> None:
    points = np.array(
        [
            [250.0, 100.0, 1000.0, 10.0, 1.0],
            [500.0, 300.0, 2750.0, 60.0, 1.0],
            [1000.0, 440.0, 1000.0, 10.0, 1.0],
            [250.0, 6.0, 1000.0, 10.0, 1.0],
            [250.0, 100.0, 1000.0, 10.0, 1.5],
        ]
    )
    # 500 beyond a range of 500; 140 beyond 280 is less; 14 below 280; psi never varied: relative to its size.
    np.testing.assert_allclose(BOX.distance(points), [0.0, 0.0, 1.0, 0.05, 0.5], atol=1e-15)
    np.testing.assert_array_equal(BOX.contains(points), [True, True, False, False, False])


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(0, 3000), min_size=5, max_size=5))
def test_a_clamped_point_is_inside_and_only_then_unchanged(values: list[float]) -> None:
    point = np.array([values])
    clamped = BOX.clamp(point)
    assert BOX.contains(clamped).all()
    assert np.array_equal(clamped, point) == bool(BOX.contains(point)[0])


def test_domain_survives_its_dict_and_refuses_another() -> None:
    assert Domain.from_dict(BOX.to_dict()) == BOX
    with pytest.raises(InputError, match="domain"):
        Domain.from_dict({"v_rel": [0.0, 1.0]})
    with pytest.raises(InputError, match=r"'T' from 300\.0 to 20\.0"):
        Domain((0.0, 300.0, 0.0, 0.0, 1.0), (1.0, 20.0, 1.0, 1.0, 1.0))
    with pytest.raises(InputError, match="v_rel"):
        Domain.from_dict({q.name: [float("nan"), 1.0] for q in LOADS})


def test_array_loads_and_frame_give_the_same() -> None:
    frame = campaign(6)
    model = LinearFriction().fit_frame(frame)
    array = frame[list(LOAD_NAMES)].to_numpy()
    np.testing.assert_array_equal(model.predict(array), model.predict_frame(frame))
    np.testing.assert_array_equal(model.predict(frame[frame.columns[::-1]]), model.predict_frame(frame))
    np.testing.assert_array_equal(model.predict(TriboLoads.from_array(array)), model.predict_frame(frame))


def test_fit_by_frame_is_fit_by_loads() -> None:
    frame = campaign(6)
    loads = TriboLoads.from_frame(frame)
    a = LinearFriction().fit_frame(frame)
    b = LinearFriction().fit(loads.as_array(), frame["mu"], groups=frame["test_id"])
    np.testing.assert_array_equal(a.coef_, b.coef_)
    assert a.training_["data"]["tests"] == b.training_["data"]["tests"] == 6


@pytest.mark.parametrize("family", [f for f in FAMILIES if f != "constant"])
def test_an_unfitted_model_says_so(family: str) -> None:
    model = make_model(family)
    with pytest.raises(InputError, match=f"the {family} model is not fitted"):
        model.predict(anywhere(3))
    with pytest.raises(InputError, match="not fitted"):
        _ = model.domain
    with pytest.raises(InputError, match="not fitted"):
        _ = model.card


def test_bad_data_is_named() -> None:
    frame = campaign(3)
    model = LinearFriction()
    with pytest.raises(InputError, match=r"column 'mu' .*is missing"):
        model.fit_frame(frame.drop(columns="mu"))
    with pytest.raises(InputError, match=r"column 'psi' .*is it 'Psi'"):
        model.fit_frame(frame.rename(columns={"psi": "Psi"}))
    with pytest.raises(InputError, match=r"column 'mu', row 4: value -0\.5"):
        model.fit_frame(frame.assign(mu=np.where(np.arange(len(frame)) == 4, -0.5, 0.1)))
    with pytest.raises(InputError, match="119 values of mu"):
        model.fit(TriboLoads.from_frame(frame), frame["mu"][:-1])
    with pytest.raises(InputError, match="2 groups for 120 points"):
        model.fit(TriboLoads.from_frame(frame), frame["mu"], groups=["a", "b"])
    with pytest.raises(InputError, match="0 loads"):
        model.fit(np.empty((0, 5)), [])
    fitted = LinearFriction().fit_frame(frame)
    with pytest.raises(InputError, match="column 'T', row 0: value nan"):
        fitted.predict([[1.0, np.nan, 1.0, 1.0, 1.0]])
    with pytest.raises(InputError, match=r"shape \(2, 3\)"):
        fitted.predict(np.ones((2, 3)))


def test_names_are_guessed() -> None:
    with pytest.raises(InputError, match=r"unknown model 'polynomal'.*did you mean 'polynomial'"):
        make_model("polynomal")
    with pytest.raises(InputError, match=r"unknown parameter of polynomial 'degre'.*did you mean 'degree'"):
        make_model("polynomial", degre=3)
    assert make_model("polynomial", degree=3).degree == 3


def test_a_misspelt_effect_is_refused_where_it_is_added() -> None:
    with pytest.raises(InputError, match="did you mean 'stribeck'"):
        _ = LinearFriction() + "stribek"
    with pytest.raises(InputError):
        _ = LinearFriction() + 5


def test_provenance_reaches_the_card_from_info_or_the_frame() -> None:
    frame = campaign(3)
    card = LinearFriction().fit_frame(frame, info={"synthetic": True, "plan": "made up", "x": [1]}).card
    assert card["data"]["synthetic"] is True
    assert card["data"]["provenance"] == {"plan": "made up"}
    frame.attrs.update(synthetic=False)
    assert LinearFriction().fit_frame(frame).card["data"]["synthetic"] is False
    frame.attrs.clear()
    assert LinearFriction().fit_frame(frame).card["data"]["synthetic"] is None


def test_view_draws_each_load_over_the_domain() -> None:
    model = LinearFriction().fit_frame(campaign(6))
    figure = model.view()
    lines = [t for t in figure.data if t.line.width]
    assert len(lines) == len(LOADS)
    for j, line in enumerate(lines):
        assert line.x[0] <= model.domain.lower[j]
        assert line.x[-1] >= model.domain.upper[j]
        loads = np.tile(model.domain.centre, (len(line.x), 1))
        loads[:, j] = line.x
        np.testing.assert_allclose(line.y, model.predict(loads), rtol=1e-12)
    # A law without training data is drawn over the reference plan.
    assert max(ConstantFriction(0.08).view().data[0].x) == 500.0


def test_importing_loads_or_the_package_costs_no_learning_library() -> None:
    import subprocess
    import sys

    code = (
        "import sys, friction_models, friction_models.loads;"
        "print([m for m in ('sklearn', 'torch', 'onnx', 'plotly') if m in sys.modules])"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert shown.strip() == "[]"


def test_everything_but_the_training_of_networks_works_without_torch(tmp_path) -> None:
    import subprocess
    import sys

    frame = pd.concat([campaign(4, 10)])
    make_model("ffnn", hidden=(4,), epochs=2).fit_frame(frame).save(tmp_path / "m")
    frame.to_csv(tmp_path / "points.csv", index=False)
    # The process cannot import torch, as where it is not installed.
    code = f"""
import sys
class NoTorch:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "torch":
            raise ModuleNotFoundError("No module named 'torch'", name="torch")
sys.meta_path.insert(0, NoTorch())
import pandas as pd
import fmus, forming, orchestrator, sct_twin
from friction_models import InputError, load_model, make_model
from friction_models.discovery import diagnose
from fmus import pack, read_friction_fmu
model = load_model({str(tmp_path / "m")!r})
friction = read_friction_fmu(pack(model, {str(tmp_path / "m.fmu")!r}))
points = pd.read_csv({str(tmp_path / "points.csv")!r})
assert abs(friction.predict_frame(points) - model.predict_frame(points)).max() < 1e-9
make_model("gradient_boosting").fit_frame(points)
print(diagnose(points, model="linear").verdict)
try:
    make_model("ffnn").fit_frame(points)
except InputError as error:
    print(error)
"""
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert shown.returncode == 0, shown.stderr
    verdict, refusal = shown.stdout.strip().splitlines()
    assert verdict
    assert "tribofmu[train-networks]" in refusal


class Unfinished(FrictionModel):
    family = "unfinished"

    def _fit(self, loads, mu, groups):  # type: ignore[no-untyped-def]
        self.mean_ = float(np.mean(mu))

    def formula(self, x, L, S=None, system=None):  # type: ignore[no-untyped-def]
        return x.constant(self.mean_, L.v_rel)


def test_a_family_of_ones_own_that_lacks_a_method_says_which(tmp_path: Path) -> None:
    data = campaign(tests=4, points=5)
    model = Unfinished().fit_frame(data)
    assert model.predict_frame(data).nunique() == 1
    with pytest.raises(InputError, match="Unfinished: the method _learned, which says what is saved, is not"):
        model.save(tmp_path / "model")
    for asked in (model, (Unfinished() + "stribeck").fit_frame(data)):
        with pytest.raises(InputError, match="Unfinished: the method formula_text"):
            asked.formula_text()
