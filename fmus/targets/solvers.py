"""`pack_forming` and `pack_twin`: the solvers as co-simulation FMUs."""

from __future__ import annotations

import inspect
import json
import os
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from friction_models.common import InputError, unknown_name
from friction_models.loads import LOADS, MU, QUANTITIES

from ..archive.content import write_archive
from ..archive.made_here import remember
from ..interface.solver_interface import SolverInterface, indexed, signal
from ..pages.documentation import page

#: `python`: in the simulator's own Python; `process`: in a Python process that the FMU starts.
SOLVER_TARGETS = ("python", "process")

_SCRIPT = '''"""Slave module of this FMU; the solver is in the package tribofmu of the simulator's Python."""

import ctypes

try:
    from fmus.slaves.{solver}_slave import {name}Slave as Fmi2Slave
except ModuleNotFoundError as error:
    raise ImportError(
        f"the Python environment of the simulator lacks {{error.name}}; install it: pip install tribofmu"
    ) from None

# PythonFMU 0.7 runs this file again for every instance and each time gives back a reference to the
# module's dictionary that it does not own; without one more the dictionary is gone.
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))


class {name}SlaveFmu(Fmi2Slave):
    pass
'''

#: Units as the processes write them in messages, where FMI has another name for them.
_FMI_UNITS = {"degrees": "deg", "": "1"}
#: What the loads of the forming FMUs are, more closely than for any friction model.
_FORMING_WORDS = {
    "v_rel": "sliding speed of the workpiece against the tool along the surface: a magnitude, never negative; kept from the last contact where there is none",
    "T": "contact temperature, mean of both surfaces; kept from the last contact where there is none",
    "sigma_n": "contact normal pressure, positive in compression; 0 where there is no contact",
    "sd": "distance that the material point has slid, the integral of v_rel",
    "psi": "surface expansion: area of the rings beside the marker over that area in the undeformed billet",
}
#: Where the markers of each process lie, in their order.
_SURFACES = {
    "fre": "on the billet's surface from the axis at its lower end over the side, which the die works on, to the upper end",
    "bce": "on the billet's surface from the axis at its lower end over the side to the axis under the punch, densest there",
    "upsetting": "on the billet's surface from the axis at its lower face over the side to the axis at its upper face",
    "ring": "on the whole outline of the ring, from the bore at its lower face counter-clockwise back to there",
}
#: Numbers of the processes that are fixed in an FMU: another parameter would renumber the flags behind the parameters.
_FIXED = ("friction_heat_share",)
#: Travel in the default experiment [mm], where the process reaches it.
_STROKE = 20.0


