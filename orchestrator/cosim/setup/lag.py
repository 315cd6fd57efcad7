"""Forming components whose friction lags too far behind their loads."""

from __future__ import annotations

from forming.processes.lag import lag_warnings

from .description import SystemDescription
from .wiring import Wiring


def lag_notes(system: SystemDescription, wiring: Wiring, mode: str) -> list[str]:
    """Return a sentence for each forming FMU whose tools travel far in a communication step.

    A forming FMU is one that tells its stroke and force and has a parameter `speed` [mm/s]. Where nothing feeds it
    or the mode repeats the steps, there is no lag.
    """
    if mode == "iterated":
        return []
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
