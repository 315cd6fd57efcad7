"""The ecos command line out of its wheel: a simulator without Python."""

from __future__ import annotations

import csv
import shutil
import sys
from importlib.util import find_spec
from pathlib import Path

from .running import Outcome, run
from .subjects import STEP, STEPS


def run_ecos(ssp: Path, columns: list[str], folder: Path, step: float = STEP, steps: int = STEPS) -> Outcome:
    """Run an SSP and read columns of the results, without the row at the start.

    Parameters
    ----------
    ssp : Path
        The archive.
    columns : list of str
        ``meter::scaled``.
    folder : Path
        Where it may write.
    step, steps : float, int
        Communication step [s], and how many.
    """
    found = find_spec("ecospy")
    assert found is not None and found.submodule_search_locations
    program = folder / "ecos"
    shutil.copyfile(Path(next(iter(found.submodule_search_locations))) / "binaries" / "ecos", program)
    program.chmod(0o755)
    # Nothing of Python reaches the program; tbb comes from the folder that its wheel fills.
    environment = {
        "PATH": "/usr/bin:/bin",
        "HOME": str(folder),
        "LD_LIBRARY_PATH": str(Path(sys.prefix, "lib")),
    }
    command = [str(program), "simulate", "--path", str(ssp), "--stepSize", repr(step), "--noParallel"]
    outcome = run([*command, "--stopTime", repr((steps + 0.5) * step)], folder, environment, folder)
    files = sorted(folder.glob("*.csv"))
    if outcome.result is None or not files:
        return Outcome(None, outcome.seen or "no results were written")
    with files[0].open(encoding="utf-8", newline="") as stream:
        rows = list(csv.reader(stream, skipinitialspace=True))
    heads = [head.partition("[REAL]")[0] for head in rows[0]]
    missing = [c for c in columns if c not in heads]
    if missing:
        return Outcome(None, f"the results lack {missing[0]}; they hold {', '.join(heads[:4])} ...")
    places = [heads.index(c) for c in columns]
    return Outcome({"values": [[float(row[p]) for p in places] for row in rows[2:]]})
