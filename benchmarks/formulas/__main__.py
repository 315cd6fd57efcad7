"""``python -m benchmarks.formulas [--unseen] [--part K OF] [-o FILE]``: run all cases or some, print the tables."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

from ..common import machine
from .cases import cases
from .study import run_all, summary


def main() -> None:
    """Run, and print or write the section."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.formulas", description=__doc__)
    parser.add_argument(
        "--part", nargs=2, type=int, metavar=("K", "OF"), help="only each OF-th case from K on"
    )
    parser.add_argument("--unseen", action="store_true", help="only the cases that were left alone")
    parser.add_argument("--folder", type=Path, default=Path("build/benchmarks/formulas"))
    parser.add_argument("-o", "--out", type=Path, help="write the section here instead of printing it")
    given = parser.parse_args()
    chosen = [case for case in cases() if case.unseen or not given.unseen]
    if given.part:
        chosen = chosen[given.part[0] :: given.part[1]]
    found = summary(run_all(given.folder, chosen, lambda key: print(key, flush=True)))
    text = "\n".join(
        [f"## {found['title']}", "", found["text"], "", f"Measured on: {machine()}.", *found["lines"], ""]
    )
    if given.out:
        given.out.write_text(text, encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()
