"""Check that the class of an effect, which users may write, declares all that the diagnosis relies on."""

from __future__ import annotations

from typing import Any

from ..loads import LOAD_NAMES
from .base import Effect
from .parameters import Amplitude, ShapeParameter

TEXTS = ("name", "title", "label", "sentence", "equation", "latex", "citation", "where_it_shows")
KINDS = ("physics", "system", "fault")


def declaration_fault(effect: type[Effect]) -> str | None:
    """Return what is missing or wrong in the declaration of an effect, None where it is complete.

    Examples
    --------
    >>> from friction_models.effects import Stribeck
    >>> declaration_fault(Stribeck) is None
    True
    >>> class Nameless(Stribeck):
    ...     name = ""
    >>> declaration_fault(Nameless)
    "name = ''; allowed: a text"
    """
    for text in TEXTS:
        value = getattr(effect, text, None)
        if not isinstance(value, str) or not value:
            return f"{text} = {value!r:.40}; allowed: a text"
    faults = (
        _tuple_of(effect, "driver", str, least=1),
        _tuple_of(effect, "amplitudes", Amplitude, least=1),
        _tuple_of(effect, "shapes", ShapeParameter),
        _tuple_of(effect, "metadata", str),
        _tuple_of(effect, "metadata_units", str),
        _tuple_of(effect, "needs", str) if effect.needs is not None else None,
        _tuple_of(effect, "states", tuple),
    )
    fault = next((f for f in faults if f), None)
    if fault:
        return fault
    if effect.kind not in KINDS:
        return f"kind = {effect.kind!r:.40}; allowed: {', '.join(KINDS)}"
    if len(effect.metadata) != len(effect.metadata_units):
        return f"{len(effect.metadata)} metadata and {len(effect.metadata_units)} metadata_units; allowed: one unit each"
    if effect.name in (*LOAD_NAMES, "mu"):
        return f"name = {effect.name!r}; allowed: a name that neither a load nor mu has"
    strange = next((d for d in effect.driver if d not in (*LOAD_NAMES, *effect.metadata)), None)
    if strange is not None:
        return f"driver {strange!r}; allowed: {', '.join(LOAD_NAMES)}, or metadata of the effect"
    for s in effect.shapes:
        if not s.lower < s.upper:
            return f"shape {s.name!r} from {s.lower:g} to {s.upper:g}; allowed: a lower bound below the upper one"
    names = [a.name for a in effect.amplitudes] + [s.name for s in effect.shapes]
    twice = next((n for n in names if names.count(n) > 1), None)
    if twice is not None:
        return f"parameter {twice!r} stands twice; allowed: once"
    if any(len(s) != 2 or not all(isinstance(part, str) for part in s) for s in effect.states):
        return f"states = {effect.states!r:.60}; allowed: pairs of name and unit"
    taken = next((name for name, _ in effect.states if name in (*LOAD_NAMES, "mu")), None)
    if taken is not None:
        return f"state {taken!r}; allowed: a name that neither a load nor mu has"
    if effect.basis is Effect.basis:
        return "basis is not written; allowed: a method that returns one column an amplitude"
    stepped, linear = effect.advance is not Effect.advance, effect.linear_step is not Effect.linear_step
    if effect.states and not (stepped or linear or effect.rate is not Effect.rate):
        return "states without rate, linear_step or advance; allowed: one of them"
    if stepped and linear:
        return "advance and linear_step both written; allowed: one of them, the other would be another step"
    return None


def _tuple_of(effect: type[Effect], name: str, kind: type, least: int = 0) -> str | None:
    value: Any = getattr(effect, name, None)
    if not isinstance(value, tuple) or len(value) < least or not all(isinstance(v, kind) for v in value):
        some = f"at least {least} " if least else ""
        return f"{name} = {value!r:.60}; allowed: a tuple of {some}{kind.__name__}"
    return None
