"""Thermal softening: the lubricant film shears more easily when warm."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter

#: From here on a film softens, or from the lowest temperature of the tests on where that is lower, or far higher [degC].
ROOM = 20.0


class ThermalSoftening(Effect):
    """Extra friction of the cold film that fades with temperature, ``delta_T * exp(-((T - T_0)/T_s)^n)``.

    `T_0` is 20 degC, or the lowest temperature of the tests where that is lower, or higher by half of the range of their temperatures.

    Examples
    --------
    What is left of `delta_T` at 20, 70 and 120 degC, with T_s = 50 K: 1, 1/e, 1/e^2.

    >>> from friction_models.effects import ThermalSoftening
    >>> ThermalSoftening(T_s=50.0, n=1.0).at(T=[20, 70, 120]).round(3).tolist()
    [[1.0], [0.368], [0.135]]
    """

    name = "thermal_softening"
    title = "the lubricant film softens with temperature"
    label = "Thermal softening"
    sentence = "friction falls as the contact warms up and the lubricant film softens"
    equation = "mu += delta_T * exp(-(max(T - T_0, 0)/T_s)^n)"
    latex = r"\mu \mathrel{+}= \Delta\mu_T\,e^{-\left(\max(T-T_0,0)/T_s\right)^n}"
    citation = "Ceron, Bay et al.: friction falls with interface temperature, CIRP Annals (2011); exponential law after Reynolds (1886)"
    where_it_shows = "cold contacts against warm ones, and the heating within a test"
    driver = ("T",)
    amplitudes = (Amplitude("delta_T", "1", "friction of the cold film above the soft one", 1, 0.03),)
    shapes = (
        ShapeParameter(
            "T_s",
            "K",
            "temperature rise over which the film softens",
            5.0,
            2000.0,
            120.0,
            follows="T_rise",
            span=(0.5, 1.5),
            points=12,
        ),
        ShapeParameter("n", "1", "steepness", 1.0, 4.0, 1.0, values=(1.0, 2.0)),
        ShapeParameter(
            "T_0",
            "degC",
            "temperature from which on the film softens",
            -200.0,
            1500.0,
            ROOM,
            follows="T_cold",
            points=1,
            log=False,
            earlier=ROOM,
        ),
    )

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        return (x.exp(-x.power(x.relu(L.T - p["T_0"]) / p["T_s"], p["n"])),)
