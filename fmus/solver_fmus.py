"""`pack_forming` and `pack_twin`: the solvers as co-simulation FMUs that run in Python."""

from __future__ import annotations

import dataclasses
import inspect
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from friction_models.loads import LOADS, MU, InputError, Quantity, unknown_name

from .archive import write_archive
from .documentation import page
from .interface import Variable
from .model_description import Description
from .python_target import python_fmu_files

_SCRIPT = '''"""Slave module of this FMU; the solver is in the package tribofmu of the simulator's Python."""

import ctypes

try:
    from fmus.slaves.{module} import {name} as Fmi2Slave
except ModuleNotFoundError as error:
    raise ImportError(
        f"the Python environment of the simulator lacks {{error.name}}; install it: pip install tribofmu"
    ) from None

# PythonFMU 0.7 runs this file again for every instance and each time gives back a reference to the
# module's dictionary that it does not own; without one more the dictionary is gone.
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))


class {name}Fmu(Fmi2Slave):
    pass
'''


def pack_forming(
    path: str | os.PathLike[str], *, communication_step: float = 0.1, stroke: float = 20.0, **kwargs: Any
) -> Path:
    """Write the forward rod extrusion as an FMU (co-simulation, Python).

    Parameters
    ----------
    path : path-like
        The FMU to write.
    communication_step : float
        Travel of the punch in one step of the default experiment [mm].
    stroke : float
        Travel in the default experiment [mm].
    **kwargs
        Parameters of `forming.ForwardRodExtrusion`; the numbers become FMI parameters that can be set
        before initialization, all else (`n_points`, `material`, switches) is fixed in the FMU.

    Raises
    ------
    InputError
        Unknown parameter, or a value that the solver refuses.
    """
    from forming.fre import ForwardRodExtrusion

    units = {
        "diameter": "mm",
        "exit_diameter": "mm",
        "half_angle": "deg",
        "billet_length": "mm",
        "speed": "mm/s",
        "T_billet": "degC",
        "T_tool": "degC",
        "mesh_size": "mm",
        "entry_radius": "mm",
        "edge_radius": "mm",
        "land": "mm",
    }
    _check_names(ForwardRodExtrusion, kwargs)
    process = ForwardRodExtrusion(**kwargs)
    if not 0.0 < communication_step <= stroke <= process.max_stroke:
        raise InputError(
            f"communication_step = {communication_step!r} mm and stroke = {stroke!r} mm, "
            f"allowed: 0 < communication_step <= stroke <= {process.max_stroke:.3f} mm"
        )
    n = process.n_points
    parameters = {
        name: (unit, float(_value(ForwardRodExtrusion, kwargs, name))) for name, unit in units.items()
    }
    outputs = [_indexed(q, n, i) for q in LOADS for i in range(n)]
    outputs += [
        _Signal("stroke", "mm", "travel of the punch"),
        _Signal("force", "kN", "punch force"),
        _Signal("work", "J", "work of the punch"),
        _Signal("max_tau_over_k", "1", "highest friction stress over shear yield stress"),
    ]
    inputs = [_indexed(MU, n, i) for i in range(n)]
    flags = [f"active[{i + 1}]" for i in range(n)]
    fixed = {k: v for k, v in kwargs.items() if k not in units and k != "material"}
    config = {"fixed": fixed | {"n_points": n}, "material": dataclasses.asdict(process.material)}
    return _write(
        path,
        ("forming_slave", "FormingSlave"),
        "forward rod extrusion",
        "forming_fre",
        (outputs, inputs, parameters, flags),
        config,
        (communication_step / process.speed, stroke / process.speed),
    )


def pack_twin(
    path: str | os.PathLike[str], *, communication_step: float = 0.01, duration: float = 1.0, **kwargs: Any
) -> Path:
    """Write the twin of the sliding compression test as an FMU (co-simulation, Python).

    Parameters
    ----------
    path : path-like
        The FMU to write.
    communication_step, duration : float
        Step and end of the default experiment [s].
    **kwargs
        Parameters of `sct_twin.process.SctProcess`; `T_tool` becomes the start value of the input, the
        other numbers FMI parameters, `material` and `T_specimen` are fixed in the FMU.

    Raises
    ------
    InputError
        Unknown parameter, or a geometry that cannot be.
    """
    from forming.material import steel_16MnCr5
    from forming.upsetting import PunchGeometry
    from sct_twin.process import SctProcess

    units = {
        "specimen_diameter": "mm",
        "specimen_height": "mm",
        "bore": "mm",
        "tip": "mm",
        "F_max": "N",
        "upsetting_mu": "1",
        "speed": "mm/s",
        "mesh_size": "mm",
    }
    _check_names(SctProcess, kwargs, without=("thermal",))
    values = {name: _value(SctProcess, kwargs, name) for name in (*units, "T_tool", "T_specimen")}
    for name, value in values.items():
        if not isinstance(value, (int, float)) and not (name == "T_specimen" and value is None):
            raise InputError(f"{name} = {value!r}, allowed: a number")
    PunchGeometry(
        specimen_diameter=values["specimen_diameter"],
        specimen_height=values["specimen_height"],
        bore_diameter=values["bore"] or None,
        tip_diameter=values["tip"] or None,
    )
    if not 0.0 < communication_step <= duration:
        raise InputError(
            f"communication_step = {communication_step!r} s and duration = {duration!r} s, "
            "allowed: 0 < communication_step <= duration"
        )
    T = next(q for q in LOADS if q.name == "T")
    inputs = [
        _Signal("F_n", "N", "normal force", float(values["F_max"]), 0.0, 1e8),
        _Signal("v_slide", "mm/s", "sliding speed of the plate", float(values["speed"]), 0.0, 1e5),
        _Signal(
            "T_tool",
            "degC",
            "temperature of punch and fresh plate",
            float(values["T_tool"]),
            T.lower,
            T.upper,
        ),
        _Signal(MU.name, MU.unit, MU.meaning, MU.nominal, MU.lower, MU.upper),
    ]
    config = {
        "material": dataclasses.asdict(kwargs.get("material") or steel_16MnCr5()),
        "T_specimen": values["T_specimen"],
    }
    return _write(
        path,
        ("twin_slave", "TwinSlave"),
        "sliding compression test",
        "twin_sct",
        (
            [_indexed(q, 1, 0) for q in LOADS],
            inputs,
            {n: (u, float(values[n])) for n, u in units.items()},
            (),
        ),
        config,
        (communication_step, duration),
    )


