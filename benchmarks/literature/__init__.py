"""Synthetic campaigns with laws of the literature hidden in them. Nothing in here is measured."""

from __future__ import annotations

import json
from pathlib import Path

from ..common import Section
from ..data import sources
from .build import Campaign, make
from .case import Case
from .collection import cases, quick

__all__ = ["Campaign", "Case", "cases", "make", "measure", "quick"]

#: Where `make bench-literature` keeps its results.
FOLDER = Path("build/benchmarks/literature")


def kept_file(folder: Path) -> Path:
    """Return the results of the diagnosis as it is now: those of another version are not mixed with them."""
    return folder / f"results-{sources('friction_models')}.jsonl"


def measure(folder: Path) -> Section:
    """Run what is missing of the cases chosen last (all without a choice); return the section of the page."""
    from .judge import run
    from .page import summary
    from .table import load

    place = folder / "literature"
    place.mkdir(parents=True, exist_ok=True)
    choice = place / "chosen.json"
    wanted = set(json.loads(choice.read_text(encoding="utf-8"))["cases"]) if choice.is_file() else None
    todo = [case for case in cases() if wanted is None or case.id in wanted]
    run(todo, kept_file(place))
    ids = {case.id for case in todo}
    return summary([line for line in load([kept_file(place)]) if line["id"] in ids])