def pack_forming(
    path: str | os.PathLike[str],
    *,
    process: str = "fre",
    target: str = "python",
    platforms: Sequence[str] | None = None,
    python: str | None = None,
    communication_step: float = 0.1,
    stroke: float | None = None,
    **kwargs: Any,
) -> Path:
    """Write a forming process as an FMU for co-simulation.

    Parameters
    ----------
    path : path-like
        The FMU to write.
    process : {"fre", "bce", "upsetting", "ring"}
        Forward rod extrusion, backward cup extrusion, or compression of a cylinder or a ring.
    target : {"python", "process"}
        `python`: the solver runs in the Python interpreter of the simulator. `process`: a native library
        starts the solver as a Python process of its own, for simulators without Python; the package
        tribofmu must be installed in the Python that it finds (environment variable TRIBOFMU_PYTHON, then
        ``python3`` or ``python`` on PATH). The numbers are the same.
    platforms : sequence of str, optional
        Platforms of the native library, target `process` only; this machine's by default.
    python : str, optional
        Interpreter that an FMU of target `process` starts when TRIBOFMU_PYTHON is not set. Such an FMU
        belongs to one machine.
    communication_step : float
        Travel of the punch in one step of the default experiment [mm].
    stroke : float, optional
        Travel in the default experiment [mm]; 20 mm, or what the process allows, by default.
    **kwargs
        Parameters of `forming.ForwardRodExtrusion`, `BackwardCupExtrusion`, `Upsetting` or `RingCompression`; the
        numbers become FMI parameters that can be set before initialization (0: a number that may be left out
        is left out), all else (`n_points`, `material`, switches) is fixed in the FMU.

    Raises
    ------
    InputError
        Unknown process, target or parameter, or a value that the solver refuses; no compiler.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from fmus.runtime.fmu_files import describe
    >>> with TemporaryDirectory() as place:
    ...     description = describe(pack_forming(Path(place) / "fre.fmu", process="fre", stroke=5.0))
    ...     description.resolve("force")[0].unit, description.resolve("mu")[0].causality
    ('kN', 'input')
    """
    from forming.materials.materials import as_material
    from forming.processes.names import PROCESSES
    from forming.processes.parameters import constructor_parameters
    from forming.processes.parameters import meanings as meanings_of

    if process not in PROCESSES:
        raise unknown_name("forming process", process, PROCESSES)
    solver: Any = PROCESSES[process]
    beside = [p.name for p in inspect.signature(pack_forming).parameters.values() if p.kind is p.KEYWORD_ONLY]
    _check_names(solver, kwargs, f"forming process {process!r}", beside=beside)
    made = solver(**kwargs)
    if stroke is None:
        stroke = min(_STROKE, made.max_stroke)
    if not 0.0 < communication_step <= stroke <= made.max_stroke:
        raise InputError(
            f"communication_step = {communication_step!r} mm and stroke = {stroke!r} mm, "
            f"allowed: 0 < communication_step <= stroke <= {made.max_stroke:.3f} mm"
        )
    n = made.n_points
    known = constructor_parameters(solver)
    told = [name for name in made.units if name not in _FIXED]
    numbers = {name: kwargs.get(name, p.default) for name, p in known.items() if name in told}
    meanings = meanings_of(solver)
    surface = _SURFACES[process]
    outputs = [replace(indexed(q, n, i), description=_FORMING_WORDS[q.name]) for q in LOADS for i in range(n)]
    outputs += [
        signal("stroke", "mm", "travel of the punch"),
        signal("force", "kN", f"punch force of {made.name}, positive against the motion of the punch"),
        signal("work", "J", "work of the punch"),
        signal("max_tau_over_k", "1", "highest friction stress over shear yield stress at a node in contact"),
    ]
    places = {"r": "radius", "z": "height along the axis"}
    further = [
        signal(name if n == 1 else f"{name}[{i + 1}]", "mm", f"{what} of the marker; markers lie {surface}")
        for name, what in places.items()
        for i in range(n)
    ]
    fixed = {k: v for k, v in kwargs.items() if k not in numbers and k != "material"} | {"n_points": n}
    if fixed.get("tool_material") is not None:  # its data, not its name: the FMU goes where the file is not
        fixed["tool_material"] = as_material(fixed["tool_material"]).to_dict()
    interface = SolverInterface(
        solver="forming",
        title=made.name,
        identifier=f"forming_{process}",
        outputs=outputs,
        inputs=[indexed(MU, n, i) for i in range(n)],
        parameters={
            name: (_FMI_UNITS.get(made.units[name], made.units[name]), float(value or 0.0))
            for name, value in numbers.items()
        },
        meanings={name: meanings.get(name, "") for name in numbers},
        experiment=(communication_step / made.speed, stroke / made.speed),
        flags=[f"active[{i + 1}]" for i in range(n)],
        further=further,
        fixed={
            "process": process,
            "fixed": fixed,
            "optional": [name for name in numbers if known[name].default is None],
            "material": made.material.to_dict(),
        },
    )
    return write_solver_fmu(path, interface, target, platforms, python)


