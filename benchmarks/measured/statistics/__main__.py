"""``python -m benchmarks.measured.statistics [--data FOLDER] [SET ...]``: print one JSON block a set."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from .. import DATA
from . import SETS


def short(value: object) -> object:
    """Return numbers rounded to four digits, through all levels."""
    if isinstance(value, dict):
        return {key: short(item) for key, item in value.items()}
    if isinstance(value, list):
        return [short(item) for item in value]
    return float(f"{value:.4g}") if isinstance(value, float) else value


def main() -> None:
    """Print the numbers of the sets named (all without a name)."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.measured.statistics", description=__doc__)
    parser.add_argument("sets", nargs="*", metavar="SET", help=f"of {', '.join(SETS)}")
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the measurements")
    chosen = parser.parse_args()
    for name in chosen.sets or list(SETS):
        print(json.dumps({name: short(SETS[name](chosen.data))}, indent=1))


if __name__ == "__main__":
    main()
