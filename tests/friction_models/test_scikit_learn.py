"""Models in the tools of scikit-learn."""

from __future__ import annotations

import warnings

import numpy as np
import pandas as pd
import pytest
from sklearn.base import clone, is_regressor
from sklearn.ensemble import VotingRegressor
from sklearn.exceptions import NotFittedError
from sklearn.inspection import permutation_importance
from sklearn.model_selection import GridSearchCV, GroupKFold, cross_val_score
from sklearn.pipeline import Pipeline
from sklearn.preprocessing import FunctionTransformer
from sklearn.utils.estimator_checks import check_estimator

from friction_models import ConstantFriction, FrictionModel, LinearFriction, PolynomialFriction, make_model
from friction_models.families.registry import FAMILIES
from friction_models.loads import LOAD_NAMES

#: Checks of scikit-learn that a friction model passes: the others fit it to made-up columns, which are no loads (another
#: number of them, or values that no contact has), and the model refuses them with a sentence.
PASSED = {
    "check_estimator_cloneable",
    "check_estimator_repr",
    "check_estimator_tags_renamed",
    "check_estimators_unfitted",
    "check_get_params_invariance",
    "check_mixin_order",
    "check_no_attributes_set_in_init",
    "check_parameters_default_constructible",
    "check_set_params",
    "check_valid_tag_types",
}


@pytest.fixture(scope="module")
def data() -> pd.DataFrame:
    rng = np.random.default_rng(8)
    n = 120
    low, high = np.array([5.0, 20.0, 300.0, 0.0, 1.0]), np.array([300.0, 200.0, 1500.0, 40.0, 5.0])
    table = pd.DataFrame(low + (high - low) * rng.random((n, 5)), columns=list(LOAD_NAMES))
    mu = 0.12 - 2e-5 * table["sigma_n"] + 1e-7 * (table["T"] - 100.0) ** 2
    return table.assign(test_id=[f"t{k // 8}" for k in range(n)], mu=mu + 1e-4 * rng.normal(size=n))


@pytest.mark.parametrize("family", [*FAMILIES, "linear + stribeck"])
def test_checks_of_scikit_learn(family: str) -> None:
    model: FrictionModel = LinearFriction() + "stribeck" if "+" in family else make_model(family)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        results = check_estimator(model, on_fail=None)
    passed = {r["check_name"] for r in results if r["status"] == "passed"}
    no_value = {"check_estimators_unfitted"} if model.is_fitted else set()
    assert passed >= PASSED - no_value


def test_a_search_takes_whole_tests_and_finds_the_degree(data: pd.DataFrame) -> None:
    loads, mu = data[list(LOAD_NAMES)], data["mu"]
    search = GridSearchCV(PolynomialFriction(), {"degree": [1, 2]}, cv=GroupKFold(4))
    search.fit(loads, mu, groups=data["test_id"])
    assert search.best_params_ == {"degree": 2} and search.best_score_ > 0.99
    scores = cross_val_score(LinearFriction(), loads, mu, groups=data["test_id"], cv=GroupKFold(3))
    line = LinearFriction().fit(loads, mu)
    squared = np.mean((mu - line.predict(loads)) ** 2)
    assert line.score(loads, mu) == pytest.approx(1.0 - squared / np.var(mu))
    assert len(scores) == 3 and scores.max() < search.best_score_
    assert (
        LOAD_NAMES[int(permutation_importance(line, loads, mu, random_state=0).importances_mean.argmax())]
        == "sigma_n"
    )


def test_models_stand_in_pipelines_and_votes(data: pd.DataFrame) -> None:
    loads, mu = data[list(LOAD_NAMES)], data["mu"]
    flow = Pipeline([("as they are", FunctionTransformer()), ("law", LinearFriction() + "stribeck")])
    flow.set_output(transform="pandas").fit(loads, mu)
    np.testing.assert_allclose(flow.predict(loads), flow["law"].predict(loads))
    vote = VotingRegressor([("line", LinearFriction()), ("constant", ConstantFriction())]).fit(loads, mu)
    alone = LinearFriction().fit(loads, mu).predict(loads)
    np.testing.assert_allclose(vote.predict(loads), 0.5 * (alone + mu.mean()))


def test_a_clone_has_the_parameters_and_nothing_learned(data: pd.DataFrame) -> None:
    model = (PolynomialFriction(degree=3) + "viscous").fit_frame(data)
    copy = clone(model)
    assert is_regressor(copy) and copy.get_params()["base__degree"] == 3
    with pytest.raises(NotFittedError, match="is not fitted"):
        copy.predict(data[list(LOAD_NAMES)])
