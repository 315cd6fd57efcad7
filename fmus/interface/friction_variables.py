"""The FMI variables of a friction FMU: one table for both versions of the standard."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from friction_models.loads import LOADS, MU

from .quantities import DeclaredVariable, FrictionInterface, bounds, parameter_arrays

#: Names that FMI 3.0 takes besides those of FMI 2.0.
NAMES = ("time", "n", "domain_indicator")
#: Most contact points of one instance; `native/instance.h` has the same number.
MAX_NODES = 100_000
#: What the description of a load adds that the training data did not hold.
NOT_MEASURED = "; not measured in training, no influence"


def table(interface: FrictionInterface, ode: bool = False) -> Iterator[DeclaredVariable]:
    """Yield one variable a quantity, not yet numbered; `array` where every contact point has a value of its own.

    The five loads, `mu`, `domain_distance`, the states, the system variables, with `ode` (the states are continuous states)
    the derivatives of the states, the bounds of a prediction interval; then `in_domain` and `clamp_to_domain`.
    """
    loads = tuple(q.name for q in LOADS)
    states = tuple(s.name for s in interface.states)
    system = tuple(p.name for p in interface.system)
    now = (*loads, *(states if ode else ()), *system)
    first = (*loads, *states, *system)

    def coefficient(name: str, meaning: str) -> DeclaredVariable:
        return DeclaredVariable(
            name,
            "output",
            initial="calculated",
            unit=MU.unit,
            nominal=MU.nominal,
            lower=0.0,
            description=meaning,
            depends=(*now, "clamp_to_domain"),
            initial_depends=(*first, "clamp_to_domain"),
            array=True,
        )

    for q in LOADS:
        yield DeclaredVariable(
            q.name,
            "input",
            unit=q.unit,
            nominal=q.nominal,
            start=interface.start(q),
            lower=q.lower,
            upper=q.upper,
            description=q.meaning + (NOT_MEASURED if q.name in interface.absent else ""),
            array=True,
        )
    yield coefficient(MU.name, MU.meaning)
    yield DeclaredVariable(
        "domain_distance",
        "output",
        initial="calculated",
        unit="1",
        lower=0.0,
        description="0 inside the trained domain; outside, largest exceedance in units of a load's range",
        depends=loads,
        array=True,
    )
    for s in interface.states:
        yield DeclaredVariable(
            s.name,
            "local",
            initial="exact",
            unit=s.unit,
            start=s.start,
            nominal=s.nominal if ode else None,
            description="memory of the contact point",
            array=True,
        )
    for p in interface.system:
        yield DeclaredVariable(
            p.name,
            "parameter",
            "tunable",
            "exact",
            unit=p.unit,
            start=p.start,
            lower=p.minimum,
            description=p.description,
        )
    for s in interface.states if ode else ():
        yield DeclaredVariable(
            f"der({s.name})",
            "local",
            initial="calculated",
            unit=s.rate_unit,
            derivative=s.name,
            description=f"rate of {s.name}, 0 without contact",
            depends=now,
            initial_depends=first,
            array=True,
        )
    for bound, meaning in bounds(interface.interval):
        yield coefficient(bound, meaning)
    yield DeclaredVariable(
        "in_domain",
        "output",
        "discrete",
        "calculated",
        type="Boolean",
        description="whether every point in contact is inside the trained domain",
        depends=loads,
    )
    yield DeclaredVariable(
        "clamp_to_domain",
        "parameter",
        "tunable",
        "exact",
        type="Boolean",
        start=True,
        description="evaluate at the nearest point of the trained domain instead of extrapolating",
    )


def variables2(interface: FrictionInterface, ode: bool = False) -> list[DeclaredVariable]:
    """Return the scalar variables of FMI 2.0 in file order, every point of a quantity after the other.

    Value references count through the file, over all types: `native/fmi2.c` does the same.

    Examples
    --------
    >>> from fmus.interface.quantities import FrictionInterface
    >>> names = [v.name for v in variables2(FrictionInterface(nodes=2))]
    >>> [name for name in names if name.startswith(("T[", "mu["))]
    ['T[1]', 'T[2]', 'mu[1]', 'mu[2]']
    """
    rows = list(table(interface, ode))
    by_point = {row.name for row in rows if row.array}
    # Tunable parameters are known at an event and at a communication point; FMI 2.0 lists them for the start only.
    parameters = {row.name for row in rows if row.causality == "parameter"}
    points = range(interface.nodes)

    def named(name: str, i: int) -> str:
        if interface.nodes == 1 or name not in by_point:
            return name
        return f"{name[:-1]}[{i + 1}])" if name.endswith(")") else f"{name}[{i + 1}]"

    def known(names: tuple[str, ...] | None, row: DeclaredVariable, i: int) -> tuple[str, ...] | None:
        if names is None or row.array:
            return None if names is None else tuple(named(name, i) for name in names)
        return tuple(named(name, k) for name in names for k in points)

    def expanded() -> Iterator[DeclaredVariable]:
        for row in rows:
            always = None if row.depends is None else tuple(d for d in row.depends if d not in parameters)
            for i in points if row.array else (0,):
                yield replace(
                    row,
                    name=named(row.name, i),
                    derivative=named(row.derivative, i) if row.derivative else "",
                    depends=known(always, row, i),
                    initial_depends=known(row.initial_depends, row, i),
                    array=False,
                )

    return [replace(v, reference=k) for k, v in enumerate(expanded())]


def variables3(interface: FrictionInterface, ode: bool = False) -> list[DeclaredVariable]:
    """Return the variables of FMI 3.0 in file order: scalars, or arrays whose length is the parameter `n`.

    Value references: 0 is the time; then the Real rows of the table, `domain_indicator` (only present with a recorded
    domain), the Boolean rows, and `n`. Yet `n` stands before the arrays, as some importers resolve a dimension while
    they read.

    Examples
    --------
    >>> from fmus.interface.quantities import FrictionInterface
    >>> [v.name for v in variables3(FrictionInterface(nodes=2, arrays=True)) if v.array][:6]
    ['v_rel', 'T', 'sigma_n', 'sd', 'psi', 'mu']
    """
    rows = [v if interface.sized else replace(v, array=False) for v in table(interface, ode)]
    rows.insert(
        sum(v.type == "Real" for v in rows),
        DeclaredVariable(
            "domain_indicator",
            "local",
            initial="calculated",
            unit="1",
            description="above 0 where a point in contact is outside the trained domain; in_domain changes where it crosses 0",
            depends=tuple(q.name for q in LOADS),
        ),
    )
    numbered = [replace(v, reference=k + 1) for k, v in enumerate(rows)]
    time = DeclaredVariable("time", "independent", unit="s", description="simulation time")
    size = DeclaredVariable(
        "n",
        "structuralParameter",
        "fixed",
        "exact",
        "UInt64",
        start=interface.nodes,
        lower=1,
        upper=MAX_NODES,
        description="number of contact points",
        reference=len(numbered) + 1,
    )
    shown = [v for v in _gathered(numbered, interface) if interface.domain or v.name != "domain_indicator"]
    return [time, *([size] if interface.sized else []), *shown]


def _gathered(rows: Iterable[DeclaredVariable], interface: FrictionInterface) -> Iterator[DeclaredVariable]:
    """Yield the variables with arrays of system variables in place of their elements.

    An array has the reference of its first element; those of the others are not used.
    """
    arrays = parameter_arrays(interface.system)
    owner = {name: array.name for array in arrays for name in array.elements()}
    firsts = {array.elements()[0]: array for array in arrays}
    starts = [p.start for p in interface.system]

    def named(names: tuple[str, ...] | None) -> tuple[str, ...] | None:
        return None if names is None else tuple(dict.fromkeys(owner.get(n, n) for n in names))

    for row in rows:
        if row.name in firsts:
            array = firsts[row.name]
            values = tuple(starts[array.first : array.first + array.size])
            yield replace(row, name=array.name, shape=array.shape, starts=values)
        elif row.name not in owner:
            yield replace(row, depends=named(row.depends), initial_depends=named(row.initial_depends))
