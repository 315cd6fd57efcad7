"""Flash temperature: asperities heat beyond the contact temperature and soften."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter


class FlashTemperature(Effect):
    """Extra friction of asperities that stay cold, ``delta_f / (1 + (mu sigma_n sqrt(v_rel)/q_c)^n)``.

    ``mu sigma_n sqrt(v_rel)`` is the flash temperature of a fast contact but for material constants; mu is
    the friction coefficient of the whole model, this term included; a model solves for it by damped substitution.

    Examples
    --------
    Half of `delta_f` is gone where mu sigma_n sqrt(v_rel) = 0.1 * 500 * 10 reaches q_c:

    >>> import numpy as np
    >>> from friction_models.effects import EffectContext, FlashTemperature
    >>> context = EffectContext(mu=np.array([[0.1]]))
    >>> FlashTemperature(q_c=500.0, n=2.0).at(context, v_rel=100, sigma_n=500).round(3).tolist()
    [[0.5]]
    """

    name = "flash_temperature"
    title = "local heating beyond the contact temperature"
    label = "Flash temperature"
    sentence = (
        "friction falls where high pressure meets high speed, as the tips of the asperities get "
        "hotter than the contact"
    )
    equation = "mu += delta_f / (1 + (mu sigma_n sqrt(v_rel)/q_c)^n)"
    latex = r"\mu \mathrel{+}= \frac{\Delta\mu_f}{1+\left(\mu\,\sigma_n\sqrt{v_\mathrm{rel}}/q_c\right)^n}"
    citation = "Jaeger: Moving sources of heat and the temperature at sliding contacts (1942); Ashby, Abulawi, Kong, Tribol. Trans. 34 (1991)"
    where_it_shows = "high pressure together with high speed"
    driver = ("v_rel", "sigma_n")
    amplitudes = (Amplitude("delta_f", "1", "friction of cold asperities above hot ones", 1, 0.03),)
    shapes = (
        ShapeParameter(
            "q_c",
            "MPa (mm/s)^0.5",
            "heating at which half of the effect is gone",
            1e-12,
            1e6,
            500.0,
            follows="flash",
            span=(0.5, 1.0),
        ),
        ShapeParameter("n", "1", "steepness", 0.5, 6.0, 1.0, values=(1.0, 2.0, 4.0)),
    )
    needs_mu = True

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        heating = x.relu(context.mu) * L.sigma_n * x.sqrt(L.v_rel)
        return (1.0 / (1.0 + x.power(heating / p["q_c"] + 1e-9, p["n"])),)
