"""Batch of the lubricant: a system variable, constant within a test."""

from __future__ import annotations

import numpy as np

from ...expressions.ops import LoadColumns, Ops, Value
from ...loads import FloatArray
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter, Spans

#: Batches that are tried.
MOST = 60


class Batch(Effect):
    """Offset of one batch against all others, ``c_b`` where ``batch`` equals ``deviating``.

    Batches that are named by text are numbered in alphabetical order, from 0; the labels stand with the
    system variable in the exported file, so that tables of tests keep their texts.

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
    title = "one batch of the lubricant differs"
    label = "Batch of the lubricant"
    sentence = "tests with one batch of the lubricant lie above or below the others by the same amount"
    equation = "mu += c_b where batch = deviating, else 0"
    latex = r"\mu \mathrel{+}= c_b\,[\mathrm{batch}=\mathrm{deviating}]"
    citation = "blocking, Box, Hunter, Hunter: Statistics for Experimenters (2005)"
    where_it_shows = "a constant offset of all tests run with one batch"
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

    def grids(self, spans: Spans) -> dict[str, FloatArray]:
        """Return every batch of the data: each may be the one that deviates."""
        known = np.unique(spans.get("batch", (self.start_shape()["deviating"],)))[:MOST]
        return {"deviating": np.array([self.fixed["deviating"]]) if self.fixed else known}

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        distance = x.abs(context.system["batch"] + 0.0 * L.sd - p["deviating"])
        return (x.relu(1.0 - distance),)
