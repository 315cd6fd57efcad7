"""The tribometer twin as a PythonFMU slave."""

from __future__ import annotations

from .base import SolverSlave
from .twin_solver import TwinSolver


class TwinSlave(SolverSlave):
    """See `fmus.slaves.twin_solver`."""

    solver_type = TwinSolver
