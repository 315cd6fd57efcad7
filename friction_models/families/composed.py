"""`ComposedFriction`: a base model with physical effects on top, all parameters fitted together."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, Self

import numpy as np
from sklearn.base import clone

from ..common import InputError
from ..common.errors import shown
from ..effects import CATALOGUE, ENTRY_POINT_GROUP, known_effect, make_effect
from ..effects.base import Effect, EffectContext
from ..effects.time_course import Rows, TimeCourse
from ..effects.together import check_together
from ..estimation.campaign.metadata import with_all_metadata
from ..estimation.fit.joint_fit import fit_jointly
from ..estimation.search.memory import states_along
from ..expressions.ops import LoadColumns, NumpyOps, Ops, Value
from ..loads import FloatArray, TriboLoads
from ..loads.order import order_of_tests
from ..models.base import FrictionModel, LoadsLike
from ..models.law import Arrays, Groups, JsonObject, Learned, States, System, Weights
from ..models.tangent import MeasuredPoints, Tangent
from ..models.variables import StateVariable, SystemVariable, as_numbers
from .metadata import check_loads, levels_of, system_variables_of
from .refinement_history import checked_round
from .registry import make_model
from .stored_parameters import stored_amplitudes, stored_effect, stored_levels, stored_shapes, stored_system

#: Steps of bisection, then of Newton, to a friction coefficient that agrees with an effect of itself.
BISECTIONS, NEWTON_STEPS = 20, 2
#: Step of mu for a slope.
MU_STEP = 1e-6


class ComposedFriction(FrictionModel):
    """mu = base(loads) + sum of effects (loads, memory, metadata), fitted together.

    Made by ``model + effects.Stribeck()``. Faults of the data (`sensor_drift`, ...) take part in the fit,
    so that they do not spoil the rest, but never in a prediction or an exported file.

    Parameters
    ----------
    base : FrictionModel
        Unfitted model of any family.
    effects : list of str or Effect
        Names of the catalogue, or effects.

    Attributes
    ----------
    base_ : FrictionModel
        The base with its jointly fitted parameters.
    effects_ : list of Effect
    shapes_, amplitudes_ : list of dict
        Fitted parameters of each effect by name.
    system_ : list of SystemVariable
        Metadata that the exported effects need, with the range of the training data.
    levels_ : dict
        Labels of metadata that is text, in the order of their numbers.
    noise_floor_ : dict
        Noise floor of the training data (empty where it could not be estimated).

    Examples
    --------
    A constant level with friction that falls as the speed rises, mu = 0.05 + 0.04 exp(-v_rel / 20):

    >>> import math
    >>> from friction_models import ConstantFriction
    >>> from friction_models.effects import Stribeck
    >>> speeds = [0, 10, 20, 40, 80, 160]
    >>> mu = [0.05 + 0.04 * math.exp(-v / 20) for v in speeds]
    >>> model = ConstantFriction() + Stribeck(v_s=20.0, d=1.0)
    >>> model = model.fit([[v, 20, 500, 0, 1] for v in speeds], mu)
    >>> model.name
    'constant + stribeck'
    >>> round(model.base_.value, 4), round(model.amplitudes_[0]["delta_s"], 4)
    (0.05, 0.04)
    """

    family: ClassVar[str] = "composed"
    #: Errors of a twin are common to its tests: weights take the fast and hot ones away, by which effects are known.
    honours_uncertain_loads: ClassVar[bool] = False

    def __init__(self, base: FrictionModel, effects: Sequence[str | Effect] = ()) -> None:
        self.base = base
        self.effects = effects

    def __add__(self, effect: str | Effect) -> ComposedFriction:
        return ComposedFriction(clone(self.base), [*self.effects, effect])

    @property
    def name(self) -> str:
        """Families and effects, for example ``linear + stribeck``."""
        return " + ".join([self.base.family, *(make_effect(e).name for e in self.effects)])

    # --- fit ------------------------------------------------------------------------------------------

    def _fit(self, loads: TriboLoads, mu: FloatArray, groups: Groups, sample_weight: Weights = None) -> None:
        self._check_base()
        self.effects_ = [make_effect(e) for e in self.effects]
        check_together("composed", self.effects_)
        check_loads(loads, self.effects_)
        rows = order_of_tests(
            loads.test_id if groups is None else groups,
            loads.t,
            loads.sd,
            memory=any(e.states for e in self.effects_),
        )
        if rows is not None:
            loads, mu = loads.take(rows), mu[rows]
            groups = None if groups is None else groups[rows]
            sample_weight = None if sample_weight is None else sample_weight[rows]
        loads = with_all_metadata(loads, [m for e in self.effects_ for m in e.metadata])
        self.levels_ = levels_of(loads, self.effects_)
        self.effects_ = [e.with_levels(self.levels_) for e in self.effects_]
        fitted = fit_jointly(
            self.base, self.effects_, loads, mu, groups, self._metadata(loads), sample_weight
        )
        self.base_, self.shapes_, self.amplitudes_ = fitted.base, fitted.shapes, fitted.amplitudes
        self.noise_floor_ = fitted.noise_floor
        self.system_ = system_variables_of(loads, self._metadata(loads), self.exported, self.levels_)

    def tangent(self, data: MeasuredPoints) -> Tangent:
        """Return the columns of the base, and the effects at their fitted shapes, whose amplitudes may change."""
        fitted = self if self.is_fitted else clone(self).fit(data.loads, data.mu)
        inner = fitted.base.tangent(data)
        mu = fitted.predict(data.loads)
        terms = [
            np.broadcast_to(column, (len(mu), 1))
            for effect, shape in zip(fitted.effects_, fitted.shapes_, strict=True)
            for column in data.effect_columns(effect, mu, shape)
        ]
        names = tuple(e.name for e in fitted.effects_)
        return Tangent(
            np.column_stack([inner.columns, *terms]), inner.offset, effects=names, beside=inner.beside
        )

    def _check_base(self) -> None:
        if not isinstance(self.base, FrictionModel) or isinstance(self.base, ComposedFriction):
            raise InputError(
                f"composed: base {self.base!r:.60}; allowed: an unfitted model of another family (add effects with +)"
            )

    @property
    def exported(self) -> list[Effect]:
        """The effects that predictions and files hold: all but faults of the data."""
        effects = getattr(self, "effects_", None) or [make_effect(e) for e in self.effects]
        return [e for e in effects if e.kind != "fault"]

    def _terms(self) -> list[tuple[Effect, dict[str, float], dict[str, float]]]:
        """Return the exported effects with their shapes and amplitudes."""
        terms = zip(self.effects_, self.shapes_, self.amplitudes_, strict=True)
        return [term for term in terms if term[0].kind != "fault"]

    # --- law ------------------------------------------------------------------------------------------

    @property
    def states(self) -> tuple[StateVariable, ...]:
        if not self.is_fitted and not hasattr(self, "shapes_"):
            found = [v for e in self.exported for v in e.state_variables(e.start_shape())]
        else:
            found = [v for e, shape, _ in self._terms() for v in e.state_variables(shape)]
        return tuple(found)

    @property
    def system_variables(self) -> tuple[SystemVariable, ...]:
        return tuple(getattr(self, "system_", ()))

    def formula(self, x: Ops, L: LoadColumns, S: States = None, system: System = None) -> Value:
        held = self._held(x, L, S)
        known = {v.name: v.start for v in self.system_variables} | dict(system or {})
        mu = self.base_.formula(x, L)
        own = [t for t in self._terms() if t[0].needs_mu and not t[0].states]
        for term in [t for t in self._terms() if not t[0].needs_mu or t[0].states]:
            mu = _added(mu, term, x, L, EffectContext(mu, held, known))
        if not own:
            return mu

        def whole(seen: Value) -> Value:
            total = mu
            for term in own:
                total = _added(total, term, x, L, EffectContext(seen, held, known))
            return total

        return _agreeing(x, mu, whole)

    def _held(self, x: Ops, L: LoadColumns, S: Sequence[Value] | None) -> dict[str, Value]:
        values = S if S is not None else [x.constant(v.start, L.v_rel) for v in self.states]
        return {v.name: value for v, value in zip(self.states, values, strict=True)}

    def state_update(
        self, x: Ops, L: LoadColumns, S: Sequence[Value], mu: Value, dt: Value
    ) -> tuple[list[Value], list[Value] | None]:
        context = EffectContext(mu, self._held(x, L, S), {v.name: v.start for v in self.system_variables})
        following: list[Value] = []
        rates: list[Value] = []
        for effect, shape, _ in self._terms():
            if effect.states:
                following += effect.advance(x, L, shape, context, dt)
                rates += effect.rate(x, L, shape, context)
        return following, rates or None

    # --- prediction -----------------------------------------------------------------------------------

    def predict(self, loads: LoadsLike) -> FloatArray:
        """Return mu, shape (n,).

        With memory, the states run through every test in the order of its time, from fresh contact; the
        first point of a test sees the start state. Loads without time and test are fresh contact each.
        """
        points = self._evaluable(loads)
        x = NumpyOps()
        system = self._metadata(points)
        if not self.states or (points.test_id is None and points.t is None):
            L = LoadColumns.from_matrix(x, points.as_array()).without(x, self.domain.absent)
            return x.relu(self.formula(x, L, None, system))[:, 0]
        points, order = points.in_order(memory=True)
        course = TimeCourse.of(
            points, np.array([s.start for s in points.segments()], dtype=np.intp), self.domain.absent
        )
        system = {k: v[order] for k, v in system.items()}
        states = self._states_along(x, course, system)
        mu = np.empty(len(points))
        mu[order] = x.relu(self.formula(x, course.at(), states, system))[:, 0]
        return mu

    def _states_along(self, x: Ops, course: TimeCourse, system: Mapping[str, FloatArray]) -> list[FloatArray]:
        """Return the states of all effects at the points of some tests, shape (n, 1) each."""
        terms = [(effect, shape) for effect, shape, _ in self._terms() if effect.states]
        if all(e.steps_linearly and not e.needs_mu for e, _ in terms):
            return [s for e, shape in terms for s in states_along(e, course, None, system, shape).values()]

        def advance(
            rows: Rows, L: LoadColumns, held: Sequence[FloatArray], dt: FloatArray
        ) -> Sequence[FloatArray]:
            inside = {k: v[rows] for k, v in system.items()}
            mu = x.relu(self.formula(x, L, held, inside))
            return self.state_update(x, L, held, mu, dt[:, None])[0]

        return course.step_by_step([np.full((len(course.starts), 1), v.start) for v in self.states], advance)

    def _metadata(self, loads: TriboLoads) -> dict[str, FloatArray]:
        """Return metadata that effects need as columns [n, 1]; what a table lacks takes its start value."""
        effects = self.effects_ if not hasattr(self, "system_") else self.exported
        columns: dict[str, FloatArray] = {}
        starts = {v.name: v.start for v in self.system_variables}
        for name in dict.fromkeys(m for e in effects for m in e.metadata):
            values = loads.context_column(name)
            if values is None:
                continue
            start = starts.get(name, np.nan)
            columns[name] = as_numbers(values, self.levels_.get(name, ()), start)[:, None]
        return columns

    # --- words and files ------------------------------------------------------------------------------

    def formula_text(self) -> str:
        parts = [self.base_.formula_text()]
        for effect, shape, amplitudes in self._terms():
            shown = ", ".join(f"{k} = {v:.4g}" for k, v in (amplitudes | shape).items())
            parts.append(f"{effect.equation} [{shown}]")
        return "; ".join(parts)

    def _plain_params(self) -> dict[str, object]:
        effects = [make_effect(e) for e in self.effects]
        return {
            "base": {"family": self.base.family, "params": self.base._plain_params()},
            "effects": [{"name": e.name, "fixed": e.fixed} for e in effects],
        }

    def _learned(self) -> Learned:
        content, arrays = self.base_.parts()
        values = {
            "base": content,
            "shapes": self.shapes_,
            "amplitudes": self.amplitudes_,
            "system": [v.to_dict() for v in self.system_],
            "levels": self.levels_,
            "noise_floor": self.noise_floor_,
            "error_history": getattr(self, "error_history_", []),
        }
        return values, {f"base.{k}": v for k, v in arrays.items()}

    def _restore(self, values: JsonObject, arrays: Arrays) -> None:
        shapes, amplitudes = values["shapes"], values["amplitudes"]
        for sets in (shapes, amplitudes):
            if not isinstance(sets, list) or len(sets) != len(self.effects):
                raise InputError(
                    "composed: the parameters do not fit the effects; allowed: one set an effect"
                )
        self.levels_ = stored_levels(values["levels"])
        self.effects_ = [
            stored_effect(make_effect(e), self.levels_, a)
            for e, a in zip(self.effects, amplitudes, strict=True)
        ]
        inner = {k.removeprefix("base."): v for k, v in arrays.items() if k.startswith("base.")}
        self.base_ = type(self.base).from_parts(values["base"], inner)
        self.amplitudes_ = [stored_amplitudes(e, a) for e, a in zip(self.effects_, amplitudes, strict=True)]
        self.shapes_ = [stored_shapes(e, s) for e, s in zip(self.effects_, shapes, strict=True)]
        self.system_ = stored_system(values["system"], self.exported, self.levels_)
        self.noise_floor_ = dict(values["noise_floor"])
        self.error_history_ = [checked_round(entry) for entry in values.get("error_history", [])]

    @classmethod
    def from_parts(cls, content: JsonObject, arrays: Arrays) -> Self:
        """Build a model from `parts`; see `FrictionModel.from_parts`."""
        params = content["params"]
        base = make_model(str(params["base"]["family"]), **params["base"]["params"])
        effects: list[str | Effect] = []
        for entry in params["effects"]:
            if not known_effect(str(entry["name"])):
                raise InputError(
                    f"composed: effect {str(entry['name'])!r} is not in the catalogue; allowed: {', '.join(sorted(CATALOGUE))}, and "
                    f"effects that an installed package offers under the entry point {ENTRY_POINT_GROUP}"
                )
            effect = make_effect(str(entry["name"]))
            effects.append(type(effect)(**{str(k): float(v) for k, v in entry["fixed"].items()}))
        model = cls(base, effects)
        return model._restored(content, arrays)


def _agreeing(x: Ops, rest: Value, whole: Callable[[Value], Value]) -> Value:
    """Return the friction coefficient with ``mu = whole(mu)``, between `rest` and ``whole(rest)``.

    Bisection stands steep effects; the Newton steps behind it make result and derivatives those of the exact solution.
    """
    first = whole(rest)
    mu, width = 0.5 * (rest + first), 0.25 * x.abs(first - rest)
    for _ in range(BISECTIONS):
        ahead = whole(mu) - mu
        mu = mu + width * (ahead / (x.abs(ahead) + 1e-30))
        width = 0.5 * width
    for _ in range(NEWTON_STEPS):
        there = whole(mu)
        slope = (whole(mu + MU_STEP) - there) * (1.0 / MU_STEP)
        mu = mu + (there - mu) / (1.0 - slope)
    return mu


def _added(
    mu: Value,
    term: tuple[Effect, dict[str, float], dict[str, float]],
    x: Ops,
    L: LoadColumns,
    context: EffectContext,
) -> Value:
    """Return mu with one effect added."""
    effect, shape, amplitudes = term
    try:
        columns = effect.basis(x, L, shape, context)
    except TypeError as error:
        if type(x) is NumpyOps:  # others write files
            raise
        raise InputError(
            f"effect {effect.name!r}: basis cannot be written to a file ({shown(error)}); allowed: functions of x, as x.exp, and none of NumPy"
        ) from None
    for amplitude, column in zip(amplitudes.values(), columns, strict=True):
        if amplitude != 0.0:
            mu = mu + amplitude * column
    return mu


def _sum(base: FrictionModel, effects: list[Any]) -> FrictionModel:
    """Return an unfitted sum; a misspelt effect is refused here, not at the fit."""
    for effect in effects:
        make_effect(effect)
    return ComposedFriction(base, effects)


FrictionModel._compose = _sum
