"""Stribeck effect: friction falls from boundary to mixed lubrication as speed rises."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter


class Stribeck(Effect):
    """Transition from boundary to mixed lubrication, ``delta_s * exp(-(v_rel/v_s)^d)``.

    Examples
    --------
    What is left of `delta_s` at rest and at 20, 40 mm/s, with v_s = 20 mm/s: 1, 1/e, 1/e^2.

    >>> from friction_models.effects import Stribeck
    >>> Stribeck(v_s=20.0, d=1.0).at(v_rel=[0, 20, 40]).round(3).tolist()
    [[1.0], [0.368], [0.135]]
    """

    name = "stribeck"
    title = "mixed to boundary transition"
    label = "Stribeck effect"
    sentence = "friction falls as speed rises, as the lubricant carries more of the load"
    equation = "mu += delta_s * exp(-(v_rel/v_s)^d)"
    latex = r"\mu \mathrel{+}= \Delta\mu_s\,e^{-(v_\mathrm{rel}/v_s)^d}"
    citation = "Andersson, Söderberg, Björklund: Friction models for sliding dry, boundary and mixed lubricated contacts, Tribol. Int. 40 (2007)"
    where_it_shows = "low against high speed, and the speed ramp at the start of a test"
    driver = ("v_rel",)
    amplitudes = (Amplitude("delta_s", "1", "friction at rest above the mixed level", 1, 0.02),)
    shapes = (
        ShapeParameter(
            "v_s", "mm/s", "Stribeck speed", 1e-9, 1e5, 30.0, follows="v_rel", span=(0.5, 1.2), points=12
        ),
        ShapeParameter("d", "1", "steepness", 0.5, 2.0, 1.0, values=(0.5, 1.0, 2.0)),
    )

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        return (x.exp(-x.power(L.v_rel / p["v_s"], p["d"])),)
