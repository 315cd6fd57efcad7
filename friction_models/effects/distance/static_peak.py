"""Static peak: break-away friction at the very start of sliding."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter


class StaticPeak(Effect):
    """Break-away peak, ``delta_0 * exp(-(sd/s_0)^2)``, over the first tenths of a millimetre.

    Examples
    --------
    What is left of `delta_0` at first, after s_0 and after ten times s_0:

    >>> from friction_models.effects import StaticPeak
    >>> StaticPeak(s_0=0.5).at(sd=[0, 0.5, 5]).round(3).tolist()
    [[1.0], [0.368], [0.0]]
    """

    name = "static_peak"
    title = "break-away peak"
    label = "Break-away peak"
    sentence = "friction peaks in the first moment of a test, before the contact slides freely"
    equation = "mu += delta_0 * exp(-(sd/s_0)^2)"
    latex = r"\mu \mathrel{+}= \Delta\mu_0\,e^{-(s_d/s_0)^2}"
    citation = (
        "Rabinowicz: The nature of the static and kinetic coefficients of friction, J. Appl. Phys. 22 (1951)"
    )
    where_it_shows = "first points of every test"
    driver = ("sd",)
    amplitudes = (Amplitude("delta_0", "1", "static friction above the sliding one", 1, 0.03),)
    shapes = (
        ShapeParameter(
            "s_0",
            "mm",
            "distance of break-away",
            1e-6,
            1e9,
            0.4,
            follows="distance",
            span=(3.0, 0.02),
            points=5,
        ),
    )

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        ratio = L.sd / p["s_0"]
        return (x.exp(-ratio * ratio),)
