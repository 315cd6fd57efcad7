"""Resolves the connections of a system to elements of variables, and reports all errors of its set-up at once."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

from fmus.runtime.errors import collected
from fmus.runtime.fmu_files import FmuDescription, describe
from fmus.runtime.fmu_variables import StartValue, Variable, integer_limits
from fmus.runtime.instance import Start
from friction_models.common import InputError, unknown_name

from .array_lengths import size_arrays
from .connections import scaling, split_connection
from .description import SystemDescription

#: A component and the elements of one of its variables.
_End = tuple[str, list[Variable]]

NUMBERS = ("Real", "Integer", "Enumeration", "Boolean")


@dataclass(frozen=True)
class Link:
    """A connection after expansion: element k of `sources` feeds element k of `targets`.

    The target gets ``factor * value + offset``, where the connection names another unit.
    """

    source: str
    sources: tuple[Variable, ...]
    target: str
    targets: tuple[Variable, ...]
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Recorded:
    """A variable that the run keeps; more than one element for structured variables."""

    component: str
    name: str
    elements: tuple[Variable, ...]

    @property
    def label(self) -> str:
        """Name in the results, ``forming.force``."""
        return f"{self.component}.{self.name}"


@dataclass
class Wiring:
    """A system whose names are resolved and whose set-up was checked.

    Examples
    --------
    One output feeds one input; what else the friction FMU takes keeps its start values, which a note says:

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from fmus import pack, pack_signals
    >>> from friction_models import ConstantFriction
    >>> with TemporaryDirectory() as place:
    ...     table = pack_signals(Path(place) / "table.fmu", [0.0, 1.0], {"T": ("degC", "temperature", [80.0])})
    ...     law = pack(ConstantFriction(mu=0.1), Path(place) / "law.fmu", target="python")
    ...     wiring = Wiring.of(SystemDescription.from_dict({
    ...         "communication_step": 0.1, "stop_time": 1.0,
    ...         "components": {"table": {"fmu": str(table)}, "friction": {"fmu": str(law)}},
    ...         "connections": ["table.T -> friction.T"],
    ...     }))
    >>> [(link.source, link.target, link.targets[0].unit) for link in wiring.links], len(wiring.notes)
    ([('table', 'friction', 'degC')], 4)
    """

    descriptions: dict[str, FmuDescription]  # by component
    links: list[Link] = field(default_factory=list)  # expanded connections
    starts: dict[str, list[Start]] = field(default_factory=dict)  # by component
    recorded: list[Recorded] = field(default_factory=list)
    #: Scalar friction FMUs that are fed by a vector, and its length: they run once a contact point.
    points: dict[str, int] = field(default_factory=dict)
    #: FMI 3.0 FMUs whose arrays took the length of what feeds them.
    sizes: dict[str, int] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)  # a sentence for each input that nothing feeds

    def count(self, name: str) -> int:
        """Return for how many contact points a component runs an FMU made for one."""
        return self.points.get(name) or self.sizes.get(name) or 1

    @classmethod
    def of(cls, system: SystemDescription) -> Wiring:
        """Open the FMUs of a system and resolve everything; an error lists all problems.

        These are unreadable FMUs, unknown names, units or lengths that do not fit, inputs that are connected twice, or
        not at all where an output of the same name could feed them or no start value is known.
        """
        problems = _Problems()
        descriptions: dict[str, FmuDescription] = {}
        for name in system.components:
            with problems.noted(f"component {name!r}: "):
                descriptions[name] = describe(system.fmu_path(name))
        for name in system.order or []:
            if name not in system.components:
                problems.append(str(unknown_name("component", name, system.components, "order")))
        if system.order is not None and not problems and sorted(system.order) != sorted(system.components):
            problems.append(
                f"order {system.order} must name every component once: {', '.join(system.components)}"
            )
        wiring = cls(descriptions, sizes=size_arrays(system, descriptions, problems))
        broken = set(system.components) - set(descriptions)
        ends = [(c, pair) for c in system.connections if (pair := wiring._ends(c, broken, problems))]
        for _, pair in ends:
            wiring._count_points(system, *pair)
        for connection, pair in ends:
            with problems.noted(f"connection {connection!r}: "):
                wiring._connect(connection, *pair)
        for name, description in descriptions.items():
            wiring.starts[name] = []
            for key, value in system.components[name].start.items():
                with problems.noted(f"component {name!r}: start value"):
                    wiring.starts[name] += _started(name, description, key, value)
        if not problems:
            problems += wiring._unconnected()
        wiring._record(system.record, broken, problems)
        if problems:
            raise collected(system.source, problems)
        return wiring

    def _endpoint(self, text: str, causality: str, connection: str) -> tuple[str, list[Variable]]:
        component, dot, name = text.strip().partition(".")
        if not dot:
            raise InputError(f"connection {connection!r}: {text.strip()!r} is not 'component.variable'")
        if component not in self.descriptions:
            raise unknown_name("component", component, self.descriptions, f"connection {connection!r}")
        elements = self.descriptions[component].resolve(name, f"{causality} of {component!r}", causality)
        if elements[0].causality != causality:
            raise InputError(
                f"connection {connection!r}: {text.strip()!r} is of causality {elements[0].causality!r}, allowed: {causality!r}"
            )
        return component, elements

    def _ends(self, connection: str, broken: set[str], problems: _Problems) -> tuple[_End, _End] | None:
        parts = split_connection(connection)
        if parts is None:
            problems.append(
                f"connection {connection!r} is not of the form 'component.output -> component.input'"
            )
            return None
        left, right, _ = parts
        if {left.partition(".")[0], right.partition(".")[0]} & broken:
            return None
        ends = []
        for text, causality in ((left, "output"), (right, "input")):
            with problems.noted():
                ends.append(self._endpoint(text, causality, connection))
        return (ends[0], ends[1]) if len(ends) == 2 else None

    def _count_points(self, system: SystemDescription, source: _End, target: _End) -> None:
        """Let a scalar friction FMU that a vector feeds run once a point of the vector."""
        name, elements = target
        alone = system.components[name].each_point or self.descriptions[name].is_scalar_friction
        if len(elements) == 1 and len(source[1]) > 1 and alone:
            self.points.setdefault(name, len(source[1]))

    def _at_points(self, end: _End) -> _End:
        """Return one variable an instance where the component runs once a point."""
        name, elements = end
        if name not in self.points:
            return end
        (one,) = elements
        count = self.points[name]
        return name, [replace(one, name=f"{one.name}[{k + 1}]", point=k, base=one.name) for k in range(count)]

    def _connect(self, connection: str, left: _End, right: _End) -> None:
        source, sources = self._at_points(left)
        target, targets = self._at_points(right)
        if self.count(target) == len(targets) > 1 and self.count(source) == 1 == len(sources):
            sources = sources * len(targets)  # one value for all points
        if len(sources) != len(targets):
            names = [part.strip() for part in connection.split("->")]
            raise InputError(
                f"{names[0]} has {len(sources)} elements, {names[1]} has {len(targets)}; allowed: equal numbers (a friction "
                f"FMU is packed with --nodes {max(len(sources), len(targets))}; one for a single point takes each_point: true)"
            )
        parts = split_connection(connection)
        unit = parts[2] if parts is not None else ""
        factor, offset = scaling(sources[0], targets[0], unit) if unit else (1.0, 0.0)
        for a, b in zip(sources, targets):
            if not unit and a.unit and b.unit and a.unit != b.unit:
                raise InputError(
                    f"{a.name!r} is in {a.unit!r}, {b.name!r} in {b.unit!r}; allowed: the same unit, "
                    f"or that of the target in brackets behind it to convert a load ('{connection.strip()} [{b.unit}]')"
                )
            if a.type != b.type or a.type not in NUMBERS:
                raise InputError(
                    f"{a.name!r} is of type {a.type}, {b.name!r} of type {b.type}; allowed: the same numeric type"
                )
        taken = {(k.target, v.name) for k in self.links for v in k.targets}
        twice = [v.name for v in targets if (target, v.name) in taken]
        if twice:
            raise InputError(f"the input {target}.{twice[0]} is already connected; allowed: one source")
        self.links.append(Link(source, tuple(sources), target, tuple(targets), factor, offset))

    def _unconnected(self) -> list[str]:
        fed = {(link.target, v.name) for link in self.links for v in link.targets}
        points = [link for link in self.links if link.target in self.points]
        fed |= {(link.target, v.name.rpartition("[")[0]) for link in points for v in link.targets}
        fed |= {(name, v.name) for name, pairs in self.starts.items() for v, _ in pairs}
        problems = []
        for name, description in self.descriptions.items():
            for base, elements in description.arrays.items():
                open_ = [v.name for v in elements if v.causality == "input" and (name, v.name) not in fed]
                if not open_:
                    continue
                what = f"{name}.{base}" if len(open_) == len(elements) else f"{name}.{open_[0]}"
                hint = self._source_like(base, name)
                guess = f"; connect it, for example '{hint} -> {what}'" if hint else ""
                # An output of the same name makes it likely that the connection was forgotten.
                if not hint and elements[0].start_text is not None:
                    stays = f"stays at {elements[0].start_text}, the start value of its FMU"
                    self.notes.append(f"the input {what} is not connected and {stays}")
                    continue
                problems.append(
                    f"the input {what} is not connected and has no start value{guess or '; allowed: a connection or a start value'}"
                )
        return problems

    def _source_like(self, base: str, target: str) -> str | None:
        for name, description in self.descriptions.items():
            found = description.arrays.get(base)
            if name != target and found and found[0].causality == "output":
                return f"{name}.{base}"
        return None

    def _record(self, record: Iterable[str] | None, broken: set[str], problems: _Problems) -> None:
        if record is None:
            record = [
                f"{name}.{base}"
                for name, description in self.descriptions.items()
                for base, elements in description.arrays.items()
                if elements[0].causality == "output" and elements[0].type in NUMBERS
            ]
        for text in record:
            component, _, name = text.strip().partition(".")
            if component in broken:
                continue
            with problems.noted():
                if component not in self.descriptions:
                    raise unknown_name("component", component, self.descriptions, f"record {text!r}")
                elements = self.descriptions[component].resolve(name, f"variable of {component!r}")
                self.recorded.append(
                    Recorded(component, name, tuple(self._at_points((component, elements))[1]))
                )


class _Problems(list[str]):
    """Sentences about what is wrong."""

    @contextmanager
    def noted(self, where: str = "") -> Iterator[None]:
        """Note an error and go on."""
        try:
            yield
        except InputError as error:
            self.append(f"{where}{error}")


def _started(name: str, description: FmuDescription, key: str, value: StartValue) -> list[Start]:
    """Return the elements of a variable with their start values; structural parameters are set before all others."""
    if key in description.structure:
        return []
    try:
        elements = description.resolve(key, f"variable of {name!r}")
    except InputError as error:
        raise InputError(f": {error}") from None
    if elements[0].causality not in {"input", "parameter"}:
        raise InputError(f" {key!r} is of causality {elements[0].causality!r}; allowed: input, parameter")
    values = list(value) if isinstance(value, list) else [value] * len(elements)
    if len(values) != len(elements):
        raise InputError(f" {key!r} has {len(values)} elements, the FMU has {len(elements)}")
    wrong = [v for v, e in zip(values, elements) if not _fits(v, e)]
    if wrong:
        raise InputError(f" {key!r} is {wrong[0]!r}; allowed: {_allowed(elements[0])}")
    return list(zip(elements, values))


def _fits(value: object, variable: Variable) -> bool:
    if variable.type == "Boolean":
        return isinstance(value, bool)
    if variable.type in {"Integer", "Enumeration"}:
        low, high = integer_limits(variable.exchange)
        return isinstance(value, int) and not isinstance(value, bool) and low <= value <= high
    if variable.type == "String":
        return isinstance(value, str)
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _allowed(variable: Variable) -> str:
    if variable.type not in {"Integer", "Enumeration", "Boolean", "String"}:
        return f"{variable.type}, a finite number"
    if variable.type not in {"Integer", "Enumeration"}:
        return variable.type
    low, high = integer_limits(variable.exchange)
    return f"{variable.type} from {low} to {high}"
