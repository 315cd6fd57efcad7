"""A longer run of the fuzzers: every model and version in turn with new seeds, until the time is up."""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import time
from pathlib import Path

from .building import build, compiler, run
from .models import MODELS
from .packing import packed


def main() -> int:
    """Run the fuzzers; return 1 when one of them found something."""
    parser = argparse.ArgumentParser(prog="python -m tests.fmus.fuzz", description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0, help="how long to go on (default: 60)")
    parser.add_argument("--calls", type=int, default=300_000, help="calls of one run (default: 300000)")
    parser.add_argument("--seed", type=int, default=None, help="first seed (default: a random one)")
    parser.add_argument("--models", nargs="+", choices=[*MODELS], default=[*MODELS])
    parser.add_argument("--fmi", nargs="+", choices=["2.0", "3.0"], default=["2.0", "3.0"])
    parser.add_argument("--nodes", nargs="+", type=int, default=[1, 4])
    parser.add_argument("--plain", action="store_true", help="without the kernels for newer processors")
    wanted = parser.parse_args()
    tool = compiler()
    if tool is None:
        print("no compiler with sanitizers was found")
        return 1
    print(f"noticed: {tool.what}")
    seed = wanted.seed if wanted.seed is not None else random.randrange(2**31)
    options = ["-DTF_PLAIN_ONLY"] if wanted.plain else []
    with tempfile.TemporaryDirectory(prefix="tribofmu-fuzz-") as place:
        programs = {}
        for name in [(k, n, f) for f in wanted.fmi for k in wanted.models for n in wanted.nodes]:
            folder = Path(place) / "-".join(map(str, name))
            folder.mkdir()
            programs[name] = build(packed(*name, folder), folder, tool, "", *options)
        end, runs = time.monotonic() + wanted.seconds, 0
        while not runs or time.monotonic() < end:
            for name, program in programs.items():
                done = run(program, tool, seed, wanted.calls)
                if done.returncode:
                    print(
                        f"{name} with seed {seed} ended with code {done.returncode}:\n{done.stderr[-8000:]}"
                    )
                    return 1
                runs += 1
            seed += 1
    print(f"{runs} runs of {wanted.calls} calls, nothing found; last seed {seed - 1}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
