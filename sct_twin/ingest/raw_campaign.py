"""A folder of raw records: `raw/<test_id>.csv`, `tests.csv`, `campaign.json`."""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from friction_models.common import InputError, unknown_name, write_json
from friction_models.common.files import read_json
from friction_models.loads import dataset
from friction_models.loads.dataset import says_synthetic

from ..readers import read_csv
from ..records.cells import Cell
from ..records.record import SctRecord
from .channel_map import ChannelMap

FORMAT = "tribofmu raw SCT campaign"


@dataclass
class RawCampaign:
    """Raw records with their test table, on disk.

    Attributes
    ----------
    folder : Path
        Where the files are.
    tests : pandas.DataFrame
        One row a test: `test_id` and metadata.
    info : dict
        Content of `campaign.json`: ``synthetic``, ``moving_mass_kg``, specimen, plan.

    Examples
    --------
    A folder with one test, written and opened again:

    >>> import tempfile
    >>> import numpy as np
    >>> from sct_twin import RawCampaign, SctRecord
    >>> t = np.arange(100) / 100
    >>> record = SctRecord("sct001", t, F_n=90e3 + 100 * t, F_r=7e3 + 10 * t, s=20 * t)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     saved = record.save(Path(folder) / "raw" / "sct001.csv")
    ...     tests = pd.DataFrame({"test_id": ["sct001"], "T_tool": [200.0]})
    ...     write_tables(Path(folder), tests, {"moving_mass_kg": 25.0})
    ...     campaign = RawCampaign.load(folder)
    ...     again = campaign.record("sct001")
    >>> campaign.moving_mass, campaign.synthetic
    (25.0, False)
    >>> again.number("T_tool"), len(again)
    (200.0, 100)
    """

    folder: Path
    tests: pd.DataFrame
    info: dict[str, Any] = field(default_factory=dict)
    #: Keeps a temporary folder alive as long as the campaign that lives in it.
    _temporary: tempfile.TemporaryDirectory[str] | None = field(default=None, repr=False)

    @classmethod
    def load(cls, folder: str | os.PathLike[str]) -> RawCampaign:
        """Open a campaign folder.

        Raises
        ------
        InputError
            Not such a folder, or `tests.csv` or `campaign.json` are damaged.
        """
        path = Path(folder)
        if not path.is_dir():
            raise InputError(
                f"{path}: no such folder; allowed: a folder with raw/, tests.csv and campaign.json"
            )
        if not (path / "raw").is_dir() or not (path / "campaign.json").is_file():
            raise InputError(
                f"{path}: not a raw campaign; allowed: a folder with raw/, tests.csv and campaign.json "
                "(`ingest` writes one from measurement files)"
            )
        info = read_json(path / "campaign.json")
        tests = read_test_table(path / "tests.csv")
        for test_id in tests["test_id"]:
            if not (path / "raw" / f"{test_id}.csv").is_file():
                raise InputError(f"{path / 'tests.csv'}: test {test_id!r} has no file raw/{test_id}.csv")
        return cls(path, tests, info)

    @property
    def synthetic(self) -> bool:
        """Whether the records come from a virtual laboratory."""
        return bool(self.info.get("synthetic", False)) or says_synthetic(self.tests)

    @property
    def moving_mass(self) -> float:
        """Mass that is accelerated between force cell and contact [kg]."""
        return float(self.info.get("moving_mass_kg") or 0.0)

    def __len__(self) -> int:
        return len(self.tests)

    def raw_file(self, test_id: str) -> Path:
        """Return the file of a test."""
        return self.folder / "raw" / f"{test_id}.csv"

    def metadata(self, test_id: str) -> dict[str, Cell]:
        """Return the test's row of the test table.

        Raises
        ------
        InputError
            No such test.
        """
        rows = self.tests[self.tests["test_id"] == test_id]
        if rows.empty:
            raise unknown_name("test", test_id, self.tests["test_id"], str(self.folder / "tests.csv"))
        row = rows.iloc[0]
        return {str(k): (v.item() if hasattr(v, "item") else v) for k, v in row.items() if not pd.isna(v)}

    def record(self, test_id: str) -> SctRecord:
        """Read and check one record.

        Raises
        ------
        InputError
            No such test, or its file is bad.
        """
        metadata = self.metadata(test_id)
        return ChannelMap().record(read_csv(self.raw_file(test_id)), test_id, metadata)


def read_test_table(path: Path) -> pd.DataFrame:
    """Read a test table whose tests name files; see `friction_models.loads.dataset.read_tests`."""
    frame = dataset.read_tests(path)
    for test_id in frame["test_id"]:
        check_test_id(test_id, str(path))
    return frame


def check_test_id(test_id: str, where: str) -> str:
    """Return the name of a test, which also names its files, or refuse what cannot be a file name.

    Raises InputError: empty, hidden, or with characters that lead out of the folder.

    >>> check_test_id("sct001", "tests.csv")
    'sct001'
    >>> check_test_id("../sct001", "tests.csv")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: tests.csv: test_id '../sct001'; allowed: a name that can be a file name
    """
    if (
        not test_id
        or test_id.startswith(".")
        or any(c in '/\\:*?"<>|' or not c.isprintable() for c in test_id)
    ):
        raise InputError(f"{where}: test_id {test_id!r}; allowed: a name that can be a file name")
    return test_id


def write_tables(folder: Path, tests: pd.DataFrame, info: dict[str, object]) -> None:
    """Write `tests.csv` and `campaign.json` into a campaign folder that is being made."""
    tests.to_csv(folder / "tests.csv", index=False, lineterminator="\n")
    write_json(folder / "campaign.json", {"format": FORMAT, "version": 1, **info})
