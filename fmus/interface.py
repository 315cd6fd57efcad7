"""FMI variables of a friction FMU, derived from the loads contract; units with their SI base factors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from friction_models.loads import LOADS, MU, Quantity

#: Exponents of the SI base units, factor and offset: value_SI = factor * value + offset.
UNITS: dict[str, dict[str, float]] = {
    "1": {},
    "s": {"s": 1},
    "mm": {"m": 1, "factor": 1e-3},
    "mm/s": {"m": 1, "s": -1, "factor": 1e-3},
    "um": {"m": 1, "factor": 1e-6},
    "degC": {"K": 1, "offset": 273.15},
    "K": {"K": 1},
    "MPa": {"kg": 1, "m": -1, "s": -2, "factor": 1e6},
    "N": {"kg": 1, "m": 1, "s": -2},
    "kN": {"kg": 1, "m": 1, "s": -2, "factor": 1e3},
    "J": {"kg": 1, "m": 2, "s": -2},
    "mJ": {"kg": 1, "m": 2, "s": -2, "factor": 1e-3},
    "J/mm2": {"kg": 1, "s": -2, "factor": 1e6},
    "mJ/mm2": {"kg": 1, "s": -2, "factor": 1e3},
    "MPa.mm": {"kg": 1, "s": -2, "factor": 1e3},
    "deg": {"rad": 1, "factor": 0.017453292519943295},
    "GPa": {"kg": 1, "m": -1, "s": -2, "factor": 1e9},
    "kN/mm": {"kg": 1, "s": -2, "factor": 1e6},
    "W/(m2 K)": {"kg": 1, "s": -3, "K": -1},
    "kW/(m2 K)": {"kg": 1, "s": -3, "K": -1, "factor": 1e3},
}


def unit_base(name: str) -> dict[str, float] | None:
    """Return the entry of `UNITS` of a unit, or of a known unit per second (``x/s``); None when it is unknown."""
    if name in UNITS:
        return UNITS[name]
    if not name.endswith("/s") or name[:-2] not in UNITS:
        return None
    base = dict(UNITS[name[:-2]])
    base.pop("offset", None)  # a rate has no zero point
    base["s"] = base.get("s", 0) - 1
    return base if base["s"] else {k: v for k, v in base.items() if k != "s"}


@dataclass(frozen=True)
class Variable:
    """One FMI variable: a scalar of FMI 2.0, or a scalar or array of FMI 3.0.

    Attributes
    ----------
    name : str
        Structured name, ``mu`` or ``mu[3]``.
    reference : int
        Value reference; in FMI 2.0 Real and Boolean variables are numbered separately.
    causality, variability, initial : str
        As in the standard; `initial` may be empty.
    type : str
        ``Real``, ``Boolean`` or ``Integer``.
    unit : str
        A key of `UNITS`, or any other text (then without base factors); empty for none.
    start : float, bool, int or None
        Start value.
    lower, upper : float or None
        Physical limits.
    depends : tuple of str or None
        For outputs: names of the inputs it depends on directly; None leaves the statement out.
    initial_depends : tuple of str or None
        For outputs: what the initial value depends on; None means `depends`.
    nominal : float or None
        Size that a continuous state is expected to have.
    derivative : str
        Name of the state whose derivative this is.
    array : bool
        FMI 3.0: whether it has one element a contact point.
    """

    name: str
    reference: int
    causality: str
    variability: str = "continuous"
    initial: str = ""
    type: str = "Real"
    unit: str = ""
    start: float | bool | int | None = None
    lower: float | None = None
    upper: float | None = None
    description: str = ""
    depends: tuple[str, ...] | None = None
    initial_depends: tuple[str, ...] | None = None
    nominal: float | None = None
    derivative: str = ""
    array: bool = False


@dataclass(frozen=True)
class Parameter:
    """A system variable (tool roughness, lubricant batch) that the model takes beside the loads.

    Attributes
    ----------
    name, unit : str
    start : float
        Value unless another one is set.
    lower, upper : float or None
        Range seen in training; not a physical limit.
    labels : tuple of str
        What the numbers 0, 1, 2 ... stand for, where the metadata are text.
    """

    name: str
    unit: str
    start: float
    lower: float | None = None
    upper: float | None = None
    labels: tuple[str, ...] = ()

    @property
    def minimum(self) -> float | None:
        """Physical lower limit: 0 for what was never negative (roughness, the number of a batch)."""
        return 0.0 if self.lower is not None and self.lower >= 0.0 and self.start >= 0.0 else None

    @property
    def description(self) -> str:
        """One line for the model description."""
        if self.labels:
            meaning = ", ".join(f"{i} = {label}" for i, label in enumerate(self.labels))
            return f"system variable: {meaning}"[:300]
        if self.lower is None or self.upper is None:
            return "system variable"
        return f"system variable, trained from {self.lower:g} to {self.upper:g}"


@dataclass(frozen=True)
class State:
    """One internal state of a model with memory; every contact point has its own."""

    name: str
    unit: str
    start: float
    ode: bool = False

    @property
    def nominal(self) -> float:
        """Size that the state is expected to have."""
        return abs(self.start) if self.start else 1.0

    @property
    def rate_unit(self) -> str:
        """Unit of its derivative."""
        return {"1": "1/s", "s": "1"}.get(self.unit, f"{self.unit}/s")


@dataclass(frozen=True)
class FrictionInterface:
    """What a friction FMU shows: the five loads in, `mu` out, at `nodes` contact points.

    Value references of the Real variables of FMI 2.0 run through the names in groups of `nodes`: the five
    loads, `mu`, `domain_distance`, then the states; then the system variables, one each; then the
    derivatives of the states, in groups again; last, where `interval` is the level of a prediction
    interval, the groups `mu_low` and `mu_high`. FMI 3.0 is in `interface3`.
    """

    nodes: int = 1
    domain: dict[str, tuple[float, float]] = field(default_factory=dict)
    states: tuple[State, ...] = ()
    system: tuple[Parameter, ...] = ()
    interval: float | None = None

    def names(self, name: str) -> list[str]:
        """Return the variable names of one quantity: ``[mu]``, or ``[mu[1], mu[2], ...]``."""
        return [name] if self.nodes == 1 else [f"{name}[{i + 1}]" for i in range(self.nodes)]

    def start(self, load: Quantity) -> float:
        """Return the start value of a load: its nominal value, moved into the trained domain."""
        lower, upper = self.domain.get(load.name, (load.lower, load.upper))
        return min(max(load.nominal, lower), upper)

    def variables(self, ode: bool = False) -> list[Variable]:
        """Return all variables of FMI 2.0 in file order; with `ode` the states are continuous states."""
        result: list[Variable] = []
        reference = 0

        def group(name: str, causality: str, unit: str, **more: object) -> None:
            nonlocal reference
            for i, full in enumerate(self.names(name)):
                extra = {k: v(i) if callable(v) else v for k, v in more.items()}
                result.append(Variable(full, reference, causality, unit=unit, **extra))  # type: ignore[arg-type]
                reference += 1

        columns = [self.names(q.name) for q in LOADS]
        states = [self.names(s.name) for s in self.states]
        parameters = tuple(p.name for p in self.system)

        def loads_of(i: int) -> tuple[str, ...]:
            return tuple(c[i] for c in columns)

        def now_of(i: int) -> tuple[str, ...]:
            return (*loads_of(i), *(s[i] for s in states)) if ode else loads_of(i)

        def initial_of(i: int) -> tuple[str, ...]:
            return (*loads_of(i), *(s[i] for s in states), *parameters, "clamp_to_domain")

        for q in LOADS:
            group(
                q.name,
                "input",
                q.unit,
                start=self.start(q),
                lower=q.lower,
                upper=q.upper,
                description=q.meaning,
            )
        group(
            MU.name,
            "output",
            MU.unit,
            initial="calculated",
            lower=0.0,
            description=MU.meaning,
            depends=now_of,
            initial_depends=initial_of,
        )
        group(
            "domain_distance",
            "output",
            "1",
            initial="calculated",
            lower=0.0,
            description="0 inside the trained domain; outside, largest exceedance in units of a load's range",
            depends=loads_of,
        )
        for s in self.states:
            group(
                s.name,
                "local",
                s.unit,
                initial="exact",
                start=s.start,
                nominal=s.nominal if ode else None,
                description="memory of the contact point",
            )
        for p in self.system:
            result.append(
                Variable(
                    p.name,
                    reference,
                    "parameter",
                    "tunable",
                    "exact",
                    unit=p.unit,
                    start=p.start,
                    lower=p.minimum,
                    description=p.description,
                )
            )
            reference += 1
        for s, names in zip(self.states if ode else (), states):
            for i, name in enumerate(names):
                result.append(
                    Variable(
                        f"der({name})",
                        reference,
                        "local",
                        initial="calculated",
                        unit=s.rate_unit,
                        derivative=name,
                        description=f"rate of {name}, 0 without contact",
                        depends=now_of(i),
                        initial_depends=initial_of(i)[:-1],
                    )
                )
                reference += 1
        for bound, meaning in bounds(self.interval):
            group(
                bound,
                "output",
                MU.unit,
                initial="calculated",
                lower=0.0,
                description=meaning,
                depends=now_of,
                initial_depends=initial_of,
            )
        every_load = tuple(name for column in columns for name in column)
        result.append(
            Variable(
                "in_domain",
                0,
                "output",
                "discrete",
                "calculated",
                "Boolean",
                description="whether every point in contact is inside the trained domain",
                depends=every_load,
            )
        )
        result.append(
            Variable(
                "clamp_to_domain",
                1,
                "parameter",
                "tunable",
                "exact",
                "Boolean",
                start=True,
                description="evaluate at the nearest point of the trained domain instead of extrapolating",
            )
        )
        return result


def bounds(level: float | None) -> list[tuple[str, str]]:
    """Return name and meaning of the bounds of the prediction interval; none without a level."""
    if level is None:
        return []
    what = f"bound of the {100.0 * level:g} % prediction interval for mu of a new test"
    return [("mu_low", f"lower {what}"), ("mu_high", f"upper {what}")]


def vector(variables: Sequence[str], name: str) -> list[str]:
    """Return the scalar names that make up `name`: itself, or its elements in order of index.

    Used to connect and to read structured variables; an empty list when there is no such variable.
    """
    if name in variables:
        return [name]
    present = set(variables)
    elements: list[str] = []
    while f"{name}[{len(elements) + 1}]" in present:
        elements.append(f"{name}[{len(elements) + 1}]")
    return elements
