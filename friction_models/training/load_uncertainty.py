"""What uncertain loads do to a friction model: the standard uncertainty of mu that comes from those of the loads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt
import pandas as pd

from ..loads import QUANTITIES, DataSet, FloatArray, TriboLoads


class Predictor(Protocol):
    """Anything that predicts mu for a table of points."""

    def predict_frame(self, data: pd.DataFrame, tests: pd.DataFrame | None = None) -> npt.ArrayLike: ...


@dataclass(frozen=True)
class LoadUncertainty:
    """Standard uncertainty of a model's mu through the loads."""

    #: Of every point, loads added as squares; shape (n,).
    points: FloatArray
    #: Of the mean of every test, by `test_id`. The errors of a load are common to the points of a test: they do not average out.
    tests: pd.Series[float]
    #: Root mean square over the points, of each uncertain load by itself.
    by_load: Mapping[str, float]

    @property
    def rms(self) -> float:
        """Root mean square over the points: what uncertain loads alone would make of the error of a true model."""
        return self.rms_of(np.full(len(self.points), True))

    def rms_of(self, some: npt.NDArray[np.bool_]) -> float:
        """Return the root mean square over some of the points, shape (n,)."""
        return float(np.sqrt(np.mean(self.points[some] ** 2)))


def load_uncertainty(
    model: Predictor, data: pd.DataFrame | DataSet, tests: pd.DataFrame | None = None
) -> LoadUncertainty | None:
    """Return the uncertainty of mu that the stated uncertainties of the loads give a model, to first order.

    Each load is raised by its uncertainty at all points of all tests, one load after the other; the change of mu is what an
    error of that size does. Loads count as independent of each other. None where the data state no uncertainty.

    The points have one or more of the columns `u_sigma_n` [MPa], `u_psi` [1], `u_T` [K], as the twin writes them; without
    `test_id` they count as one test. `tests` is for models that read metadata.

    Raises InputError: an uncertainty that is negative or not finite.

    Examples
    --------
    >>> class Falling:
    ...     def predict_frame(self, data, tests=None):
    ...         return 0.1 - 1e-5 * data["sigma_n"].to_numpy()
    >>> points = pd.DataFrame({"test_id": ["a", "b"], "sigma_n": [1000.0, 2000.0], "u_sigma_n": [10.0, 40.0]})
    >>> load_uncertainty(Falling(), points).tests.round(6).to_dict()
    {'a': 0.0001, 'b': 0.0004}
    """
    if isinstance(data, DataSet):
        tests = data.tests if tests is None else tests
        data = data.points
    stated = {} if data.empty else TriboLoads.from_frame(data).stated_uncertainty()
    if not stated:
        return None
    ids = data["test_id"].astype(str) if "test_id" in data.columns else pd.Series("all", index=data.index)
    usual = np.asarray(model.predict_frame(data, tests), dtype=np.float64)
    points, means, by_load = np.zeros(len(data)), pd.Series(0.0, index=ids.unique()), {}
    for load, u in stated.items():
        raised = np.minimum(data[load].to_numpy(dtype=np.float64) + u, QUANTITIES[load].upper)
        change = np.asarray(model.predict_frame(data.assign(**{load: raised}), tests)) - usual
        points += change**2
        means += pd.Series(change, index=ids.to_numpy()).groupby(level=0).mean().reindex(means.index) ** 2
        by_load[load] = float(np.sqrt(np.mean(change**2)))
    return LoadUncertainty(np.sqrt(points), means.pow(0.5).rename_axis("test_id"), by_load)
