"""`python -m benchmarks.blind`: runs the blind benchmark and prints its numbers."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from benchmarks.blind.cases import all_cases
from benchmarks.blind.judge import judge
from benchmarks.blind.record import Record
from benchmarks.blind.runner import file_of, run
from benchmarks.blind.score import by_recipe, failed, failure, numbers


def main() -> None:
    """Run what is missing, then score all that has a record."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.blind", description=__doc__)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--only", default="", help="part of the names of cases")
    parser.add_argument("--kind", choices=["null", "single", "pair", "triple", "outside"], action="append")
    parser.add_argument("--half", choices=["a", "b"])
    parser.add_argument(
        "--seed", type=int, action="append", help="other draws of the same cases; may be repeated (default 0)"
    )
    parser.add_argument("--limit", type=float, default=240.0, help="seconds a case")
    parser.add_argument("--score", action="store_true", help="only score what has been run")
    parser.add_argument("-o", "--out", type=Path, default=Path("build/blind"))
    given = parser.parse_args()
    cases = [
        c
        for seed in given.seed or [0]
        for c in all_cases(seed)
        if given.only in c.name and (not given.kind or c.kind in given.kind) and given.half in (None, c.half)
    ]
    if not given.score:
        run(cases, given.out, given.workers, given.limit)
    judged = []
    for c in cases:
        if file_of(c, given.out).exists():
            kept: Record = json.loads(file_of(c, given.out).read_text())
            judged.append(judge(c, kept["answer"], kept["truth"]))
    halves = {half: [j for j in judged if j.case.half == half] for half in "ab"}
    table = {"a": numbers(halves["a"]), "b": numbers(halves["b"]), "both": numbers(judged)}
    rows = list(dict.fromkeys(row for column in table.values() for row in column))
    print(f"\n{'':66s}{'a':>28s}{'b':>28s}{'both':>28s}")
    for row in rows:
        print(f"{row:66s}" + "".join(f"{column.get(row, ''):>28}" for column in table.values()))
    print("\nFalse alarms of both halves where there are any:", *by_recipe(judged), sep="\n  ")
    print("\nFailures of half a:")
    for j in halves["a"]:
        if failed(j):
            print(" ", failure(j))
    given.out.mkdir(parents=True, exist_ok=True)
    (given.out / "numbers.json").write_text(json.dumps(table, indent=1))


if __name__ == "__main__":
    main()
