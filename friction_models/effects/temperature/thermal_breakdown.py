"""Thermal breakdown: the lubricant fails above a temperature."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter


class ThermalBreakdown(Effect):
    """Step from lubricated to dry friction at ``T_b``, ``delta_b / (1 + exp(-(T - T_b)/w))``.

    Examples
    --------
    Half of `delta_b` acts at the breakdown temperature, next to nothing far below it:

    >>> from friction_models.effects import ThermalBreakdown
    >>> ThermalBreakdown(T_b=250.0, w=20.0).at(T=[50, 250, 450]).round(3).tolist()
    [[0.0], [0.5], [1.0]]
    """

    name = "thermal_breakdown"
    title = "the lubricant fails above a temperature"
    label = "Thermal breakdown"
    sentence = "friction rises above a temperature at which the lubricant fails"
    equation = "mu += delta_b / (1 + exp(-(T - T_b)/w))"
    latex = r"\mu \mathrel{+}= \frac{\Delta\mu_b}{1+e^{-(T-T_b)/w}}"
    citation = "mixture law mu = beta mu_dry + (1 - beta) mu_wet of the interactive friction model, Hu, Wang, Politis et al., Friction 10 (2022)"
    where_it_shows = "hot contacts only: flat below the threshold, then a rise"
    driver = ("T",)
    amplitudes = (Amplitude("delta_b", "1", "dry friction above the lubricated one", 1, 0.08),)
    shapes = (
        ShapeParameter(
            "T_b",
            "degC",
            "breakdown temperature",
            -200.0,
            1200.0,
            250.0,
            follows="T",
            span=(2.0, 1.02),
            points=16,
            log=False,
        ),
        ShapeParameter("w", "K", "width of the transition", 2.0, 200.0, 20.0, values=(8.0, 18.0, 40.0)),
    )

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        return (x.sigmoid((L.T - p["T_b"]) / p["w"]),)
