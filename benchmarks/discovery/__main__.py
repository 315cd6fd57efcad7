"""``python -m benchmarks.discovery -o build/discovery --seeds 2``: run, print and write the tables."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

from friction_models.common import write_text

from . import Sizes, all_parts


def main() -> None:
    """Run what is missing, print the tables and write them beside the results."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.discovery", description=__doc__)
    parser.add_argument("-o", "--out", type=Path, default=Path("build/benchmarks/discovery"))
    parser.add_argument("--seeds", type=int, default=Sizes.seeds, help="campaigns of each case")
    parser.add_argument(
        "--chain", type=int, default=Sizes.chain, help="campaigns of each effect through raw records"
    )
    parser.add_argument(
        "--protocols",
        type=int,
        default=Sizes.protocols,
        help="campaigns of each effect for proposed protocols",
    )
    parser.add_argument(
        "--sequential",
        type=int,
        default=Sizes.sequential,
        help="campaigns of each effect and plan for tests one after the other",
    )
    chosen = parser.parse_args()
    sizes = Sizes(chosen.seeds, chosen.chain, chosen.protocols, chosen.sequential)
    sizes.keep(chosen.out)
    parts = all_parts(chosen.out, sizes, lambda text: print(text, flush=True))
    page = "\n\n".join("\n".join([f"## {p['title']}", "", p["text"], *p["lines"]]) for p in parts) + "\n"
    print(page)
    write_text(chosen.out / "table.md", page)


if __name__ == "__main__":
    main()
