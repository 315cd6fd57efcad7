"""``python -m benchmarks -o docs/benchmarks.md [--only NAME]``: measure, print, write markdown.

Finished parts are kept in ``build/benchmarks``; an interrupted measurement goes on from there, and
``--only`` measures one part afresh and takes the others as they are kept there, or as they stand on the page.
"""

from __future__ import annotations

import argparse
import json
import os
import re
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

from friction_models.common import write_json, write_text

from . import (
    attribution,
    coupling,
    discovery,
    fmu_cost,
    forming_speed,
    forming_sweep,
    formulas,
    kernels,
    literature,
    prior,
    sct_round_trip,
    studies,
    tests_time,
)
from .common import Section, machine

PARTS: dict[str, Callable[[Path], Section]] = {
    "kernels": kernels.measure,
    "fmu-cost": fmu_cost.measure,
    "coupling": coupling.measure,
    "twin-diagnosis": tests_time.measure,
    "sct-round-trip": sct_round_trip.measure,
    "discovery": discovery.measure,
    "literature": literature.measure,
    "confidence": prior.measure,
    "formulas": formulas.measure,
    "attribution": attribution.measure,
    "forming-speed": forming_speed.measure,
    "forming-sweep": forming_sweep.measure,
    "studies": studies.measure,
}
KEPT = Path("build/benchmarks")
HEAD = """# Benchmarks

Written by `make bench` from measurements; nothing here is typed by hand.
"""


def main() -> None:
    """Measure what is asked for and write the page."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("-o", "--out", type=Path, default=Path("docs/benchmarks.md"))
    parser.add_argument("--only", choices=PARTS, help="measure this part afresh, keep the others")
    parser.add_argument("--fresh", action="store_true", help="measure everything afresh")
    chosen = parser.parse_args()
    standing = parts_of(chosen.out)
    sections: dict[str, str] = {}
    for name, measure in PARTS.items():
        kept = KEPT / f"{name}.json"
        again = chosen.fresh or chosen.only == name
        if not again and kept.is_file():
            sections[name] = section(name, json.loads(kept.read_text(encoding="utf-8")))
            continue
        if not again and chosen.only:
            if name in standing:
                sections[name] = standing[name]
            continue
        print(f"measuring: {name}", flush=True)
        found: Section = {**measure(KEPT), "machine": machine()}
        write_json(kept, found)
        sections[name] = section(name, found)
        print(sections[name], flush=True)
    write_text(chosen.out, "\n".join([HEAD, *sections.values()]))


def section(name: str, found: Section) -> str:
    """Return the markdown of a part, under a mark by which it is found again."""
    head = [
        f"<!-- {name} -->",
        f"## {found['title']}",
        "",
        found["text"],
        "",
        f"Measured on: {found['machine']}.",
    ]
    return "\n".join([*head, *found["lines"], ""])


def parts_of(page: Path) -> dict[str, str]:
    """Return the parts of an earlier page by name, as they stand there."""
    text = page.read_text(encoding="utf-8") if page.is_file() else ""
    pieces = re.split(r"^<!-- ([\w-]+) -->$", text, flags=re.MULTILINE)
    return {
        name: f"<!-- {name} -->{body.rstrip()}\n"
        for name, body in zip(pieces[1::2], pieces[2::2])
        if name in PARTS
    }


if __name__ == "__main__":
    main()
