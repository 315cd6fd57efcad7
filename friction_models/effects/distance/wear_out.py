"""Wear-out: the film is used up over distance."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter


class WearOut(Effect):
    """Late rise over distance, ``delta_w * (1 - exp(-(sd/s_w)^n))``.

    Examples
    --------
    The share of `delta_w` that acts at 0, at half of s_w and at s_w, with n = 2: 0, 1 - exp(-1/4), 1 - 1/e.

    >>> from friction_models.effects import WearOut
    >>> WearOut(s_w=20.0, n=2.0).at(sd=[0, 10, 20]).round(3).tolist()
    [[0.0], [0.221], [0.632]]
    """

    name = "wear_out"
    title = "the film wears out over distance"
    label = "Film wear"
    sentence = "friction rises late in long tests, as sliding wears the lubricant film out"
    equation = "mu += delta_w * (1 - exp(-(sd/s_w)^n))"
    latex = r"\mu \mathrel{+}= \Delta\mu_w\left(1-e^{-(s_d/s_w)^n}\right)"
    citation = "exhaustion of a lubricant film over sliding distance; stretched (Weibull) form of a lifetime"
    where_it_shows = "end of long tests: flat, then rising"
    driver = ("sd",)
    amplitudes = (Amplitude("delta_w", "1", "friction of the worn film above the fresh one", 1, 0.04),)
    shapes = (
        ShapeParameter(
            "s_w", "mm", "life of the film", 1e-6, 1e9, 35.0, follows="distance", span=(200.0, 2.0)
        ),
        ShapeParameter("n", "1", "steepness", 1.5, 8.0, 3.0, values=(2.0, 4.0, 7.0)),
    )

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        return (1.0 - x.exp(-x.power(L.sd / p["s_w"], p["n"])),)
