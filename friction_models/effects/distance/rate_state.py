"""Rate and state friction: the contact remembers its age; has memory."""

from __future__ import annotations

from typing import Any

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter


class RateState(Effect):
    """Dieterich law ``a ln(v/v_0) + b ln(v_0 age/D_c)`` with ``d(age)/dt = 1 - v_rel age/D_c``.

    Examples
    --------
    At rest the contact ages by one second a second; while it slides its age settles at D_c / v_rel, here 1/100 s:

    >>> import numpy as np
    >>> from friction_models.effects import EffectContext, RateState
    >>> from friction_models.expressions.ops import NumpyOps
    >>> one = np.ones((1, 1))
    >>> p, context = {"v_0": 1.0, "D_c": 1.0, "age_0": 2.0}, EffectContext(state={"age": 2 * one})
    >>> rest = LoadColumns(0 * one, 20 * one, 500 * one, 0 * one, one)
    >>> RateState().advance(NumpyOps(), rest, p, context, dt=3.0)[0].round(6).tolist()
    [[5.0]]
    >>> slip = LoadColumns(100 * one, 20 * one, 500 * one, 0 * one, one)
    >>> RateState().advance(NumpyOps(), slip, p, context, dt=3.0)[0].round(6).tolist()
    [[0.01]]
    """

    name = "rate_state"
    title = "memory of the contact (rate and state)"
    label = "Memory of the contact"
    sentence = (
        "after a change of speed, which can make it jump, friction settles over a short sliding distance "
        "as the contacts renew themselves"
    )
    equation = "mu += a ln((v_rel + v_0/10)/v_0) + b ln(v_0 age/D_c),  d(age)/dt = 1 - v_rel age/D_c"
    latex = (
        r"\mu \mathrel{+}= a\ln\frac{v_\mathrm{rel}+v_0/10}{v_0}+b\ln\frac{v_0\theta}{D_c},"
        r"\quad \dot\theta=1-\frac{v_\mathrm{rel}\theta}{D_c}"
    )
    citation = "Dieterich: Modeling of rock friction, J. Geophys. Res. 84 (1979); Marone, Annu. Rev. Earth Planet. Sci. 26 (1998)"
    where_it_shows = (
        "after every change of speed: a jump that decays over a fixed distance; first contact after rest"
    )
    driver = ("v_rel", "sd")
    needs = ("v_rel",)
    amplitudes = (
        Amplitude("a", "1", "direct effect of speed", 1, 0.004),
        Amplitude("b", "1", "effect of the age of the contact (below 0 in some clays)", 0, 0.006),
    )
    shapes = (
        ShapeParameter("v_0", "mm/s", "reference speed", 1e-9, 1e5, 5.0, follows="v_rel_low", points=1),
        ShapeParameter(
            "D_c",
            "mm",
            "distance over which the contact renews itself",
            1e-9,
            1e9,
            1.0,
            follows="distance",
            span=(5.0, 0.2),
        ),
        ShapeParameter(
            "age_0",
            "s",
            "age of the contact at the start of a test",
            1e-9,
            1e12,
            1.0,
            follows="duration",
            span=(0.01, 100.0),
            points=3,
        ),
    )
    states = (("age", "s"),)

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        direct = x.log(L.v_rel / p["v_0"] + 0.1)
        return (direct, x.log(p["v_0"] / p["D_c"] * x.maximum(context.state["age"], 1e-12)))

    def start_state(self, p: Parameters) -> tuple[Any, ...]:
        return (p["age_0"],)

    def rate(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        return (1.0 - L.v_rel * context.state["age"] / p["D_c"],)

    def linear_step(
        self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext, dt: Value
    ) -> tuple[Value, ...]:
        # exact for constant speed; (1 - exp(-a))/a is replaced by its limit where the contact rests
        a = L.v_rel * dt / p["D_c"]
        safe = x.maximum(a, 1e-6)
        growth = x.where(a > 1e-6, (1.0 - x.exp(-safe)) / safe, 1.0 - 0.5 * a)
        return (x.exp(-a), dt * growth)