@dataclasses.dataclass(frozen=True)
class _Signal:
    name: str
    unit: str
    meaning: str
    start: float = 0.0
    lower: float | None = None
    upper: float | None = None


def _indexed(quantity: Quantity, n: int, i: int) -> _Signal:
    name = quantity.name if n == 1 else f"{quantity.name}[{i + 1}]"
    q = quantity
    return _Signal(name, q.unit, q.meaning, q.nominal, q.lower, q.upper)


def _check_names(solver: Any, kwargs: Mapping[str, Any], without: Sequence[str] = ()) -> None:
    allowed = [p for p in inspect.signature(solver).parameters if p not in without]
    for name in kwargs:
        if name not in allowed:
            raise unknown_name(f"parameter of {solver.__name__}", name, allowed)


def _value(solver: Any, kwargs: Mapping[str, Any], name: str) -> Any:
    return kwargs.get(name, inspect.signature(solver).parameters[name].default)


def _write(
    path: str | os.PathLike[str],
    slave: tuple[str, str],
    title: str,
    identifier: str,
    signals: tuple[Sequence[_Signal], Sequence[_Signal], Mapping[str, tuple[str, float]], Sequence[str]],
    config: dict[str, Any],
    experiment: tuple[float, float],
) -> Path:
    """Write a solver FMU: outputs, inputs and parameters are numbered in this order, as the slave keeps them."""
    if Path(path).suffix != ".fmu":
        raise InputError(f"{path}: suffix {Path(path).suffix!r}, allowed: '.fmu'")
    outputs, inputs, parameters, flags = signals
    depends = tuple(parameters)
    # Outputs answer the inputs of the step before: no direct dependence, no algebraic loop for any master.
    variables = [
        Variable(
            s.name,
            i,
            "output",
            initial="calculated",
            unit=s.unit,
            description=s.meaning,
            depends=(),
            initial_depends=depends,
        )
        for i, s in enumerate(outputs)
    ]
    variables += [
        Variable(
            s.name,
            len(outputs) + i,
            "input",
            unit=s.unit,
            start=s.start,
            lower=s.lower,
            upper=s.upper,
            description=s.meaning,
        )
        for i, s in enumerate(inputs)
    ]
    variables += [
        Variable(name, len(outputs) + len(inputs) + i, "parameter", "fixed", "exact", unit=unit, start=value)
        for i, (name, (unit, value)) in enumerate(parameters.items())
    ]
    variables += [
        Variable(
            name,
            i,
            "output",
            "discrete",
            "calculated",
            "Boolean",
            description="whether the marker is in contact",
            depends=(),
            initial_depends=depends,
        )
        for i, name in enumerate(flags)
    ]
    reals = [v for v in variables if v.type == "Real"]
    config = config | {
        "names": [v.name for v in reals],
        "first_input": len(outputs),
        "first_parameter": len(outputs) + len(inputs),
        "start": [float(v.start or 0.0) for v in reals],
        "flags": len(flags),
    }
    step, stop = experiment
    description = Description(
        model_name=title,
        identifier=identifier,
        guid="",
        text=f"{title}; runs in Python with the package tribofmu",
        variables=variables,
        co_simulation={
            "needsExecutionTool": True,
            "canHandleVariableCommunicationStepSize": True,
            "canInterpolateInputs": False,
            "canBeInstantiatedOnlyOncePerProcess": False,
            "canNotUseMemoryManagementFunctions": True,
            "canGetAndSetFMUstate": True,
            "canSerializeFMUstate": False,
        },
        step=step,
        stop=stop,
        annotations={"target": "python"},
    )
    script = _SCRIPT.format(module=slave[0], name=slave[1])
    files = python_fmu_files(description, script, {"interface.json": (json.dumps(config) + "\n").encode()})
    facts = {name: f"{value:g} {unit}" for name, (unit, value) in parameters.items()}
    files["documentation/index.html"] = page(
        title, {"Parameters": facts, "Fixed in this FMU": config.get("material")}
    )
    return write_archive(path, files)
