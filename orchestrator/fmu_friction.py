"""A friction FMU with the interface that evaluation and comparison expect of a model."""

from __future__ import annotations

import pandas as pd

from fmus.reading import FmuModel
from friction_models.loads import FloatArray, TriboLoads


class FmuFriction(FmuModel):
    """The law inside a friction FMU: a fixed model that predicts for tables of points too."""

    @property
    def name(self) -> str:
        """Name of the file."""
        return self.path.stem

    def predict_frame(self, data: pd.DataFrame, tests: pd.DataFrame | None = None) -> FloatArray:
        """Return mu for a table with the columns of the contract."""
        return self.predict(TriboLoads.from_frame(data, tests))
