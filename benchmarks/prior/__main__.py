"""``python -m benchmarks.prior -o build/prior --campaigns 400``: fit the confidence of the diagnosis, and print how reliable it is."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from pprint import pformat

os.environ.setdefault("OMP_NUM_THREADS", "1")

from .others import rows_of_others
from .study import answers, fitted, measure


def main() -> None:
    """Run what is missing; print the weights for `friction_models.discovery.judge.confidence`, and the table of the campaigns that judge."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.prior", description=__doc__)
    parser.add_argument("-o", "--out", type=Path, default=Path("build/benchmarks"))
    parser.add_argument("--campaigns", type=int, default=400, help="campaigns that the weights are fitted to")
    parser.add_argument("--first", type=int, default=0, help="first of them")
    parser.add_argument("--judge", type=int, default=0, help="campaigns that judge the weights as they stand")
    chosen = parser.parse_args()
    if chosen.campaigns:
        rows = answers(chosen.out, range(chosen.first, chosen.first + chosen.campaigns))
        print(pformat(fitted(rows, rows_of_others(chosen.out, apart=False)), sort_dicts=False))
    if chosen.judge:
        part = measure(chosen.out, chosen.judge)
        print("\n".join([part["text"], *part["lines"]]))


if __name__ == "__main__":
    main()
