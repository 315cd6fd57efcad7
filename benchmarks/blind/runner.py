"""Diagnoses the cases, each in a process of its own with a time-out, and keeps one JSON file a case."""

from __future__ import annotations

import json
import multiprocessing
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.blind.cases import Case
from benchmarks.blind.record import Record, no_answer, said


def answer_of(case: Case) -> Record:
    """Build a case and diagnose it: truth, answer, seconds."""
    from benchmarks.blind.build import build
    from friction_models.discovery import diagnose

    built = build(case)
    start = time.process_time()
    try:
        answer = said(diagnose(built.points, tests=built.tests, model=built.model))
    except Exception as error:  # a crash is an answer, and a wrong one
        answer = no_answer("crash", repr(error)[:500])
    return {
        "name": case.name,
        "truth": built.truth,
        "answer": answer,
        "seconds": round(time.process_time() - start, 2),
    }


def _write(path: Path, record: Record) -> None:
    part = path.with_suffix(".part")
    part.write_text(json.dumps(record, indent=1, default=float))
    part.replace(path)


def _work(case: Case, path: Path) -> None:
    _write(path, answer_of(case))


def file_of(case: Case, folder: Path) -> Path:
    """Where the record of a case is kept; the halves lie in folders of their own."""
    return folder / (f"seed-{case.seed}" if case.seed else "") / case.half / f"{case.name}.json"


def run(cases: Sequence[Case], folder: Path, workers: int, limit: float) -> None:
    """Diagnose what has no record yet."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["benchmarks.blind.build", "friction_models.discovery"])
    for case in cases:
        file_of(case, folder).parent.mkdir(parents=True, exist_ok=True)
    waiting = [c for c in cases if not file_of(c, folder).exists()]
    total, running = len(waiting), list[tuple[Any, Case, float]]()
    print(f"{len(cases)} cases, {total} to run", flush=True)
    while waiting or running:
        while waiting and len(running) < workers:
            case = waiting.pop(0)
            process = context.Process(target=_work, args=(case, file_of(case, folder)))
            process.start()
            running.append((process, case, time.monotonic()))
        for process, case, start in list(running):
            process.join(0.2 / len(running))
            late = time.monotonic() - start > limit
            if process.is_alive() and not late:
                continue
            process.kill()
            process.join()
            path = file_of(case, folder)
            if not path.exists():
                why = f"no answer in {limit:g} s" if late else f"the process ended with {process.exitcode}"
                answer = no_answer("time-out" if late else "crash", why)
                _write(path, {"name": case.name, "truth": None, "answer": answer, "seconds": limit})
            running.remove((process, case, start))
            done = total - len(waiting) - len(running)
            if done % 10 == 0:
                print(f"{done} of {total}", flush=True)
