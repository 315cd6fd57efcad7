"""``--target table``: mu over a grid of loads, for codes with friction tables, with its interpolation error.

The grid is refined where linear interpolation is worst until the error is below a tolerance or the table is
as large as allowed; then the error of multilinear interpolation is measured at points that took no part in
choosing the grid.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from friction_models.common import InputError
from friction_models.loads import LOAD_NAMES, QUANTITIES, FloatArray

from ...interface.friction_source import FrictionSource
from ...interface.quantities import USUAL
from .. import options
from ..common import Files, Reference, description, documents, rows, template
from .deviation import held_loads, held_system, system_values, with_unit
from .grid import Grid, grid_points

OPTIONS = ("axes", "points", "limits", "fixed", "system", "tolerance", "max_rows", "start_memory")
#: Order of the axes when none are named; sd is left to `fixed`.
AXES = ("sigma_n", "T", "psi", "v_rel")
MAX_ROWS = 2_000_000
#: Random points at which the error is measured.
_MEASURED = 20_000


@dataclass(frozen=True)
class FrictionTable:
    """mu on a grid."""

    axes: dict[str, FloatArray]  #: Load name to grid lines, in the order of the axes of `mu`.
    mu: FloatArray  #: One axis a load.
    fixed: dict[str, float]  #: The other loads.
    system: dict[str, float]  #: Values of the system variables.
    tolerance: float  #: Wanted largest error.
    largest: float  #: Measured largest error of multilinear interpolation.
    rms: float  #: Its root mean square.
    left_out: dict[str, float]  #: How much mu changes at most over the trained range of each fixed load.
    trained: dict[str, tuple[float, float]]  #: Trained range of the loads, where it is recorded.
    full: bool  #: Whether the grid ended at the largest allowed number of rows.

    @property
    def met(self) -> bool:
        """Whether the measured error is below the tolerance."""
        return self.largest <= self.tolerance

    def held(self) -> list[str]:
        """Return a sentence for each load that is held: where, and how much mu changes over its trained range."""
        found = []
        for name, value in self.fixed.items():
            text = f"{name} is held at {with_unit(name, value)}"
            low, high = self.trained.get(name, (value, value))
            if not low <= value <= high:
                text += f", OUTSIDE its trained range {low:g} to {high:g}"
            found.append(f"{text}; over its trained range mu changes by up to {self.left_out[name]:.2e}")
        return found

    def summary(self) -> str:
        """Return one sentence about size and error."""
        shape = " x ".join(f"{len(lines)} {name}" for name, lines in self.axes.items())
        reason = "max_rows is reached" if self.full else "mu jumps between grid lines"
        ending = "met" if self.met else f"NOT met: {reason}"
        return (
            f"{self.mu.size} rows ({shape}); multilinear interpolation is off by at most {self.largest:.2e} "
            f"(root mean square {self.rms:.2e}) at {_MEASURED} random points; tolerance {self.tolerance:g} {ending}"
        )


def tabulate(
    source: FrictionSource,
    axes: str | Sequence[str] = AXES,
    points: Mapping[str, int] | None = None,
    limits: Mapping[str, Sequence[float]] | None = None,
    fixed: Mapping[str, float] | None = None,
    system: Mapping[str, float] | None = None,
    tolerance: float = 1e-3,
    max_rows: int = 50_000,
    start_memory: bool = False,
) -> FrictionTable:
    """Choose a grid, evaluate mu on it and measure the interpolation error.

    Raises InputError: unknown names, values out of range, no trained range and no limits, or memory.

    Parameters
    ----------
    axes : sequence of str
        Loads that vary, slowest first; a load that mu does not react to gets two grid lines.
    points : mapping, optional
        Load to number of evenly spaced grid lines; such an axis is not refined.
    limits : mapping, optional
        Load to (lower, upper); the trained range by default.
    fixed : mapping, optional
        Values of the loads that are no axis; by default the start value (nominal, inside the trained range).
    system : mapping, optional
        Values of system variables; their start values by default.
    tolerance : float
        Largest error of mu that is aimed at (absolute).
    max_rows : int
        Most rows of the table.
    start_memory : bool
        Tabulate a model with memory as a fresh contact point; without it such a model is refused.

    Examples
    --------
    >>> from fmus.source.reading import read_source
    >>> from friction_models import ConstantFriction
    >>> source = read_source(ConstantFriction(mu=0.1))
    >>> table = tabulate(source, axes="T", limits={"T": (20.0, 200.0)}, points={"T": 3})
    >>> table.axes["T"], table.mu
    (array([ 20., 110., 200.]), array([0.1, 0.1, 0.1]))
    """
    if source.states and not start_memory:
        names = ", ".join(s.name for s in source.states)
        raise InputError(
            f"{source.where}: a table has no memory and this model has ({names}); allowed: the targets c, ufric and "
            "vfric, or start_memory to tabulate a fresh contact point"
        )
    axes = options.axis_names(axes)
    goal = options.number("tolerance", tolerance, 1e-9, 1.0)
    room = options.whole("max_rows", max_rows, 2 ** len(axes), MAX_ROWS)
    box = _box(source, axes, limits)
    lines = options.mapping("points", points, axes)
    counts = {n: options.whole(f"points of {n!r}", k, 2, 1000) for n, k in lines.items()}
    held = held_loads(source, fixed, [n for n in LOAD_NAMES if n not in axes])
    variables = system_values(source, system)
    reference = Reference(source)
    values = list(variables.values())

    def evaluate(at: FloatArray, held: Mapping[str, float] = held) -> FloatArray:
        loads = np.empty((len(at), len(LOAD_NAMES)))
        for name, value in held.items():
            loads[:, LOAD_NAMES.index(name)] = value
        loads[:, [LOAD_NAMES.index(n) for n in axes]] = at
        return reference.mu(loads, system=values)

    grid = Grid(evaluate, [box[n] for n in axes], [counts.get(n) for n in axes])
    grid.refine(goal, room)
    largest, rms = grid.error(np.random.default_rng(31), _MEASURED)
    some = np.random.default_rng(32).uniform(grid.lower, grid.upper, size=(500, len(axes)))
    left_out = {}
    for name, own in held.items():
        lower, upper = source.domain.get(name, (own, own))
        moved = [evaluate(some, held | {name: v}) for v in (*np.linspace(lower, upper, 5).tolist(), own)]
        left_out[name] = float(np.ptp(moved, axis=0).max())
    return FrictionTable(
        axes=dict(zip(axes, grid.lines)),
        mu=grid.values(),
        fixed=held,
        system=variables,
        tolerance=goal,
        largest=largest,
        rms=rms,
        left_out=left_out,
        trained=dict(source.domain),
        full=grid.full,
    )


def table_files(source: FrictionSource, **given: Any) -> Files:
    """Return the files of a table export; the options are those of `tabulate`.

    Examples
    --------
    >>> from fmus.source.reading import read_source
    >>> from friction_models import ConstantFriction
    >>> files = table_files(read_source(ConstantFriction(mu=0.1)), axes="T", limits={"T": (20.0, 200.0)})
    >>> sorted(files)
    ['LICENSE.txt', 'README.txt', 'card.json', 'model.onnx', 'mu_table.csv', 'mu_table.txt', 'table.json']
    """
    table = tabulate(source, **given)
    system = held_system(source, table.system)
    values = description(source) | {
        "SUMMARY": table.summary(),
        "AXES": "\n".join(
            f"  {n:8} {QUANTITIES[n].unit:5} {len(x):4} lines, {x[0]:g} to {x[-1]:g}"
            for n, x in table.axes.items()
        ),
        "FIXED": rows(table.held()),
        "SYSTEM_VALUES": rows(system),
        "MEMORY": memory_note(source),
    }
    report = {
        "axes": {n: x.tolist() for n, x in table.axes.items()},
        "fixed": table.fixed,
        "held": [*table.held(), *system],
        "largest change of mu over the trained range of a fixed load": table.left_out,
        "system": table.system,
        "rows": int(table.mu.size),
        "tolerance": table.tolerance,
        "tolerance met": table.met,
        "largest error": table.largest,
        "root mean square error": table.rms,
        "summary": table.summary(),
    }
    return {
        "mu_table.csv": _long(table),
        "mu_table.txt": _blocks(table, values["TITLE"]),
        "table.json": json.dumps(report, indent=2) + "\n",
        "README.txt": template("readme_table.txt", values),
        **documents(source),
    }


def memory_note(source: FrictionSource) -> str:
    """Return what a table makes of the memory of a model."""
    if not source.states:
        return "The model has no memory."
    return "THIS MODEL HAS MEMORY, which a table cannot have: mu is that of a fresh contact point."


def _long(table: FrictionTable) -> str:
    """Return one row a grid point, with a row of units; the last axis runs fastest."""
    stream = io.StringIO()
    names = [*table.axes, "mu"]
    stream.write(",".join(names) + "\n" + ",".join(QUANTITIES[n].unit for n in names) + "\n")
    points = grid_points(list(table.axes.values()))
    np.savetxt(stream, np.column_stack([points, table.mu.ravel()]), fmt="%.9g", delimiter=",")
    return stream.getvalue()


def _blocks(table: FrictionTable, title: str) -> str:
    """Return the grid lines once and then one line of mu for each combination of all axes but the last."""
    lines = [f"# {title}", f"# {table.summary()}"]
    lines += [f"# {n} = {v:g} {QUANTITIES[n].unit}" for n, v in table.fixed.items()]
    lines += [f"# {n} = {v:g}" for n, v in table.system.items()]
    lines.append(f"{len(table.axes)}")
    for name, grid in table.axes.items():
        lines.append(f"{name} [{QUANTITIES[name].unit}] {len(grid)}")
        lines.append(" ".join(f"{x:.9g}" for x in grid))
    values = table.mu.reshape(-1, table.mu.shape[-1])
    lines.append(f"mu [1] {values.shape[0]} {values.shape[1]}")
    lines += [" ".join(f"{x:.6e}" for x in row) for row in values]
    return "\n".join(lines) + "\n"


def _box(source: FrictionSource, axes: Sequence[str], given: object) -> dict[str, tuple[float, float]]:
    """Return the ends of each axis: those that were asked for, or the trained range."""
    wanted = options.mapping("limits", given, axes)
    box = {}
    for name in axes:
        if name not in wanted and name not in source.domain and name not in source.absent:
            raise InputError(
                f"{source.where}: no trained range of {name!r} is recorded; allowed: give it as limits of {name!r}"
            )
        # The plan's range serves a load that was not measured: mu does not react to it.
        usual = source.domain.get(name, USUAL[name])
        box[name] = options.limits(name, wanted[name]) if name in wanted else usual
    return box
