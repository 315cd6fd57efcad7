"""`tribofmu twin` killed in the middle: the same command goes on and leaves what an undisturbed run leaves."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import netCDF4
import numpy as np
import pytest

Tribofmu = Callable[..., str]
COMMAND = "import sys; from orchestrator.cli.main import main; main(sys.argv[1:])"
#: Longest wait for the first finished tests [s]; a kernel may have to be compiled.
PATIENCE = 300.0


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from sct_twin.virtual_lab import Campaign

    out = tmp_path_factory.mktemp("killed") / "lab"
    Campaign(plan="tiny-6+3", seed=8).run(out=out, jobs=1)
    return out


def contents(folder: Path) -> dict[str, object]:
    """Return all files of a data set: text as it is, netCDF files as their arrays and attributes."""
    found: dict[str, object] = {}
    for file in sorted(p for p in folder.rglob("*") if p.is_file()):
        name = file.relative_to(folder).as_posix()
        if file.suffix == ".nc":
            with netCDF4.Dataset(file) as data:
                arrays = {n: np.asarray(v[:]).tobytes() for n, v in data.variables.items()}
                found[name] = (arrays, {n: str(data.getncattr(n)) for n in data.ncattrs()})
        else:
            found[name] = file.read_bytes()
    return found


@pytest.mark.nightly  # by day without the command line: tests/sct_twin/test_twin.py
def test_a_killed_twin_goes_on_where_it_was(campaign: Path, tribofmu: Tribofmu, tmp_path: Path) -> None:
    tribofmu("twin", campaign, "-o", tmp_path / "whole", "--jobs", 1)
    arguments = [
        sys.executable,
        "-c",
        COMMAND,
        "twin",
        str(campaign),
        "-o",
        str(tmp_path / "cut"),
        "--jobs",
        "1",
    ]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    killed = subprocess.Popen(arguments, env=environment, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + PATIENCE
    while len(list((tmp_path / "cut" / "twin").glob("sct*.nc"))) < 2:
        assert killed.poll() is None, killed.stderr.read() if killed.stderr else ""
        assert time.monotonic() < deadline
        time.sleep(0.01)
    killed.send_signal(signal.SIGKILL)
    assert killed.wait() == -signal.SIGKILL
    finished = {p: p.stat().st_mtime_ns for p in (tmp_path / "cut" / "twin").glob("sct*.nc")}
    assert 2 <= len(finished) < 9
    assert not (tmp_path / "cut" / "points.csv").exists()  # no data set that looks complete
    tribofmu("twin", campaign, "-o", tmp_path / "cut", "--jobs", 1)
    assert {p: p.stat().st_mtime_ns for p in finished} == finished  # taken as they were
    assert contents(tmp_path / "cut") == contents(tmp_path / "whole")
