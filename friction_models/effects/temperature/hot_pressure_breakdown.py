"""Breakdown of the lubricant by temperature and pressure together."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter


class HotPressureBreakdown(Effect):
    """The film fails where temperature and pressure are high together, ``delta_k / (1 + exp(-(s/s_k - 1)/w))``.

    ``s = sigma_n exp(gamma (T - 20))``: the hotter the film, the less pressure it bears.

    Examples
    --------
    A film that bears 1000 MPa at 20 degC and half as much at 120 degC; half of `delta_k` acts at either limit:

    >>> import numpy as np
    >>> from friction_models.effects import HotPressureBreakdown
    >>> effect = HotPressureBreakdown(s_k=1000.0, gamma=np.log(2.0) / 100.0, w=0.1)
    >>> effect.at(T=[20, 120, 20], sigma_n=[1000, 500, 400]).round(3).tolist()
    [[0.5], [0.5], [0.002]]
    """

    name = "hot_pressure_breakdown"
    title = "the lubricant fails under temperature and pressure together"
    label = "Breakdown by temperature and pressure"
    sentence = "friction rises where the contact is hot and the pressure high at the same time, as the film no longer bears the load"
    equation = "mu += delta_k / (1 + exp(-(sigma_n exp(gamma (T - 20))/s_k - 1)/w))"
    latex = r"\mu \mathrel{+}= \frac{\Delta\mu_k}{1+\exp\left[-\left(\sigma_n e^{\gamma(T-20)}/s_k-1\right)/w\right]}"
    citation = "film strength falls with temperature: Blok, Proc. Instn. Mech. Engrs. 2 (1937); Hu, Wang, Politis et al., Friction 10 (2022)"
    where_it_shows = "hot contacts under high pressure, and neither alone"
    driver = ("T", "sigma_n")
    needs = ("T", "sigma_n")
    amplitudes = (Amplitude("delta_k", "1", "dry friction above the lubricated one", 1, 0.06),)
    shapes = (
        ShapeParameter(
            "s_k",
            "MPa",
            "pressure that the film bears at 20 degC",
            1e-9,
            1e6,
            2000.0,
            follows="sigma_n_hot",
            span=(2.0, 1.0),
        ),
        ShapeParameter(
            "gamma",
            "1/K",
            "loss of strength with temperature",
            0.0005,
            0.05,
            0.004,
            values=(0.002, 0.005, 0.012),
        ),
        ShapeParameter("w", "1", "width of the transition", 0.02, 1.0, 0.15, values=(0.08, 0.2)),
    )

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        strained = L.sigma_n * x.exp(p["gamma"] * (L.T - 20.0))
        return (x.sigmoid((strained / p["s_k"] - 1.0) / p["w"]),)
