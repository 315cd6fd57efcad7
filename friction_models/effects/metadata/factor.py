"""Any further column of the test table as an effect: ``factor:COLUMN``, of texts or of numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cache
from itertools import combinations
from typing import Any, ClassVar

import numpy as np

from ...common import InputError, shown
from ...expressions.ops import LoadColumns, Ops, Value
from ...loads import FloatArray
from ...loads.contract import POINT_COLUMNS, SETTING_UNITS
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter, Spans
from .levels import MOST, at_level, at_levels, with_offsets

PREFIX = "factor:"
#: Texts of at most so many levels are also split into two groups of several levels.
SPLIT = 5
_LINEAR = "mu += c * ({} - centre)/scale"


class Factor(Effect):
    """Whole tests differ with one column of the test table; `factor_effect` makes the class of a column.

    Texts are levels. `diagnose` looks for one that deviates from all others by ``c``, as a batch does (`Batch`), and among few
    levels (`SPLIT`) for two groups that lie apart by ``c``. A fit (`with_levels`) gives each level an offset of its own, drawn towards zero by the scatter within levels over that between
    them: the more, the fewer tests it has. A level that the training did not hold has the offset 0, the mean of the levels.

    Numbers act linearly, ``c * (value - centre) / scale``: `centre` is the middle of the training range and `scale` half of
    it, so that ``c`` is the change of mu from the middle to the largest value. Beyond the range the line goes on.
    """

    citation = "blocking and covariates, Box, Hunter, Hunter: Statistics for Experimenters (2005)"
    amplitudes = (
        Amplitude(
            "c", "1", "friction of the deviating level, or of the largest number over the middle", 0, 0.01
        ),
    )
    shapes = (
        ShapeParameter("deviating", "1", "number of the deviating level, for texts", 0.0, 1e6, 1.0, points=2),
        ShapeParameter(
            "centre", "1", "middle of the training range, for numbers", -1e12, 1e12, 0.0, points=1
        ),
        ShapeParameter("scale", "1", "half of the training range; 0 for texts", 0.0, 1e12, 0.0, points=1),
    )
    kind = "system"
    #: Labels of the levels, where each has an offset.
    labels: ClassVar[tuple[str, ...]] = ()
    #: Levels that deviate together; the first ones are single levels. None where any level may be fixed.
    groups: ClassVar[tuple[tuple[int, ...], ...]] = ()
    #: What the class was made of.
    declared_by: ClassVar[tuple[Any, ...]]

    def __repr__(self) -> str:
        return f"{super().__repr__()[:-1]}{', ' if self.fixed else ''}column={self.metadata[0]!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return _made, (self.declared_by, self.fixed)

    def with_levels(self, levels: Mapping[str, Sequence[str]]) -> Effect:
        """Return the effect with an offset for each label of its column, or a line for numbers; as it is with fixed shapes."""
        column = self.metadata[0]
        if self.fixed:
            return self
        if column not in levels:
            return scanned_factor(column, [])
        return _declared(column, tuple(levels[column]), "", (), ())()

    def grids(self, spans: Spans) -> dict[str, FloatArray]:
        """Return every level of the data, each may be the one that deviates; or middle and half range of numbers."""
        column = self.metadata[0]
        low, high = spans.get(f"numbers:{column}", (0.0, 0.0))
        values: dict[str, tuple[float, ...]] = {
            "deviating": (0.0,),
            "centre": (0.5 * (low + high),),
            "scale": (0.5 * (high - low) or 1.0,),
        }
        if f"numbers:{column}" not in spans:
            levels = tuple(spans.get(f"levels:{column}", (1.0,)))[:MOST]
            several = tuple(float(k) for k, group in enumerate(self.groups) if len(group) > 1)
            values = {"deviating": levels + several, "centre": (0.0,), "scale": (0.0,)}
        values |= {n: (v,) for n, v in self.fixed.items()}
        return {s.name: np.array(values[s.name]) for s in self.shapes}

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        value = context.system[self.metadata[0]] + 0.0 * L.sd
        if self.pooled:
            return at_levels(x, value, len(self.labels))
        if self.groups:
            parts = [
                at_level(x, value, float(level))
                * sum(at_level(x, p["deviating"], float(k)) for k, g in enumerate(self.groups) if level in g)
                for level in range(max(map(max, self.groups)) + 1)
            ]
            return (sum(parts[1:], start=parts[0]),)
        if np.all(np.asarray(p.get("scale", 0.0)) == 0.0):
            return (at_level(x, value, p["deviating"]),)
        return ((value - p["centre"]) / p["scale"],)


def factor_effect(column: str) -> type[Factor]:
    """Return the effect of a column of the test table; the same class each time.

    Parameters
    ----------
    column : str

    Raises
    ------
    InputError
        No name, or that of a column of points.

    Examples
    --------
    Three operators, of whom number 1 deviates, and a humidity of 30 to 70 %:

    >>> import numpy as np
    >>> from friction_models.effects import EffectContext, factor_effect
    >>> operators = EffectContext(system={"operator": np.array([[0.0], [1.0], [2.0]])})
    >>> factor_effect("operator")(deviating=1.0).at(operators).tolist()
    [[0.0], [1.0], [0.0]]
    >>> days = EffectContext(system={"humidity": np.array([[30.0], [50.0], [70.0]])})
    >>> factor_effect("humidity")(centre=50.0, scale=20.0).at(days).tolist()
    [[-1.0], [0.0], [1.0]]
    """
    if not column.strip() or not column.isprintable() or column in POINT_COLUMNS:
        raise InputError(
            f"effect {PREFIX + column!r}: allowed is {PREFIX}COLUMN, of a column of the test table"
        )
    return _declared(column, (), "", Factor.shapes, ())


def scanned_factor(column: str, labels: Sequence[str]) -> Factor:
    """Return the effect as `diagnose` tries it, for texts with these labels in alphabetical order, or for numbers.

    Examples
    --------
    >>> scanned_factor("operator", ["anna", "bert"]).equation
    'mu += c where operator = deviating (0 = anna, 1 = bert), else 0'
    >>> scanned_factor("oil", ["a", "b", "c", "d"]).groups
    ((0,), (1,), (2,), (3,), (0, 1), (0, 2), (0, 3))
    >>> scanned_factor("humidity", []).equation, scanned_factor("humidity", []).degrees_of_freedom
    ('mu += c * (humidity - centre)/scale', 1)
    """
    if not labels:
        return _declared(column, (), _LINEAR.format(column), Factor.shapes[1:], ())()
    groups = _groups(len(labels))
    names = numbered([" or ".join(labels[k] for k in group) for group in groups])
    equation = f"mu += c where {column} = deviating ({names}), else 0"
    return _declared(column, (), equation, Factor.shapes[:1], groups)()


def _groups(levels: int) -> tuple[tuple[int, ...], ...]:
    """Return each level, and of few levels every further way to set some of them apart from the others."""
    groups: list[tuple[int, ...]] = [(k,) for k in range(levels)]
    for size in range(2, levels // 2 + 1 if levels <= SPLIT else 0):
        # of two halves one is enough
        groups += [g for g in combinations(range(levels), size) if 2 * size < levels or 0 in g]
    return tuple(groups)


def numbered(labels: Sequence[str]) -> str:
    """Return which label is which number.

    Examples
    --------
    >>> numbered(["anna", "bert"])
    '0 = anna, 1 = bert'
    """
    return shown(", ".join(f"{k} = {label}" for k, label in enumerate(labels)))


@cache
def _declared(
    column: str,
    labels: tuple[str, ...],
    equation: str,
    shapes: tuple[ShapeParameter, ...],
    groups: tuple[tuple[int, ...], ...],
) -> type[Factor]:
    words = re.sub(r"[^0-9A-Za-z]+", " ", column).strip() or "column"
    declared: dict[str, Any] = {
        "name": PREFIX + column,
        "title": f"tests differ with {column}",
        "label": f"Factor {column}",
        "sentence": f"the friction of whole tests differs with the column {column} of the test table",
        "equation": equation
        or f"mu += c where {column} = deviating, else 0; of numbers: {_LINEAR.format(column)}",
        "latex": rf"\mu \mathrel{{+}}= c\,f(\mathrm{{{words}}})",
        "where_it_shows": f"an offset of whole tests that goes with {column}",
        "declared_by": (column, labels, equation, shapes, groups),
        "shapes": shapes,
        "groups": groups,
        "driver": (column,),
        "metadata": (column,),
        "metadata_units": (SETTING_UNITS.get(column, "1"),),
        "__doc__": f"Whole tests differ with the column {column} of the test table; see `Factor`.",
        "__module__": __name__,
    }
    if labels:
        declared |= with_offsets("c", column, labels)
    return type("Factor", (Factor,), declared)


def _made(by: tuple[Any, ...], fixed: Mapping[str, float]) -> Factor:
    return _declared(*by)(**fixed)
