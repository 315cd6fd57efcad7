"""fmusim and OMSimulator: a command line, tables in and out."""

from __future__ import annotations

import csv
import os
from pathlib import Path

import numpy as np

from friction_models.loads import FloatArray

from .programs import PROGRAMS
from .running import Outcome, run
from .subjects import STEP, STEPS


def run_fmusim(
    fmu: Path,
    kind: str,
    loads: dict[str, FloatArray],
    output: list[str],
    folder: Path,
    *options: str,
) -> Outcome:
    """Run an FMU.

    Parameters
    ----------
    fmu : Path
    kind : {"cs", "me"}
    loads : dict of str to ndarray, shape (steps,) or (steps, n)
        Inputs at the beginning of each step; arrays of FMI 3.0 have several columns.
    output : list of str
        What is wanted.
    folder : Path
        Where it may write.
    *options : str
        Further words of the command line.

    Returns
    -------
    Outcome
        With a row at the start and after each step.
    """
    folder.mkdir(parents=True, exist_ok=True)
    steps = len(next(iter(loads.values())))
    rows = [["time", *loads]]
    for k in range(steps + 1):  # one row more than it needs: it looks at the next one, too
        values = (np.atleast_1d(column[min(k, steps - 1)]) for column in loads.values())
        rows.append([repr(STEP * k), *(" ".join(repr(float(v)) for v in cells) for cells in values)])
    _write(folder / "loads.csv", rows)
    wanted = [word for name in output for word in ("--output-variable", name)]
    command = [str(PROGRAMS["fmusim"].path), "--interface-type", kind, "--start-time", "0"]
    command += ["--stop-time", repr(STEP * steps), "--output-interval", repr(STEP), *options, *wanted]
    command += ["--input-file", str(folder / "loads.csv"), "--output-file", str(folder / "mu.csv"), str(fmu)]
    return _table(run(command, folder, _environment(folder), folder), folder / "mu.csv", output)


def run_omsimulator(file: Path, output: list[str], folder: Path, *options: str) -> Outcome:
    """Run an FMU or an SSP with the start values in it; rows as those of `run_fmusim`."""
    folder.mkdir(parents=True, exist_ok=True)
    result = folder / "results.csv"
    command = [str(PROGRAMS["OMSimulator"].path), "--startTime=0", f"--stopTime={STEP * STEPS!r}"]
    command += [f"--stepSize={STEP!r}", f"--intervals={STEPS}", f"--resultFile={result}"]
    command += [f"--tempDir={folder}", *options, str(file)]
    outcome = _table(run(command, folder, _environment(folder), folder), result, output)
    if outcome.result is None and outcome.seen.startswith("info"):  # the reason stands above its last words
        said = (folder / "output.txt").read_text(encoding="utf-8", errors="replace").splitlines()
        outcome.seen = next((line[:200] for line in said if line.startswith("error")), outcome.seen)
    if outcome.result is not None:  # it writes a row before and after each event, at the same time
        times = np.array(outcome.result["times"])
        last = [int(np.flatnonzero(np.abs(times - STEP * k) < 1e-9)[-1]) for k in range(STEPS + 1)]
        outcome.result["values"] = [outcome.result["values"][k] for k in last]
    return outcome


def _environment(folder: Path) -> dict[str, str]:
    """Nothing of Python reaches the programs."""
    return {"PATH": "/usr/bin:/bin", "HOME": str(folder), "TMPDIR": str(folder)} | {
        k: os.environ[k] for k in ("LD_LIBRARY_PATH",) if k in os.environ
    }


def _write(path: Path, rows: list[list[str]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows(rows)


def _table(outcome: Outcome, path: Path, output: list[str]) -> Outcome:
    """Read columns of a result by name (the last words of a name are enough)."""
    if outcome.result is None or not path.is_file():
        return Outcome(None, outcome.seen or "no results were written")
    with path.open(encoding="utf-8", newline="") as stream:
        heads, *rows = list(csv.reader(stream))
    places = [next((k for k, h in enumerate(heads) if h == n or h.endswith(f".{n}")), -1) for n in output]
    if -1 in places:
        return Outcome(
            None, f"the results lack {output[places.index(-1)]}; they hold {', '.join(heads[:4])} ..."
        )
    values = [[float(cell) for p in places for cell in row[p].split()] for row in rows]
    return Outcome({"times": [float(row[0]) for row in rows], "values": values})
