"""The closed loop of a predicted test: source of signals, friction FMU, twin FMU; and what its loads may be off by."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from fmus import FmuModel, pack_signals, pack_twin
from fmus.runtime.friction_names import FrictionNames
from forming.processes.parameters import constructor_parameters
from friction_models.common import InputError, unknown_name
from friction_models.common.processes.pool import map_unordered
from friction_models.loads import LOAD_NAMES, MU, FloatArray, TriboLoads
from sct_twin.twin.process import SctProcess
from sct_twin.twin.process_uncertainty import process_uncertainties

from ..cosim.run_folders import Run
from ..cosim.system import System
from .schedule import SctSchedule

#: Parameters of `fmus.pack_twin`: `material`, `mesh_size`, `upsetting_mu` ...
TwinParameters = Mapping[str, Any]
#: Sliding of one communication step at the highest speed [mm].
STEP = 0.1
#: A test of many speeds is not followed in more steps than these.
MOST_STEPS = 6000


def sct_system(
    friction: str | os.PathLike[str],
    schedule: SctSchedule,
    fmus: Path,
    *,
    twin: TwinParameters | None = None,
    label: str | None = None,
    names: FrictionNames | None = None,
) -> System:
    """Return the system of one test: source of signals, friction FMU, twin FMU with the test's geometry.

    `fmus` is the folder for the FMU of the signals and that of the twin, which tests of one specimen temperature
    share; the rest is as in `predict_sct`.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from fmus import pack
    >>> from friction_models import ConstantFriction
    >>> plan = {"test_id": "t1", "F_set": 50e3, "v_set": 20.0, "sd_set": 10.0, "T_tool": 20.0}
    >>> with TemporaryDirectory() as place:
    ...     law = pack(ConstantFriction(mu=0.1), Path(place) / "law.fmu", target="python")
    ...     system = sct_system(law, SctSchedule.from_plan(plan), Path(place))
    >>> system.evaluation_order(), system.steps
    (['inputs', 'friction', 'twin'], 100)
    """
    fmus.mkdir(parents=True, exist_ok=True)
    called = names or FrictionNames()
    given = _process_parameters(twin, schedule)
    steps = int(np.clip(np.ceil(schedule.duration * given["speed"] / STEP), 1, MOST_STEPS))
    step = schedule.duration / steps
    fixed = {k: given.pop(k) for k in ("material", "T_specimen") if k in given}
    start = {k: float(v) for k, v in given.items()}
    start |= {"F_n": float(schedule.F_n[0]), "v_slide": float(schedule.v_slide[0])}
    twin_fmu = fmus / ("twin.fmu" if "T_specimen" not in fixed else f"twin-{fixed['T_specimen']:g}C.fmu")
    pack_twin(twin_fmu, **fixed)
    signals = pack_signals(
        fmus / f"inputs-{schedule.test_id}.fmu",
        schedule.edges,
        {
            "F_n": ("N", "normal force", schedule.F_n),
            "v_slide": ("mm/s", "sliding speed of the plate", schedule.v_slide),
            "T_tool": ("degC", "temperature of punch and fresh plate", schedule.T_tool),
        },
        title=f"inputs of test {schedule.test_id}",
        communication_step=step,
    )
    return System.from_dict(
        {
            "name": f"{schedule.test_id}, {label or Path(friction).stem}",
            "communication_step": step,
            "stop_time": step * steps,
            "components": {
                "inputs": {"fmu": str(signals.resolve())},
                "friction": {
                    "fmu": str(Path(friction).resolve()),
                    "start": _system_values(friction, schedule) if names is None else dict(names.start),
                },
                "twin": {"fmu": str(twin_fmu.resolve()), "start": start},
            },
            "connections": [
                *(f"inputs.{name} -> twin.{name}" for name in ("F_n", "v_slide", "T_tool")),
                *(f"twin.{load} -> friction.{target}" for load, target in called.targets()),
                f"friction.{called.mu} -> twin.mu",
            ],
            "order": ["inputs", "friction", "twin"],
            "synthetic": schedule.synthetic,
            "provenance": {"test": schedule.test_id, "friction": label or Path(friction).stem},
        }
    )


def _process_parameters(twin: TwinParameters | None, schedule: SctSchedule) -> dict[str, Any]:
    """Return the parameters of the process: what the user says about specimen, punch and twin, the test before it."""
    allowed = [name for name in constructor_parameters(SctProcess) if name != "thermal"]
    for name, value in (twin or {}).items():
        if name not in allowed:
            raise unknown_name("parameter of the twin", name, allowed)
        if name != "material" and not isinstance(value, (int, float)):
            raise InputError(f"parameter of the twin: {name} = {value!r}; allowed: a number")
    given = {**(twin or {}), **schedule.parameters()}
    given["F_max"] = float(schedule.F_n.max())
    given["speed"] = float(schedule.v_slide.max())
    given["T_tool"] = float(schedule.T_tool[0])
    if schedule.T_specimen is not None:
        given["T_specimen"] = schedule.T_specimen
    return given


def _system_values(friction: str | os.PathLike[str], schedule: SctSchedule) -> dict[str, float]:
    """Return the friction FMU's system variables (roughness, batch) that the test table gives."""
    source = FmuModel(friction).source
    if source is None or not source.system:
        return {}
    tests = pd.DataFrame([{**schedule.metadata, "test_id": schedule.test_id}])
    point = pd.DataFrame([{"test_id": schedule.test_id, **dict.fromkeys(LOAD_NAMES, 1.0)}])
    values = source.system_values(TriboLoads.from_frame(point, tests))
    return {name: float(column[0]) for name, column in values.items()}


def uncertainties_of(
    schedules: Sequence[SctSchedule],
    runs: Sequence[Run],
    *,
    twin: TwinParameters | None = None,
    output: str = MU.name,
    jobs: int | None = None,
) -> list[Mapping[str, FloatArray]]:
    """Return the standard uncertainties of the loads of predicted tests, one mapping a test.

    They are those that the twin states with measured tests (`sct_twin.twin.uncertainty`), under the predicted
    friction; what the friction model may be off by is not in them. The arguments are as in `predict_sct`.
    """
    names = ("inputs.F_n", "inputs.v_slide", "inputs.T_tool", f"friction.{output}")
    tasks = []
    for schedule, run in zip(schedules, runs, strict=True):
        process = _process_parameters(twin, schedule)
        tasks.append((process, np.diff(run.time), *(run[name][1:] for name in names)))
    found = dict(map_unordered(_uncertainties, tasks, jobs))
    return [found[k] for k in range(len(tasks))]


def _uncertainties(
    process: Mapping[str, Any], *steps: *tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
) -> dict[str, FloatArray]:
    return process_uncertainties(SctProcess(**process), *steps)
