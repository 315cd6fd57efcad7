"""Pressure power law: friction falls with a power of the pressure (adhesion + ploughing at q = 1)."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter


class PressurePower(Effect):
    """Power law ``c_p * (sigma_n/s_0)^-q``; ``q = 1`` is adhesion + ploughing (Bowden-Tabor).

    Examples
    --------
    With q = 1 a tenth of the pressure (and s_0/100 more) means nearly ten times the friction, 1 / 0.11:

    >>> from friction_models.effects import PressurePower
    >>> PressurePower(s_0=1000.0, q=1.0).at(sigma_n=[100, 990]).round(3).tolist()
    [[9.091], [1.0]]
    """

    name = "pressure_power"
    title = "power law of pressure, or adhesion + ploughing"
    label = "Pressure dependence"
    sentence = "friction falls as pressure rises, because adhesion grows less than pressure"
    equation = "mu += c_p * ((sigma_n + s_0/100)/s_0)^-q"
    latex = r"\mu \mathrel{+}= c_p\left(\frac{\sigma_n+s_0/100}{s_0}\right)^{-q}"
    citation = "Bowden, Tabor: The Friction and Lubrication of Solids (1950); Filzek, Ludwig, Groche: pressure-dependent friction, Tribol. Schmierungstech. (2011)"
    where_it_shows = (
        "low contact pressure: straight in log(mu) against log(sigma_n), or in mu against 1/sigma_n"
    )
    driver = ("sigma_n",)
    amplitudes = (Amplitude("c_p", "1", "pressure-dependent friction at s_0", 1, 0.03),)
    shapes = (
        ShapeParameter("s_0", "MPa", "reference pressure", 1e-9, 1e5, 1000.0, follows="sigma_n", points=1),
        ShapeParameter("q", "1", "exponent", 0.05, 1.5, 0.5, values=(0.1, 0.3, 0.5, 0.75, 1.0)),
    )

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        return (x.power(L.sigma_n / p["s_0"] + 0.01, -p["q"]),)
