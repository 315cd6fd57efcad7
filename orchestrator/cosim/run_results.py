"""Results of a run, read back from `results.nc`."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from friction_models.common import InputError
from friction_models.common.netcdf_files import read_numbers
from friction_models.common.netcdf_quantities import check_shapes, in_units
from friction_models.common.units import spelling, units_like
from friction_models.loads import LOAD_NAMES, LOADS, MU, FloatArray

#: Most numbers of a file that is read back: ten million steps of twenty results.
MOST_NUMBERS = 200_000_000
_FORCE_CURVE = {"stroke": "mm", "force": "kN"}
_UNITS = {q.name: q.unit for q in (*LOADS, MU)} | _FORCE_CURVE


class RunResults(NamedTuple):
    """What `results.nc` holds: one entry a communication point, and one a contact point where there are several."""

    time: FloatArray
    values: dict[str, FloatArray]
    units: dict[str, str]


def read_results(path: Path) -> RunResults:
    """Read the results of a run, what is known by its name in the project's unit.

    Raises InputError: the file cannot be read, is too large, has no step; a unit that does not fit, a variable of another shape.
    """
    found = read_numbers(path, ["time"], MOST_NUMBERS)
    units = {name: unit for name, unit in found.units.items() if name not in found.scales}
    known = _known(units)
    values = in_units(found, {"time": "s", **known}, path)
    time = values["time"]
    if time.ndim != 1 or len(time) < 2:
        raise InputError(f"{path}: time has the shape {time.shape}; allowed: one step at least")
    for name in units:
        if values[name].ndim == 2:
            check_shapes(values, [name], time, path)
        elif values[name].shape != time.shape:
            check_shapes(values, ["time", name], time, path)
    for component in {name.rpartition(".")[0] for name in units}:
        loads = [f"{component}.{name}" for name in (*LOAD_NAMES, MU.name, "active")]
        if set(loads[: len(LOAD_NAMES)]) <= units.keys():
            check_shapes(values, [name for name in loads if name in units], time, path)
    return RunResults(time, {name: values[name] for name in units}, units | known)


def _known(units: dict[str, str]) -> dict[str, str]:
    """Return the project's unit of each result that is a load, mu, a stroke or a force.

    What is called like one and measures something else is left alone, unless all that makes a process stands beside it.
    A pure number is a value of an FMU that states no unit.
    """
    known = {}
    for label, unit in units.items():
        component, _, name = label.rpartition(".")
        beside = _FORCE_CURVE if name in _FORCE_CURVE else LOAD_NAMES
        if name in _UNITS and (
            spelling(unit) in units_like(_UNITS[name])
            or (spelling(unit) != "1" and all(f"{component}.{n}" in units for n in beside))
        ):
            known[label] = _UNITS[name]
    return known
