"""The command lines behind the pages of measurements: from raw files and tables to data sets."""

from __future__ import annotations

from collections.abc import Iterable

from .command import Command

#: What the maps of a set of files are called, which stand beside the files.
CHANNEL_MAP, POINT_MAP = "channels.yaml", "points.yaml"


def ingest(raw: str, name: str, dry_run: bool = False) -> Command:
    """Turn the records of a set of files into a campaign.

    Examples
    --------
    >>> ingest("raw/rig", "rig").line
    'tribofmu ingest raw/rig --map raw/rig/channels.yaml -o campaigns/rig'
    """
    words = ("ingest", raw, "--map", f"{raw}/{CHANNEL_MAP}")
    if dry_run:
        return Command(f"Look through {name}", (*words, "--dry-run"))
    return Command(f"Take in the records of {name}", (*words, "-o", f"campaigns/{name}"))


def points(files: Iterable[str], raw: str, name: str, dry_run: bool = False) -> Command:
    """Turn tables of points into a data set.

    Examples
    --------
    >>> points(["raw/oil/oil.csv"], "raw/oil", "oil").line
    'tribofmu points raw/oil/oil.csv --map raw/oil/points.yaml -o data/oil'
    """
    words = ("points", *files, "--map", f"{raw}/{POINT_MAP}")
    if dry_run:
        return Command(f"Look through {name}", (*words, "--dry-run"))
    return Command(f"Make the data set {name}", (*words, "-o", f"data/{name}"))


def twin(campaign: str, name: str) -> Command:
    """Run the digital twin of a campaign."""
    return Command(f"Digital twin of {name}", ("twin", campaign, "-o", f"data/{name}"))


def edit_tests(folder: str, changes: Iterable[tuple[str, str, str]]) -> Command:
    """Change the test table of a folder.

    Examples
    --------
    >>> edit_tests("data/oil", [("t 1", "role", "test")]).line
    "tribofmu tests data/oil --set 't 1:role=test'"
    """
    words = [word for test, column, value in changes for word in ("--set", f"{test}:{column}={value}")]
    return Command(f"Change the test table of {folder}", ("tests", folder, *words), quick=True)
