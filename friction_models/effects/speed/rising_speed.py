"""Rising speed law: friction grows with the logarithm or a power of the speed."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter


class RisingSpeed(Effect):
    """Velocity strengthening, ``k_r * ((1 + v_rel/v_1)^n - 1)/n``; towards n = 0 it is ``k_r * ln(1 + v_rel/v_1)``.

    Examples
    --------
    With n = 0.5 and v_1 = 10 mm/s, at rest and at 30 mm/s: 0 and 2 (sqrt(4) - 1):

    >>> from friction_models.effects import RisingSpeed
    >>> RisingSpeed(v_1=10.0, n=0.5).at(v_rel=[0, 30]).round(3).tolist()
    [[0.0], [2.0]]
    """

    name = "rising_speed"
    title = "friction rises with the logarithm or a power of speed"
    label = "Rising speed law"
    sentence = "friction rises with speed, the less the faster the contact slides already"
    equation = "mu += k_r * ((1 + v_rel/v_1)^n - 1)/n"
    latex = r"\mu \mathrel{+}= k_r\,\frac{(1+v_\mathrm{rel}/v_1)^n-1}{n}"
    citation = "thermally activated shear, Eyring, J. Chem. Phys. 4 (1936); Briscoe, Evans, Proc. R. Soc. Lond. A 380 (1982)"
    where_it_shows = "over decades of speed: straight in mu against log(v_rel), or in log against log"
    driver = ("v_rel",)
    amplitudes = (Amplitude("k_r", "1", "rise per e-fold of the speed (n = 0)", 1, 0.005),)
    shapes = (
        ShapeParameter(
            "v_1",
            "mm/s",
            "speed from which on the law bends",
            1e-9,
            1e5,
            10.0,
            follows="v_rel",
            span=(0.1, 0.3),
            points=5,
        ),
        ShapeParameter("n", "1", "exponent", 0.02, 0.9, 0.1, values=(0.02, 0.3, 0.6)),
    )

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        return ((x.power(1.0 + L.v_rel / p["v_1"], p["n"]) - 1.0) / p["n"],)
