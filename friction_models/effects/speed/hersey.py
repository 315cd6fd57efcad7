"""Stribeck curve over the Hersey number: friction falls as viscosity times speed over pressure rises.

Viscosity depends on temperature only, by the law of `viscous.py`.
"""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter

T_REF = 20.0  # degC


class Hersey(Effect):
    """Asperities share the load less, the higher the Hersey number: ``delta_h * exp(-(H/h_0)^d)``.

    ``H = exp(-beta (T - 20)) v_rel / sigma_n``, the Hersey number over the viscosity at 20 degC [mm/s/MPa].

    Examples
    --------
    Twice the speed under twice the pressure is the same; at H = h_0, 1/e is left:

    >>> from friction_models.effects import Hersey
    >>> Hersey(h_0=0.1, beta=0.0, d=1.0).at(v_rel=[0, 50, 100], sigma_n=[500, 500, 1000]).round(3).tolist()
    [[1.0], [0.368], [0.368]]
    """

    name = "hersey"
    title = "Stribeck curve over viscosity times speed over pressure"
    label = "Hersey law"
    sentence = (
        "friction falls where speed is high for the pressure, as the lubricant film carries more of the load"
    )
    equation = "mu += delta_h * exp(-(exp(-beta (T - 20)) * v_rel/(sigma_n h_0))^d)"
    latex = r"\mu \mathrel{+}= \Delta\mu_h\,\exp\left[-\left(e^{-\beta(T-20)}\,\frac{v_\mathrm{rel}}{\sigma_n h_0}\right)^d\right]"
    citation = (
        "Hersey: The laws of lubrication of horizontal journal bearings (1914); Stribeck, VDI-Z. 46 (1902)"
    )
    where_it_shows = "speed and pressure varied apart: one curve in mu against v_rel/sigma_n"
    driver = ("v_rel", "sigma_n", "T")
    needs = ("v_rel", "sigma_n")
    amplitudes = (Amplitude("delta_h", "1", "friction without film above the full film", 1, 0.03),)
    shapes = (
        ShapeParameter(
            "h_0", "mm/s/MPa", "number at which the film carries most", 1e-12, 1e9, 0.1, follows="hersey"
        ),
        ShapeParameter(
            "beta", "1/K", "decay of viscosity with temperature", 0.0, 0.1, 0.01, values=(0.0, 0.01, 0.03)
        ),
        ShapeParameter("d", "1", "steepness", 0.3, 2.0, 1.0, values=(0.5, 1.0)),
    )

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        number = L.v_rel / (x.relu(L.sigma_n) + 1e-9) / p["h_0"] * x.exp(-p["beta"] * (L.T - T_REF))
        return (x.exp(-x.power(number + 1e-9, p["d"])),)
