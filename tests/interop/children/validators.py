"""The two validators: fmpy's, and ``fmutool -check``."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tests.interop.children.common import done, job


def main() -> None:
    work = job()
    if work["validator"] == "fmpy":
        from fmpy.validation import validate_fmu

        done(validate_fmu(work["fmu"]))
        return
    command = [str(Path(sys.executable).with_name("fmutool")), "-input", work["fmu"], "-check"]
    said = subprocess.run(command, capture_output=True, text=True, timeout=100, check=True)
    text = said.stdout + said.stderr
    good = "seems to be compliant" in text and "No semantic error" in text
    done([] if good else [line for line in text.splitlines() if line][-3:])


if __name__ == "__main__":
    main()
