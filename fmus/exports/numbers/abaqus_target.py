"""``--target abaqus``: the native table of *FRICTION, for Abaqus/Standard and Explicit jobs without a user subroutine.

Abaqus Keywords Guide, *FRICTION: a line holds mu, slip rate, contact pressure, mean temperature of the two surfaces, then field
variables (DEPENDENCIES); Abaqus interpolates linearly between the lines and keeps the last value outside.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from friction_models.common import InputError
from friction_models.loads import FloatArray

from ...interface.friction_source import FrictionSource
from .. import options
from ..common import Files, c_prefix, description, documents, template
from ..host_units import HostUnits, host_units
from .deviation import deviation, held_system
from .table_target import FrictionTable, tabulate

OPTIONS = (
    "name",
    "fields",
    "units",
    "temperature",
    "points",
    "limits",
    "fixed",
    "system",
    "tolerance",
    "max_rows",
    "start_memory",
)
#: Places of the data line behind mu; the fastest first.
_PLACES = ("v_rel", "sigma_n", "T")
#: Loads that may be field variables.
_FIELDS = ("sd", "psi")


def interpolated(table: FrictionTable, loads: FloatArray) -> FloatArray:
    """Return mu of a table at loads of shape (n, 5), the edge value outside.

    Examples
    --------
    >>> from fmus.source.reading import read_source
    >>> from friction_models import ConstantFriction
    >>> table = tabulate(read_source(ConstantFriction(mu=0.1)), axes="T", limits={"T": (20.0, 200.0)})
    >>> interpolated(table, np.array([[1.0, 500.0, 1.0, 0.0, 1.0]])).round(12).tolist()
    [0.1]
    """
    from scipy.interpolate import RegularGridInterpolator

    from friction_models.loads import LOAD_NAMES

    names = [n for n, x in table.axes.items() if len(x) > 1]
    values = table.mu.reshape([len(table.axes[n]) for n in names])
    if not names:
        return np.full(len(loads), float(values))
    at = np.column_stack(
        [np.clip(loads[:, LOAD_NAMES.index(n)], table.axes[n][0], table.axes[n][-1]) for n in names]
    )
    return np.asarray(RegularGridInterpolator([table.axes[n] for n in names], values)(at))


def friction_lines(table: FrictionTable, axes: tuple[str, ...], units: HostUnits) -> str:
    """Return the data lines: mu, then the loads of `axes` in the units of the job; the first load runs fastest."""
    from friction_models.loads import LOAD_NAMES

    grid = np.stack(np.meshgrid(*(table.axes[n] for n in axes[::-1]), indexing="ij"), -1).reshape(
        -1, len(axes)
    )
    loads = np.ones((len(grid), len(LOAD_NAMES)))
    loads[:, [LOAD_NAMES.index(n) for n in axes[::-1]]] = grid
    host = units.to_host(loads)[:, [LOAD_NAMES.index(n) for n in axes]]
    rows = np.column_stack([table.mu.reshape(-1), host])
    return "".join(", ".join(f"{x:.9g}" for x in row) + "\n" for row in rows)


def abaqus_files(
    source: FrictionSource,
    name: str | None = None,
    fields: object = (),
    units: object = "tonne-mm-s",
    temperature: object = None,
    **given: Any,
) -> Files:
    """Return the files of an Abaqus table.

    Raises InputError: as of `tabulate`; a field that is none.

    Parameters
    ----------
    name : str, optional
        Name of the surface interaction.
    fields : list of str
        Loads of ``sd`` and ``psi`` that the job provides as field variables 1, 2, in this order.
    units, temperature : str
        Units of the job, see `fmus.exports.host_units.host_units`.
    **given
        Options of `fmus.exports.numbers.table_target.tabulate`; `max_rows` is 5000 by default.

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
    found = deviation(source, lambda loads: interpolated(table, loads), table.system)
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
        "FIXED": "\n".join(f"  {line}" for line in held) or "  none",
        "MEMORY": "THIS MODEL HAS MEMORY, which a table cannot have: mu is that of a fresh contact point."
        if source.states
        else "The model has no memory.",
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
