"""Running-in: friction changes at the beginning of sliding."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter


class RunningIn(Effect):
    """Exponential approach to the steady level, ``delta_r * exp(-sd/s_r)``; rises or falls.

    Examples
    --------
    What is left of `delta_r` at first and after 3 and 6 mm, with s_r = 3 mm: 1, 1/e, 1/e^2.

    >>> from friction_models.effects import RunningIn
    >>> RunningIn(s_r=3.0).at(sd=[0, 3, 6]).round(3).tolist()
    [[1.0], [0.368], [0.135]]
    """

    name = "running_in"
    title = "running-in at the beginning of sliding"
    label = "Running-in"
    sentence = (
        "friction changes over the first part of the sliding distance, as the surfaces adapt to each other"
    )
    equation = "mu += delta_r * exp(-sd/s_r)"
    latex = r"\mu \mathrel{+}= \Delta\mu_r\,e^{-s_d/s_r}"
    citation = "Blau: A model for run-in and other transitions in sliding friction, J. Tribol. 109 (1987)"
    where_it_shows = "beginning of every test; invisible in averages"
    driver = ("sd",)
    amplitudes = (Amplitude("delta_r", "1", "friction of the first contact above the run-in one", 0, 0.02),)
    shapes = (
        ShapeParameter(
            "s_r", "mm", "running-in distance", 1e-6, 1e9, 3.0, follows="distance", span=(20.0, 0.27)
        ),
    )

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        return (x.exp(-L.sd / p["s_r"]),)
