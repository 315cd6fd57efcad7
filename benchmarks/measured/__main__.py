"""``python -m benchmarks.measured -o docs/measured-data.md``: diagnose the measured tables, grade, write the page."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

from friction_models.common import write_text

from ..common import machine
from . import DATA
from .page import page
from .run import expected, run_all


def main() -> None:
    """Run what is missing and write the page; without the measurements say so and write nothing."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.measured", description=__doc__)
    parser.add_argument("-o", "--out", type=Path, default=Path("docs/measured-data.md"))
    parser.add_argument(
        "--data", type=Path, default=DATA, help="folder of the measurements (beside the repository)"
    )
    parser.add_argument("--kept", type=Path, default=Path("build/benchmarks/measured"))
    parser.add_argument(
        "--only", nargs="+", choices=list(expected()), metavar="SET", help="only these tables"
    )
    chosen = parser.parse_args()
    if not (chosen.data / "real").is_dir():
        print("skipped: the measured data are not beside the repository (--data FOLDER)")
        return
    results = run_all(chosen.data, chosen.kept, lambda text: print(text, flush=True), chosen.only)
    write_text(chosen.out, page(results, expected(), machine()))


if __name__ == "__main__":
    main()
