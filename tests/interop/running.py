"""Clients in processes of their own: some of them crash."""

from __future__ import annotations

import importlib.metadata
import json
import os
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from .children.common import Found, Job
from .programs import PROGRAMS

ROOT = Path(__file__).resolve().parents[2]
SECONDS = 120


@dataclass
class Outcome:
    """What a child process brought: a result, or what was seen instead."""

    result: Found | None
    seen: str = ""


def run_child(client: str, job: Job, folder: Path) -> Outcome:
    """Run a script of `tests.interop.children`."""
    folder.mkdir(parents=True, exist_ok=True)
    given, found = folder / "job.json", folder / "result.json"
    given.write_text(json.dumps({**job, "folder": str(folder)}), encoding="utf-8")
    found.unlink(missing_ok=True)
    command = [sys.executable, "-m", f"tests.interop.children.{client}", str(given), str(found)]
    # What a client leaves behind when it crashes stays in the folder.
    environment = {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1", "TMPDIR": str(folder)}
    outcome = run(command, folder, os.environ | environment, ROOT)
    if found.is_file():  # a client that crashes at its exit has done its work
        return Outcome(json.loads(found.read_text(encoding="utf-8")), outcome.seen)
    return Outcome(None, outcome.seen or "no result")


def run(command: list[str], folder: Path, environment: dict[str, str], cwd: Path) -> Outcome:
    """Run a command; `seen` tells how it failed, and is empty when it did not."""
    with (folder / "output.txt").open("wb") as output:
        try:
            code = subprocess.run(
                command, cwd=cwd, env=environment, stdout=output, stderr=subprocess.STDOUT, timeout=SECONDS
            ).returncode
        except subprocess.TimeoutExpired:
            return Outcome(None, f"no end after {SECONDS} s")
    if code == 0:
        return Outcome({}, "")
    if code < 0:
        return Outcome(None, f"the process died of {signal.Signals(-code).name}")
    said = (folder / "output.txt").read_text(encoding="utf-8", errors="replace").strip().splitlines()
    return Outcome(None, said[-1][:200] if said else f"exit code {code}")


def version(name: str) -> str | None:
    """Return the version of an installed distribution or of a program, None without it."""
    if name in PROGRAMS:
        return PROGRAMS[name].version
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def missing(name: str) -> str:
    """Say what is not here, and where it should have been."""
    return PROGRAMS[name].missing if name in PROGRAMS else f"{name} (extra [interop])"
