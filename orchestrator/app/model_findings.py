"""What `diagnose` and `refine` wrote about a model, as far as pages show it; entries that cannot be used are left out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from friction_models.common import InputError
from friction_models.common.errors import shown
from friction_models.common.files import read_json

from .commands import effect_names

#: Most effects of a ranking that are told in words.
_TOLD = 50


@dataclass(frozen=True)
class Offer:
    """Empirical terms that would help: the effects to add, and in words their curve and what it removes."""

    effects: list[str]
    equation: str
    removes: str


@dataclass(frozen=True)
class Answer:
    """The answer of a diagnosis: the effects that it names, and those that the data cannot tell from them."""

    effects: list[str] = field(default_factory=list)
    rivals: list[str] = field(default_factory=list)
    #: What was tried, best evidence first.
    ranking: list[str] = field(default_factory=list)
    offers: list[Offer] = field(default_factory=list)
    #: What no model predicts, RMS in mu.
    floor: float | None = None
    #: What the effects are, as far as the catalogue knows them.
    words: dict[str, str] = field(default_factory=dict)

    @classmethod
    def read(cls, file: Path) -> Answer:
        """Read an answer; an empty one where nothing was asked yet.

        Raises InputError: the file cannot be read.
        """
        if not file.is_file():
            return cls()
        content = read_json(file)
        named = effect_names(content.get("effects"))
        rivals = [e for e in effect_names(content.get("confusion_set")) if e not in named]
        ranking = effect_names([r.get("effect") for r in _objects(content.get("ranking"))])
        return cls(
            named,
            rivals,
            ranking,
            [offer for o in _objects(content.get("formulas")) if (offer := _offer(o)).effects],
            noise_floor(content),
            {effect: _in_words(effect) for effect in (*rivals, *ranking[:_TOLD])},
        )


def noise_floor(content: Mapping[str, object]) -> float | None:
    """Return the noise floor by the JSON of a diagnosis, RMS in mu; None where it states none."""
    found = content.get("noise_floor")
    floor = found.get("total") if isinstance(found, dict) else None
    return floor if isinstance(floor, float) and math.isfinite(floor) else None


def _in_words(effect: str) -> str:
    """Return what an effect is; nothing of a name that is none.

    Examples
    --------
    >>> _in_words("stribeck"), _in_words("none")
    ('Mixed to boundary transition.', '')
    """
    # It brings all that counts, for which a page without an answer does not wait.
    from friction_models.effects import make_effect

    try:
        title = make_effect(effect).title
    except InputError:
        return ""
    return f"{title[:1].upper()}{title[1:]}."


def _offer(entry: dict[str, object]) -> Offer:
    """Return an offer of a file.

    Examples
    --------
    >>> _offer({"add": ["empirical:v"], "equation": "f(v)", "share": 0.8, "interval": [0.6, None]}).removes
    'It removes 80 % [60 to ? %] of the error that can be avoided.'
    """
    share, interval, removes = entry.get("share"), entry.get("interval"), ""
    if isinstance(share, float) and isinstance(interval, list) and len(interval) == 2:
        low, high = (f"{100 * v:.0f}" if isinstance(v, int | float) else "?" for v in interval)
        removes = f"It removes {100 * share:.0f} % [{low} to {high} %] of the error that can be avoided."
    return Offer(effect_names(entry.get("add")), shown(entry.get("equation", ""), 300), removes)


def _objects(found: object) -> list[dict[str, object]]:
    return [o for o in found if isinstance(o, dict)] if isinstance(found, list) else []


def rounds_of(card: Path) -> list[Mapping[str, Any]]:
    """Return what the card of a model keeps of its refinement: what each round added, and the errors before and after.

    Raises InputError: the file cannot be read.
    """
    found: object = read_json(card)
    for name in ("model", "learned", "error_history"):
        found = found.get(name) if isinstance(found, dict) else None
    return [_without_strange(entry) for entry in found if _is_round(entry)] if isinstance(found, list) else []


def _without_strange(entry: dict[str, Any]) -> dict[str, Any]:
    """Return a round without parts that are none, such as intervals of text."""
    # It brings all that counts, for which the first page does not wait.
    from friction_models.families.refinement_history import strange_parts

    strange = strange_parts(entry)
    return {k: v for k, v in entry.items() if k not in strange}


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
