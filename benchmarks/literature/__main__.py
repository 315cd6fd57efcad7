"""``python -m benchmarks.literature [--quick]``: run what is missing of the campaigns, print what came out.

Results are kept by the version of `friction_models`; an interrupted run goes on where it stopped.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from friction_models.common import write_json

from . import FOLDER, kept_file
from .collection import cases, quick
from .judge import run
from .table import load, report


def main() -> None:
    """Run the cases asked for, remember the choice for the page and print the tables."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.literature",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="about 40 of the cases")
    parser.add_argument("--some", type=int, help="only so many of the cases chosen, evenly spread")
    parser.add_argument("-o", "--out", type=Path, help=f"results, one JSON line a case; {FOLDER} by default")
    parser.add_argument("--kind", help="only cases of this kind")
    parser.add_argument("--points", type=int, default=120, help="points a test, 20 to 550")
    parser.add_argument(
        "--module", default="friction_models.discovery", help="module with diagnose and refine"
    )
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--timeout", type=float, default=120.0, help="seconds a case")
    parser.add_argument("--laws", action="store_true", help="print the table by law, too")
    chosen = parser.parse_args()
    if not chosen.out and (chosen.points, chosen.module) != (120, "friction_models.discovery"):
        parser.error("--points and --module need a file of their own: -o FILE")
    todo = quick(chosen.points) if chosen.quick else cases(chosen.points)
    todo = [case for case in todo if chosen.kind in (None, case.kind)]
    if chosen.some:
        todo = todo[:: max(len(todo) // chosen.some, 1)][: chosen.some]
    out = chosen.out or kept_file(FOLDER)
    out.parent.mkdir(parents=True, exist_ok=True)
    if not chosen.out:
        write_json(FOLDER / "chosen.json", {"cases": [case.id for case in todo]})
    run(todo, out, chosen.module, chosen.workers, chosen.timeout)
    wanted = {case.id for case in todo}
    print(report([line for line in load([out]) if line["id"] in wanted], laws=chosen.laws))


if __name__ == "__main__":
    main()
