"""Run cases and write one JSON line a case; a file that exists is continued."""

from __future__ import annotations

import importlib
import json
import math
import multiprocessing as mp
import os
import time
import traceback
import warnings
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

from .answers import read, score
from .build import make
from .case import Case
from .line import Line, begun
from .refining import measure_refinement

#: Errors with which a table may be refused; anything else is a crash.
REFUSALS = (ValueError, KeyError)


def judge_case(case: Case, module: Any) -> Line:
    """Make a campaign, diagnose it, refine with the answer, score.

    Parameters
    ----------
    case : Case
        What to run.
    module : module
        Has ``diagnose`` and ``refine``.

    Returns
    -------
    Line
        One line of the results; ``status`` is ``ok``, ``refused`` or ``crash``.
    """
    line = begun(case, "ok")
    start = time.perf_counter()
    campaign = make(case)
    line["truth"], line["t_make"] = campaign.record, time.perf_counter() - start
    start = time.perf_counter()
    try:
        diagnosis = module.diagnose(
            campaign.data.copy(),
            tests=None if campaign.tests is None else campaign.tests.copy(),
            model="linear",
            seed=0,
        )
        line["t_diagnose"] = time.perf_counter() - start
        answer = read(diagnosis)
    except REFUSALS as error:
        line |= {
            "status": "refused",
            "error": f"{type(error).__name__}: {error}"[:500],
            "where": traceback.format_exc()[-1500:],
        }
        return line
    except Exception as error:
        line |= {
            "status": "crash",
            "error": f"{type(error).__name__}: {error}"[:500],
            "where": traceback.format_exc()[-1500:],
        }
        return line
    line["answer"] = {
        "verdict": answer.verdict,
        "effects": answer.effects,
        "confusion": answer.confusion,
        "confidence": answer.confidence,
        "grounds": diagnosis.grounds,
    }
    line["score"] = score(case, answer)
    start = time.perf_counter()
    comparable = case.kind not in ("thin", "foreign", "hidden_group") and not any(
        key.startswith(("drift_", "zero_", "twin_")) for key in case.laws
    )
    if comparable:
        line["refinement"] = measure_refinement(module, diagnosis, answer, campaign)
    line["t_refine"] = time.perf_counter() - start
    return line


def _clean(value: Any) -> Any:
    """Values JSON can hold; NaN and infinity become None."""
    if isinstance(value, dict):
        return {str(k): _clean(v) for k, v in value.items()}
    if isinstance(value, (list, tuple, set, frozenset)):
        return [_clean(v) for v in value]
    if hasattr(value, "item"):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if isinstance(value, (str, int, float, bool, type(None))) else str(value)


def _serve(connection: Connection, module_name: str) -> None:
    """Loop of a worker process: receive a case, send its line."""
    warnings.simplefilter("ignore")
    module = importlib.import_module(module_name)
    connection.send("ready")
    while (case := connection.recv()) is not None:
        try:
            connection.send(_clean(judge_case(case, module)))
        except Exception:
            connection.send({**begun(case, "judge_error"), "error": traceback.format_exc()[-1500:]})


class _Worker:
    """One process, started again after a time-out."""

    def __init__(self, module_name: str) -> None:
        self.module_name = module_name
        self.case: Case | None = None
        self.since = 0.0
        self._start()

    def _start(self) -> None:
        context = mp.get_context("spawn")
        self.connection, other = context.Pipe()
        self.process: BaseProcess = context.Process(
            target=_serve, args=(other, self.module_name), daemon=True
        )
        self.process.start()
        other.close()
        if self.connection.recv() != "ready":
            raise RuntimeError("a worker did not start")

    def give(self, case: Case) -> None:
        self.case, self.since = case, time.monotonic()
        self.connection.send(case)

    def again(self) -> None:
        self.process.kill()
        self.process.join()
        self.connection.close()
        self._start()

    def stop(self) -> None:
        if self.process.is_alive():
            self.connection.send(None)
            self.process.join(5.0)
        if self.process.is_alive():
            self.process.kill()


def done_ids(out: Path) -> set[str]:
    """Cases that a results file holds; a half-written last line is ignored."""
    found = set()
    if out.exists():
        for text in out.read_text().splitlines():
            try:
                found.add(json.loads(text)["id"])
            except (json.JSONDecodeError, KeyError):
                continue
    return found


def run(
    todo: list[Case],
    out: Path,
    module_name: str = "friction_models.discovery",
    workers: int = 1,
    timeout: float = 120.0,
    verbose: bool = True,
) -> int:
    """Run the cases that `out` does not hold yet.

    Parameters
    ----------
    todo : list of Case
        Cases.
    out : pathlib.Path
        Results, one JSON line a case; lines are appended.
    module_name : str
        Module with ``diagnose`` and ``refine``.
    workers : int
        Largest number of processes.
    timeout : float
        Longest time of a case [s]; after it the process is killed and the case is noted as ``timeout``.
    verbose : bool
        Print one line a case.

    Returns
    -------
    int
        Number of cases run.
    """
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    have = done_ids(out)
    queue = [case for case in todo if case.id not in have]
    total, count = len(queue), 0
    if not queue:
        return 0
    pool = [_Worker(module_name) for _ in range(min(workers, total))]
    if out.exists() and (old := out.read_text()) and not old.endswith("\n"):
        out.write_text(old + "\n")
    with out.open("a") as file:
        while queue or any(w.case for w in pool):
            for worker in pool:
                if worker.case is None and queue:
                    worker.give(queue.pop(0))
            ready = wait([w.connection for w in pool if w.case], timeout=0.5)
            for worker in pool:
                if worker.case is None:
                    continue
                line: Line | None = None
                if worker.connection in ready:
                    try:
                        line = worker.connection.recv()
                    except EOFError:
                        line = {**begun(worker.case, "crash"), "error": "the process died"}
                        worker.again()
                elif time.monotonic() - worker.since > timeout:
                    line = begun(worker.case, "timeout")
                    worker.again()
                if line is not None:
                    worker.case = None
                    count += 1
                    file.write(json.dumps(line) + "\n")
                    file.flush()
                    if verbose:
                        said = line.get("answer")
                        words = f"{said['verdict']} {','.join(said['effects'])}" if said else " "
                        print(
                            f"{count:4d}/{total} {line['id'][:60]:60s} {line['status']:8s} {words}",
                            flush=True,
                        )
    for worker in pool:
        worker.stop()
    return count
