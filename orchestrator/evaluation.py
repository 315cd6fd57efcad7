"""Errors of a friction model on a data set: overall, by role, test by test."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import pandas as pd

from friction_models.loads import LOAD_NAMES, DataSet, FloatArray
from friction_models.training.measures import error_measures


class Predicts(Protocol):
    """Whatever gives mu for a table of points: a model, an FMU."""

    def predict_frame(self, data: pd.DataFrame, tests: pd.DataFrame | None = None) -> FloatArray: ...


@dataclass(frozen=True)
class Evaluation:
    """Errors of one model.

    Attributes
    ----------
    roles : dict of str to dict
        Error measures of the roles in the data (``train``, ``test``) and of all points (``all``).
    tests : pandas.DataFrame
        One row a test, the worst first: ``test_id, role, points, mae, rmse, bias, outside``; `outside`
        is the share of points beyond the model's domain.
    mu : ndarray, shape (n,)
        Predicted friction in the order of the points.
    """

    roles: dict[str, dict[str, float]]
    tests: pd.DataFrame
    mu: FloatArray

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers."""
        return {"roles": self.roles, "tests": self.tests.to_dict(orient="records")}


def evaluate(model: Predicts, data: DataSet) -> Evaluation:
    """Compare a model with measurements; whole tests count as units.

    Raises
    ------
    InputError
        What the model refuses.
    """
    points = data.points
    predicted = model.predict_frame(points, data.tests)
    measured = points["mu"].to_numpy()
    test_id = points["test_id"].to_numpy().astype(str)
    outside = _outside(model, points)
    role = _roles(data, test_id)
    roles = {
        name: error_measures(measured[role == name], predicted[role == name], test_id[role == name])
        for name in sorted(set(role.tolist()), key=lambda r: r != "train")
    }
    if len(roles) > 1:
        roles["all"] = error_measures(measured, predicted, test_id)
    rows = []
    for name in dict.fromkeys(test_id.tolist()):
        part = test_id == name
        errors = error_measures(measured[part], predicted[part])
        rows.append(
            {
                "test_id": name,
                "role": str(role[part][0]),
                "points": int(part.sum()),
                "mae": errors["mae"],
                "rmse": errors["rmse"],
                "bias": errors["bias"],
                "outside": float(np.mean(outside[part])),
            }
        )
    table = pd.DataFrame(rows).sort_values("rmse", ascending=False, ignore_index=True)
    return Evaluation(roles, table, predicted)


def _roles(data: DataSet, test_id: np.ndarray) -> np.ndarray:
    if data.tests is None or "role" not in data.tests.columns:
        return np.full(len(test_id), "all", dtype=object)
    lookup = dict(zip(data.tests["test_id"].astype(str), data.tests["role"].astype(str)))
    return np.array([lookup.get(t, "unlisted") for t in test_id], dtype=object)


def _outside(model: Predicts, points: pd.DataFrame) -> np.ndarray:
    domain = getattr(model, "domain", None)
    if domain is None:
        return np.zeros(len(points), dtype=bool)
    return np.asarray(~domain.contains(points[list(LOAD_NAMES)].to_numpy()))
