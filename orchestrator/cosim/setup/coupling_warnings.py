"""Warnings about the coupling: algebraic loops that the mode does not solve, and steps too long for friction that lags.

Loops are found by the dependencies that FMUs declare.
"""

from __future__ import annotations

from graphlib import CycleError, TopologicalSorter

from fmus.runtime.fmu_files import FmuDescription
from forming.processes.lag_warning import lag_warnings

from .description import SystemDescription
from .wiring import Wiring

#: What a mode does where a loop is closed.
_TREATMENT = {
    "gauss_seidel": "the mode 'gauss_seidel' closes it with values of the step before",
    "jacobi": "the mode 'jacobi' takes values of the step before at every connection of it",
}


def coupling_warnings(system: SystemDescription, wiring: Wiring, mode: str) -> list[str]:
    """Return a sentence about a loop that the mode does not solve, and about each forming FMU whose friction lags too far."""
    if mode == "iterated":  # repeats each step until all values agree
        return []
    return [*_loop_note(wiring, mode), *_lag_notes(system, wiring)]


def _loop_note(wiring: Wiring, mode: str) -> list[str]:
    found = algebraic_loop(wiring)
    if not found:
        return []
    shown = found if len(found) <= 8 else [*found[:8], "..."]
    return [
        f"algebraic loop {' -> '.join([*shown, found[0]])}: each of these values depends on itself within a step; "
        f"{_TREATMENT[mode]}, and 'iterated' solves it"
    ]


def algebraic_loop(wiring: Wiring) -> list[str]:
    """Return the ends of one algebraic loop, ``["a.y", "b.u", "b.z", "a.x"]``; empty where there is none.

    An output depends at once on the inputs that ``ModelStructure`` lists as its dependencies, and on all inputs where it
    says nothing about them, as FMI defines it.
    """
    feeds: dict[str, set[str]] = {}
    for name, description in wiring.descriptions.items():
        _feed_through(name, description, feeds)
    for link in wiring.links:
        for source, target in zip(link.sources, link.targets):
            feeds.setdefault(f"{link.target}.{target.own}", set()).add(f"{link.source}.{source.own}")
    try:
        TopologicalSorter(feeds).prepare()
    except CycleError as error:
        return [end for end in error.args[1][:-1] if not end.endswith(".")]
    return []


def _feed_through(name: str, description: FmuDescription, feeds: dict[str, set[str]]) -> None:
    """Add which inputs each output of a component follows at once; the node ``name.`` stands for all inputs."""
    inputs = {v.name for v in description.raw.modelVariables if v.causality == "input"}
    feeds[f"{name}."] = {f"{name}.{v}" for v in inputs}
    listed = {unknown.variable.name: unknown.dependencies for unknown in description.raw.outputs or ()}
    for variable in description.raw.modelVariables:
        if variable.causality != "output":
            continue
        known = listed.get(variable.name)
        feeds[f"{name}.{variable.name}"] = (
            {f"{name}."} if known is None else {f"{name}.{v.name}" for v in known if v.name in inputs}
        )


def _lag_notes(system: SystemDescription, wiring: Wiring) -> list[str]:
    """Return a sentence for each forming FMU whose tools travel far in a communication step.

    A forming FMU is one that tells its stroke and force and has a parameter `speed` [mm/s]. Where nothing feeds it there
    is no lag.
    """
    notes: list[str] = []
    for name, description in wiring.descriptions.items():
        variables = {v.name: v for v in description.raw.modelVariables}
        fed = any(link.target == name for link in wiring.links)
        if not fed or not {"stroke", "force", "speed"} <= set(variables):
            continue
        start = system.components[name].start.get("speed", variables["speed"].start)
        if variables["speed"].causality == "parameter" and start is not None:
            travel = float(start) * system.communication_step  # type: ignore[arg-type]
            notes += lag_warnings(travel, f"component {name!r}")
    return notes
