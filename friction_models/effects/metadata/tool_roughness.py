"""Tool roughness: a system variable, constant within a test."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude


class ToolRoughness(Effect):
    """Ploughing by tool asperities, ``c_Ra * Ra``.

    Examples
    --------
    >>> import numpy as np
    >>> from friction_models.effects import EffectContext, ToolRoughness
    >>> tools = EffectContext(system={"Ra": np.array([[0.25], [0.5]])})
    >>> ToolRoughness().at(tools).tolist()
    [[0.25], [0.5]]
    """

    name = "tool_roughness"
    title = "roughness of the tool"
    label = "Tool roughness"
    sentence = "friction is higher with rougher tools"
    equation = "mu += c_Ra * Ra"
    latex = r"\mu \mathrel{+}= c_{Ra}\,R_a"
    citation = "Challen, Oxley: An explanation of the different regimes of friction and wear using asperity deformation models, Wear 53 (1979)"
    where_it_shows = "a constant offset of all tests run with one tool"
    driver = ("Ra",)
    amplitudes = (Amplitude("c_Ra", "1/um", "friction per micrometre of roughness", 1, 0.1),)
    kind = "system"
    metadata = ("Ra",)
    metadata_units = ("um",)

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        return (context.system["Ra"] + 0.0 * L.sd,)
