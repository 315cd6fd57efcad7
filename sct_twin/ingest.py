"""Measurement files of a laboratory -> canonical raw campaign folder, with a quality table."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from friction_models.loads import InputError, atomic_folder

from .channel_map import ChannelMap
from .quality import quality_row, repeats, warnings
from .raw_campaign import RawCampaign, check_target, check_test_id, read_json, read_tests, write_tables
from .readers import SUFFIXES, read_file
from .record import write_csv

#: Files of a campaign folder that hold no test, and companions of measurement files.
_OTHER = {"tests.csv", "quality.csv", "points.csv", "channels.yaml", "channels.yml"}
_COMPANIONS = {".yaml", ".yml", ".json", ".md", ".pdf", ".png", ".jpg", ".npz", ".tdms_index"}


@dataclass
class IngestReport:
    """What was taken over, how good it is, and what was left out.

    Attributes
    ----------
    campaign : RawCampaign
        The new folder.
    quality : pandas.DataFrame
        One row a test: sampling rate, gaps, clipping, zeros and drift, spikes, phases, repeats.
    left_out : pandas.DataFrame
        `file` and `reason` of what could not be used.
    """

    campaign: RawCampaign
    quality: pd.DataFrame
    left_out: pd.DataFrame

    def __str__(self) -> str:
        text = f"{len(self.quality)} tests in {self.campaign.folder}, {len(self.left_out)} files left out"
        for row in self.quality.to_dict("records"):
            named = {str(name): None if pd.isna(value) else value for name, value in row.items()}
            text += "".join(f"\n  {row['test_id']}: {said}" for said in warnings(named))
        return text + "".join(f"\n  left out: {reason}" for reason in self.left_out["reason"])


def ingest(
    source: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    channel_map: str | os.PathLike[str] | Mapping[str, Any] | None = None,
    out: str | os.PathLike[str] | None = None,
    tests: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> IngestReport:
    """Read measurement files and write a raw campaign folder, atomically.

    Parameters
    ----------
    source : path-like or iterable of path-like
        A folder (its measurement files, or those in its `raw/`) or single files, one test each; the
        name of the file is the name of the test.
    channel_map : path-like or mapping, optional
        YAML file or dictionary, see `ChannelMap.load`; canonical names and a units row by default.
    out : path-like
        Folder to write.
    tests : path-like, optional
        Test table with a column `test_id`; by default `tests.csv` beside the files.
    progress : callable, optional
        Called with (done, total, test_id).

    Returns
    -------
    IngestReport

    Raises
    ------
    InputError
        No files, a bad channel map or test table, no file that can be used, or `out` holds something
        else than a campaign.
    """
    if out is None:
        raise InputError("ingest: out is missing; allowed: the folder to write")
    check_target(Path(out))
    mapping = ChannelMap.load(channel_map)
    files, home = measurement_files(source)
    passed_over = _passed_over(source)
    table = None
    if tests is not None:
        table = read_tests(Path(tests))
    elif home is not None and (home / "tests.csv").is_file():
        table = read_tests(home / "tests.csv")
    info: dict[str, Any] = {"synthetic": False}
    if home is not None and (home / "campaign.json").is_file():
        info = read_json(home / "campaign.json")
    if mapping.moving_mass is not None:
        info["moving_mass_kg"] = mapping.moving_mass
    mass = float(info.get("moving_mass_kg") or 0.0)
    rows: list[dict[str, Any]] = []
    quality: list[dict[str, Any]] = []
    left_out: list[dict[str, str]] = []
    with atomic_folder(out) as temporary:
        (temporary / "raw").mkdir()
        for number, file in enumerate(files):
            test_id = file.stem
            try:
                check_test_id(test_id, str(file))
                if test_id in {row["test_id"] for row in rows}:
                    raise InputError(f"{file}: a second file of test {test_id!r}; allowed: one file a test")
                record = mapping.record(read_file(file), test_id, _metadata(table, test_id, mapping.metadata))
                quality.append(quality_row(record, mass))
            except InputError as error:
                left_out.append({"file": str(file), "reason": str(error)})
                continue
            except MemoryError:
                left_out.append({"file": str(file), "reason": f"{file}: too large for the memory"})
                continue
            finally:
                if progress is not None:
                    progress(number + 1, len(files), test_id)
            write_csv(temporary / "raw" / f"{test_id}.csv", record)
            rows.append({**record.metadata, "test_id": test_id})
        if not rows:
            raise InputError(f"none of {len(files)} files can be used; the first: {left_out[0]['reason']}")
        if table is not None:
            gone = set(table["test_id"]) - {file.stem for file in files}
            left_out += [
                {"file": "", "reason": f"test {t!r} of the test table has no file"} for t in sorted(gone)
            ]
        front = ["test_id"]
        frame = pd.DataFrame(rows)
        frame = frame[front + [c for c in frame.columns if c not in front]]
        for row, count in zip(quality, repeats(frame)):
            row["repeats"] = count
        left_out += passed_over
        info["left_out"] = left_out
        write_tables(temporary, frame, info)
        pd.DataFrame(quality).to_csv(temporary / "quality.csv", index=False, lineterminator="\n")
    return IngestReport(
        RawCampaign.load(out), pd.DataFrame(quality), pd.DataFrame(left_out, columns=["file", "reason"])
    )


def _metadata(table: pd.DataFrame | None, test_id: str, common: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is known about a test: its row of the test table over what all tests share."""
    metadata = dict(common)
    if table is not None:
        hits = table[table["test_id"] == test_id]
        if not hits.empty:
            metadata |= {str(k): v for k, v in hits.iloc[0].dropna().items()}
    return metadata


