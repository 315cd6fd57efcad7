"""Twin heating: the contact temperature of the twin rises too much or too little; a fault of the data."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude


class TwinHeating(Effect):
    """Error in proportion to the computed rise of temperature, ``k_h * (T - T_tool)/100``; never exported.

    Examples
    --------
    The share of `k_h` at the temperature of the tool and 100 K above it:

    >>> import numpy as np
    >>> from friction_models.effects import EffectContext, TwinHeating
    >>> tool = EffectContext(system={"T_tool": np.array([[20.0]])})
    >>> TwinHeating().at(tool, T=[20, 120]).tolist()
    [[0.0], [1.0]]
    """

    name = "twin_heating"
    title = "the twin heats the contact too much or too little"
    label = "Heating in the twin"
    sentence = (
        "the twin of the test heats the contact too much or too little, which shows in friction "
        "as the contact warms up"
    )
    equation = "measured mu += k_h * (T - T_tool)/100"
    latex = r"\mu_\mathrm{meas} \mathrel{+}= k_h\,(T-T_\mathrm{tool})/100"
    citation = "heat transfer coefficient and heat partition of the twin are uncertain: first-order error of a temperature-dependent law"
    where_it_shows = "in proportion to T - T_tool"
    driver = ("T",)
    amplitudes = (Amplitude("k_h", "1", "error at 100 K above the tool", 0, 0.01),)
    kind = "fault"
    metadata = ("T_tool",)
    metadata_units = ("degC",)

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        return ((L.T - context.system["T_tool"]) / 100.0,)
