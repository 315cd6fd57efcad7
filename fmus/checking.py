"""`check`: an FMU looked at from outside first, then run in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from friction_models.loads import LOADS, MU

from .archive import read_archive, read_description

#: Longest time that the FMU may take for the trial runs [s].
TIME_LIMIT = 600.0


@dataclass
class CheckReport:
    """Result of `check`.

    Attributes
    ----------
    path : Path
    findings : list of (str, str)
        Outcome ``passed``, ``failed`` or ``skipped`` and what was looked at.
    """

    path: Path
    findings: list[tuple[str, str]] = field(default_factory=list)

    @property
    def ok(self) -> bool:
        """Whether nothing failed."""
        return all(outcome != "failed" for outcome, _ in self.findings)

    @property
    def messages(self) -> list[str]:
        """One line a finding."""
        return [f"{outcome}: {text}" for outcome, text in self.findings]

    def add(self, good: bool, text: str) -> None:
        """Note a finding."""
        self.findings.append(("passed" if good else "failed", text))

    def __str__(self) -> str:
        head = f"{self.path}: {'ok' if self.ok else 'NOT ok'}"
        return "\n".join([head, *(f"  {m}" for m in self.messages)])


def check(path: str | os.PathLike[str]) -> CheckReport:
    """Check any FMI 2.0 FMU; friction FMUs are also compared with the ONNX model they carry.

    The archive is checked before anything is unpacked; the binary is loaded by a second process
    only. Looked at: schema and semantics (fmpy), platforms, units of the contract's names, a trial
    run in two instances, equal results of repeated runs, the FMU state where it is claimed, refusal of
    NaN, and mu against ONNX Runtime.

    Raises
    ------
    InputError
        Not an FMU at all, or a hostile or damaged archive.
    """
    report = CheckReport(Path(path))
    root = read_description(path)
    version = root.get("fmiVersion", "")
    _schema(report)
    _platforms(report, version)
    if version != "2.0":
        report.findings.append(("skipped", f"trial run: FMI version {version!r}, only '2.0' is run"))
        return report
    _units(report, root)
    with tempfile.TemporaryDirectory(prefix="tribofmu-check-") as folder:
        result = Path(folder) / "result.json"
        command = [sys.executable, "-m", "fmus.trial", str(Path(path).resolve()), str(result)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=TIME_LIMIT, check=False)
        except subprocess.TimeoutExpired:
            report.add(False, f"trial run in a second process: not finished after {TIME_LIMIT:g} s")
            return report
        findings: list[list[Any]] = []
        if result.is_file():
            findings = [json.loads(line) for line in result.read_text(encoding="utf-8").splitlines()]
        report.findings += [(str(outcome), str(text)) for outcome, text in findings]
        if done.returncode:
            last = (done.stderr.strip().splitlines() or ["no message"])[-1]
            report.add(False, f"trial run: the process ended with code {done.returncode} ({last[:200]})")
    return report


def _schema(report: CheckReport) -> None:
    from fmpy.validation import validate_fmu

    problems = validate_fmu(str(report.path))
    report.add(not problems, "model description: schema and semantics (fmpy)")
    for problem in problems:
        report.add(False, " ".join(str(problem).split()))


def _platforms(report: CheckReport, version: str) -> None:
    from fmpy import platform, platform_tuple, supported_platforms

    found = supported_platforms(str(report.path))
    here = platform if version == "2.0" else platform_tuple
    folders = {
        n.split("/")[1] for n in read_archive(report.path) if n.startswith("binaries/") and n.count("/") > 1
    }
    report.add(
        here in folders,
        f"platforms: {', '.join(sorted({*found, *folders})) or 'none'} (this machine: {here})",
    )


def _units(report: CheckReport, root: Any) -> None:
    expected = {q.name: q.unit for q in (*LOADS, MU)}
    seen = set()
    for variable in root.iter("ScalarVariable"):
        base = str(variable.get("name", "")).partition("[")[0]
        real = variable.find("Real")
        if base not in expected or real is None:
            continue
        seen.add(base)
        unit = real.get("unit", "")
        if unit and unit != expected[base]:
            report.add(False, f"unit of {variable.get('name')!r} is {unit!r}, allowed: {expected[base]!r}")
            return
    if seen:
        report.add(True, f"units of {', '.join(sorted(seen))} are those of the loads contract")
