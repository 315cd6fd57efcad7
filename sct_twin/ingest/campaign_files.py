"""`ingest`: from measurement files of a laboratory to a raw campaign folder with a quality table."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass

import pandas as pd

from friction_models.common import InputError, atomic_folder
from friction_models.common.folders import CAMPAIGN
from friction_models.common.processes.pool import Progress
from friction_models.common.wording import counted

from ..records.record import SctRecord, write_csv
from .channel_map import Map
from .measurement_files import Source
from .preview import remarks
from .raw_campaign import RawCampaign, write_tables
from .survey import Survey, survey


@dataclass
class IngestReport:
    """Result of `ingest`: the new campaign, the quality of its tests, and the files left out."""

    campaign: RawCampaign
    #: One row a test: sampling rate, gaps, clipping, zeros and drift, spikes, phases, friction, repeats.
    quality: pd.DataFrame
    #: `file` and `reason` of what could not be used.
    left_out: pd.DataFrame
    found: Survey

    def __str__(self) -> str:
        return "\n".join([self.headline(), *remarks(self.found)])

    def headline(self) -> str:
        """Return how many tests were written where, and how many were left out."""
        return (
            f"{counted(len(self.quality), 'test')} in {self.campaign.folder}, {len(self.left_out)} left out"
        )


def ingest(
    source: Source,
    channel_map: Map = None,
    out: str | os.PathLike[str] | None = None,
    tests: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
    show: Callable[[Survey], None] | None = None,
    test_id: str | None = None,
) -> IngestReport:
    """Read measurement files and write a raw campaign folder, atomically.

    Raises InputError: no files, a bad channel map or test table, no file that can be used, or `out` holds
    something else than a campaign.

    - `source`: a folder (its measurement files, or those in its `raw/`) or single files, one test each (two,
      where the map says how upsetting and sliding files end); the name of the file is the name of the test,
      or the part of it that `test_id` says.
    - `channel_map`: YAML file or dictionary, see `ChannelMap.load`; canonical names and a units row by
      default.
    - `tests`: test table with a column `test_id`; by default `tests.csv` beside the files.
    - `progress`: called with (done, total, test_id).
    - `show`: called with what was found, before the folder appears; an exception keeps it from appearing.
    - `test_id`: which part of a file's name is that of the test (``*_SCT{test_id}_raw``); by default what the
      map says, or all.
    """
    if out is None:
        raise InputError("ingest: out is missing; allowed: the folder to write")
    with atomic_folder(out, CAMPAIGN) as temporary:
        (temporary / "raw").mkdir()

        def take(record: SctRecord) -> None:
            write_csv(temporary / "raw" / f"{record.test_id}.csv", record.to_frame())

        found = survey(source, channel_map, tests, take, progress, test_id)
        if show is not None:
            show(found)
        if not found.tests:
            first = found.left_out[0].reason if found.left_out else "no files"
            raise InputError(f"none of {found.count} files can be used; the first: {first}")
        found.info["left_out"] = [entry._asdict() for entry in found.left_out]
        write_tables(temporary, found.test_table, found.info)
        quality = pd.DataFrame(found.rows)
        quality.to_csv(temporary / "quality.csv", index=False, lineterminator="\n")
    left_out = pd.DataFrame(found.left_out, columns=["file", "reason"])
    return IngestReport(RawCampaign.load(out), quality, left_out, found)
