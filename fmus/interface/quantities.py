"""FMI variables of a friction FMU, derived from the loads contract; units with their SI base factors."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from friction_models.common import unknown_name
from friction_models.common.units import conversion, spelling, units_like
from friction_models.loads import QUANTITIES, Quantity

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

#: Ending of the names of arrays that hold the sampling points of a map.
AXIS = "_axis"
#: An element of an array of system variables; no array is larger than what a graph may compute.
_ELEMENT = re.compile(r"(?P<name>[A-Za-z_]\w*)\[(?P<place>[1-9]\d{0,4}(?:,[1-9]\d{0,4}){0,4})\]", re.ASCII)

#: Ranges of the loads in the reference plan of the tests, used where no trained domain is recorded.
USUAL = {
    "v_rel": (5.0, 500.0),
    "T": (20.0, 300.0),
    "sigma_n": (500.0, 2750.0),
    "sd": (0.0, 60.0),
    "psi": (1.0, 20.0),
}


def unit_base(name: str) -> dict[str, float] | None:
    """Return the entry of `UNITS` of a unit, or of a known unit per second (``x/s``); None when it is unknown.

    Examples
    --------
    >>> unit_base("mm/s")
    {'m': 1, 's': -1, 'factor': 0.001}
    >>> unit_base("degC/s"), unit_base("furlong")
    ({'K': 1, 's': -1}, None)
    """
    if name in UNITS:
        return UNITS[name]
    if not name.endswith("/s") or name[:-2] not in UNITS:
        return None
    base = dict(UNITS[name[:-2]])
    base.pop("offset", None)  # a rate has no zero point
    base["s"] = base.get("s", 0) - 1
    return base if base["s"] else {k: v for k, v in base.items() if k != "s"}


def load_conversion(name: str, unit: str, where: str) -> tuple[float, float]:
    """Return (factor, offset) that turn a load in the contract's unit into `unit`.

    Raises InputError: the unit does not measure this load; names the nearest one that does.

    Examples
    --------
    >>> load_conversion("T", "K", "law.yaml"), load_conversion("sigma_n", "GPa", "law.yaml")
    ((1.0, 273.15), (0.001, 0.0))
    """
    load = QUANTITIES[name]
    allowed = list(dict.fromkeys([load.unit, *units_like(load.unit)]))
    if spelling(unit) not in allowed:
        raise unknown_name(f"unit of {name!r}", unit, allowed, where)
    return conversion(spelling(unit), load.unit, name, where)


@dataclass(frozen=True)
class DeclaredVariable:
    """One FMI variable: a scalar of FMI 2.0, or a scalar or array of FMI 3.0."""

    name: str  #: Structured name, ``mu`` or ``mu[3]``.
    causality: str  #: As in the standard, as the next two.
    variability: str = "continuous"
    initial: str = ""
    type: str = "Real"  #: ``Real``, ``Boolean`` or ``Integer``.
    unit: str = ""  #: A key of `UNITS`, or any other text (then without base factors); empty for none.
    start: float | bool | int | None = None
    lower: float | None = None  #: Physical limit.
    upper: float | None = None  #: Physical limit.
    description: str = ""
    #: For outputs: names of the inputs it depends on directly; None leaves the statement out.
    depends: tuple[str, ...] | None = None
    #: For outputs: what the initial value depends on; None means `depends`.
    initial_depends: tuple[str, ...] | None = None
    nominal: float | None = None  #: Size that the value is expected to have.
    derivative: str = ""  #: Name of the state whose derivative this is.
    array: bool = False  #: FMI 3.0: whether it has one element a contact point.
    shape: tuple[int, ...] = ()  #: FMI 3.0: dimensions of an array of fixed size.
    starts: tuple[float, ...] = ()  #: Its start values.
    reference: int = 0  #: Value reference; no two variables of an FMU share one, whatever their types.


@dataclass(frozen=True)
class Parameter:
    """A system variable (tool roughness, lubricant batch) that the model takes beside the loads.

    Examples
    --------
    >>> Parameter("roughness", "um", start=0.2, lower=0.1, upper=0.6).minimum
    0.0
    >>> Parameter("batch", "1", start=0.0, labels=("A7", "B2")).description
    'system variable: 0 = A7, 1 = B2'
    """

    name: str
    unit: str
    start: float  #: Value unless another one is set.
    lower: float | None = None  #: Least value seen in training; not a physical limit.
    upper: float | None = None  #: Greatest value seen in training.
    labels: tuple[str, ...] = ()  #: What the numbers 0, 1, 2 ... stand for, where the metadata are text.
    #: One line that describes it; empty for a system variable that a model was trained with.
    meaning: str = ""

    @property
    def minimum(self) -> float | None:
        """Physical lower limit: 0 for what was never negative (roughness, the number of a batch)."""
        return 0.0 if self.lower is not None and self.lower >= 0.0 and self.start >= 0.0 else None

    @property
    def description(self) -> str:
        """One line for the model description."""
        if self.meaning:
            return self.meaning
        if self.labels:
            meaning = ", ".join(f"{i} = {label}" for i, label in enumerate(self.labels))
            return f"system variable: {meaning}"[:300]
        if self.lower is None or self.upper is None:
            return "system variable"
        return f"system variable, trained from {self.lower:g} to {self.upper:g}"


@dataclass(frozen=True)
class ParameterArray:
    """System variables that are the elements of one array, the last index fastest: ``mu_map[1,1]``, ``mu_map[1,2]`` ..."""

    name: str
    shape: tuple[int, ...]
    first: int  #: Place of its first element among the system variables.

    @property
    def size(self) -> int:
        """Number of elements."""
        return math.prod(self.shape)

    @property
    def rises(self) -> bool:
        """Whether its values must rise: the sampling points of a map."""
        return self.name.endswith(AXIS)

    def elements(self) -> list[str]:
        """Return the names of the elements."""
        places = itertools.product(*(range(1, n + 1) for n in self.shape))
        return [f"{self.name}[{','.join(map(str, place))}]" for place in places]


def parameter_arrays(parameters: Sequence[Parameter]) -> list[ParameterArray]:
    """Return the arrays among system variables, by their names; a name that does not fit is a scalar.

    Examples
    --------
    >>> names = ["Ra", "T_axis[1]", "T_axis[2]", "mu_map[1,1]", "mu_map[1,2]", "lone[2]"]
    >>> [(a.name, a.shape, a.first) for a in parameter_arrays([Parameter(n, "1", 0.0) for n in names])]
    [('T_axis', (2,), 1), ('mu_map', (1, 2), 3)]
    """
    matches = [_ELEMENT.fullmatch(p.name) for p in parameters]
    arrays = []
    first = 0
    for name, group in itertools.groupby(matches, lambda m: m["name"] if m else ""):
        found = list(group)
        last = found[-1]
        if last is not None:
            array = ParameterArray(name, tuple(int(k) for k in last["place"].split(",")), first)
            if array.size == len(found) and array.elements() == [m[0] for m in found if m]:
                arrays.append(array)
        first += len(found)
    return arrays


@dataclass(frozen=True)
class State:
    """One internal state of a model with memory; every contact point has its own.

    Examples
    --------
    >>> state = State("film", "mm", start=1.0)
    >>> state.rate_unit, state.nominal
    ('mm/s', 1.0)
    """

    name: str
    unit: str
    start: float

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

    Its variables are in `friction_variables`.

    Examples
    --------
    >>> interface = FrictionInterface(nodes=3)
    >>> interface.names("mu")
    ['mu[1]', 'mu[2]', 'mu[3]']
    """

    nodes: int = 1  #: Contact points; where the simulator sets their number, its default.
    #: Load name to (lower, upper) of the trained domain; empty when none is recorded.
    domain: dict[str, tuple[float, float]] = field(default_factory=dict)
    states: tuple[State, ...] = ()  #: Memory of a point.
    system: tuple[Parameter, ...] = ()
    interval: float | None = None  #: Level of the prediction interval that is shown, None without one.
    #: FMI 3.0: whether one point is an array of length `n`, too, which the simulator can set.
    arrays: bool = False
    absent: tuple[str, ...] = ()  #: Loads that were not measured in training: inputs without influence.

    @property
    def sized(self) -> bool:
        """Whether the quantities of FMI 3.0 are arrays whose length is the structural parameter `n`."""
        return self.arrays or self.nodes > 1

    def names(self, name: str) -> list[str]:
        """Return the variable names of one quantity: ``[mu]``, or ``[mu[1], mu[2], ...]``."""
        return [name] if self.nodes == 1 else [f"{name}[{i + 1}]" for i in range(self.nodes)]

    def start(self, load: Quantity) -> float:
        """Return the start value of a load: its nominal value, moved into the trained domain."""
        lower, upper = self.domain.get(load.name, (load.lower, load.upper))
        return min(max(load.nominal, lower), upper)


def bounds(level: float | None) -> list[tuple[str, str]]:
    """Return name and meaning of the bounds of the prediction interval; none without a level.

    Examples
    --------
    >>> [name for name, _ in bounds(0.9)], bounds(None)
    (['mu_low', 'mu_high'], [])
    """
    if level is None:
        return []
    what = f"bound of the {100.0 * level:g} % prediction interval for mu of a new test"
    return [("mu_low", f"lower {what}"), ("mu_high", f"upper {what}")]
