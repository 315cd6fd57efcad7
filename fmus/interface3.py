"""The FMI 3.0 variables of a friction FMU: every quantity of a point is an array, its length the parameter `n`."""

from __future__ import annotations

from friction_models.loads import LOADS, MU

from .interface import FrictionInterface, Variable, bounds

#: Names that FMI 3.0 takes besides those of FMI 2.0.
NAMES = ("time", "n", "domain_indicator")
#: Most contact points of one instance; `native/instance.h` has the same number.
MAX_NODES = 100_000


def variables3(interface: FrictionInterface, ode: bool = False) -> list[Variable]:
    """Return the variables in file order.

    Value references: 0 is the time; then one a variable: the five loads, `mu`, `domain_distance`, the states, the
    system variables, with `ode` the derivatives of the states, the bounds of a prediction interval; then `domain_indicator` (only present with
    a recorded domain), `in_domain`, `clamp_to_domain` and `n`.

    Parameters
    ----------
    interface : FrictionInterface
        Its `nodes` is the default of `n`.
    ode : bool
        Whether the states are continuous states.
    """
    loads = tuple(q.name for q in LOADS)
    states = tuple(s.name for s in interface.states)
    system = tuple(p.name for p in interface.system)
    # Tunable parameters count as known at an event and at a communication point; FMI 2.0 does not list them.
    now = (*loads, *(states if ode else ()), *system)
    first = (*loads, *states, *system)
    result = [Variable("time", 0, "independent", unit="s", description="simulation time")]

    def add(
        name: str, causality: str, variability: str = "continuous", initial: str = "", **more: object
    ) -> None:
        result.append(Variable(name, len(result), causality, variability, initial, **more))  # type: ignore[arg-type]

    for q in LOADS:
        start = interface.start(q)
        add(
            q.name,
            "input",
            unit=q.unit,
            start=start,
            lower=q.lower,
            upper=q.upper,
            description=q.meaning,
            array=True,
        )
    add(
        MU.name,
        "output",
        initial="calculated",
        unit=MU.unit,
        lower=0.0,
        description=MU.meaning,
        depends=(*now, "clamp_to_domain"),
        initial_depends=(*first, "clamp_to_domain"),
        array=True,
    )
    add(
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
        add(
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
        add(
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
        add(
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
        add(
            bound,
            "output",
            initial="calculated",
            unit=MU.unit,
            lower=0.0,
            description=meaning,
            depends=(*now, "clamp_to_domain"),
            initial_depends=(*first, "clamp_to_domain"),
            array=True,
        )
    indicator = Variable(
        "domain_indicator",
        len(result),
        "local",
        initial="calculated",
        unit="1",
        description="above 0 where a point in contact is outside the trained domain; in_domain changes where it crosses 0",
        depends=loads,
    )
    booleans = len(result) + 1
    return [
        *result,
        *([indicator] if interface.domain else []),
        Variable(
            "in_domain",
            booleans,
            "output",
            "discrete",
            "calculated",
            "Boolean",
            description="whether every point in contact is inside the trained domain",
            depends=loads,
        ),
        Variable(
            "clamp_to_domain",
            booleans + 1,
            "parameter",
            "tunable",
            "exact",
            "Boolean",
            start=True,
            description="evaluate at the nearest point of the trained domain instead of extrapolating",
        ),
        Variable(
            "n",
            booleans + 2,
            "structuralParameter",
            "fixed",
            "exact",
            "UInt64",
            start=interface.nodes,
            lower=1,
            upper=MAX_NODES,
            description="number of contact points",
        ),
    ]
