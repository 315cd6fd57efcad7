"""Surface expansion: the lubricant film thins as the workpiece surface grows."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter


class SurfaceExpansion(Effect):
    """Saturating rise with the grown surface, ``delta_psi * (1 - exp(-((psi - 1)/psi_c)^n))``.

    With `n` = 1 the film thins from the beginning; the larger `n`, the longer it holds before it tears.

    Examples
    --------
    Nothing of `delta_psi` acts on the old surface, 1 - 1/e where it has grown by psi_c, all of it later:

    >>> from friction_models.effects import SurfaceExpansion
    >>> SurfaceExpansion(psi_c=0.5).at(psi=[1, 1.5, 50]).round(3).tolist()
    [[0.0], [0.632], [1.0]]
    """

    name = "surface_expansion"
    title = "the lubricant film thins as the surface grows"
    label = "Surface expansion"
    sentence = "friction rises as the surface of the workpiece grows and stretches the lubricant film"
    equation = "mu += delta_psi * (1 - exp(-(max(psi - 1, 0)/psi_c)^n))"
    latex = r"\mu \mathrel{+}= \Delta\mu_\psi\left(1-e^{-(\max(\psi-1,0)/\psi_c)^n}\right)"
    citation = "film thickness h = h_0/psi as the governing quantity: Groche et al., Friction (2018); stretched (Weibull) form of a lifetime"
    where_it_shows = "small against moderate surface expansion; nothing at psi = 1"
    driver = ("psi",)
    amplitudes = (Amplitude("delta_psi", "1", "friction of the thin film above the thick one", 1, 0.04),)
    shapes = (
        ShapeParameter(
            "psi_c",
            "1",
            "expansion over which the film thins",
            1e-3,
            100.0,
            0.5,
            follows="psi_rise",
            span=(1.5, 1.5),
            points=13,
        ),
        ShapeParameter("n", "1", "steepness", 1.0, 3.0, 1.0, values=(1.0, 2.0), earlier=1.0),
    )

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        return (1.0 - x.exp(-x.power(x.relu(L.psi - 1.0) / p["psi_c"], p["n"])),)
