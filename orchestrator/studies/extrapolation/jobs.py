"""The job of the study ``extrapolation`` that makes the reduced training data."""

from __future__ import annotations

from pathlib import Path

from friction_models.common import InputError
from friction_models.common.wording import listed
from friction_models.loads import DataSet

from ...jobs.job import Files, Inputs, Needs
from ..models import load_data

#: Loads whose upper half of the tested range is left out of the reduced training data.
REDUCED_BY = ("sigma_n", "T")
#: Fewest tests of a reduced training set.
FEWEST = 4


def reduce(inputs: Inputs, files: Files, needs: Needs, folder: Path) -> dict[str, object]:
    """Keep the training tests with low pressure and temperature: the lower half of the tested range of each.

    The tests held out stay all, so that errors beyond the reduced domain are seen.
    """
    data = load_data(files, needs)
    training = data.select("train").points
    middle = training.groupby("test_id", sort=True)[list(REDUCED_BY)].median()
    limit = 0.5 * (middle.min() + middle.max())
    kept = middle.index[(middle <= limit).all(axis=1)]
    if len(kept) < FEWEST:
        raise InputError(
            f"{len(kept)} training tests lie in the lower half of the tested {listed(REDUCED_BY)}; "
            f"allowed: at least {FEWEST} (the reduced training data need them)"
        )
    held_out = data.select("test").points["test_id"].unique()
    ids = {*kept, *held_out}
    points = data.points[data.points["test_id"].isin(ids)].reset_index(drop=True)
    assert data.tests is not None
    tests = data.tests[data.tests["test_id"].isin(ids)].reset_index(drop=True)
    DataSet(points, tests, dict(data.info)).save(folder / "dataset")
    return {
        "dataset": "dataset",
        "train": len(kept),
        "limits": {name: float(limit[name]) for name in REDUCED_BY},
        "synthetic": bool(data.synthetic),
    }
