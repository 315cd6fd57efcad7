"""How far the loads of a co-simulated forming process may be off: the system again with smaller elements."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fmus.runtime.errors import SimulationError
from forming.results.local_errors import ELEMENTS, FINER, Contact, local_errors, summary
from friction_models.common import InputError, atomic_path
from friction_models.common.netcdf_files import Dataset, NetcdfVariable, read_numbers, write_dataset
from friction_models.common.netcdf_quantities import check_shapes, in_units
from friction_models.common.processes.child_processes import environment
from friction_models.loads import LOAD_NAMES, LOADS
from friction_models.loads.contract import with_unit

from .master import Master
from .run_folders import Run
from .run_results import MOST_NUMBERS

#: In a run folder: stated errors of the loads, one variable a load.
FILE = "local_errors.nc"


def forming_with_elements(master: Master) -> tuple[str, float]:
    """Return the component that computes the loads and has elements, and their size [mm]: one, whose loads are recorded.

    The size is 0 where the process chooses it by its geometry.
    """
    recorded = {item.label for item in master.wiring.recorded}
    found = [
        (name, float(size.start))
        for name, description in master.wiring.descriptions.items()
        for size in description.raw.modelVariables
        if size.name == "mesh_size"
        and size.start is not None
        and {*LOAD_NAMES, "active"} <= description.arrays.keys()
    ]
    if len(found) != 1:
        raise InputError(
            f"{master.system.source}: {len(found)} components with mesh_size, active and the five loads; "
            "allowed with --local-errors: one forming process of this version"
        )
    name, size = found[0]
    missing = [label for label in (f"{name}.{n}" for n in (*LOAD_NAMES, "active")) if label not in recorded]
    if missing:
        raise InputError(f"{master.system.source}: record leaves out {missing[0]}; --local-errors needs it")
    own = master.system.components[name].start.get("mesh_size")
    return name, size if own is None else float(own)  # type: ignore[arg-type]


def state_local_errors(run: Run, master: Master, progress: Callable[[float], None] | None = None) -> str:
    """Run the system of `master` with smaller elements, write the stated errors into the folder of `run`; return a table."""
    name, size = forming_with_elements(master)
    sizes = (
        f"{size:g} mm against {FINER * size:.3g} mm"
        if size > 0.0
        else f"the usual size against {FINER:.3g} of it"
    )
    try:
        # not by mesh_size: a process holds some of its elements smaller by its geometry
        with (
            tempfile.TemporaryDirectory(prefix="tribofmu-") as place,
            environment(**{ELEMENTS: repr(FINER)}),
        ):
            found = Master(master.system, mode=master.mode, tolerance=master.tolerance).run(
                Path(place) / "run", progress
            )
            finer = _contact(found, name)
    except SimulationError as error:
        return f"errors of the loads are not known: with elements {FINER:.3g} times as large {error}"
    loads, active = _contact(run, name)
    if np.array_equal(loads, finer[0]):
        return (
            f"errors of the loads are not known: {name} does the same where smaller elements are asked for; the tribofmu that runs in it is "
            "older than this one"
        )
    errors = local_errors(loads, active, finer)
    about: dict[str, str | int | float] = {"component": name, "elements_smaller_by": FINER}
    if size > 0.0:
        about |= {"mesh_size": size, "compared_with": FINER * size}
    data = Dataset(
        {
            q.name: NetcdfVariable(("time", "point"), errors[:, :, k], {"units": q.unit})
            for k, q in enumerate(LOADS)
        },
        {"time": NetcdfVariable(("time",), run.time[1:], {"units": "s"})},
        about,
    )
    with atomic_path(run.folder / FILE) as path:
        write_dataset(data, path)
    lines = [
        f"stated errors of the loads of {name} (elements of {sizes}): median, and below which 9 of 10 are"
    ]
    return "\n".join([*lines, *(StatedError(*row).line() for row in summary(loads, active, errors))])


class StatedError(NamedTuple):
    """The stated error of one load over the points in contact."""

    load: str
    middle: float  # median of the load
    usual: float  # median of the error
    high: float  # below which 9 of 10 errors are

    def line(self) -> str:
        """Return a line of a table."""
        return f"  {with_unit(self.load):14s} {self.usual:10.3g} {self.high:10.3g}   (median of the load {self.middle:.3g})"


def stated_errors(run: Run) -> list[StatedError]:
    """Return what `state_local_errors` wrote into a run folder, load by load; empty where it wrote nothing."""
    if not (run.folder / FILE).is_file():
        return []
    path = run.folder / FILE
    found = read_numbers(path, LOAD_NAMES, MOST_NUMBERS)
    loads, active = _contact(run, found.attributes.get("component", ""))
    values = in_units(found, {q.name: q.unit for q in LOADS}, path, differences=LOAD_NAMES)
    check_shapes({"loads": loads[..., 0], **values}, ["loads", *LOAD_NAMES], run.time[1:], path)
    errors = np.stack([values[n] for n in LOAD_NAMES], axis=2)
    return [StatedError(*row) for row in summary(loads, active, errors)]


def _contact(run: Run, name: str) -> Contact:
    """Return loads and contact of a run, without its first row: the start, before any contact."""
    loads = np.stack([run[f"{name}.{n}"][1:] for n in LOAD_NAMES], axis=2)
    return loads, run[f"{name}.active"][1:] > 0.5
