"""`check`: looks at an FMU from outside, then runs it in a separate process."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from friction_models.common import given_path
from friction_models.common.processes.child_processes import python_command

from ..archive.content import read_archive, read_description
from .report import OUTCOMES, CheckReport, Finding

__all__ = ["CheckReport", "Finding", "check"]

#: Longest time that the FMU may take for all trials [s].
TIME_LIMIT = 600.0
#: Most memory that it may take [bytes].
MEMORY_LIMIT = 8 * 1024**3
#: Most output of the second process that is read [bytes], and findings that are kept.
_TAIL, _MAX_FINDINGS = 4000, 2000


def check(
    path: str | os.PathLike[str], time_limit: float = TIME_LIMIT, memory_limit: int = MEMORY_LIMIT
) -> CheckReport:
    """Check any FMU of FMI 2.0 or 3.0; friction FMUs are also compared with the ONNX model they carry.

    The archive is checked before anything is unpacked. Everything else happens in a second process with
    limits on time and memory, which an FMU that hangs, crashes or ends its process cannot pass:
    schema and semantics, what each binary is and needs, units of the contract's names, trial runs, equal
    results of repeated runs, the FMU state and the directional derivatives where they are claimed,
    refusal of NaN, mu against ONNX Runtime, model exchange, and recorded reference results.

    Parameters
    ----------
    time_limit : float
        Longest time that all trials may take [s].
    memory_limit : int
        Most memory that the second process may take [bytes], where the system can limit it; never
        more than three quarters of what the machine has.

    Raises
    ------
    InputError
        Not an FMU at all, or a hostile or damaged archive.

    Examples
    --------
    >>> check("no-such.fmu")
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: no-such.fmu: no such FMU
    """
    file = given_path(path, "an FMU")
    root = read_description(file)
    members = read_archive(file)
    report = CheckReport(file, _title(root))
    size = sum(m.file_size for m in members.values())
    report.add(
        True, "archive", f"{len(members)} files, {size / 1000:.0f} kB unpacked, no path leaves the folder"
    )
    with tempfile.TemporaryDirectory(prefix="tribofmu-check-", ignore_cleanup_errors=True) as folder:
        result = Path(folder) / "result.json"
        code, last = _second_process(file, result, folder, time_limit, memory_limit)
        findings, complete = _read(result)
    report.findings += findings
    group = findings[-1].group if findings else "second process"
    said = f" ({last})" if last else ""
    if code is None:
        report.add(False, group, f"not finished after {time_limit:g} s, ended")
    elif not complete:
        report.add(False, group, f"the second process ended early: {_cause(code)}{said}")
    return report


def _second_process(
    file: Path, result: Path, folder: str, limit: float, memory: int
) -> tuple[int | None, str]:
    """Run the trials; return the exit code, None after the time limit, and the last line of errors."""
    command = python_command("fmus.checks.trial", str(file.resolve()), str(result), str(memory))
    place = Path(folder) / "run"
    place.mkdir()
    # Output goes to a file: a child of the FMU that outlives it would keep a pipe open.
    with (Path(folder) / "output.txt").open("w+b") as output:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=output,
            cwd=place,
            start_new_session=True,
        )
        try:
            code: int | None = process.wait(limit)
        except subprocess.TimeoutExpired:
            code = None
        finally:
            _end(process)
        output.seek(max(0, output.seek(0, os.SEEK_END) - _TAIL))
        lines = output.read(_TAIL).decode("utf-8", "replace").strip().splitlines()
    return code, " ".join(lines[-1].split())[:200] if lines else ""


def _end(process: subprocess.Popen[bytes]) -> None:
    """End the process and whatever it started."""
    if hasattr(os, "killpg"):
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    elif process.poll() is None:
        process.kill()
    process.wait()


def _read(result: Path) -> tuple[list[Finding], bool]:
    """Return the findings of the second process and whether it came to its end."""
    if not result.is_file():
        return [], False
    findings: list[Finding] = []
    for line in result.read_text(encoding="utf-8", errors="replace").splitlines()[:_MAX_FINDINGS]:
        try:
            outcome, group, text = json.loads(line)
        except ValueError:  # also where the number of values is wrong
            continue
        if outcome == "end":
            return findings, True
        if outcome in OUTCOMES:
            findings.append(Finding(str(outcome), str(group), str(text)))
    return findings, False


def _cause(code: int) -> str:
    if code < 0:
        with contextlib.suppress(ValueError):
            return f"stopped by {signal.Signals(-code).name}"
    return f"exit code {code}"


def _title(root: Any) -> str:
    kinds = [
        words
        for tag, words in (("CoSimulation", "co-simulation"), ("ModelExchange", "model exchange"))
        if root.find(tag) is not None
    ]
    name = " ".join(str(root.get("modelName", "without a name")).split())[:80]
    tool = " ".join(str(root.get("generationTool", "")).split())[:80]
    made = f", made by {tool}" if tool else ""
    return f"{name}: FMI {root.get('fmiVersion')}, {' and '.join(kinds) or 'no known interface'}{made}"
