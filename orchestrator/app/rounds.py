"""The rounds of refinement that the card of a model keeps; a file of the project may hold anything."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from friction_models.common.files import read_json


def rounds_of(card: Path) -> list[Mapping[str, Any]]:
    """Return what was added in each round, with the errors before and after.

    Raises
    ------
    InputError
        The file cannot be read.
    """
    found: object = read_json(card)
    for name in ("model", "learned", "error_history"):
        found = found.get(name) if isinstance(found, dict) else None
    return [_without_strange(entry) for entry in found if _is_round(entry)] if isinstance(found, list) else []


def _without_strange(entry: dict[str, Any]) -> dict[str, Any]:
    """Return a round without intervals that are none."""
    # It brings all that counts, for which the first page does not wait.
    from friction_models.models.rounds import are_intervals

    good = are_intervals(entry.get("intervals", {})) and isinstance(entry.get("clear", False), bool)
    return entry if good else {k: v for k, v in entry.items() if k not in {"intervals", "clear"}}


def _is_round(entry: object) -> bool:
    """Whether an entry of a card says what was added and which errors it had before and after."""
    if not isinstance(entry, dict) or not isinstance(entry.get("added"), list):
        return False
    errors = [entry.get("before"), entry.get("after")]
    return "judged_by" in entry and all(
        isinstance(e, dict)
        and all(isinstance(e.get(k), float) and math.isfinite(e[k]) and e[k] > 0.0 for k in ("rmse", "mae"))
        for e in errors
    )
