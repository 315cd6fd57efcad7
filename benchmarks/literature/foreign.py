"""What is unusual about tables that come from elsewhere."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

STYLES = ("as_is", "no_tests", "no_psi", "shuffled", "gaps", "numbered", "single_test")


def mangle(
    style: str,
    data: pd.DataFrame,
    tests: pd.DataFrame | None,
    mu_true: NDArray[Any],
    heldout: pd.DataFrame,
    rng: np.random.Generator,
) -> tuple[pd.DataFrame, pd.DataFrame | None, NDArray[Any], pd.DataFrame]:
    """Make a table look foreign.

    Parameters
    ----------
    style : str
        One of `STYLES`: unchanged; without test table; without the column psi; rows in random order; some
        missing temperatures; whole numbers as test identifiers; one test only.
    data, tests, mu_true, heldout
        Campaign as made.
    rng : numpy.random.Generator
        Source of randomness.

    Returns
    -------
    tuple
        The same four, changed.

    Raises
    ------
    ValueError
        If `style` is unknown.
    """
    if style not in STYLES:
        raise ValueError(f"style {style!r} is unknown; use one of {STYLES}")
    if style in ("no_tests", "single_test"):
        tests = None
    if style == "single_test":
        keep = (data["test_id"] == data["test_id"].iloc[0]).to_numpy()
        data, mu_true = data[keep].reset_index(drop=True), mu_true[keep]
    if style == "no_psi":
        data, heldout = data.drop(columns="psi"), heldout.drop(columns="psi")
    if style == "shuffled":
        place = rng.permutation(len(data))
        data, mu_true = data.iloc[place].reset_index(drop=True), mu_true[place]
    if style == "gaps":
        data = data.copy()
        data.loc[rng.random(len(data)) < 0.01, "T [degC]"] = np.nan
    if style == "numbered" and tests is not None:
        number = {name: i + 1 for i, name in enumerate(tests["test_id"])}
        data = data.assign(test_id=data["test_id"].map(number))
        tests = tests.assign(test_id=tests["test_id"].map(number))
    return data, tests, mu_true, heldout
