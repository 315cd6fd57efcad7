"""Sensor drift: the measured friction moves with the order in which tests were run; a fault of the data."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude


class SensorDrift(Effect):
    """Linear drift over the campaign, ``k_d * order/100``; corrects data, is never exported.

    Examples
    --------
    The share of `k_d` in the first and in the fiftieth test:

    >>> import numpy as np
    >>> from friction_models.effects import EffectContext, SensorDrift
    >>> tests = EffectContext(system={"order": np.array([[1.0], [50.0]])})
    >>> SensorDrift().at(tests).tolist()
    [[0.01], [0.5]]
    """

    name = "sensor_drift"
    title = "the sensor drifts over the campaign"
    label = "Sensor drift"
    sentence = (
        "measured friction moves from test to test in the order of the campaign, as where a sensor drifts"
    )
    equation = "measured mu += k_d * order/100"
    latex = r"\mu_\mathrm{meas} \mathrel{+}= k_d\,\mathrm{order}/100"
    citation = "GUM (JCGM 100:2008), systematic effects of an instrument"
    where_it_shows = "offset of a test against its place in the order of the campaign"
    driver = ("order",)
    amplitudes = (Amplitude("k_d", "1", "drift over one hundred tests", 0, 0.02),)
    kind = "fault"
    metadata = ("order",)
    metadata_units = ("1",)

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        return (context.system["order"] / 100.0 + 0.0 * L.sd,)