def pack_twin(
    path: str | os.PathLike[str],
    *,
    target: str = "python",
    platforms: Sequence[str] | None = None,
    python: str | None = None,
    communication_step: float = 0.01,
    duration: float = 1.0,
    **kwargs: Any,
) -> Path:
    """Write the twin of the sliding compression test as an FMU for co-simulation.

    Parameters
    ----------
    path : path-like
        The FMU to write.
    target, platforms, python
        As in `pack_forming`.
    communication_step, duration : float
        Step and end of the default experiment [s].
    **kwargs
        Parameters of `sct_twin.twin.process.SctProcess`; `T_tool` becomes the start value of the input, the
        other numbers FMI parameters, `material` and `T_specimen` are fixed in the FMU.

    Raises
    ------
    InputError
        Unknown target or parameter, or a geometry that cannot be; no compiler.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from fmus.runtime.fmu_files import describe
    >>> with TemporaryDirectory() as place:
    ...     description = describe(pack_twin(Path(place) / "twin.fmu", duration=2.0))
    ...     [name for name, v in description.variables.items() if v.causality == "input"]
    ['F_n', 'v_slide', 'T_tool', 'mu']
    """
    from forming.materials.materials import as_material
    from forming.processes.parameters import constructor_parameters
    from forming.processes.parameters import meanings as meanings_of
    from forming.tools.punch_geometry import PunchGeometry
    from sct_twin.twin.process import SctProcess

    units = {
        "specimen_diameter": "mm",
        "specimen_height": "mm",
        "bore": "mm",
        "tip": "mm",
        "F_max": "N",
        "upsetting_mu": "1",
        "speed": "mm/s",
        "mesh_size": "mm",
        "tip_height": "mm",
        "t_wait": "s",
    }
    _check_names(SctProcess, kwargs, "twin", without=("thermal",))
    known = constructor_parameters(SctProcess)
    values = {name: kwargs.get(name, known[name].default) for name in (*units, "T_tool", "T_specimen")}
    for name, value in values.items():
        if not isinstance(value, (int, float)) and not (name == "T_specimen" and value is None):
            raise InputError(f"{name} = {value!r}, allowed: a number")
    PunchGeometry(
        specimen_diameter=values["specimen_diameter"],
        specimen_height=values["specimen_height"],
        bore_diameter=values["bore"] or None,
        tip_diameter=values["tip"] or None,
        tip_height=values["tip_height"],
    )
    if not 0.0 < communication_step <= duration:
        raise InputError(
            f"communication_step = {communication_step!r} s and duration = {duration!r} s, "
            "allowed: 0 < communication_step <= duration"
        )
    T = QUANTITIES["T"]
    tool = "temperature of punch and fresh plate"
    interface = SolverInterface(
        solver="twin",
        title="sliding compression test",
        identifier="twin_sct",
        outputs=[indexed(q, 1, 0) for q in LOADS],
        inputs=[
            signal("F_n", "N", "normal force", float(values["F_max"]), 0.0, 1e8),
            signal("v_slide", "mm/s", "sliding speed of the plate", float(values["speed"]), 0.0, 1e5),
            signal("T_tool", "degC", tool, float(values["T_tool"]), T.lower, T.upper),
            indexed(MU, 1, 0),
        ],
        parameters={n: (u, float(values[n])) for n, u in units.items()},
        meanings=meanings_of(SctProcess),
        experiment=(communication_step, duration),
        fixed={
            "material": as_material(kwargs.get("material")).to_dict(),
            "T_specimen": values["T_specimen"],
        },
    )
    return write_solver_fmu(path, interface, target, platforms, python)


def _check_names(
    solver: Any,
    names: Iterable[str],
    what: str,
    without: Sequence[str] = (),
    beside: Sequence[str] = (),
) -> None:
    """Refuse unknown parameters of `what`; options of the packing itself (`beside`) are allowed names, too."""
    from forming.processes.parameters import constructor_parameters

    allowed = [p for p in constructor_parameters(solver) if p not in without]
    for name in names:
        if name not in allowed:
            raise unknown_name(f"parameter of the {what}", name, [*beside, *allowed])


def write_solver_fmu(
    path: str | os.PathLike[str],
    interface: SolverInterface,
    target: str,
    platforms: Sequence[str] | None = None,
    python: str | None = None,
) -> Path:
    """Write a solver FMU."""
    if target not in SOLVER_TARGETS:
        raise unknown_name("target of a solver FMU", target, SOLVER_TARGETS)
    if Path(path).suffix != ".fmu":
        raise InputError(f"{path}: suffix {Path(path).suffix!r}, allowed: '.fmu'")
    description, config = interface.description(target), interface.config()
    facts = {name: f"{value:g} {unit}" for name, (unit, value) in interface.parameters.items()}
    sections: dict[str, object] = {"Parameters": facts, "Fixed in this FMU": config.get("material")}
    if target == "process":
        from .process import process_fmu_files

        files = process_fmu_files(description, interface.solver, config, platforms, python)
        sections["Where the solver runs"] = {
            "TRIBOFMU_PYTHON": "environment variable: the Python interpreter in which tribofmu is installed; "
            + (f"without it {python}" if python else "without it python3 or python on PATH"),
            "TRIBOFMU_TIMEOUT": "environment variable: longest time of one call [s]; 1800 without it, 0 for no limit",
        }
    else:
        for name, given in (("platforms", platforms), ("python", python)):
            if given:
                raise InputError(f"{name} = {given!r}, allowed with the target 'process' only")
        from .python import python_fmu_files

        script = _SCRIPT.format(solver=interface.solver, name=interface.solver.capitalize())
        files = python_fmu_files(
            description, script, {"interface.json": (json.dumps(config) + "\n").encode()}
        )
    files["documentation/index.html"] = page(interface.title, sections)
    return remember(write_archive(path, files))
