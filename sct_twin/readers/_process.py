"""The reading process of `readers.guarded`: reads one file for each line of its input.

It answers with two lines: that the library is loaded, and what it read.
"""

from __future__ import annotations

import json
import os
import sys
import warnings
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from friction_models.common import InputError

from .formats import load_library, read_kind
from .guarded import MEMORY, READY
from .table import RawTable


def _limit_memory() -> None:
    try:
        import resource

        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        soft = MEMORY if hard == resource.RLIM_INFINITY else min(MEMORY, hard)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
        resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
    except (ImportError, ValueError, OSError):
        # Windows has no such limit; the sizes that the readers check remain.
        return


def _answer(question: Mapping[str, str]) -> dict[str, object]:
    file = Path(question["file"])
    try:
        table = read_kind(file, question["kind"])
        folder = Path(question["folder"])
        for number, name in enumerate(table.frame.columns):
            np.save(folder / f"{number}.npy", _numbers(table, name), allow_pickle=False)
    except InputError as error:
        return {"error": str(error)}
    except MemoryError:
        return {"error": f"{file}: needs more than {MEMORY} bytes of memory; allowed: smaller files"}
    except Exception as error:
        # Libraries raise anything on damaged files; the user gets a sentence whatever it is.
        return {"error": f"{file}: not a readable {question['kind']} file ({_line(error)})"}
    return {
        "names": [str(name) for name in table.frame.columns],
        "units": table.units,
        "format": table.format,
        "notes": list(table.notes),
    }


def _numbers(table: RawTable, name: str) -> np.ndarray:
    values = table.frame[name]
    if values.dtype.kind in "fiub":
        return values.to_numpy()
    numbers, bad = table.numbers(name)
    if bad is not None:
        raise InputError(
            f"{table.source}: column {name!r}, row {bad}: value {values.iloc[bad]!r} is not a number"
        )
    return numbers


def _line(error: BaseException) -> str:
    text = " ".join(str(error).split()) or type(error).__name__
    return "".join(c for c in text if c.isprintable())[:200]


def main() -> None:
    """Answer every line of the input until it ends."""
    _limit_memory()
    warnings.simplefilter("ignore")
    # What a library prints must not stand between the answers.
    out = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    for line in sys.stdin:
        question = json.loads(line)
        load_library(question["kind"])
        print(READY, file=out, flush=True)
        print(json.dumps(_answer(question)), file=out, flush=True)
