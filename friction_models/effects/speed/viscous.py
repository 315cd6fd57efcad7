"""Viscous share of mixed lubrication: friction rises with speed (divided by pressure: Hersey number) and falls when hot.

Viscosity depends on temperature only; no effect of the catalogue lets it rise with pressure (Barus).
"""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter

T_REF = 20.0  # degC


class Viscous(Effect):
    """``k_v * (eta(T) * v_rel/v_0 * (2 s_0/(sigma_n + s_0))^m)^q``: near a Hersey number, but finite without pressure.

    Viscosity falls exponentially with temperature; m = 0 leaves the pressure out.

    Examples
    --------
    Without pressure and temperature (m = 0, beta = 0) and with q = 1 the share is the speed over v_0:

    >>> from friction_models.effects import Viscous
    >>> effect = Viscous(v_0=100.0, s_0=1000.0, beta=0.0, q=1.0, m=0.0)
    >>> effect.at(v_rel=[0, 50, 100]).round(3).tolist()
    [[0.0], [0.5], [1.0]]
    """

    name = "viscous"
    title = "viscous share of the lubricant film"
    label = "Viscous friction"
    sentence = "friction rises with speed, as the film of lubricant resists shearing"
    equation = "mu += k_v * (exp(-beta (T - 20)) * v_rel/v_0 * (2 s_0/(sigma_n + s_0))^m)^q"
    latex = (
        r"\mu \mathrel{+}= k_v\left(e^{-\beta(T-20)}\,\frac{v_\mathrm{rel}}{v_0}"
        r"\left(\frac{2 s_0}{\sigma_n+s_0}\right)^m\right)^q"
    )
    citation = "Hersey: The laws of lubrication of horizontal journal bearings (1914); viscosity-temperature law after Reynolds (1886)"
    where_it_shows = "high speed while the contact is still cold"
    driver = ("v_rel", "T", "sigma_n")
    needs = ("v_rel",)
    amplitudes = (Amplitude("k_v", "1", "viscous friction at v_0, s_0 and 20 degC", 1, 0.02),)
    shapes = (
        ShapeParameter("v_0", "mm/s", "reference speed", 1e-9, 1e5, 500.0, follows="v_rel", points=1),
        ShapeParameter("s_0", "MPa", "reference pressure", 1e-9, 1e5, 1000.0, follows="sigma_n", points=1),
        ShapeParameter(
            "beta",
            "1/K",
            "decay of viscosity with temperature",
            0.0,
            0.1,
            0.01,
            values=(0.004, 0.008, 0.015, 0.03),
        ),
        ShapeParameter("q", "1", "exponent of the Hersey number", 0.2, 1.0, 1.0, values=(0.3, 0.6, 1.0)),
        ShapeParameter("m", "1", "share of the pressure", 0.0, 1.0, 1.0, values=(0.0, 1.0)),
    )

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        speed = L.v_rel / p["v_0"] + 1e-6
        pressure = x.power((L.sigma_n + p["s_0"]) / (2.0 * p["s_0"]), -p["m"] * p["q"])
        return (x.power(speed, p["q"]) * pressure * x.exp(-p["beta"] * p["q"] * (L.T - T_REF)),)
