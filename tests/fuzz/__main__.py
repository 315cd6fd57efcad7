"""``python -m tests.fuzz --tries 3000 --seed 1 -o report.md``: damaged inputs and hostile outputs for every command.

``--only N`` repeats one try of that seed (with ``--quick`` where that was given).
"""

from __future__ import annotations

import argparse
import importlib
import multiprocessing
import os
import pkgutil
import sys
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import partial
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

from friction_models.common import write_text

from .stock import Box, make_stock
from .trying import Try, one_try

_boxes: dict[int, Box] = {}


def load_everything() -> None:
    """Import all modules, so that children need not."""
    for package in ("friction_models", "forming", "sct_twin", "fmus", "orchestrator"):
        module = importlib.import_module(package)
        for found in pkgutil.walk_packages(module.__path__, f"{package}."):
            if not found.name.endswith("__main__"):
                importlib.import_module(found.name)


def in_worker(number: int, seed: int, stock: Path, limit: float, quick: bool) -> Try:
    """Make a try in the sandbox of this process."""
    if os.getpid() not in _boxes:
        _boxes[os.getpid()] = Box(stock, stock.with_name(f"box-{os.getpid()}"))
    return one_try(seed, number, _boxes[os.getpid()], limit, quick)


def tries(numbers: list[int], seed: int, folder: Path, limit: float, quick: bool, jobs: int) -> Iterator[Try]:
    """Make tries, `jobs` at a time."""
    stock = make_stock(folder / "stock")
    load_everything()
    work = partial(in_worker, seed=seed, stock=stock, limit=limit, quick=quick)
    # Workers that may have children of their own, as commands have; a Pool's may not.
    with ProcessPoolExecutor(jobs, multiprocessing.get_context("fork")) as pool:
        for done in as_completed([pool.submit(work, number) for number in numbers]):
            yield done.result()


def kind(wrong: str) -> str:
    """Return what went wrong without the name of the file."""
    return wrong.partition(":")[0].partition(" (")[0]


def report(found: list[Try], seed: int, seconds: float) -> str:
    """Return the page: how many, how they ended, and every try with something wrong."""
    found = sorted(found, key=lambda t: t.number)
    codes = Counter(t.code for t in found)
    bad = [t for t in found if t.wrong]
    ended = ", ".join(f"{n} with {c}" for c, n in sorted(codes.items()))
    lines = [
        "# Fuzz of the command line",
        "",
        f"{len(found)} tries with seed {seed} in {seconds / 60:.1f} min; ended: {ended}. {len(bad)} with something wrong.",
        "",
    ]
    groups: dict[tuple[str, str], list[Try]] = defaultdict(list)
    for tried in bad:
        for what in dict.fromkeys(kind(w) for w in tried.wrong):
            groups[what, tried.name].append(tried)
    if groups:
        lines += ["| what | command and parameter | tries | the first of them |", "|---|---|---|---|"]
        lines += [f"| {w} | {n} | {len(g)} | {g[0].number} |" for (w, n), g in sorted(groups.items())]
    slow = sorted(found, key=lambda t: -t.seconds)[:5]
    lines += [
        "",
        "The slowest: " + ", ".join(f"{t.number} ({t.name}, {t.seconds:.0f} s)" for t in slow) + ".",
    ]
    for tried in bad:
        lines += [
            "",
            f"## {tried.number}: {tried.name}",
            "",
            f"- `tribofmu {tried.command[:500]}`",
            f"- {tried.damage}",
        ]
        lines += [f"- WRONG: {w}" for w in tried.wrong]
        lines += [
            f"- exit code {tried.code} after {tried.seconds:.1f} s: {' / '.join(tried.said.splitlines())[-600:]}"
        ]
    return "\n".join([*lines, ""])


def main() -> int:
    """Make the tries and write the page; the exit code says whether something was wrong."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--tries", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first try")
    parser.add_argument("--only", type=int, help="repeat this try")
    parser.add_argument("--limit", type=float, default=180.0, help="longest time of a command [s]")
    parser.add_argument("--quick", action="store_true", help="leave out commands that solve for seconds")
    parser.add_argument("-j", "--jobs", type=int, default=2)
    parser.add_argument("-o", "--out", type=Path)
    chosen = parser.parse_args()
    numbers = list(range(chosen.first, chosen.first + chosen.tries)) if chosen.only is None else [chosen.only]
    began, found, page = time.monotonic(), [], ""
    with tempfile.TemporaryDirectory(prefix="fuzz-") as place:
        folder = Path(place).resolve()
        for tried in tries(numbers, chosen.seed, folder, chosen.limit, chosen.quick, chosen.jobs):
            found.append(tried)
            if tried.wrong:
                print(f"{tried.number}: {tried.name}: {tried.wrong[0]}", file=sys.stderr, flush=True)
            if len(found) % 100 and len(found) < len(numbers):
                continue
            # What is known so far stays when the rest is interrupted.
            seconds = time.monotonic() - began
            print(f"{len(found)} tries, {seconds:.0f} s", file=sys.stderr, flush=True)
            page = report(found, chosen.seed, seconds)
            if chosen.out is not None:
                write_text(chosen.out, page)
    print(page if chosen.only is None or found[0].wrong else f"{found[0]}")
    return int(any(t.wrong for t in found))


if __name__ == "__main__":
    sys.exit(main())
