"""`Calibrated`: what every friction model offers around its prediction interval."""

from __future__ import annotations

from typing import TYPE_CHECKING, Self, cast

import numpy as np
import numpy.typing as npt
import pandas as pd

from ..common import InputError
from ..loads import FloatArray, TriboLoads
from .intervals import LEVEL, PredictionInterval

if TYPE_CHECKING:
    from .base import FrictionModel, LoadsLike


class Calibrated:
    """Part of `FrictionModel`: calibration on tests left out, and how far a measurement may lie from mu.

    Attributes
    ----------
    interval_ : PredictionInterval
        After `calibrate`.
    """

    @property
    def interval(self) -> PredictionInterval | None:
        """The calibrated prediction interval, None without one."""
        return getattr(self, "interval_", None)

    @property
    def interval_level(self) -> float | None:
        """Level of the prediction interval, None without one."""
        return None if self.interval is None else self.interval.level

    def calibrate(
        self,
        loads: LoadsLike,
        mu: npt.ArrayLike,
        groups: npt.ArrayLike | None = None,
        level: float = LEVEL,
        seed: int = 0,
    ) -> Self:
        """Give a fitted model its prediction interval, from the data it was fitted to.

        Parameters
        ----------
        loads, mu, groups
            As in `fit`; the tests must be known, at least four.
        level : float
            Share of the points of new tests that the interval is to hold, 0.5 to 0.999.
        seed : int
            Of the folds.

        Raises
        ------
        InputError
            The model is not fitted, the tests are not known or too few, a fold cannot be fitted.
        """
        from .calibration import calibrate

        model = cast("FrictionModel", self)
        model.require_fitted()
        points, target, tests = model._checked(loads, mu, groups)
        self.interval_ = calibrate(model, points, target, tests, level, seed=seed)
        return self

    def left_out(
        self, loads: TriboLoads, mu: FloatArray, groups: npt.NDArray[np.str_], folds: int, seed: int
    ) -> tuple[FloatArray, str]:
        """Return mu of points predicted without their tests, shape (n,), NaN where there is none; and how, in words.

        The points are those the model was fitted to. A family that leaves tests out while it trains overrides this.
        """
        from .calibration import folds_of

        return folds_of(cast("FrictionModel", self), loads, mu, groups, folds, seed)

    def predict_interval(self, loads: LoadsLike, level: float | None = None) -> tuple[FloatArray, FloatArray]:
        """Return the lower and upper bound of mu of a new test at `loads`, each of shape (n,).

        Never negative; outside the trained domain the interval widens, but promises no coverage.

        Raises
        ------
        InputError
            The model has no interval, or a level outside 0.5 to 0.999.
        """
        from .base import as_loads

        model = cast("FrictionModel", self)
        points = as_loads(loads)
        mu = model.predict(points)
        if self.interval is None:
            raise InputError(f"the {model.name} model has no prediction interval; call calibrate first")
        margin = self.interval.margins(points.as_array(), model.domain, level)
        return np.maximum(mu - margin, 0.0), mu + margin

    def predict_interval_frame(
        self, data: pd.DataFrame, tests: pd.DataFrame | None = None, level: float | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Return the bounds of `predict_interval` for a table with the columns of the contract."""
        return self.predict_interval(TriboLoads.from_frame(data, tests), level)
