"""Tries a graph without translation in a second process, because it may run forever or take all memory."""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path

import numpy as np

from friction_models.common import InputError
from friction_models.common.processes.child_processes import python_command
from friction_models.common.processes.timed import NotReady, run_timed, say_ready

from .operators.nodes import Array
from .parity import original_mu, session
from .signature import Signature

#: Longest time [s] that the graph may run, and most memory [bytes] of the process.
TIME_LIMIT = 60.0
MEMORY_LIMIT = 2 * 1024**3


def try_original(content: bytes, signature: Signature, points: Array, where: str) -> None:
    """Run the original graph at `points`, shape (n, 5), in a process of its own.

    Raises InputError: it cannot be run, does not end, takes too much memory, or gives no numbers.
    """
    with tempfile.TemporaryDirectory(prefix="tribofmu-") as name:
        folder = Path(name)
        (folder / "original.onnx").write_bytes(content)
        task = {"where": where, "signature": signature.to_dict(), "points": points.tolist()}
        (folder / "task.json").write_text(json.dumps(task), encoding="utf-8")
        try:
            run_timed(python_command(__name__, name), TIME_LIMIT)
        except TimeoutError:
            raise InputError(
                f"{where}: {len(points)} points are not evaluated after {TIME_LIMIT:g} s; allowed: a closed formula"
            ) from None
        except NotReady as late:
            raise InputError(
                f"{where}: the process that is to run the graph is {late}; allowed: a machine with less other work"
            ) from None
        answer = folder / "answer.json"
        if not answer.is_file():
            raise InputError(
                f"{where}: the process that runs the graph ended early; allowed: a graph that ONNX Runtime runs in "
                f"{MEMORY_LIMIT >> 30} GiB of memory"
            )
        error = json.loads(answer.read_text(encoding="utf-8"))["error"]
    if error:
        raise InputError(error)


def main() -> None:
    """Run the task in the folder of the first argument; the answer is a sentence, or empty."""
    import onnxruntime  # noqa: F401  (that it is loaded before the time counts)

    from ..archive.limits import limit_memory

    say_ready()
    limit_memory(MEMORY_LIMIT)
    folder = Path(sys.argv[1])
    task = json.loads((folder / "task.json").read_text(encoding="utf-8"))
    where, error = str(task["where"]), ""
    signature = Signature.from_dict(task["signature"])
    try:
        content = (folder / "original.onnx").read_bytes()
        mu = original_mu(session(content, where), signature, np.array(task["points"]), where)
        if not np.isfinite(mu).any():
            error = f"{where}: mu is nowhere a finite number at random loads; allowed: finite numbers"
    except InputError as problem:
        error = str(problem)
    part = folder / "answer.part"
    part.write_text(json.dumps({"error": error}), encoding="utf-8")
    part.replace(folder / "answer.json")
