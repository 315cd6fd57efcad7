"""``python -m tests.benchmarks.discovery -o build/discovery --seeds 2``: run, print and write the tables."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

from friction_models.loads import write_text

from ..common import Section
from . import protocols, study


def main() -> None:
    """Run what is missing, print the tables and write them beside the results."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.discovery", description=__doc__)
    parser.add_argument("-o", "--out", type=Path, default=Path("build/discovery"))
    parser.add_argument("--seeds", type=int, default=12, help="campaigns of each case")
    parser.add_argument(
        "--protocols", type=int, default=0, help="campaigns of each effect for proposed protocols"
    )
    chosen = parser.parse_args()

    def tell(text: str) -> None:
        print(text, flush=True)

    parts: list[Section] = []
    if chosen.seeds:
        parts.append(study.summary(study.run_all(chosen.out, chosen.seeds, tell)))
    if chosen.protocols:
        parts.append(protocols.summary(protocols.run_all(chosen.out, chosen.protocols, tell)))
    page = "\n\n".join("\n".join([f"## {p['title']}", "", p["text"], *p["lines"]]) for p in parts) + "\n"
    print(page)
    write_text(chosen.out / "table.md", page)


if __name__ == "__main__":
    main()
