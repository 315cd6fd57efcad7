"""What a forming run costs, beside another state of the solver if there is one: ``TRIBOFMU_OTHER=folder make bench``."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .common import Section, Table, section

#: Folder with another checkout, whose runs take turns with ours.
OTHER = "TRIBOFMU_OTHER"
REPEATS = 3
MU = 0.08


def _rod(stroke: float, mesh_size: float = 0.4) -> Any:
    from forming import ForwardRodExtrusion

    process = ForwardRodExtrusion(mesh_size=mesh_size)
    process.run(MU, stroke)
    return process.simulation.state


def _cup(stroke: float, mesh_size: float = 0.35) -> Any:
    from forming import BackwardCupExtrusion

    process = BackwardCupExtrusion(mesh_size=mesh_size)
    process.run(MU, stroke)
    return process.simulation.state


def _ring(stroke: float) -> Any:
    from forming import RingCompression

    process = RingCompression()
    process.run(MU, stroke)
    return process.simulation.state


def _specimen(force: float) -> Any:
    from forming import upset

    upset(force=force)


#: What is run, shortly first so that nothing compiles in the time that counts.
CASES: dict[str, tuple[Callable[[], Any], Callable[[], Any]]] = {
    "rod, 20 mm": (lambda: _rod(1.0), lambda: _rod(20.0)),
    "cup, 10 mm": (lambda: _cup(1.0), lambda: _cup(10.0)),
    "ring, 2 mm": (lambda: _ring(0.1), lambda: _ring(2.0)),
    "specimen of the twin, 250 kN": (lambda: _specimen(1e5), lambda: _specimen(2.5e5)),
    "rod, elements of 0.2 mm, 4 mm": (lambda: _rod(0.5), lambda: _rod(4.0, mesh_size=0.2)),
    "cup, elements of 0.2 mm, 3 mm": (lambda: _cup(0.5), lambda: _cup(3.0, mesh_size=0.2)),
}


def once(name: str) -> dict[str, float]:
    """Run a case and return its CPU time [s], increments and iterations (0 where the process does not tell)."""
    shortly, whole = CASES[name]
    shortly()
    began = time.process_time()
    state = whole()
    taken = time.process_time() - began
    return {
        "seconds": taken,
        "increments": state.increments if state else 0,
        "iterations": state.iterations if state else 0,
    }


def _in(folder: str, name: str) -> dict[str, float]:
    """Run a case with the solver of a checkout, in a process of its own with one thread."""
    environment = os.environ | {"PYTHONPATH": folder, "OMP_NUM_THREADS": "1"}
    # By its path: the other checkout need not have this file; -P keeps its own folder out of the search.
    command = [sys.executable, "-P", "-c", _BRIDGE, str(Path(__file__).resolve().parents[1]), name]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True, cwd=folder)
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


#: The packages of the checkout come first, this one last.
_BRIDGE = """
import importlib, json, sys, types
sys.path.append(sys.argv[1])
import forming
package = types.ModuleType("benchmarks")
package.__path__ = [sys.argv[1] + "/benchmarks"]
sys.modules["benchmarks"] = package
print(json.dumps(importlib.import_module("benchmarks.forming_speed").once(sys.argv[2])))
"""


def measure(folder: Path) -> Section:
    """Run all cases, in turns with those of the other checkout."""
    here, other = str(Path(__file__).resolve().parents[1]), os.environ.get(OTHER)
    trees = [here, other] if other else [here]
    headings = ["run", "CPU time [s]", "increments", "iterations", "CPU time an increment [ms]"]
    table = Table([*headings, "over that of the other state"] if other else headings)
    for name in CASES:
        runs: dict[str, list[dict[str, float]]] = {tree: [] for tree in trees}
        for k in range(REPEATS):
            for tree in trees[:: 1 if k % 2 == 0 else -1]:
                runs[tree].append(_in(tree, name))
        taken = {tree: statistics.median(r["seconds"] for r in runs[tree]) for tree in trees}
        last = runs[here][-1]
        row = [name, f"{taken[here]:.2f}"]
        if last["increments"]:
            row += [f"{last['increments']:.0f}", f"{last['iterations']:.0f}"]
            row.append(f"{1e3 * taken[here] / last['increments']:.1f}")
        else:
            row += ["-", "-", "-"]
        if other:
            row.append(f"{taken[here] / taken[other]:.2f}")
        table.rows.append(row)
        print(" | ".join(row), flush=True)
    beside = ", in turns with another state of the solver in the same measurement" if other else ""
    return section(
        "Speed of forming runs",
        f"Default set-ups, mu {MU:g}, tool temperature fields included; median of {REPEATS} runs with one thread, without "
        f"compilation{beside}.",
        table,
    )
