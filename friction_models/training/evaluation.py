"""Errors of a model on data: over all points, by role of the tests, and of each test."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import pandas as pd

from ..common import InputError
from ..common.errors import shown
from ..loads import MEASURED_MU, DataSet, FloatArray, TriboLoads, check_column, missing_column
from ..loads.dataset import TRAINING, roles_of
from ..models.domain import known_domain
from ..models.measures import Measures, error_measures, loads_sentence, range_warning
from .load_uncertainty import Predictor, load_uncertainty

if TYPE_CHECKING:
    from ..models.base import FrictionModel

#: Typical accuracy of a tribometer in mu; tests with a smaller MAE count as described.
TRIBOMETER_ACCURACY = 0.01
WORST_SHOWN = 5


@dataclass(frozen=True)
class Evaluation:
    """Measured errors of one model.

    Attributes
    ----------
    model : str
        Name of the model.
    overall : dict
        Measures over all points (`error_measures`), `outside_domain` (share of points outside the trained
        domain; None for a model that has none or does not say) and `tests_within_accuracy` (share of tests with an MAE below 0.01);
        `rms_from_loads` (RMSE that the stated uncertainties of the loads alone would make) where the data state any.
    roles : dict of dict
        The same by role (``train``, ``test``); empty where no role is recorded.
    per_test : pandas.DataFrame
        One row a test, worst first: `test_id, role, points, mae, rmse, bias, max_error, outside_domain`.
    synthetic : bool or None
        Whether the data is labelled synthetic.
    warning : str
        That predicted mu leaves 0 to 1; or empty.

    Examples
    --------
    >>> from friction_models import ConstantFriction, evaluate
    >>> data = pd.DataFrame({"test_id": ["a", "b"], "sigma_n": [500.0, 900.0], "mu": [0.5, 0.25]})
    >>> tests = pd.DataFrame({"test_id": ["a", "b"], "role": ["train", "test"]})
    >>> found = evaluate(ConstantFriction(0.5), data, tests)
    >>> {role: measures["mae"] for role, measures in found.roles.items()}
    {'train': 0.0, 'test': 0.25}
    >>> found.per_test["test_id"].tolist()
    ['b', 'a']
    """

    model: str
    overall: Measures
    roles: dict[str, Measures]
    per_test: pd.DataFrame = field(repr=False)
    synthetic: bool | None = None
    warning: str = ""

    def to_dict(self) -> dict[str, object]:
        """Return a JSON-able dict: `model, synthetic, overall, roles, per_test`."""
        return {
            "model": self.model,
            "synthetic": self.synthetic,
            "overall": self.overall,
            "roles": self.roles,
            "per_test": self.per_test.to_dict(orient="records"),
        }

    def report(self) -> str:
        """Return a text report."""
        label = " (synthetic data)" if self.synthetic else ""
        lines = [f"Evaluation of {self.model}{label}", ""]
        lines.append(
            f"{'':12s}{'MAE':>9s}{'RMSE':>9s}{'bias':>10s}{'max':>9s}{'tests':>7s}{'points':>8s}"
            f"{'within 0.01':>13s}{'outside domain':>16s}"
        )
        for name, m in {**self.roles, "all": self.overall}.items():
            lines.append(
                f"{name:12s}{m['mae']:9.5f}{m['rmse']:9.5f}{m['bias']:+10.5f}{m['max_error']:9.4f}"
                f"{m['tests']:7d}{m['points']:8d}{m['tests_within_accuracy']:13.0%}{_share(m['outside_domain']):>16}"
            )
        lines += ["", f"Worst tests{'':9s}{'role':8s}{'MAE':>9s}{'bias':>10s}"]
        for row in self.per_test.head(WORST_SHOWN).to_dict(orient="records"):
            lines.append(
                f"  {shown(row['test_id'], 40):17s} {shown(row['role'] or '', 20):8s}{row['mae']:9.5f}{row['bias']:+10.5f}"
            )
        from_loads = self.overall.get("rms_from_loads")
        if from_loads is not None:
            lines += ["", loads_sentence(from_loads, self.overall["rmse"] or 0.0)]
        lines += ["", self.warning] if self.warning else []
        return "\n".join(lines) + "\n"


def evaluate(
    model: Predictor,
    data: pd.DataFrame | DataSet,
    tests: pd.DataFrame | None = None,
    name: str | None = None,
) -> Evaluation:
    """Measure `model` on points with a measured mu.

    Parameters
    ----------
    model : Predictor
        A friction model, or anything with `predict_frame`.
    data : pandas.DataFrame or DataSet
        Points in the columns of the contract; without `test_id` all points count as one test.
    tests : pandas.DataFrame, optional
        One row a test; its column `role` splits the report.
    name : str, optional
        Name for the report, by default the model's own.

    Raises
    ------
    InputError
        mu is missing or outside its limits, there are no points, the model gives values that are not finite.

    Examples
    --------
    >>> from friction_models import ConstantFriction, evaluate
    >>> data = pd.DataFrame({"test_id": ["a", "a"], "sigma_n": [500.0, 900.0], "mu": [0.25, 0.5]})
    >>> found = evaluate(ConstantFriction(0.5), data)
    >>> found.overall["mae"], found.overall["bias"], found.overall["max_error"]
    (0.125, 0.125, 0.25)
    """
    synthetic = None
    if isinstance(data, DataSet):
        synthetic = data.synthetic if "synthetic" in data.info else None
        tests = data.tests if tests is None else tests
        data = data.points
    if "mu" not in data.columns:
        raise missing_column("mu", data.columns)
    if data.empty:
        raise InputError("evaluate: the table has no rows")
    mu = check_column(data["mu"].to_numpy(), MEASURED_MU)
    ids = data["test_id"].to_numpy().astype(str) if "test_id" in data.columns else np.full(len(data), "all")
    predicted = np.asarray(model.predict_frame(data, tests), dtype=np.float64)
    if predicted.shape != mu.shape or not np.isfinite(predicted).all():
        raise InputError(f"evaluate: the model gives {predicted.shape} values, not {mu.shape} finite ones")
    loads = TriboLoads.from_frame(data)
    domain = known_domain(model)
    outside = None if domain is None else ~domain.without(loads.absent).contains(loads.as_array())
    table = _per_test(mu, predicted, outside, ids, _roles(tests))
    uncertain = load_uncertainty(model, data, tests)

    def measures(own: npt.NDArray[np.bool_]) -> Measures:
        mae = table.loc[table["test_id"].isin(ids[own]), "mae"].to_numpy()
        return (
            error_measures(mu[own], predicted[own], ids[own])
            | {
                "outside_domain": None if outside is None else float(np.mean(outside[own])),
                "tests_within_accuracy": float(np.mean(mae < TRIBOMETER_ACCURACY)),
            }
            | ({} if uncertain is None else {"rms_from_loads": uncertain.rms_of(own)})
        )

    roles = {
        role: measures(np.isin(ids, table.loc[table["role"] == role, "test_id"].to_numpy().astype(str)))
        for role in sorted({r for r in table["role"] if r}, key=lambda r: (r != "train", r))
    }
    overall = measures(np.full(len(ids), True))
    label = name or str(getattr(model, "name", "model"))
    return Evaluation(label, overall, roles, table, synthetic, range_warning(predicted))


def train(model: FrictionModel, data: DataSet) -> Evaluation:
    """Fit `model` on the training tests of `data`, measure it on all, and record the errors in its card.

    Tests are the training tests where the table of tests has a column `role` with ``train``; without
    that column all are. The errors of each role stand in the card under its name.

    Examples
    --------
    >>> from friction_models import ConstantFriction, DataSet
    >>> points = pd.DataFrame({"test_id": ["a", "b"], "sigma_n": [500.0, 900.0], "mu": [0.5, 0.25]})
    >>> tests = pd.DataFrame({"test_id": ["a", "b"], "role": ["train", "test"]})
    >>> model = ConstantFriction()
    >>> train(model, DataSet(points, tests)).roles["test"]["mae"]
    0.25
    >>> model.value
    0.5
    """
    chosen = data.select("train")
    if chosen.points.empty and data.tests is not None:
        found = ", ".join(sorted(map(repr, set(data.tests["role"].astype(str)))))
        raise InputError(
            f"train: no test has the role 'train', the table holds {found}; allowed: train, test"
        )
    model.fit_frame(chosen.points, chosen.tests, chosen.info)
    evaluation = evaluate(model, data)
    for role, measures in evaluation.roles.items():
        model.record_errors(role, measures)
    return evaluation


def _roles(tests: pd.DataFrame | None) -> dict[str, str]:
    if tests is None or "role" not in tests.columns or "test_id" not in tests.columns:
        return {}
    return dict(zip(tests["test_id"].astype(str), roles_of(tests["role"])))


def _per_test(
    mu: FloatArray, predicted: FloatArray, outside: np.ndarray | None, ids: np.ndarray, roles: dict[str, str]
) -> pd.DataFrame:
    tests = list(dict.fromkeys(ids.tolist()))
    points = [ids == test for test in tests]
    measures = [error_measures(mu[own], predicted[own]) for own in points]
    shares = [None if outside is None else float(np.mean(outside[own])) for own in points]
    table = pd.DataFrame(measures, columns=["points", "mae", "rmse", "bias", "max_error"])
    table.insert(0, "test_id", tests)
    # As objects, so that a test without a role or a known domain has None and not NaN, which JSON lacks.
    unlisted = TRAINING if roles else None  # as `DataSet.select` has it
    table.insert(1, "role", pd.Series([roles.get(test, unlisted) for test in tests], dtype=object))
    table["outside_domain"] = pd.Series(shares, dtype=object)
    return table.sort_values(["mae", "test_id"], ascending=[False, True], ignore_index=True)


def _share(value: float | None) -> str:
    return "not known" if value is None else f"{value:.1%}"
