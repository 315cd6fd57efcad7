"""Batch of the lubricant: a system variable, constant within a test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, ClassVar

import numpy as np

from ...expressions.ops import LoadColumns, Ops, Value
from ...loads import FloatArray
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter, Spans
from .levels import MOST, at_level, at_levels, with_offsets


class Batch(Effect):
    """Offset of one batch against all others, ``c_b`` where ``batch`` equals ``deviating``.

    Batches that are named by text are numbered in alphabetical order, from 0; the labels stand with the
    system variable in the exported file, so that tables of tests keep their texts.

    The search for effects asks for one batch that deviates. A fit (`with_levels`) to more than two batches that are named by text
    gives each an offset of its own, drawn towards zero by the scatter within batches over that between them.

    Examples
    --------
    Three batches, of which number 1 deviates:

    >>> import numpy as np
    >>> from friction_models.effects import Batch, EffectContext
    >>> batches = EffectContext(system={"batch": np.array([[0.0], [1.0], [2.0]])})
    >>> Batch(deviating=1.0).at(batches).tolist()
    [[0.0], [1.0], [0.0]]
    """

    name = "batch"
    title = "batches of the lubricant differ"
    label = "Batch of the lubricant"
    sentence = "tests with one batch of the lubricant lie above or below those with others by the same amount"
    equation = "mu += c_b where batch = deviating, else 0"
    latex = r"\mu \mathrel{+}= c_b\,[\mathrm{batch}=\mathrm{deviating}]"
    citation = "blocking, Box, Hunter, Hunter: Statistics for Experimenters (2005)"
    where_it_shows = "a constant offset of all tests run with one batch, or one for each batch"
    driver = ("batch",)
    amplitudes = (Amplitude("c_b", "1", "friction of the deviating batch above the others", 0, 0.01),)
    shapes = (
        ShapeParameter(
            "deviating", "1", "number of the deviating batch", 0.0, 1e6, 1.0, follows="batch", points=2
        ),
    )
    kind = "system"
    metadata = ("batch",)
    metadata_units = ("1",)
    #: Names of the batches, where each has an offset.
    labels: ClassVar[tuple[str, ...]] = ()

    def __reduce__(self) -> tuple[Any, ...]:
        return _made, (self.labels, self.fixed)

    def with_levels(self, levels: Mapping[str, Sequence[str]]) -> Effect:
        """Return the effect with an offset for each of several batches; as it is for two, or with a fixed one."""
        labels = tuple(levels.get(self.metadata[0], ()))
        return self if self.fixed or len(labels) <= 2 else _each(labels)()

    def grids(self, spans: Spans) -> dict[str, FloatArray]:
        """Return every batch of the data: each may be the one that deviates; nothing where each has an offset."""
        if self.pooled:
            return {}
        known = np.unique(spans.get("batch", (self.start_shape()["deviating"],)))[:MOST]
        return {"deviating": np.array([self.fixed["deviating"]]) if self.fixed else known}

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        batch = context.system["batch"] + 0.0 * L.sd
        if self.pooled:
            return at_levels(x, batch, len(self.labels))
        return (at_level(x, batch, p["deviating"]),)


@cache
def _each(labels: tuple[str, ...]) -> type[Batch]:
    """Return the effect with an offset for each of several batches; the same class each time."""
    return type(
        "Batch",
        (Batch,),
        {
            "latex": r"\mu \mathrel{+}= c_{b,\mathrm{batch}}",
            "shapes": (),
            "__doc__": Batch.__doc__,
            "__module__": __name__,
        }
        | with_offsets("c_b", Batch.name, labels),
    )


def _made(labels: tuple[str, ...], fixed: Mapping[str, float]) -> Batch:
    return (_each(labels) if labels else Batch)(**fixed)
