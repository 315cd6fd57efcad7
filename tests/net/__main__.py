"""Record what the fixed set of commands writes, or compare two records.

``python -m tests.net record -o old --tree PATH``, the same with the other tree, then ``python -m tests.net compare old new``.
A command whose record is there already is not run again.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

from .commands import HIDDEN, SYSTEM, Command, commands
from .compare import differences

_RUN = "from orchestrator.cli import main; main()"


def record(out: Path, tree: Path, parts: list[str]) -> int:
    """Run the commands of `tree` in `out`; return how many ended with another code than 0."""
    out.mkdir(parents=True, exist_ok=True)
    for name in ("json", "pages", "printed", "fmus", "predicted", "runs", "exports", "models", *HIDDEN):
        (out / name).mkdir(exist_ok=True)
    (out / "system.yaml").write_text(SYSTEM, encoding="utf-8")
    return sum(
        _ended(command, k, out, tree) != 0 for k, command in enumerate(commands()) if command.part in parts
    )


def _ended(command: Command, number: int, out: Path, tree: Path) -> int:
    kept = out / "printed" / f"{number:03d}.json"
    if kept.is_file():
        return int(json.loads(kept.read_text(encoding="utf-8"))["exit"])
    words = command.words
    call = ["-c", words[1]] if words[0] == "python" else ["-c", _RUN, *words]
    environment = os.environ | {"PYTHONPATH": str(tree.resolve()), "COLUMNS": "200", "NO_COLOR": "1"}
    began = time.monotonic()
    done = subprocess.run(
        [sys.executable, "-P", *call], cwd=out, env=environment, capture_output=True, text=True, check=False
    )
    print(f"{time.monotonic() - began:7.1f} s  exit {done.returncode}  {command.name[:120]}", flush=True)
    if done.returncode:
        print(done.stderr[-1500:], flush=True)
    shown = {"command": command.name, "exit": done.returncode, "stdout": done.stdout.splitlines()}
    kept.write_text(json.dumps(shown, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return done.returncode


def main() -> int:
    """Run one of the two words."""
    parser = argparse.ArgumentParser(prog="python -m tests.net", description=__doc__.splitlines()[0])
    words = parser.add_subparsers(dest="word", required=True)
    recording = words.add_parser("record", help="run the commands")
    recording.add_argument("-o", "--out", type=Path, required=True)
    recording.add_argument("--tree", type=Path, default=Path.cwd(), help="checkout whose code runs")
    recording.add_argument("--part", action="append", choices=sorted({c.part for c in commands()}))
    comparing = words.add_parser("compare", help="compare two records")
    comparing.add_argument("old", type=Path)
    comparing.add_argument("new", type=Path)
    chosen = parser.parse_args()
    if chosen.word == "record":
        parts = chosen.part or list(dict.fromkeys(c.part for c in commands()))
        return min(record(chosen.out, chosen.tree, parts), 1)
    found = list(differences(chosen.old, chosen.new))
    print("\n".join(found) or "no difference")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
