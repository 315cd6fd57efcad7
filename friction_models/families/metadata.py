"""Loads and metadata of tests that effects need: what is missing, labels of texts, and system variables."""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from ..common import InputError, nearest, shown
from ..common.wording import listed
from ..effects.base import Effect
from ..loads import FloatArray, TriboLoads
from ..models.variables import SystemVariable


def check_loads(loads: TriboLoads, effects: Sequence[Effect]) -> None:
    """Refuse an effect of loads that were not measured."""
    for effect in effects:
        absent = effect.lacking(loads.absent)
        if absent:
            raise InputError(
                f"effect {effect.name!r} needs {listed(absent)}, which the data lack; allowed: effects of the loads that "
                "were measured"
            )
        if effect.needs_state and loads.t is None and {"sd", "v_rel"} & set(loads.absent):
            raise InputError(
                f"effect {effect.name!r} needs the time t, or distance and speed, which the data lack"
            )


def levels_of(loads: TriboLoads, effects: Sequence[Effect]) -> dict[str, list[str]]:
    """Return the labels of metadata that is not numeric; raise where metadata that an effect needs is missing."""
    levels: dict[str, list[str]] = {}
    for effect in effects:
        for name in effect.metadata:
            values = loads.context_column(name)
            if values is None:
                raise InputError(
                    f"effect {effect.name!r} needs the column {name!r} in the table of tests; {_columns(loads, name)}"
                )
            if bool(pd.isna(values).any()):
                row = int(np.argmax(pd.isna(values)))
                raise InputError(
                    f"effect {effect.name!r}: column {name!r} has no value for the test of row {row}; allowed: one a test"
                )
            if pd.to_numeric(pd.Series(values), errors="coerce").isna().any():
                levels[name] = sorted({str(v) for v in values})
                _check_labels(levels[name], effect, name)
    return levels


def _check_labels(labels: Sequence[str], effect: Effect, name: str) -> None:
    """Refuse labels that cannot stand in a line of a card, nor in the XML of an FMU; blanks of all kinds can."""
    for label in labels:
        bad = next((c for c in label if not c.isprintable() and unicodedata.category(c) != "Zs"), None)
        if bad is not None:
            raise InputError(
                f"effect {effect.name!r}: column {name!r} holds {shown(ascii(label), 60)} with the character U+{ord(bad):04X}; "
                "allowed: a text of one line without control characters"
            )


def _columns(loads: TriboLoads, name: str) -> str:
    """Return which columns the table of tests has, and the one that is nearest to `name`."""
    if loads.context is None or not len(loads.context.columns):
        return "allowed: give tests with it"
    names = sorted(map(str, loads.context.columns))
    hint = nearest(name, names)
    guess = f"; did you mean {hint!r}?" if hint else ""
    return f"allowed: give tests with it; this one has {', '.join(names)}{guess}"


def system_variables_of(
    loads: TriboLoads,
    metadata: Mapping[str, FloatArray],
    effects: Sequence[Effect],
    levels: Mapping[str, Sequence[str]],
) -> list[SystemVariable]:
    units = {m: u for e in effects for m, u in zip(e.metadata, e.metadata_units, strict=True)}
    tests = np.array([s.start for s in loads.segments()])
    found = []
    for name, unit in units.items():
        values = metadata[name][tests, 0]
        labels = tuple(levels.get(name, ()))
        # Between two labels there is nothing: where the metadata lacks one, the commonest is taken.
        start = np.bincount(values.astype(int)).argmax() if labels else np.median(values)
        found.append(
            SystemVariable(name, unit, float(start), float(values.min()), float(values.max()), labels)
        )
    return found
