"""Result of a campaign: data sets of all points and of test averages, and their files."""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from friction_models.common import atomic_path, grown
from friction_models.common.cached_results import path_digest
from friction_models.common.folders import TWIN
from friction_models.common.replaced_outputs import moved_aside
from friction_models.loads import DataSet

from . import error_study

#: Folder of the average-based data set inside that of the time series.
AVERAGES = "averages"
#: What the two data sets are called in `dataset.json`.
KIND = "sliding compression tests, time series from the SCT twin"
KIND_AVERAGES = "sliding compression tests, one average point a test from the SCT twin"


@dataclass
class TwinResult:
    """A campaign after the twin.

    Attributes
    ----------
    points : pandas.DataFrame
        Columns of the contract (`test_id, t, v_rel, T, sigma_n, sd, psi, mu`) and
        `sct_twin.twin.test_result.EXTRA_UNITS`; `t` counts from the start of sliding.
    tests : pandas.DataFrame
        The campaign's test table with a summary of each test.
    info : dict
        Provenance: ``synthetic``, assumptions, settings, versions, errors where they were checked.
    left_out : pandas.DataFrame
        `test_id` and `reason` of tests that could not be evaluated.
    errors : pandas.DataFrame
        What `sct_twin.twin.error_study.check` found; empty without.

    Examples
    --------
    Two tests; mu of a test as a whole is its mean force over its mean normal force:

    >>> points = pd.DataFrame({"test_id": ["a", "a", "b"], "sd": [0.0, 1.0, 0.0], "mu": [0.05, 0.1, 0.2]})
    >>> points = points.assign(F_r=[50.0, 300.0, 200.0], F_n=[1000.0, 3000.0, 1000.0])
    >>> tests = pd.DataFrame({"test_id": ["a", "b"], "role": ["train", "test"]})
    >>> result = TwinResult(points, tests, {"synthetic": True}, left_out=pd.DataFrame())
    >>> result.averages().points["mu"].tolist()
    [0.0875, 0.2]
    >>> training, held_out = result.frames()
    >>> len(training), len(held_out)
    (2, 1)
    """

    points: pd.DataFrame
    tests: pd.DataFrame
    info: dict[str, object]
    left_out: pd.DataFrame
    errors: pd.DataFrame = field(default_factory=pd.DataFrame)
    #: What of the records speaks against the loads that come of them: `test_id` and `remark`.
    doubtful: list[dict[str, str]] = field(default_factory=list)
    #: Where `save` put errors that were found of other points.
    put_aside: Path | None = field(default=None, init=False)

    def dataset(self) -> DataSet:
        """Return points and tests as a data set."""
        return DataSet(self.points, self.tests, self.info)

    def frames(self) -> tuple[pd.DataFrame, pd.DataFrame]:
        """Return the points of the training and of the held-out tests (column `role`)."""
        return self.dataset().frames()

    def averages(self) -> DataSet:
        """Return the average-based data set, the state of the art that time series are compared with.

        One point a test: means over the distance slid, of loads and friction alike.
        """
        columns = [c for c in self.points.columns if c != "test_id"]
        means = self.points.groupby("test_id", sort=False)[columns].mean().reset_index()
        if {"mu", "F_r", "F_n"} <= set(columns):
            # Friction of a test as a whole: mean force over mean force.
            means["mu"] = (means["F_r"] / means["F_n"]).clip(lower=0.0)
        return DataSet(means, self.tests, {**self.info, "kind": KIND_AVERAGES})

    @property
    def remarks(self) -> list[dict[str, str]]:
        """What of the test table does not fit a test, and is not used, and what is doubtful of records: `test_id` and `remark`."""
        return [*remarks_in(self.tests, "contact_diameter_remark"), *self.doubtful]

    def error_table(self) -> str:
        """Return what was found about the twin's errors as text."""
        return error_study.table(self.errors)

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Write both data sets, each file at once; other files in the folder stay.

        The time series go into the folder itself, the averages into `averages/` in it; tests that were
        left out into `left_out.csv`, errors into `errors.csv`, where there are any. Errors that were found before stay
        with the points that they are of; where these change they become `errors.csv.1`, and `put_aside` says so.
        """
        place = grown(folder, TWIN)
        before = path_digest(place / "points.csv") if (place / "points.csv").is_file() else ""
        path = save_dataset(self.dataset(), place)
        save_dataset(self.averages(), path / AVERAGES)
        changed = path_digest(path / "points.csv") != before
        self.put_aside = None
        for name, table in (("left_out.csv", self.left_out), ("errors.csv", self.errors)):
            if not table.empty:
                with atomic_path(path / name) as temporary:
                    table.to_csv(temporary, index=False, lineterminator="\n")
            elif name == "left_out.csv":
                (path / name).unlink(missing_ok=True)
            elif changed and (path / name).is_file():
                self.put_aside = moved_aside(path / name)
        return path


def remarks_in(table: pd.DataFrame, column: str) -> list[dict[str, str]]:
    """Return the texts in a column of a table with a row a test: `test_id` and `remark`."""
    if column not in table:
        return []
    rows = zip(table["test_id"], table[column])
    return [{"test_id": str(t), "remark": r} for t, r in rows if isinstance(r, str) and r]


def save_dataset(dataset: DataSet, folder: Path) -> Path:
    """Write the files of a data set into a folder that may hold others; each is replaced at once."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".dataset.", dir=folder) as temporary:
        dataset.write_into(Path(temporary))
        for name in ("points.csv", "tests.csv", "dataset.json"):
            if (Path(temporary) / name).is_file():
                (Path(temporary) / name).replace(folder / name)
    return folder
