"""`pack_signals`: recorded quantities over time as an FMU, which feeds the inputs of other FMUs."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from friction_models.common import InputError

from ..interface.solver_interface import SolverInterface, signal
from .solvers import write_solver_fmu

#: Longest table; it is read at once where the FMU starts.
MOST_INTERVALS = 1_000_000


def pack_signals(
    path: str | os.PathLike[str],
    edges: npt.ArrayLike,
    signals: Mapping[str, tuple[str, str, npt.ArrayLike]],
    *,
    title: str = "signals over time",
    communication_step: float | None = None,
) -> Path:
    """Write a source of signals as an FMU for co-simulation (FMI 2.0, in the simulator's Python).

    An output after a step is the mean of the signal over that step, so that distances and energies of the
    table are kept whatever the step. The last value holds beyond the table.

    Parameters
    ----------
    path : path-like
        The FMU to write.
    edges : array_like, shape (n + 1,)
        Times at which the values change [s], from 0 on, increasing.
    signals : mapping
        Name of an output to its unit, its meaning and its values, shape (n,), each constant between two edges.
    title : str
        Name of the model.
    communication_step : float, optional
        Step of the default experiment [s]; a hundredth of the table by default.

    Raises
    ------
    InputError
        No signals, arrays of other lengths, values that are not finite numbers, times that do not increase.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from fmus.runtime.fmu_files import describe
    >>> force = ("N", "normal force", [100.0, 300.0])  # 100 N in the first half second, then 300 N
    >>> with TemporaryDirectory() as place:
    ...     fmu = pack_signals(Path(place) / "press.fmu", [0.0, 0.5, 1.0], {"F_n": force})
    ...     describe(fmu).resolve("F_n")[0].unit
    'N'
    """
    times = np.asarray(edges, dtype=np.float64)
    if times.ndim != 1 or not 2 <= len(times) <= MOST_INTERVALS + 1:
        raise InputError(f"signals: {times.size} times, allowed: 2 to {MOST_INTERVALS + 1} in one dimension")
    if not np.isfinite(times).all() or times[0] != 0.0 or (np.diff(times) <= 0.0).any():
        raise InputError("signals: the times must be finite, begin at 0 s and increase")
    if not signals:
        raise InputError("signals: none given, allowed: at least one")
    rows = []
    for name, (_, _, values) in signals.items():
        row = np.asarray(values, dtype=np.float64)
        if row.shape != (len(times) - 1,) or not np.isfinite(row).all():
            raise InputError(
                f"signals: {name!r} has shape {row.shape}, allowed: ({len(times) - 1},), one finite number an interval"
            )
        rows.append(row.tolist())
    interface = SolverInterface(
        solver="signals",
        title=title,
        identifier="signals",
        outputs=[signal(name, unit, meaning) for name, (unit, meaning, _) in signals.items()],
        inputs=[],
        parameters={},
        experiment=(communication_step or float(times[-1]) / 100.0, float(times[-1])),
        fixed={"edges": times.tolist(), "means": rows},
    )
    return write_solver_fmu(path, interface, "python")
