"""Force zero: an offset of the force sensor; a fault of the data."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter


class ForceZero(Effect):
    """Offset of the measured friction force, ``k_F * s_0/sigma_n``; corrects data, is never exported.

    Examples
    --------
    An offset of the force counts twice as much at half the pressure (s_0/100 added):

    >>> from friction_models.effects import ForceZero
    >>> ForceZero(s_0=1000.0).at(sigma_n=[490, 990]).round(6).tolist()
    [[2.0], [1.0]]
    """

    name = "force_zero"
    title = "the friction force has an offset"
    label = "Zero of the friction force"
    sentence = "the friction force is read with a constant offset, which counts most at low pressure"
    equation = "measured mu += k_F * s_0/(sigma_n + s_0/100)"
    latex = r"\mu_\mathrm{meas} \mathrel{+}= k_F\,\frac{s_0}{\sigma_n+s_0/100}"
    citation = "GUM (JCGM 100:2008), systematic effects of an instrument"
    where_it_shows = "as 1/sigma_n: strongest at low pressure; an unloaded reading shows it directly"
    driver = ("sigma_n",)
    amplitudes = (Amplitude("k_F", "1", "apparent friction at s_0", 0, 0.01),)
    shapes = (
        ShapeParameter("s_0", "MPa", "reference pressure", 1e-9, 1e5, 1000.0, follows="sigma_n", points=1),
    )
    kind = "fault"

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        return (1.0 / (L.sigma_n / p["s_0"] + 0.01),)
