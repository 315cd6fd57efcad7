"""Check that effects can stand in one model, or in one catalogue: each has names of its own."""

from __future__ import annotations

from collections.abc import Iterable

from ..common import InputError
from .base import Effect


def check_together(where: str, effects: Iterable[Effect | type[Effect]]) -> None:
    """Raise InputError if an effect stands twice, or if two remember under one name: each would go on with the state of the other.

    Examples
    --------
    >>> from friction_models.effects import RunningIn, Stribeck
    >>> check_together("composed", [Stribeck(), RunningIn()])
    >>> check_together("composed", [Stribeck(), Stribeck(d=2.0)])
    Traceback (most recent call last):
        ...
    friction_models.common.errors.InputError: composed: effect 'stribeck' stands twice; allowed: each effect once
    """
    names, owners = set[str](), dict[str, str]()
    for effect in effects:
        if effect.name in names:
            raise InputError(f"{where}: effect {effect.name!r} stands twice; allowed: each effect once")
        names.add(effect.name)
        for state, _ in effect.states:
            if state in owners:
                raise InputError(
                    f"{where}: state {state!r} stands in {owners[state]} and {effect.name}; allowed: a name of its own for each state"
                )
            owners[state] = effect.name
