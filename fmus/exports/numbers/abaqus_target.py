"""``--target abaqus``: the native table of *FRICTION, for Abaqus/Standard and Explicit jobs without a user subroutine.

Abaqus Keywords Guide, *FRICTION: a line holds mu, slip rate, contact pressure, mean temperature of the two surfaces, then field
variables (DEPENDENCIES); Abaqus interpolates linearly between the lines and keeps the last value outside.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES

from ...interface.friction_source import FrictionSource
from .. import options
from ..common import Files, c_prefix, description, documents, rows, template
from ..host_units import HostUnits, host_units
from .deviation import deviation, held_system
from .grid import grid_points, interpolated
from .table_target import OPTIONS as TABLE_OPTIONS
from .table_target import FrictionTable, memory_note, tabulate

#: The axes are not free: those of the data lines, and the fields.
OPTIONS = ("name", "fields", "units", "temperature", *(o for o in TABLE_OPTIONS if o != "axes"))
#: Places of the data line behind mu; the fastest first.
_PLACES = ("v_rel", "sigma_n", "T")
#: Loads that may be field variables.
_FIELDS = ("sd", "psi")


def friction_lines(table: FrictionTable, axes: tuple[str, ...], units: HostUnits) -> str:
    """Return the data lines: mu, then the loads of `axes` in the units of the job; the first load runs fastest."""
    loads = np.ones((table.mu.size, len(LOAD_NAMES)))
    loads[:, [LOAD_NAMES.index(n) for n in table.axes]] = grid_points(list(table.axes.values()))
    host = units.to_host(loads)[:, [LOAD_NAMES.index(n) for n in axes]]
    lines = np.column_stack([table.mu.reshape(-1), host])
    return "".join(", ".join(f"{x:.9g}" for x in line) + "\n" for line in lines)


def abaqus_files(
    source: FrictionSource,
    name: str | None = None,
    fields: object = (),
    units: object = "tonne-mm-s",
    temperature: object = None,
    **given: Any,
) -> Files:
    """Return the files of an Abaqus table; `name` is that of the surface interaction.

    `fields` are loads of ``sd`` and ``psi`` that the job provides as field variables 1, 2, in this order; `units` and
    `temperature` are those of the job (`host_units`). `given` are options of `tabulate`, whose `max_rows` is 5000 by default.
    Raises InputError: as of `tabulate`; a field that is none.

    Examples
    --------
    >>> from fmus.source.reading import read_source
    >>> from friction_models import ConstantFriction
    >>> sorted(abaqus_files(read_source(ConstantFriction(mu=0.1)), name="law"))
    ['LICENSE.txt', 'README.txt', 'card.json', 'law_friction.inp', 'model.onnx', 'table.json']
    """
    chosen = tuple(options.axis_names(fields)) if fields else ()
    if any(f not in _FIELDS for f in chosen):
        raise InputError(f"fields = {list(chosen)}, allowed: any of {', '.join(_FIELDS)}")
    host = host_units(units, temperature)
    axes = (*_PLACES, *chosen)
    table = tabulate(source, axes=axes[::-1], **{"max_rows": 5000, **given})
    grid, columns_of = list(table.axes.values()), [LOAD_NAMES.index(n) for n in table.axes]
    found = deviation(source, lambda loads: interpolated(grid, table.mu, loads[:, columns_of]), table.system)
    held = [*table.held(), *held_system(source, table.system)]
    prefix = c_prefix(source, name)
    columns = host.columns()
    texts = [f"{n} [{columns[n]}]" for n in axes]
    values = description(source) | {
        "P": prefix,
        "UNITS": host.text(),
        "COLUMNS": ", ".join(["mu", *texts]),
        "SUMMARY": table.summary(),
        "DEVIATION": found.text(),
        "LARGEST": f"{found.largest:.3g}",
        "DEPENDENCIES": f", DEPENDENCIES={len(chosen)}" if chosen else "",
        "FIELDS": "".join(
            f"  Field variable {k} is {t}: provide it (*FIELD, or a user subroutine).\n"
            for k, t in enumerate((f"{n} [{columns[n]}]" for n in chosen), 1)
        )
        or '  The job needs no field variable. --set "fields=[sd, psi]" makes axes of what it can provide as fields.\n',
        "FIXED": rows(held),
        "MEMORY": memory_note(source),
        "DATA": friction_lines(table, axes, host),
    }
    report = {
        "rows": int(table.mu.size),
        "columns": ["mu", *axes],
        "units": host.text(),
        "tolerance": table.tolerance,
        "tolerance met": table.met,
        "largest error of the interpolation": table.largest,
        "held": held,
        "summary": f"{table.summary()}; with the loads that are held mu is off by at most {found.text()}",
        "remaining": found.report(),
    }
    return {
        f"{prefix}.inp": template("abaqus.inp", values),
        "table.json": json.dumps(report, indent=2) + "\n",
        "README.txt": template("readme_abaqus.txt", values),
        **documents(source),
    }
