"""Damaged ONNX files are packed or refused with one sentence, in a process of its own with limits."""

from __future__ import annotations

import subprocess
import sys

import pytest


#: The first file and how many; the changes are decided by their numbers, so that a finding can be repeated.
@pytest.mark.parametrize(
    ("first", "count"),
    [(0, 45), *(pytest.param(k, 90, marks=pytest.mark.nightly) for k in (45, 10_000))],
)
def test_damaged_onnx_files(first: int, count: int) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tests.fmus.fuzz.onnx_files", str(first), str(count)],
        capture_output=True,
        text=True,
        timeout=900,
    )
    last = done.stderr.strip().splitlines()[-1] if done.stderr.strip() else ""
    assert done.returncode == 0, f"ended with {done.returncode} at {last!r}:\n{done.stdout[-6000:]}"
    assert f"{count} files" in done.stdout
    assert ": 0 packed" not in done.stdout  # some damage does not matter: the files do reach the readers
