"""Ready-made system: a forming FMU with a friction FMU."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from fmus.runtime.friction_names import FrictionNames
from friction_models.loads import LOAD_NAMES

from .system import System

#: Punch travel of one communication step [mm].
STEP = 0.1
#: Punch travel of a run [mm].
STROKE = 20.0
RECORDED = ("stroke", "force", "work", "max_tau_over_k", "active", *LOAD_NAMES, "mu")


def extrusion_system(
    friction: str | os.PathLike[str],
    forming: str | os.PathLike[str],
    speed: float,
    stroke: float = STROKE,
    name: str = "fre",
    synthetic: bool = False,
    provenance: Mapping[str, bool | int | float | str] | None = None,
    step: float = STEP,
    start: Mapping[str, bool | int | float | str] | None = None,
    names: FrictionNames | None = None,
) -> System:
    """Return forward rod extrusion, friction first: the one-step lag of the paper's user subroutine.

    Parameters
    ----------
    friction : path-like
        Friction FMU with as many nodes as the forming FMU has markers.
    forming : path-like
        Forming FMU (`fmus.pack_forming`).
    speed : float
        Punch speed of the forming FMU [mm/s].
    stroke : float
        Punch travel of the run [mm].
    name, synthetic, provenance
        Go into the manifest of the run.
    step : float
        Punch travel of one communication step [mm]; the stroke is rounded to whole steps.
    start : mapping, optional
        Start values of the friction FMU, such as ``clamp_to_domain``.
    names : FrictionNames, optional
        Which variables of a friction FMU that others made take the loads and give mu.

    Examples
    --------
    >>> system = extrusion_system("friction.fmu", "fre.fmu", speed=20.0, stroke=5.0)
    >>> system.steps, system.stop_time, system.connections[-1]
    (50, 0.25, 'friction.mu -> forming.mu')
    """
    seconds = step / speed
    called = names or FrictionNames()
    component: dict[str, object] = {
        "fmu": str(Path(friction).resolve()),
        "start": dict(called.start) | dict(start or {}),
    }
    if called.each_point:
        component["each_point"] = True
    if names is not None:  # an FMU of others, which may have no answer to zero pressure
        component["contact_only"] = True
    return System.from_dict(
        {
            "name": name,
            "communication_step": seconds,
            "stop_time": seconds * max(1, round(stroke / step)),
            "components": {
                "friction": component,
                "forming": {"fmu": str(Path(forming).resolve())},
            },
            "connections": [
                *(f"forming.{load} -> friction.{end}" for load, end in called.targets()),
                f"friction.{called.mu} -> forming.mu",
            ],
            "record": [
                f"friction.{called.mu}",
                *(["friction.domain_distance"] if called.has_distance else []),
                *(f"forming.{n}" for n in RECORDED if n != "mu"),
            ],
            "synthetic": synthetic,
            "provenance": dict(provenance or {}),
        }
    )
