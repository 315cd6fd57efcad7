"""Rows with values that cannot be, and the limits that leave them out."""

from __future__ import annotations

import numpy as np
import pandas as pd

from orchestrator.app.raw.map_form import MapForm, beyond_limits
from sct_twin.readers import RawTable


def test_limits_are_those_of_the_unit_of_the_file() -> None:
    # 0 to 100 000 MPa; -1 Pa is none. Of 500 rows, the fifth and the last.
    pressure = np.full(500, 2e8)
    pressure[[4, 499]] = -1.0
    table = RawTable(pd.DataFrame({"p": pressure, "mu": 0.1}), {"p": "Pa"}, "file.csv")
    form = MapForm.of(table, False, {"columns": {"p": "sigma_n", "mu": "mu"}})
    said = "points: column 'sigma_n', row 4: value -1e-06 is outside the allowed range 0 to 100000 MPa"
    found = beyond_limits(form, table, said)
    assert found is not None
    assert (found.column, found.rows, found.low, found.high) == ("p", 2, 0.0, None)
    assert beyond_limits(form, table, "points: column 'mu' is missing") is None
    assert beyond_limits(form, table, said.replace("sigma_n", "T")) is None
