"""Diagnose every table as it is and changed; what was answered is kept, so that an interrupted run goes on."""

from __future__ import annotations

import hashlib
import json
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd
import yaml

from friction_models.common import InputError, write_json
from friction_models.discovery import diagnose

from ..data import sources
from . import tables, variants
from .answers import Answer, Call, Lists, Result, Wanted
from .grade import grade

#: What an answer must survive: name of the change, and how the page says it.
INVARIANCES = {
    "reverse_rows": "row order reversed",
    "metres": "speed and distance in m for mm",
    "thin": "every second point left out",
    "copies": "every test twice (identical copies)",
    "drop_tests": "10 % of the tests left out",
    "random_column": "a random metadata column added",
}
#: With fewer tests none can be left out.
LEAST_TESTS = 10
#: Identical copies must not raise the confidence by more.
COPIES_RAISE = 0.05
Mean = Literal["mean_square", "plain_mean_square"]
PARTS: tuple[Literal["floor", "explained", "missing"], ...] = ("floor", "explained", "missing")
_HERE = Path(__file__).parent
Told = Callable[[str], None]


def expected() -> dict[str, Wanted]:
    """Return the acceptable answers by set."""
    text = (_HERE / "answers.yaml").read_text(encoding="utf-8")
    found: dict[str, Wanted] = yaml.safe_load(text)["sets"]
    return found


def table_of(call: Call, folder: Path) -> tables.Table:
    """Return points, tests and description of a set; loads that were not recorded are left out."""
    return tables.TABLES[call["function"]](folder, **call["arguments"], fill_missing=False)


def applies(change: str, data: pd.DataFrame, tests: pd.DataFrame) -> bool:
    """Return whether a change does anything to a table."""
    if change == "metres":
        return "v_rel" in data or "sd" in data
    if change == "thin":
        return bool(data.groupby("test_id").size().max() > 1)
    return change != "drop_tests" or len(tests) >= LEAST_TESTS


def answer_to(data: pd.DataFrame, tests: pd.DataFrame) -> Answer:
    """Return what the diagnosis says of a table."""
    began = time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = diagnose(data, tests=tests, model="linear", seed=0)
    except InputError as error:
        return {"status": "refused", "said": str(error)}
    except Exception as error:  # a crash is a result, and must not end the run
        return {
            "status": "crashed",
            "said": f"{type(error).__name__}: {error}",
            "where": traceback.format_exc(),
        }
    table = found.averages
    squares = table["before"].to_numpy() ** 2
    return {
        "status": "answered",
        "verdict": found.verdict,
        "effects": list(found.effects),
        "confusion_set": list(found.confusion_set),
        "confidence": float(found.confidence),
        "said": found.sentence,
        "warnings": list(found.warnings),
        "budget": {part: float(found.error_budget[part]) for part in PARTS},
        "mean_square": float(np.average(squares, weights=table["points"])),
        "plain_mean_square": float(np.mean(squares)),
        "seconds": time.perf_counter() - began,
    }


def run_all(data: Path, kept: Path, tell: Told = print, only: list[str] | None = None) -> list[Result]:
    """Diagnose what is not kept yet; return one result a set, graded, with its answers after each change.

    Parameters
    ----------
    data : pathlib.Path
        Folder of the measurements.
    kept : pathlib.Path
        Folder for the answers; those of another diagnosis or of other tables are not used.
    tell : callable
        Takes a line for each answer.
    only : list of str, optional
        Sets; all by default.
    """
    made_by = b"".join((_HERE / name).read_bytes() for name in ("tables.py", "variants.py"))
    mapping = hashlib.sha256(made_by).hexdigest()[:6]
    place = kept / f"{sources('friction_models')}-{mapping}"
    place.mkdir(parents=True, exist_ok=True)
    return [
        _run_set(name, wanted, data, place, tell)
        for name, wanted in expected().items()
        if only is None or name in only
    ]


def _run_set(name: str, wanted: Wanted, data: Path, place: Path, tell: Told) -> Result:
    points, tests, description = table_of(wanted["call"], data)

    def answer(change: str, of: tables.Table) -> Answer:
        file = place / f"{name}--{change}.json"
        if not file.is_file():
            write_json(file, answer_to(*of[:2]))
            tell(f"{name}: {change}")
        found: Answer = json.loads(file.read_text(encoding="utf-8"))
        return found

    own = answer("as_it_is", (points, tests, ""))
    changed = {
        change: answer(change, (*variants.VARIANTS[change](points, tests), ""))
        for change in INVARIANCES
        if applies(change, points, tests)
    }
    return {
        "name": name,
        "call": wanted["call"],
        "description": description,
        "tests": len(tests),
        "points": len(points),
        "answer": own,
        "grade": grade(own, wanted) if own["status"] == "answered" else own["status"],
        "changed": changed,
    }


def over_budget(answer: Answer, mean: Mean = "mean_square") -> float:
    """Return by which share floor^2 + explained^2 + missing^2 is off the mean square of what the base leaves."""
    total = sum(v**2 for v in answer["budget"].values())
    return abs(float(total / answer[mean]) - 1.0)


def same(before: Answer, after: Answer) -> tuple[bool, bool]:
    """Return whether the verdict, and whether the first effect, is the same."""
    if after["status"] != "answered":
        return False, False
    return before["verdict"] == after["verdict"], before["effects"][:1] == after["effects"][:1]


def tempted(answer: Answer, wanted: Lists) -> Iterator[str]:
    """Yield the reasons why an answer is wrong that were written down beforehand."""
    for entry in wanted["wrong"]:
        names = set(entry.get("names", []))
        if entry["verdict"] not in ("any", answer["verdict"]):
            continue
        if not names or names & set(answer["effects"]):
            yield entry["because"]
