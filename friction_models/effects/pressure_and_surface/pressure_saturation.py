"""Pressure saturation: the real contact area stops growing, friction stress meets a ceiling."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter


class PressureSaturation(Effect):
    """Friction stress saturates, ``delta_p * ((1 - exp(-x^n)) / x^n)^(1/n)`` with ``x = sigma_n/s_c``.

    With n = 1 it is Levanov's form; the larger n, the sharper the knee between a constant mu and a constant friction stress, as in the
    curves of Wanheim and Bay (n of 2 to 4) and under a shear limit.

    Examples
    --------
    All of `delta_p` acts at low pressure, at s_c the share 1 - 1/e, far above it a friction stress of `delta_p` s_c:

    >>> from friction_models.effects import PressureSaturation
    >>> PressureSaturation(s_c=800.0, n=1.0).at(sigma_n=[0, 800, 8000]).round(3).tolist()
    [[1.0], [0.632], [0.1]]
    """

    name = "pressure_saturation"
    title = "the real contact area saturates"
    label = "Pressure saturation"
    sentence = "the coefficient falls where pressure is high, as the real contact area saturates and friction rises less than pressure"
    equation = "mu += delta_p * ((1 - exp(-x^n)) / x^n)^(1/n),  x = sigma_n/s_c"
    latex = (
        r"\mu \mathrel{+}= \Delta\mu_p\left(\frac{1-e^{-x^n}}{x^n}\right)^{1/n},\quad x=\frac{\sigma_n}{s_c}"
    )
    citation = "Wanheim, Bay, Petersen: A theoretically determined model for friction in metal working processes, Wear 28 (1974); Levanov (1976)"
    where_it_shows = "high against low contact pressure"
    driver = ("sigma_n",)
    amplitudes = (Amplitude("delta_p", "1", "friction at low pressure above the saturated one", 1, 0.06),)
    shapes = (
        ShapeParameter(
            "s_c",
            "MPa",
            "pressure at which the area saturates",
            1e-9,
            1e5,
            800.0,
            follows="sigma_n",
            span=(0.3, 1.5),
            points=10,
        ),
        ShapeParameter("n", "1", "sharpness of the knee", 1.0, 6.0, 1.0, values=(1.0, 3.0), earlier=1.0),
    )

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        # below 1e-9 the difference to 1 would be lost in rounding
        power = x.maximum(x.power(L.sigma_n / p["s_c"] + 1e-9, p["n"]), 1e-9)
        return (x.power((1.0 - x.exp(-power)) / power, 1.0 / p["n"]),)