def _listing(folder: Path) -> list[Path]:
    return sorted(
        file
        for file in folder.iterdir()
        if file.is_file() and file.name not in _OTHER and not file.name.startswith((".", "~$"))
    )


def _passed_over(source: str | os.PathLike[str] | Iterable[str | os.PathLike[str]]) -> list[dict[str, str]]:
    """Return the files of a folder that no reader reads, so that none is lost without a word."""
    if not isinstance(source, str | os.PathLike) or not Path(source).is_dir():
        return []
    folder = Path(source) / "raw" if (Path(source) / "raw").is_dir() else Path(source)
    allowed = ", ".join(sorted(SUFFIXES))
    return [
        {"file": str(file), "reason": f"{file}: suffix {file.suffix!r} has no reader; allowed: {allowed}"}
        for file in _listing(folder)
        if file.suffix.lower() not in SUFFIXES and file.suffix.lower() not in _COMPANIONS
    ]


def measurement_files(
    source: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
) -> tuple[list[Path], Path | None]:
    """Return the measurement files and the folder that may hold a test table.

    Raises
    ------
    InputError
        No such file or folder, or no measurement files in it.
    """
    if isinstance(source, str | os.PathLike):
        path = Path(source)
        if path.is_file():
            return [path], path.parent
        if not path.is_dir():
            raise InputError(
                f"{path}: no such file or folder; allowed: measurement files or a folder of them"
            )
        folder = path / "raw" if (path / "raw").is_dir() else path
        files = [file for file in _listing(folder) if file.suffix.lower() in SUFFIXES]
        if not files:
            raise InputError(
                f"{folder}: no measurement files; allowed suffixes: {', '.join(sorted(SUFFIXES))}"
            )
        return files, path
    files = [Path(item) for item in source]
    if not files:
        raise InputError("ingest: the list of files is empty; allowed: at least one measurement file")
    for file in files:
        if not file.exists():
            raise InputError(f"{file}: no such file")
    homes = {f.parent.parent if f.parent.name == "raw" else f.parent for f in files}
    return files, homes.pop() if len(homes) == 1 else None
