"""Functions that the tests of job graphs run in worker processes."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import numpy as np

from friction_models.common import InputError
from orchestrator.jobs.job import Files, Inputs, Needs


def numbers(inputs: Inputs, files: Files, needs: Needs, folder: Path) -> dict[str, object]:
    """Numbers that follow from a seed, files and the results of other jobs; leaves a mark for each call."""
    rng = np.random.default_rng(inputs["seed"])
    offset = sum(float(path.read_text()) for path in files.values())
    offset += sum(result.values["total"] for result in needs.values())
    drawn = rng.standard_normal(50) @ rng.standard_normal((50, 50))
    np.save(folder / "drawn.npy", drawn)
    if "log" in inputs:
        with open(inputs["log"], "a", encoding="utf-8") as log:
            log.write(f"{inputs['seed']}\n")
    time.sleep(inputs.get("pause", 0.0))
    return {"total": float(drawn.sum()) + offset, "timing": {"now": time.time()}}


def refused(inputs: Inputs, files: Files, needs: Needs, folder: Path) -> dict[str, float]:
    """Fail the way that `inputs` says."""
    if inputs["how"] == "input":
        raise InputError("speed = -1 mm/s; allowed: above 0")
    if inputs["how"] == "nan":
        return {"total": float("nan")}
    return {"total": 1 / inputs["zero"]}


def killed(inputs: Inputs, files: Files, needs: Needs, folder: Path) -> dict[str, float]:
    """Be killed like a process that takes too much memory, as often as `inputs` says."""
    marks = Path(inputs["marks"])
    calls = len(list(marks.iterdir()))
    if calls < inputs["times"]:
        (marks / str(calls)).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return {"total": 1.0}
