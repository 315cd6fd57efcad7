"""Damaged ONNX files are packed or refused with one sentence, in a process of its own with limits."""

from __future__ import annotations

import subprocess
import sys

import pytest

#: Files of one run; the changes are decided by their numbers, so that a finding can be repeated.
COUNT = 90


@pytest.mark.parametrize("seed", [0, pytest.param(10_000, marks=pytest.mark.nightly)])
def test_damaged_onnx_files(seed: int) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tests.fmus.fuzz.onnx_files", str(seed), str(COUNT)],
        capture_output=True,
        text=True,
        timeout=900,
    )
    last = done.stderr.strip().splitlines()[-1] if done.stderr.strip() else ""
    assert done.returncode == 0, f"ended with {done.returncode} at {last!r}:\n{done.stdout[-6000:]}"
    assert f"{COUNT} files" in done.stdout
    assert ": 0 packed" not in done.stdout  # some damage does not matter: the files do reach the readers
