"""What a physical effect is: a declared term that a friction model lacks or has.

An effect adds ``sum_j amplitude_j * basis_j(loads, shape parameters, context)`` to the friction coefficient:
linear in its amplitudes, whose physical sign is declared, and nonlinear in few shape parameters. Amplitude
zero is the base model. Formulas are written against `friction_models.expressions.ops.Ops`, so that the same text
computes numbers and draws the ONNX graph.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal, Self

import numpy as np
import numpy.typing as npt

from ..common import InputError, unknown_name
from ..expressions.ops import LoadColumns, NumpyOps, Ops, Value
from ..loads import LOAD_NAMES, LOADS, FloatArray
from ..models.variables import StateVariable
from .parameters import Amplitude, ShapeParameter, Spans

#: Shape parameters by name: numbers, or rows of shape [1, g] for g sets at once.
Parameters = Mapping[str, Value]


@dataclass(frozen=True)
class EffectContext:
    """What a basis may use beside the loads.

    Attributes
    ----------
    mu : Value, shape [n, 1], or None
        The friction coefficient of the whole model.
    state : mapping
        Internal states by name, each [n, 1].
    system : mapping
        Metadata of the test (system variables) by name, each [n, 1] or [1, 1].

    Examples
    --------
    >>> from friction_models.effects import EffectContext, ToolRoughness
    >>> ToolRoughness().at(EffectContext(system={"Ra": np.array([[0.25], [0.5]])})).tolist()
    [[0.25], [0.5]]
    """

    mu: Value = None
    state: Mapping[str, Value] = field(default_factory=dict)
    system: Mapping[str, Value] = field(default_factory=dict)


#: Names that effects of users may still import.
Memory = EffectContext
Shape = ShapeParameter


class Effect:
    """One physical effect; subclasses declare it and write `basis`.

    Parameters
    ----------
    **fixed : float
        Shape parameters that are known and shall not be fitted, for example ``Stribeck(v_s=20.0)``.

    Raises
    ------
    InputError
        A parameter that the effect does not have, or a value outside its bounds.

    Examples
    --------
    An effect of one's own: friction that grows in proportion to the sliding distance.

    >>> from friction_models.effects import Amplitude, Effect, ShapeParameter, make_effect
    >>> class Galling(Effect):
    ...     name = "galling"
    ...     title = "material sticks to the tool"
    ...     equation = "mu += k_g * sd/s_g"
    ...     latex = "k_g sd / s_g"
    ...     citation = "none, an example"
    ...     where_it_shows = "long sliding"
    ...     driver = ("sd",)
    ...     amplitudes = (Amplitude("k_g", "1", "rise over s_g", 1, 0.02),)
    ...     shapes = (ShapeParameter("s_g", "mm", "reference distance", 1e-3, 1e3, 10.0),)
    ...
    ...     def basis(self, x, L, p, context):
    ...         return (L.sd / p["s_g"],)
    >>> effect = make_effect(Galling(s_g=20.0))
    >>> effect
    Galling(s_g=20.0)
    >>> effect.label, effect.start_shape()
    ('Galling', {'s_g': 20.0})

    Its basis at 0 and at 30 mm, before it is multiplied with the amplitude k_g:

    >>> effect.at(sd=[0, 30]).tolist()
    [[0.0], [1.5]]
    """

    name: ClassVar[str]
    #: A few words in lower case, shown in brackets behind the name.
    title: ClassVar[str]
    #: Name for people, as in a headline; by default made from `name`.
    label: ClassVar[str]
    #: What the effect does to friction, one sentence without capital and full stop; by default `title`.
    sentence: ClassVar[str]
    equation: ClassVar[str]
    latex: ClassVar[str]
    citation: ClassVar[str]
    where_it_shows: ClassVar[str]
    driver: ClassVar[tuple[str, ...]]
    amplitudes: ClassVar[tuple[Amplitude, ...]]
    shapes: ClassVar[tuple[ShapeParameter, ...]] = ()
    #: `physics` and `system` terms are exported; a `fault` corrects data and never leaves the laboratory.
    kind: ClassVar[Literal["physics", "system", "fault"]] = "physics"
    #: Metadata columns of the test table that the effect needs.
    metadata: ClassVar[tuple[str, ...]] = ()
    #: Units of these columns.
    metadata_units: ClassVar[tuple[str, ...]] = ()
    #: Loads without which the effect is not what it is; those of `driver` where it is None.
    needs: ClassVar[tuple[str, ...] | None] = None
    #: Names and units of internal states; each obeys an ODE that `rate` gives.
    states: ClassVar[tuple[tuple[str, str], ...]] = ()
    #: Whether the evolution of the states depends on the shape parameters (if not, it is computed once).
    states_need_shapes: ClassVar[bool] = True
    #: Whether basis or rate use the model's own friction coefficient.
    needs_mu: ClassVar[bool] = False
    #: Whether the amplitudes are offsets of levels, which a fit shrinks towards zero.
    pooled: ClassVar[bool] = False

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        own = cls.__dict__
        if "label" not in own and isinstance(own.get("name"), str):
            cls.label = own["name"].replace("_", " ").capitalize()
        if "sentence" not in own and isinstance(own.get("title"), str):
            cls.sentence = own["title"]

    def __init__(self, **fixed: float) -> None:
        known = {s.name: s for s in self.shapes}
        for key, value in fixed.items():
            if key not in known:
                raise unknown_name(f"parameter of {self.name}", key, known)
            shape = known[key]
            if not shape.lower <= value <= shape.upper:
                raise InputError(
                    f"effect {self.name}: {key} = {value!r} {shape.unit} is outside the allowed range "
                    f"{shape.lower:g} to {shape.upper:g} {shape.unit}"
                )
        self.fixed = dict(fixed)

    def __repr__(self) -> str:
        inside = ", ".join(f"{k}={v!r}" for k, v in self.fixed.items())
        return f"{type(self).__name__}({inside})"

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.fixed == other.fixed  # type: ignore[attr-defined]

    def __hash__(self) -> int:
        return hash((type(self), tuple(sorted(self.fixed.items()))))

    def with_levels(self, levels: Mapping[str, Sequence[str]]) -> Effect:
        """Return the effect as it is fitted to metadata with these labels of texts; most effects do not care."""
        return self

    @property
    def needs_state(self) -> bool:
        """Whether the effect remembers (needs time and test of every point)."""
        return bool(self.states)

    @property
    def steps_linearly(self) -> bool:
        """Whether steps are linear in the states (`linear_step` is written)."""
        return type(self).linear_step is not Effect.linear_step

    @property
    def needed_loads(self) -> tuple[str, ...]:
        """Loads that have to vary for the effect to be told from others."""
        return tuple(n for n in (self.driver if self.needs is None else self.needs) if n in LOAD_NAMES)

    def lacking(self, absent: Collection[str]) -> list[str]:
        """Return the loads of `absent` (not measured) without which the effect is not what it is."""
        return [n for n in dict.fromkeys((self.driver[0], *self.needed_loads)) if n in absent]

    @property
    def free_shapes(self) -> tuple[ShapeParameter, ...]:
        """Shape parameters that a fit may move."""
        return tuple(s for s in self.shapes if s.fitted and s.name not in self.fixed)

    @property
    def degrees_of_freedom(self) -> int:
        """Number of fitted numbers: amplitudes and free shape parameters."""
        return len(self.amplitudes) + len(self.free_shapes)

    def holding(self, values: Mapping[str, float]) -> Self:
        """Return the effect with shape parameters fixed beside those that are.

        Examples
        --------
        >>> from friction_models.effects import Stribeck
        >>> Stribeck(d=1.0).holding({"v_s": 20.0})
        Stribeck(d=1.0, v_s=20.0)
        """
        held = copy(self)
        held.fixed = {**self.fixed, **values}
        return held

    def start_shape(self) -> dict[str, float]:
        """Return typical shape parameters for cold forging (fixed ones as fixed)."""
        return {s.name: float(self.fixed.get(s.name, s.start)) for s in self.shapes}

    def grids(self, spans: Spans) -> dict[str, FloatArray]:
        """Return the scan values of every shape parameter for data with these spans."""
        return {
            s.name: np.array([self.fixed[s.name]]) if s.name in self.fixed else s.grid(spans)
            for s in self.shapes
        }

    def limits(self, shape: ShapeParameter, values: FloatArray) -> tuple[float, float]:
        """Return between which values a fit may move a shape parameter whose scan values these are."""
        least, most = float(values.min()), float(values.max())
        # temperatures may be negative: beyond a last one of -2 degC there is as much room as there are values below
        room = max(abs(most), most - least)
        return max(shape.lower, least - 0.5 * abs(least)), min(shape.upper, most + room)

    def doubt(self, shape: Mapping[str, float], spans: Spans) -> float:
        """Return how far shape parameters go beyond what data with these spans can show, in standard errors of an average.

        A fit counts it as one more residual, so of two shapes that the data tell hardly apart it takes the one without.
        """
        return 0.0

    def basis(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        """Return one column of shape [n, 1] per amplitude.

        Parameters
        ----------
        x : Ops
            Back end.
        L : LoadColumns
            The five loads.
        p : mapping
            Shape parameters; rows of shape [1, g] evaluate g parameter sets at once.
        context : EffectContext
            States, system variables and own friction coefficient, as far as declared.
        """
        raise TypeError(f"effect {self.name!r} declares no basis")

    def at(self, context: EffectContext | None = None, **loads: npt.ArrayLike) -> FloatArray:
        """Return what the amplitudes are multiplied with, shape (n, amplitudes), at loads by name, each of shape (n,).

        A load that is not given has its nominal value, a shape parameter that is not fixed a typical one.

        Raises
        ------
        InputError
            A name that is none of a load.

        Examples
        --------
        >>> from friction_models.effects import Stribeck
        >>> Stribeck(v_s=20.0, d=1.0).at(v_rel=[0, 20, 40]).round(3).tolist()
        [[1.0], [0.368], [0.135]]
        """
        for name in loads:
            if name not in LOAD_NAMES:
                raise unknown_name("load", name, LOAD_NAMES)
        columns = (np.reshape(np.asarray(loads.get(q.name, q.nominal), np.float64), (-1, 1)) for q in LOADS)
        L, context = LoadColumns(*columns), context or EffectContext()
        return np.hstack(np.broadcast_arrays(*self.basis(NumpyOps(), L, self.start_shape(), context)))

    def start_state(self, p: Parameters) -> tuple[Any, ...]:
        """Return the states of fresh contact."""
        return (0.0,) * len(self.states)

    def rate(self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext) -> tuple[Value, ...]:
        """Return the time derivative of every state [1/s times its unit]."""
        return ()

    def linear_step(
        self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext, dt: Value
    ) -> tuple[Value, ...]:
        """Return ``keep, gain`` of each state in turn, where a step of `dt` seconds makes ``keep * state + gain`` of it.

        Neither may depend on the states (`context` holds none), so fits evaluate all points at once. Written instead of `advance`.
        """
        return ()

    def advance(
        self, x: Ops, L: LoadColumns, p: Parameters, context: EffectContext, dt: Value
    ) -> tuple[Value, ...]:
        """Return the states after `dt` seconds under constant loads: by `linear_step`, else forward Euler unless a subclass is exact."""
        old = [context.state[name] for name, _ in self.states]
        if self.steps_linearly:
            step = self.linear_step(x, L, p, replace(context, state={}), dt)
            return tuple(s * keep + gain for s, keep, gain in zip(old, step[::2], step[1::2], strict=True))
        return tuple(s + dt * d for s, d in zip(old, self.rate(x, L, p, context), strict=True))

    def state_variables(self, p: Mapping[str, float]) -> tuple[StateVariable, ...]:
        """Return the declared states with their start values for shape parameters `p`."""
        return tuple(
            StateVariable(name, unit, float(start), ode=True)
            for (name, unit), start in zip(self.states, self.start_state(p), strict=True)
        )

    def describe(self) -> dict[str, object]:
        """Return the declaration as plain data, for cards and reports."""
        return {
            "name": self.name,
            "title": self.title,
            "label": self.label,
            "sentence": self.sentence,
            "equation": self.equation,
            "latex": self.latex,
            "driver": list(self.driver),
            "kind": self.kind,
            "citation": self.citation,
            "where_it_shows": self.where_it_shows,
            "needs_state": self.needs_state,
            "metadata": list(self.metadata),
            "parameters": [
                {"name": a.name, "unit": a.unit, "meaning": a.meaning, "sign": a.sign}
                for a in self.amplitudes
            ]
            + [
                {"name": s.name, "unit": s.unit, "meaning": s.meaning, "bounds": [s.lower, s.upper]}
                for s in self.shapes
            ],
        }
