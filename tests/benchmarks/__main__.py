"""``python -m tests.benchmarks -o docs/benchmarks.md [--only NAME]``: measure, print, write markdown.

Finished parts are kept in ``build/benchmarks``; an interrupted measurement goes on from there, and
``--only`` measures one part afresh and takes the others as they are kept.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

from friction_models.loads import write_json, write_text

from . import coupling, discovery_rates, fmu_cost, kernels, tests_time
from .common import Section, machine

PARTS: dict[str, Callable[[Path], Section]] = {
    "kernels": kernels.measure,
    "fmu-cost": fmu_cost.measure,
    "coupling": coupling.measure,
    "twin-diagnosis": tests_time.measure,
    "discovery": discovery_rates.measure,
}
KEPT = Path("build/benchmarks")


def main() -> None:
    """Measure what is asked for and write the page."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks", description=__doc__)
    parser.add_argument("-o", "--out", type=Path, default=Path("docs/benchmarks.md"))
    parser.add_argument("--only", choices=PARTS, help="measure this part afresh, keep the others")
    parser.add_argument("--fresh", action="store_true", help="measure everything afresh")
    chosen = parser.parse_args()
    sections: list[Section] = []
    for name, measure in PARTS.items():
        kept = KEPT / f"{name}.json"
        again = chosen.fresh or chosen.only == name
        if not again and (kept.is_file() or chosen.only):
            if kept.is_file():
                sections.append(json.loads(kept.read_text(encoding="utf-8")))
            continue
        print(f"measuring: {name}", flush=True)
        found = {**measure(KEPT), "machine": machine()}
        write_json(kept, found)
        sections.append(found)
    page = [
        "# Benchmarks",
        "",
        "Written by `make bench` from measurements; nothing here is typed by hand.",
        "",
    ]
    for part in sections:
        page += [f"## {part['title']}", "", part["text"], "", f"Measured on: {part['machine']}."]
        page += [*part["lines"], ""]
    write_text(chosen.out, "\n".join(page))
    print("\n".join(page))


if __name__ == "__main__":
    main()
