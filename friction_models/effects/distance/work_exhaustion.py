"""Work exhaustion: the film fails with the friction work that it has taken; has memory."""

from __future__ import annotations

from ...expressions.ops import LoadColumns, Ops, Value
from ..base import Effect, EffectContext, Parameters
from ..parameters import Amplitude, ShapeParameter

J_PER_MM2 = 1e-3  # one N/mm (= mu * MPa * mm) in J/mm2


class WorkExhaustion(Effect):
    """Failure after accumulated friction work, ``delta_W * (1 - exp(-(W/W_c)^n))``, ``dW/dt = mu sigma_n v_rel``.

    The work is the model's own: its friction coefficient, not the measured one, drives the state.

    Examples
    --------
    The friction work of mu = 0.1 at 1000 MPa grows by 1 J/mm2 over each 10 mm:

    >>> import numpy as np
    >>> from friction_models.effects import EffectContext, WorkExhaustion
    >>> from friction_models.expressions.ops import NumpyOps
    >>> one = np.ones((1, 1))
    >>> L = LoadColumns(10 * one, 20 * one, 1000 * one, 0 * one, one)
    >>> fresh = EffectContext(mu=0.1 * one, state={"work": 0 * one})
    >>> work = WorkExhaustion().advance(NumpyOps(), L, {}, fresh, dt=1.0)[0]
    >>> work.round(6).tolist()
    [[1.0]]
    >>> WorkExhaustion(W_c=1.0, n=3.0).at(EffectContext(state={"work": work})).round(3).tolist()
    [[0.632]]
    """

    name = "work_exhaustion"
    title = "the film fails with accumulated friction work"
    label = "Film exhaustion"
    sentence = "friction rises late in tests with high pressure, as friction work uses the lubricant film up"
    equation = "mu += delta_W * (1 - exp(-(W/W_c)^n)),  dW/dt = mu sigma_n v_rel"
    latex = (
        r"\mu \mathrel{+}= \Delta\mu_W\left(1-e^{-(W/W_c)^n}\right),\quad \dot W=\mu\,\sigma_n v_\mathrm{rel}"
    )
    citation = "friction work as the measure of film life; compare the diminution law of the interactive friction model, Friction 10 (2022)"
    where_it_shows = "late in tests with high pressure; curves of all tests collapse on the friction work"
    driver = ("sigma_n", "sd")
    amplitudes = (Amplitude("delta_W", "1", "friction of the exhausted film above the fresh one", 1, 0.06),)
    shapes = (
        ShapeParameter(
            "W_c",
            "J/mm2",
            "friction work that exhausts the film",
            1e-12,
            1e9,
            3.0,
            follows="work",
            span=(1.0, 1.5),
            points=9,
        ),
        ShapeParameter("n", "1", "steepness", 1.0, 8.0, 3.0, values=(1.0, 2.0, 4.0)),
    )
    states = (("work", "J/mm2"),)
    states_need_shapes = False
    needs_mu = True

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        return (1.0 - x.exp(-x.power(x.relu(context.state["work"]) / p["W_c"], p["n"])),)

    def rate(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        return (J_PER_MM2 * context.mu * L.sigma_n * L.v_rel,)

    def linear_step(
        self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext, dt: Value
    ) -> tuple[Value, ...]:
        (power,) = self.rate(x, L, p, context)
        return (1.0, dt * power)
